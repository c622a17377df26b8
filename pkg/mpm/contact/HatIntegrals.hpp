// SPDX-License-Identifier: GPL-2.0-or-later
// The hat function of a node, integrated over boxes.
#pragma once

#include "mpm/base/simd/Pack.hpp"
#include "mpm/base/types.hpp"

namespace mpm {

using FourBoxes = Eigen::Array<double, 4, 1>; // a number for each

// Along one axis, in cells from the node: integrals over each box of the hat function N(y) = 1 - |y|, and of
// N', y N and (y N)'. Where the cells beside the node differ, the smallest one of the grid is the unit of length.
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
    // below, above: edges of the two cells.
    HatIntegrals(const FourBoxes& centre, const FourBoxes& half, double below, double above) {
        const End last(centre + half, below, above), first(centre - half, below, above);
        N = last.N() - first.N();
        slope = first.y.abs() - last.y.abs();
        this->first = last.first() - first.first();
        slopeOfFirst = last.slopeOfFirst() - first.slopeOfFirst();
    }

  private:
    struct End { // of the boxes
        FourBoxes edge, y;
        End(const FourBoxes& x, double below, double above)
            : edge((x < 0).select(FourBoxes::Constant(below), above)), y((x / edge).max(-1).min(1)) {}
        FourBoxes N() const { return edge * (1 - 0.5 * y.abs()) * y; }
        FourBoxes first() const { return edge * edge * (0.5 - 1 / 3.0 * y.abs()) * y * y; }
        FourBoxes slopeOfFirst() const { return edge * (1 - y.abs()) * y; }
    };
};

} // namespace mpm
