// SPDX-License-Identifier: GPL-2.0-or-later
#include "mpm/material/Strength.hpp"

namespace mpm {

std::vector<Parameter> Softening::parameters() {
    return {
        {"softeningStrain", "-",
         "plastic shear strain at which 95 % of the way to the residual strength is gone; not given: the soil does "
         "not soften",
         &strain, Range::positive()},
        {"softeningLength", "m",
         "length over which the plastic shear strain that softens is a mean of the neighbours', at least 1.5 "
         "cells; not given: it is that of the particle",
         &length, Range::positive()},
        {"bandWidth", "m",
         "deprecated, give softeningLength: the law multiplies softeningStrain by bandWidth over the cell",
         &bandWidth, Range::positive()}};
}

void Softening::check(const std::string& who) const {
    const bool byLength = !std::isnan(length), byWidth = !std::isnan(bandWidth);
    require(isGiven() || !(byLength || byWidth), who,
            byLength ? ": softeningLength = " : ": bandWidth = ", byLength ? length : bandWidth,
            " m is given without softeningStrain; give both");
    require(!byLength || !byWidth, who, ": softeningLength = ", length, " m and bandWidth = ", bandWidth,
            " m are given together; give softeningLength alone");
}

std::vector<StateVariable> Softening::stateVariables() const {
    if (!std::isnan(length))
        return {{"softeningShearStrain", "-", "plastic shear strain that softens, a mean over neighbours"}};
    if (std::isnan(bandWidth)) return {};
    return {{"cellSize", "m", "size of the cell in which the particle was made", bandWidth, true}};
}

std::vector<Parameter> Strength::parameters() {
    const Range acute{0, std::acos(-1.0) / 2, false, true};
    std::vector<Parameter> all{
        {"cohesion", "kPa", "required: cohesion c", &cohesion, Range::notNegative(), {}, false, true},
        {"frictionAngle", "rad", "required: friction angle phi", &frictionAngle, acute, {}, true, true},
        {"dilatancyAngle",
         "rad",
         "dilatancy angle psi, at most frictionAngle",
         &dilatancyAngle,
         acute,
         {},
         true,
         true},
        {"residualCohesion", "kPa", "cohesion of soil that has softened; not given: cohesion",
         &residualCohesion, Range::notNegative()},
        {"residualFrictionAngle",
         "rad",
         "friction angle of soil that has softened; not given: frictionAngle",
         &residualFrictionAngle,
         acute,
         {},
         true},
        {"residualDilatancyAngle",
         "rad",
         "dilatancy angle of soil that has softened; not given: dilatancyAngle",
         &residualDilatancyAngle,
         acute,
         {},
         true}};
    for (auto& parameter : softening.parameters()) all.push_back(parameter);
    return all;
}

void Strength::finish(const Material& material) {
    const std::string who = material.className();
    const char* names[] = {"cohesion", "frictionAngle", "dilatancyAngle"};
    anyVaries_ = false;
    for (int k = 0; k < 3; ++k) anyVaries_ |= varies_[k] = material.varies(names[k]);
    require(varies_[0] || !std::isnan(cohesion), who,
            ": cohesion is required; give cohesion in kPa (0 for sand)");
    require(varies_[1] || !std::isnan(frictionAngle), who,
            ": frictionAngle is required; give it in radians (0 for undrained clay)");
    require(varies_[0] || varies_[1] || cohesion > 0 || frictionAngle > 0, who,
            ": cohesion and frictionAngle are both 0, which is a fluid; "
            "give one of them a positive value");
    require(varies_[1] || varies_[2] || dilatancyAngle <= frictionAngle, who,
            ": dilatancyAngle = ", dilatancyAngle, " exceeds frictionAngle = ", frictionAngle,
            "; give 0 <= dilatancyAngle <= frictionAngle (radians)");
    const double residual[] = {residualCohesion, residualFrictionAngle, residualDilatancyAngle},
                 peak[] = {cohesion, frictionAngle, dilatancyAngle};
    const char* residualNames[] = {"residualCohesion", "residualFrictionAngle", "residualDilatancyAngle"};
    bool softens = false;
    for (int k = 0; k < 3; ++k) {
        if (std::isnan(residual[k])) continue;
        softens = true;
        require(softening.isGiven(), who, ": ", residualNames[k], " = ", residual[k],
                " is given without softeningStrain; give both");
        require(varies_[k] || residual[k] <= peak[k], who, ": ", residualNames[k], " = ", residual[k],
                " exceeds ", names[k], " = ", peak[k], "; give at most that");
    }
    require(softens || !softening.isGiven(), who, ": softeningStrain = ", softening.strain,
            " is given without a residual strength; give residualCohesion, residualFrictionAngle or "
            "residualDilatancyAngle");
    softening.check(who);
}

std::vector<StateVariable> Strength::stateVariables() const {
    std::vector<StateVariable> all;
    if (varies_[0]) all.push_back({"cohesion", "kPa", "cohesion of the soil as it was placed", cohesion});
    if (varies_[1])
        all.push_back({"frictionAngle", "rad", "friction angle of the soil as it was placed", frictionAngle});
    if (varies_[2])
        all.push_back(
            {"dilatancyAngle", "rad", "dilatancy angle of the soil as it was placed", dilatancyAngle});
    for (auto& variable : softening.stateVariables()) all.push_back(variable);
    return all;
}

void Strength::find(int count, double* const* state, const double* plasticShear, StrengthRun& run) const {
    const double peak[] = {cohesion, frictionAngle, dilatancyAngle},
                 residual[] = {residualCohesion, residualFrictionAngle, residualDilatancyAngle};
    std::vector<double>* const found[] = {&run.cohesion, &run.frictionAngle, &run.dilatancyAngle};
    int next = 0;
    for (int k = 0; k < 3; ++k)
        varies_[k] ? std::copy_n(state[next++], count, found[k]->begin())
                   : std::fill_n(found[k]->begin(), count, peak[k]);
    if (!softening.isGiven()) return;
    const double* own = softening.hasState() ? state[next] : nullptr;
    for (int i = 0; i < count; ++i) {
        const double left = softening.left(plasticShear[i], own ? own[i] : 0);
        for (int k = 0; k < 3; ++k)
            if (double& x = (*found[k])[i]; residual[k] < x) x = residual[k] + (x - residual[k]) * left;
    }
    for (int i = 0; i < count; ++i) // psi may not exceed phi on the way
        run.dilatancyAngle[i] = std::min(run.dilatancyAngle[i], run.frictionAngle[i]);
}

} // namespace mpm
