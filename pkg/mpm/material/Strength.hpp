// SPDX-License-Identifier: GPL-2.0-or-later
// Cohesion, friction and dilatancy angle of soil: one number each, values of each particle, and on their way to
// residual ones as the soil shears. What laws of Mohr-Coulomb's kind have in common.
#pragma once

#include "mpm/material/Material.hpp"

namespace mpm {

// Strengths of a run of particles, one after the other.
struct StrengthRun {
    std::vector<double> cohesion, frictionAngle, dilatancyAngle; // kPa, rad

    explicit StrengthRun(int count) : cohesion(count), frictionAngle(count), dilatancyAngle(count) {}
};

// x = x_r + (x_0 - x_r) exp(-3 xi/xi_95): 95 % of the way to the residual value at xi = xi_95 (Einav & Randolph 2005,
// Int. J. Numer. Methods Eng. 63, 1991-2016). A band of shear is about one cell wide, whatever the soil's own width is:
// with `length`, xi is a mean over neighbours, and the band has that width. With `bandWidth`, xi_95 is multiplied by its
// ratio to the cell, so that what a band of one cell dissipates stays.
class MPM_PUBLIC Softening {
  public:
    double strain = notGiven;    // xi_95, -
    double length = notGiven;    // m
    double bandWidth = notGiven; // m

    bool isGiven() const { return !std::isnan(strain); }
    std::vector<Parameter> parameters();
    void check(const std::string& who) const;
    std::vector<StateVariable> stateVariables() const; // one or none
    bool hasState() const { return !std::isnan(length) || !std::isnan(bandWidth); }
    // first: state variable of the softening.
    NeighbourMean neighbourMean(int plasticStrain, int first) const {
        return std::isnan(length) ? NeighbourMean{} : NeighbourMean{plasticStrain, first, length};
    }
    // What is left of the way to the residual value, 1 at first. own: state of the particle, where there is one.
    double left(double plasticStrain, double own) const {
        const double xi = std::isnan(length) ? plasticStrain : std::max(0.0, own);
        const double stretch = std::isnan(bandWidth) ? 1 : bandWidth / own;
        return std::exp(-3 * xi / (strain * stretch));
    }
};

class MPM_PUBLIC Strength {
  public:
    double cohesion = notGiven, frictionAngle = notGiven, dilatancyAngle = 0;
    double residualCohesion = notGiven, residualFrictionAngle = notGiven, residualDilatancyAngle = notGiven;
    Softening softening;

    std::vector<Parameter> parameters();
    void finish(const Material& material);
    std::vector<StateVariable> stateVariables() const;
    // first: state variable of the strength.
    NeighbourMean neighbourMean(int plasticStrain, int first) const {
        int own = first;
        for (bool varies : varies_) own += varies;
        return softening.neighbourMean(plasticStrain, own);
    }
    // Whether all particles have one strength at any time.
    bool isUniform() const { return !softening.isGiven() && !anyVaries_; }
    // state: of the strength, as in stateVariables(); plasticShear: of the particles.
    void find(int count, double* const* state, const double* plasticShear, StrengthRun& run) const;

  private:
    bool varies_[3] = {false, false, false}, anyVaries_ = false;
};

} // namespace mpm
