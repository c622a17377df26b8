// SPDX-License-Identifier: GPL-2.0-or-later
// The contract of a constitutive model. A material is one file: it derives from MaterialOf<Class>,
// lists its parameters and state variables, updates the stress of a run of particles, and registers.
#pragma once

#include "mpm/base/parameters.hpp"
#include "mpm/base/registry.hpp"
#include "mpm/base/types.hpp"
#include "mpm/state/SectionStiffness.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <type_traits>
#include <vector>

namespace mpm {

// A run of particles handed to a material. Every component is an array over the particles of the run
// (planar storage), so that a loop over them vectorises. Tension positive, kPa.
//
// Components of a 3x3 tensor are numbered 3*i + j. In plane strain (Dim = 2) the components xz, yz,
// zx, zy are zero and need not be read or written; zz is stored and must be updated. The stress is
// symmetric: write both xy and yx (xz and zx, yz and zy in 3D); read the upper triangle.
template <int Dim> struct MaterialPoints {
    int count;
    double dt, time;                           // s; time at the start of the step
    int64_t step;                              // number of the step, from 0
    const char* body;                          // name of their body, for messages
    const int64_t* id;                         // which particles of the body these are
    const double* position[Dim];               // m
    const double* velocityGradient[Dim * Dim]; // L_ij at Dim*i + j, 1/s (after anti-locking, if any)
    const double* deformationGradient[9];      // F after the step, F_n+1 = (I + dt L) F_n
    const double *volume,
        *initialVolume;   // after the step, and of the initial configuration: J is their ratio
    double* stress[9];    // in: at the start of the step; out: at its end
    double* const* state; // state[k][p]: state variable k, see Material::stateVariables
    bool hasFbar;         // whether all particles of a cell take its change of volume
    // Dim = 3: whether no particle shears along the third axis, and xz, yz, zx, zy are zero (axial symmetry).
    // Dim = 2: rate of strain along the third axis, 1/s; nullptr: zero (plane strain).
    bool isRing;
    const double* hoopRate;

    // The same particles of rings as those of a plane that strain along its third axis.
    MaterialPoints<2> inPlane() const {
        MaterialPoints<2> flat{};
        flat.count = count;
        flat.dt = dt;
        flat.time = time;
        flat.step = step;
        flat.body = body;
        flat.id = id;
        for (int k = 0; k < 2; ++k) flat.position[k] = position[k];
        for (int k = 0; k < 4; ++k) flat.velocityGradient[k] = velocityGradient[Dim * (k / 2) + k % 2];
        for (int k = 0; k < 9; ++k) flat.deformationGradient[k] = deformationGradient[k];
        for (int k = 0; k < 9; ++k) flat.stress[k] = stress[k];
        flat.volume = volume;
        flat.initialVolume = initialVolume;
        flat.state = state;
        flat.hasFbar = hasFbar;
        flat.hoopRate = velocityGradient[Dim * Dim - 1];
        return flat;
    }

    // Particles [begin, end) of the run. planes: memory for pointers to their state variables.
    MaterialPoints part(int begin, int end, std::vector<double*>& planes) const {
        MaterialPoints its = *this;
        its.count = end - begin;
        its.id += begin;
        for (auto& plane : its.position) plane += begin;
        for (auto& plane : its.velocityGradient) plane += begin;
        for (auto& plane : its.deformationGradient) plane += begin;
        for (auto& plane : its.stress) plane += begin;
        its.volume += begin;
        its.initialVolume += begin;
        if (its.hoopRate) its.hoopRate += begin;
        for (size_t k = 0; k < planes.size(); ++k) planes[k] = state[k] + begin;
        its.state = planes.data();
        return its;
    }
};

// Mean stress and J2 of particle i, kPa and kPa2, from the upper triangle.
struct Invariants {
    double mean, J2;
};
template <int Dim> Invariants invariants(const MaterialPoints<Dim>& points, int i) {
    double* const* s = points.stress;
    const double xx = s[0][i], yy = s[4][i], zz = s[8][i], xy = s[1][i];
    const double mean = (xx + yy + zz) / 3, a = xx - mean, b = yy - mean, c = zz - mean;
    double J2 = 0.5 * (a * a + b * b + c * c) + xy * xy;
    if (Dim == 3) J2 += s[2][i] * s[2][i] + s[5][i] * s[5][i];
    return {mean, J2};
}

struct StateVariable {
    std::string name, unit, doc;
    double initial = 0;
    bool isCellSize = false; // initial is the size of the cell of the grid, where the particle is made
};

// What F-bar moves between the particles of a cell is counted in these state variables of a law, by their places in
// stateVariables(); -1: none.
//   opening         by how much soil stands open and bears nothing until it has closed, a logarithmic strain: shared
//   plasticStrain   plastic volumetric strain, dilation positive: changes with the opening of boxes, and by what the
//                   elastic strain has lost where F-bar changes the mean stress at constant volume
struct VolumeRecord {
    int plasticStrain = -1, opening = -1;
};

// Of a law that softens by its neighbours: state variable `mean` takes, in place of what `strain` gains in a step,
// a mean of it over neighbours (step/NeighbourMeans.hpp) that are about `length` (m) away; 0: it does not. A particle
// without neighbours has mean = strain.
struct NeighbourMean {
    int strain = -1, mean = -1;
    double length = 0;
};

class MPM_PUBLIC Material : public Configurable {
  public:
    double density = notGiven; // Mg/m3, of the initial configuration

    // Parameters that each particle has a value of its own of: a state variable of the same name holds it. A law reads
    // those that it has among its state variables (Parameter::mayVary), and these are then not given. The others stand
    // behind its state variables, and MaterialOf sets them in a copy of the law before it treats a particle.
    bool varies(const std::string& name) const {
        return std::find(varying_.begin(), varying_.end(), name) != varying_.end();
    }
    void vary(const std::string& name, bool does);
    // Whether it can vary.
    bool mayVary(const Parameter& parameter) const;
    // finish(), with values in place of those that vary outside of the law for which it succeeds.
    void finishVarying();

    virtual std::vector<StateVariable> stateVariables() const { return {}; }
    // These, and the parameters that vary outside of the law.
    std::vector<StateVariable> allStateVariables() const;

    // Stress and state at the end of a step. Throws RunError where a particle has no stress.
    virtual void update(const MaterialPoints<2>& points) const = 0;
    virtual void update(const MaterialPoints<3>& points) const = 0;
    // Sets the state variables (one value each) that belong to a given Cauchy stress at F = I. Models
    // whose stress follows from F alone throw InputError for a stress that is not zero.
    virtual void stateFromStress(const double stress[9], double* state) const = 0;
    // The same for particles of which parameters vary outside of the law; without a stress the initial values.
    virtual void startState(const double* stress, double* state) const = 0;
    // Lame constants {lambda, mu} of the elastic response, kPa, of particles at rest without stress.
    virtual std::array<double, 2> lame() const = 0;

    // What follows is optional.

    // Whether the stress is bounded by a yield surface: particles of the material then lock without F-bar.
    virtual bool yields() const { return false; }
    virtual VolumeRecord volumeRecord() const { return {}; }
    virtual NeighbourMean neighbourMean() const { return {}; }
    // Of a beam, whose mesh makes the forces; nullptr: the stress does.
    virtual const SectionStiffness* section() const { return nullptr; }
    // Whether update() gets all particles of a body at once, from one thread.
    virtual bool takesWholeBody() const { return false; }

    // Lame constants of each of a run of particles as they stand, kPa: isotropic, and not below the tangent's. The
    // critical step, hourglass control and implicit bodies use them.
    virtual void stiffness(const MaterialPoints<2>& points, double* lambda, double* mu) const = 0;
    virtual void stiffness(const MaterialPoints<3>& points, double* lambda, double* mu) const = 0;
    // Shear stress, kPa, that each of a run of particles can bear at its mean stress; infinite where nothing
    // yields. Hourglass control (APDI) resists with no more than a part of it.
    virtual void shearStrength(const MaterialPoints<2>& points, double* strength) const = 0;
    virtual void shearStrength(const MaterialPoints<3>& points, double* strength) const = 0;
    // Elastic energy of each of a run of particles by their volume, kJ/m3. The work that goes in less what it grows by
    // is dissipated.
    virtual void storedEnergy(const MaterialPoints<2>& points, double* energy) const = 0;
    virtual void storedEnergy(const MaterialPoints<3>& points, double* energy) const = 0;

    double waveSpeed() const { return std::sqrt((lame()[0] + 2 * lame()[1]) / density); }

  protected:
    std::vector<StateVariable> outside_; // parameters that vary outside of the law
    // Where it keeps these.
    std::vector<double*> targetsOutside();
    virtual bool isCopied() const = 0;

  private:
    std::vector<std::string> varying_;
};

// Forwards both dimensions to one template text. A law has
//     template <int Dim> void stress(const MaterialPoints<Dim>&) const
// and its own of the others where the text here does not suit it. Where stress<2> knows MaterialPoints::hoopRate
// (trialStress() does), takesHoopRate = true says so, and rings cost little more than the plane.
template <class Derived> class MaterialOf : public Material {
  public:
    void update(const MaterialPoints<2>& points) const override {
        const Act<2> act = [](const Derived& law, const MaterialPoints<2>& its, double*, double*) {
            gainMean<2>(law, its);
        };
        forEachLaw(points, act);
    }
    void update(const MaterialPoints<3>& points) const override {
        const Act<3> act = [](const Derived& law, const MaterialPoints<3>& its, double*, double*) {
            if (Derived::takesHoopRate && its.isRing) return gainMean<2>(law, its.inPlane());
            gainMean<3>(law, its);
        };
        forEachLaw(points, act);
    }
    void stiffness(const MaterialPoints<2>& points, double* lambda, double* mu) const override {
        stiffnessOf(points, lambda, mu);
    }
    void stiffness(const MaterialPoints<3>& points, double* lambda, double* mu) const override {
        stiffnessOf(points, lambda, mu);
    }
    void shearStrength(const MaterialPoints<2>& points, double* strength) const override {
        shearStrengthOf(points, strength);
    }
    void shearStrength(const MaterialPoints<3>& points, double* strength) const override {
        shearStrengthOf(points, strength);
    }
    void storedEnergy(const MaterialPoints<2>& points, double* energy) const override {
        storedEnergyOf(points, energy);
    }
    void storedEnergy(const MaterialPoints<3>& points, double* energy) const override {
        storedEnergyOf(points, energy);
    }
    void startState(const double* stress, double* state) const override {
        const int first = int(stateVariables().size());
        withParameters([&](int k) { return state[first + k]; },
                       [&](const Derived& law) {
                           if (stress) return law.stateFromStress(stress, state);
                           const auto variables = law.stateVariables();
                           for (int k = 0; k < first; ++k)
                               if (!variables[k].isCellSize && !varies(variables[k].name))
                                   state[k] = variables[k].initial;
                       });
    }

    // lame() for all.
    template <int Dim>
    void findStiffness(const MaterialPoints<Dim>& points, double* lambda, double* mu) const {
        const std::array<double, 2> constants = lame();
        std::fill_n(lambda, points.count, constants[0]);
        std::fill_n(mu, points.count, constants[1]);
    }
    template <int Dim> void findStrength(const MaterialPoints<Dim>& points, double* strength) const {
        std::fill_n(strength, points.count, std::numeric_limits<double>::infinity());
    }
    // Of a stress that is linear in a small strain: p^2/(2 K) + J2/(2 mu).
    template <int Dim> void findStoredEnergy(const MaterialPoints<Dim>& points, double* energy) const {
        std::vector<double> mu(points.count);
        stiffness(points, energy, mu.data());
        for (int i = 0; i < points.count; ++i) {
            const auto [mean, J2] = invariants(points, i);
            energy[i] = 0.5 * mean * mean / (energy[i] + 2.0 / 3 * mu[i]) + (J2 > 0 ? 0.5 * J2 / mu[i] : 0);
        }
    }

    static constexpr bool takesHoopRate = false;

  private:
    static constexpr bool copies = std::is_copy_constructible_v<Derived>;
    const Derived& law() const { return static_cast<const Derived&>(*this); }
    bool isCopied() const override { return copies; }

    // The stress, and what NeighbourMean::mean gains of a particle by itself.
    template <int N> static void gainMean(const Derived& law, const MaterialPoints<N>& points) {
        const NeighbourMean of = law.neighbourMean();
        if (of.length == 0) return law.template stress<N>(points);
        double *strain = points.state[of.strain], *mean = points.state[of.mean];
        const std::vector<double> before(strain, strain + points.count);
        law.template stress<N>(points);
        for (int i = 0; i < points.count; ++i) mean[i] += strain[i] - before[i];
    }
    // f(law) with the values valueOf(k) of parameters that vary outside of the law.
    template <class ValueOf, class F> void withParameters(ValueOf&& valueOf, F&& f) const {
        if constexpr (copies)
            if (!outside_.empty()) {
                Derived its(law());
                const std::vector<double*> targets = its.targetsOutside();
                for (size_t k = 0; k < targets.size(); ++k) *targets[k] = valueOf(int(k));
                its.finish();
                return f(its);
            }
        f(law());
    }
    // What a law makes of particles: of the first of them and on are the results at `first` and `second`.
    template <int Dim>
    using Act = void (*)(const Derived& law, const MaterialPoints<Dim>& its, double* first, double* second);

    // act() on all at once, or on each row of particles with the same parameters. One text for all that a law does: a
    // copy of it for each was a quarter of the materials' code.
    template <int Dim>
    void forEachLaw(const MaterialPoints<Dim>& points, Act<Dim> act, double* first = nullptr,
                    double* second = nullptr) const {
        if constexpr (copies)
            if (!outside_.empty()) {
                Derived its(law());
                const std::vector<double*> targets = its.targetsOutside();
                std::vector<double*> planes(stateVariables().size() + targets.size());
                double* const* values = points.state + stateVariables().size();
                for (int begin = 0, end; begin < points.count; begin = end) {
                    for (size_t k = 0; k < targets.size(); ++k) *targets[k] = values[k][begin];
                    const auto isAlike = [&](int i) {
                        for (size_t k = 0; k < targets.size(); ++k)
                            if (values[k][i] != values[k][begin]) return false;
                        return true;
                    };
                    for (end = begin + 1; end < points.count && isAlike(end);) ++end;
                    its.finish();
                    act(its, points.part(begin, end, planes), first ? first + begin : nullptr,
                        second ? second + begin : nullptr);
                }
                return;
            }
        act(law(), points, first, second);
    }
    template <int Dim> void stiffnessOf(const MaterialPoints<Dim>& points, double* lambda, double* mu) const {
        const Act<Dim> act = [](const Derived& law, const MaterialPoints<Dim>& its, double* lambda,
                                double* mu) { law.template findStiffness<Dim>(its, lambda, mu); };
        forEachLaw(points, act, lambda, mu);
    }
    template <int Dim> void shearStrengthOf(const MaterialPoints<Dim>& points, double* strength) const {
        const Act<Dim> act = [](const Derived& law, const MaterialPoints<Dim>& its, double* strength,
                                double*) { law.template findStrength<Dim>(its, strength); };
        forEachLaw(points, act, strength);
    }
    template <int Dim> void storedEnergyOf(const MaterialPoints<Dim>& points, double* energy) const {
        const Act<Dim> act = [](const Derived& law, const MaterialPoints<Dim>& its, double* energy, double*) {
            law.template findStoredEnergy<Dim>(its, energy);
        };
        forEachLaw(points, act, energy);
    }
};

// Isotropic elastic constants, given as lame = (lambda, mu) or as young and poisson; the others follow.
class MPM_PUBLIC Elasticity {
  public:
    std::vector<double> lame;                    // kPa
    double young = notGiven, poisson = notGiven; // kPa, -

    std::vector<Parameter> parameters();
    // Completes the constants and checks them; who = the material's class name.
    void finish(const std::string& who);

    double lambda() const { return lame[0]; }
    double mu() const { return lame[1]; }
    double bulk() const { return lame[0] + 2.0 / 3.0 * lame[1]; }

  private:
    std::vector<double> completed_; // lambda, mu, young, poisson at the last finish(): what changed since?
};

} // namespace mpm
