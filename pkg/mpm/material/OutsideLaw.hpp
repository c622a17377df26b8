// SPDX-License-Identifier: GPL-2.0-or-later
// A law from a shared library that is called once for each particle: what such laws have in common. Components of
// symmetric tensors are in the order 11 22 33 12 13 23.
#pragma once

#include "mpm/material/Material.hpp"
#include "mpm/material/tensors.hpp"

namespace mpm {

// One particle in one step. Strains with engineering shear; tensors in the axes at the end of the step.
struct OutsideCall {
    double stress[6]; // in: turned with the particle; out: at the end of the step, kPa
    double strain[6]; // at the start of the step, turned
    double increment[6];
    double rotation[9], F0[9], F1[9]; // row by row; F at the start and the end of the step
    double* states;                   // in and out
    double tangent[36] = {};          // out: d stress/d strain, row by row, kPa
    double stored = 0;                // in and out: elastic energy by volume, kJ/m3
    double time, dt, position[3];     // s, m
    int64_t step, id;
};

class OutsideLaw : public MaterialOf<OutsideLaw> {
  public:
    std::vector<StateVariable> stateVariables() const override;
    bool yields() const override { return yields_; }
    // Libraries that keep something between calls get them one after the other, in the order of the particles.
    bool takesWholeBody() const override { return !threadSafe_; }
    std::array<double, 2> lame() const override { return {modulus_ - 2 * shear_, shear_}; }
    void stateFromStress(const double stress[9], double* state) const override;

    template <int Dim> void stress(const MaterialPoints<Dim>& points) const;
    // The largest since the particle was placed: a tangent at yield says nothing about unloading.
    template <int Dim>
    void findStiffness(const MaterialPoints<Dim>& points, double* lambda, double* mu) const {
        const int first = stateCount() + 6;
        for (int i = 0; i < points.count; ++i) {
            mu[i] = points.state[first + 1][i];
            lambda[i] = points.state[first][i] - 2 * mu[i];
        }
    }
    // What the library says, or that of a linear law where it says nothing.
    template <int Dim> void findStoredEnergy(const MaterialPoints<Dim>& points, double* energy) const {
        MaterialOf::findStoredEnergy(points, energy);
        const double* stored = points.state[stateCount() + 8];
        for (int i = 0; i < points.count; ++i)
            if (stored[i] != 0) energy[i] = stored[i];
    }

  protected:
    std::string library_;
    std::vector<double> properties_, states_;
    bool threadSafe_ = false, yields_ = true;

    // Parameters of all such laws but density and library.
    std::vector<Parameter> commonParameters();
    // Symbol of the library; throws InputError where there is none, unless it may be missing (null).
    void* symbol(const std::string& name, bool isNeeded = true) const;
    // Asks for the stiffness of a particle at rest; to be called by finish(), once the library is ready.
    void findInitialStiffness();

    virtual std::vector<std::string> stateNames() const = 0;
    // Which states are the first of six components of a symmetric tensor that turns with the particle, shear times
    // sqrt(2).
    virtual std::vector<int> tensorStates() const { return {}; }
    // Throws RunError with what went wrong; who and where is added.
    virtual void call(OutsideCall& particle) const = 0;

  private:
    double modulus_ = 0, shear_ = 0; // lambda + 2 mu, mu of a particle at rest
    int stateCount() const { return int(states_.size()); }
    std::array<double, 2> moduliAt(const double stress[9], const double* states) const;
};

} // namespace mpm
