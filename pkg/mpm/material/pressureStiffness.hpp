// SPDX-License-Identifier: GPL-2.0-or-later
// A bulk modulus that grows with a power of the pressure: K = K_ref (p/p_ref)^m. Strain and pressure are positive in
// compression here.
#pragma once

#include <algorithm>
#include <cmath>

namespace mpm {

// The pressure follows from the elastic volumetric strain e, counted from the smallest pressure p_s on, exactly; below
// p_s the stiffness is the one at p_s, and there is no tension.
struct PressureStiffness {
    double bulk, reference, power, smallest; // kPa, kPa, -, kPa

    double stiffness(double p) const { // dp/de
        return power == 0 ? bulk : bulk * std::pow(std::max(p, smallest) / reference, power);
    }
    double pressure(double e) const { return std::max(0.0, pull(e)); }
    double pull(double e) const { // the same, with tension: negative
        const double atSmallest = stiffness(smallest);
        if (e <= 0 || power == 0) return smallest + atSmallest * e;
        if (power == 1) return smallest * std::exp(atSmallest / smallest * e);
        return smallest * std::pow(1 + (1 - power) * atSmallest / smallest * e, 1 / (1 - power));
    }
    double energy(double p) const { // the integral of p dp/K
        const double least = std::min(p, smallest), atLeast = least * least / stiffness(least);
        return 0.5 * atLeast + (p * p / stiffness(p) - atLeast) / (2 - power);
    }
    double strain(double p) const {
        const double atSmallest = stiffness(smallest);
        if (p <= smallest || power == 0) return (p - smallest) / atSmallest;
        if (power == 1) return smallest / atSmallest * std::log(p / smallest);
        return smallest / atSmallest / (1 - power) * (std::pow(p / smallest, 1 - power) - 1);
    }
};

} // namespace mpm
