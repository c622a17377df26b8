// SPDX-License-Identifier: GPL-2.0-or-later
// The nearest point of a surface.
#pragma once

#include "mpm/base/types.hpp"

namespace mpm {

struct Surface {
    double distance; // m, negative inside
    Vec3 normal;     // outward, at the nearest point of the surface
};

} // namespace mpm
