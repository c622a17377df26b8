// SPDX-License-Identifier: GPL-2.0-or-later
// The contract of a constitutive model. A material is one file: it derives from MaterialOf<Class>,
// lists its parameters and state variables, updates the stress of a run of particles, and registers.
#pragma once

#include "mpm/base/parameters.hpp"
#include "mpm/base/registry.hpp"
#include "mpm/base/types.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <string>
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
    double dt;
    const double* velocityGradient[Dim * Dim]; // L_ij at Dim*i + j, 1/s (after anti-locking, if any)
    const double* deformationGradient[9];      // F after the step, F_n+1 = (I + dt L) F_n
    const double *volume,
        *initialVolume;   // after the step, and of the initial configuration: J is their ratio
    double* stress[9];    // in: at the start of the step; out: at its end
    double* const* state; // state[k][p]: state variable k, see Material::stateVariables
    bool hasFbar;         // whether all particles of a cell take its change of volume
};

struct StateVariable {
    std::string name, unit, doc;
    double initial = 0;
    bool isCellSize = false; // initial is the size of the cell of the grid, where the particle is made
};

class MPM_PUBLIC Material : public Configurable {
  public:
    double density = notGiven; // Mg/m3, of the initial configuration

    // Parameters that each particle has a value of its own of: a state variable of the same name holds it, and the
    // parameter itself is not given.
    std::vector<std::string> varying;
    bool varies(const std::string& name) const {
        return std::find(varying.begin(), varying.end(), name) != varying.end();
    }

    virtual std::vector<StateVariable> stateVariables() const { return {}; }

    virtual void update(const MaterialPoints<2>& points) const = 0;
    virtual void update(const MaterialPoints<3>& points) const = 0;

    // Whether the stress is bounded by a yield surface: particles of the material then lock without F-bar.
    virtual bool yields() const { return false; }

    // The state variable that tells by how much soil stands open and bears nothing until it has closed, by its
    // place in stateVariables(); -1: none. F-bar shares it in a cell.
    virtual int opening() const { return -1; }
    // F-bar has changed the opening of each of a run of particles, and the volume of boxes with it: laws whose plastic
    // strain counts the opening book it.
    virtual void shared(const MaterialPoints<2>&, const double* /*change*/) const {}
    virtual void shared(const MaterialPoints<3>&, const double* /*change*/) const {}
    // F-bar has changed the mean stress of each of a run of particles, while their volume stays: what the elastic
    // strain of one has gained, its plastic strain has lost to others of the cell. Laws with such a strain book it.
    virtual void mixed(const MaterialPoints<2>&, const double* /*change*/) const {}
    virtual void mixed(const MaterialPoints<3>&, const double* /*change*/) const {}

    // Lame constants {lambda, mu} of the elastic response, kPa, of particles at rest without stress.
    virtual std::array<double, 2> lame() const = 0;
    // The same for each of a run of particles as they stand; a law whose stiffness follows the stress
    // overrides it.
    virtual void stiffness(const MaterialPoints<2>& points, double* lambda, double* mu) const {
        constantStiffness(points.count, lambda, mu);
    }
    virtual void stiffness(const MaterialPoints<3>& points, double* lambda, double* mu) const {
        constantStiffness(points.count, lambda, mu);
    }

    // Shear stress, kPa, that each of a run of particles can bear at its mean stress; infinite where nothing
    // yields. Hourglass control (APDI) resists with no more than a part of it.
    virtual void shearStrength(const MaterialPoints<2>& points, double* strength) const {
        std::fill_n(strength, points.count, std::numeric_limits<double>::infinity());
    }
    virtual void shearStrength(const MaterialPoints<3>& points, double* strength) const {
        std::fill_n(strength, points.count, std::numeric_limits<double>::infinity());
    }

    // Sets the state variables (one value each) that belong to a given Cauchy stress at F = I. Models
    // whose stress follows from F alone throw InputError for a stress that is not zero.
    virtual void stateFromStress(const double stress[9], double* state) const = 0;

    double waveSpeed() const { return std::sqrt((lame()[0] + 2 * lame()[1]) / density); }

  private:
    void constantStiffness(int count, double* lambda, double* mu) const {
        const std::array<double, 2> constants = lame();
        std::fill_n(lambda, count, constants[0]);
        std::fill_n(mu, count, constants[1]);
    }
};

// Forwards both dimensions to one template text: template <int Dim> void stress(const MaterialPoints<Dim>&)
// const.
template <class Derived> class MaterialOf : public Material {
  public:
    void update(const MaterialPoints<2>& points) const override {
        static_cast<const Derived*>(this)->template stress<2>(points);
    }
    void update(const MaterialPoints<3>& points) const override {
        static_cast<const Derived*>(this)->template stress<3>(points);
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
