// SPDX-License-Identifier: GPL-2.0-or-later
// The hat function of a node, integrated over boxes.
#pragma once

#include "mpm/base/simd/Pack.hpp"
#include "mpm/base/types.hpp"

namespace mpm {

using FourBoxes = Eigen::Array<double, 4, 1>; // a number for each

// Along one axis, in cells from the node: integrals over each box of the hat function N(y) = 1 - |y|, and of
// N', y N and (y N)'.
struct HatIntegrals {
    FourBoxes N, slope, first, slopeOfFirst;

    HatIntegrals() = default;
    MPM_INLINE HatIntegrals(const FourBoxes& centre, const FourBoxes& half) { // of the boxes
        const FourBoxes y = (centre + half).max(-1).min(1), z = (centre - half).max(-1).min(1), Y = y.abs(),
                        Z = z.abs();
        N = (1 - 0.5 * Y) * y - (1 - 0.5 * Z) * z;
        slope = Z - Y;
        first = (0.5 - 1 / 3.0 * Y) * y * y - (0.5 - 1 / 3.0 * Z) * z * z;
        slopeOfFirst = (1 - Y) * y - (1 - Z) * z;
    }
};

} // namespace mpm
