// SPDX-License-Identifier: GPL-2.0-or-later
// Stiffness and strength of a cross-section of a beam, plate or shell, per metre of its width.
#pragma once

#include <limits>

namespace mpm {

struct SectionStiffness {
    static constexpr double none = std::numeric_limits<double>::infinity();

    double EA, EI;                        // kN/m, kN m2/m
    double GA = none, limitMoment = none; // kN/m, kN m/m
};

} // namespace mpm
