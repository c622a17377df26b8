// SPDX-License-Identifier: GPL-2.0-or-later
// The nearest point of a surface, and what is far from it.
#pragma once

#include "mpm/base/types.hpp"

#include <limits>

namespace mpm {

struct Surface {
    double distance; // m, negative inside
    Vec3 normal;     // outward, at the nearest point of the surface
};

// Of places round one, x: y is further from the surface than asked where over + up . (y - x) > most.
struct Clearance {
    Vec3 up = Vec3::Zero();
    double over = 0, most = std::numeric_limits<double>::infinity(); // m
};

} // namespace mpm
