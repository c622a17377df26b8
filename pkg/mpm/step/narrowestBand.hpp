// SPDX-License-Identifier: GPL-2.0-or-later
// How to number the nodes of an implicit system.
#pragma once

#include "mpm/base/types.hpp"

namespace mpm {

// The axis along which nodes that strain one particle have the closest numbers. first, last: of the nodes of a system;
// reach: from the first to the last node of a particle, at most.
template <int Dim>
int axisOfNarrowestBand(const Index<Dim>& first, const Index<Dim>& last, const Index<Dim>& reach) {
    int best = -1;
    double narrowest = 0;
    for (int axis = Dim - 1; axis >= 0; --axis) {
        double band = 0, step = 1;
        for (int k = 0; k < Dim; ++k)
            if (k != axis) {
                band += step * reach[k];
                step *= last[k] - first[k] + 1;
            }
        band += step * reach[axis];
        if (best >= 0 && band >= narrowest) continue;
        best = axis;
        narrowest = band;
    }
    return best;
}

} // namespace mpm
