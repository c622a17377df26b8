// SPDX-License-Identifier: GPL-2.0-or-later
// Nodes nearest to points, and the nodes round a node.
#pragma once

#include "mpm/state/Field.hpp"
#include "mpm/state/Grid.hpp"

namespace mpm {

// f(node, steps from the middle along each axis) for the 3^Dim nodes round one.
template <int Dim, class F> MPM_INLINE void forNeighbours(const Grid<Dim>& grid, int node, F&& f) {
    if constexpr (Dim == 2) {
        for (int j = -1; j <= 1; ++j)
            for (int i = -1; i <= 1; ++i) f(node + i + j * grid.strides[1], Index<2>{i, j});
    } else
        for (int l = -1; l <= 1; ++l)
            for (int j = -1; j <= 1; ++j)
                for (int i = -1; i <= 1; ++i)
                    f(node + i + j * grid.strides[1] + l * grid.strides[2], Index<3>{i, j, l});
}

template <int Dim> int nearestNode(const Grid<Dim>& grid, const Vec<Dim>& x) {
    int node = 0;
    for (int k = 0; k < Dim; ++k) node += int(grid.inCells(x[k], k) + 0.5) * grid.strides[k];
    return node;
}

// The same for points begin ... begin + count - 1 at once.
template <int Dim>
void nearestNodes(const Grid<Dim>& grid, const Field& position, int begin, int count, int* node) {
    std::fill(node, node + count, 0);
    for (int k = 0; k < Dim; ++k) {
        const double* x = position.plane(k) + begin;
        const int stride = grid.strides[k];
        grid.alongAxis(k, [&](auto&& inCells) {
#pragma omp simd
            for (int i = 0; i < count; ++i) node[i] += int(inCells(x[i]) + 0.5) * stride;
        });
    }
}

} // namespace mpm
