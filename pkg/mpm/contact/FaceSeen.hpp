// SPDX-License-Identifier: GPL-2.0-or-later
// The surface of a group as one node sees it, weighted with the node's hat function phi; n points out, d runs from the node.
#pragma once

#include "mpm/base/types.hpp"

namespace mpm {

template <int Dim> struct FaceSeen {
    Vec<Dim> outward = Vec<Dim>::Zero(); // m2 (2D: m), int phi n dA
    Mat<Dim> moment = Mat<Dim>::Zero();  // m3, int phi d n^T dA
    double intruded = -1e300;            // m, reach of the boxes that have crossed into a mesh
    // Of explicit surfaces only:
    double extent = 0; // m2, int phi dA
    double nearest = 1e300,
           reach = 0; // m2, m: squared distance from the normal of the nearest vertex, and its reach
};

} // namespace mpm
