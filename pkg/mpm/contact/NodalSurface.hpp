// SPDX-License-Identifier: GPL-2.0-or-later
// The surface of a group as one node sees it, weighted with the node's hat function phi; n points out, d runs
// from the node.
#pragma once

#include "mpm/base/types.hpp"

namespace mpm {

constexpr double farAway = 1e300; // m, a distance that no surface has: not known. Its square is not used.

template <int Dim> struct NodalSurface {
    Vec<Dim> outward = Vec<Dim>::Zero(); // m2 (2D: m), int phi n dA
    Mat<Dim> moment = Mat<Dim>::Zero();  // m3, int phi d n^T dA
    double intruded = -farAway;          // m, reach of the boxes that have crossed into a mesh

    // Of explicit surfaces only:
    double extent = 0;        // m2, int phi dA
    double nearest = farAway; // m2, squared distance of the nearest vertex from the normal through the node,
    double reach = 0;         // m, and how far its tangent plane reaches along that normal
    bool hasPlane() const { return nearest < farAway; }
    bool isIntruded() const { return intruded > -farAway; }
};

} // namespace mpm
