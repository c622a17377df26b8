// SPDX-License-Identifier: GPL-2.0-or-later
// Parameters that the liquids have in common.
#pragma once

#include "mpm/material/required.hpp"
#include "mpm/material/viscous.hpp"

namespace mpm {

class Liquid {
  public:
    double bulk = notGiven, shear = notGiven, tension = 0; // kPa

    std::vector<Parameter> parameters() {
        return {
            {"bulk", "kPa",
             "required: bulk modulus; 100 density v^2 of the fastest flow, and 100 times the largest pressure, "
             "keep the density within 1 %",
             &bulk, Range::positive()},
            {"shearModulus", "kPa",
             "stiffness of the shear stress before it flows, 30 times the largest shear stress or more; not "
             "given: bulk/10",
             &shear, Range::positive()},
            {"tensileStrength", "kPa", "highest mean stress, at which a gap opens; 0: a free surface",
             &tension, Range::notNegative()}};
    }
    void check(const std::string& who, double density) const {
        requireDensity(who, density);
        require(!std::isnan(bulk), who, ": bulk is required; give the bulk modulus in kPa");
    }
    std::array<double, 2> elastic() const { return {bulk, std::isnan(shear) ? bulk / 10 : shear}; }
};

} // namespace mpm
