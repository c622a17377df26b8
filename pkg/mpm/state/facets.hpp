// SPDX-License-Identifier: GPL-2.0-or-later
// Facets of a quadrilateral or hexahedral cell: the one table of their corners, and their area vector.
#pragma once

#include "mpm/base/types.hpp"

#include <Eigen/Geometry>

namespace mpm {

template <int Dim> constexpr int facetsOfCell = 2 * Dim; // edges of a quadrilateral, faces of a hexahedron
template <int Dim> constexpr int cornersOfFacet = 1 << (Dim - 1); // two or four

// Corners (VTK order) of each facet of a cell, so that its area vector points outward.
template <int Dim> struct FacetCorners;
template <> struct FacetCorners<2> {
    static constexpr int of[4][2] = {{0, 1}, {1, 2}, {2, 3}, {3, 0}};
};
template <> struct FacetCorners<3> {
    static constexpr int of[6][4] = {{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4},
                                     {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}};
};

// Outward area vector of a facet, m2 (2D: m); at(a): position of its corner a.
template <int Dim, class At> Vec<Dim> areaVector(At&& at) {
    if constexpr (Dim == 2) {
        const Vec<2> along = at(1) - at(0);
        return Vec<2>(along[1], -along[0]);
    } else {
        const Vec<3> first = at(2) - at(0);
        const Vec<3> second = at(3) - at(1);
        return 0.5 * first.cross(second);
    }
}

} // namespace mpm
