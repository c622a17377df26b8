// SPDX-License-Identifier: GPL-2.0-or-later
// What a body is made from: a lattice of equal boxes, or a mesh.
#pragma once

#include "mpm/base/types.hpp"

#include <vector>

namespace mpm {

template <int Dim> struct Geometry {
    std::vector<Vec<Dim>> positions; // lattice: centres of the domains
    Vec<Dim> halfSize;               // lattice: half edges of a domain
    std::vector<int> carriers;       // lattice: facets of its outline, by the number of a domain,
    std::vector<Vec<Dim>> offsets;   //          where they are from its centre,
    std::vector<Vec<Dim>> areas;     //          and their area vectors
    std::vector<Vec<Dim>> points;    // mesh: vertices
    std::vector<int> cells;          // mesh: corners of every domain (VTK order)
    std::vector<int> slaves;         // mesh: hanging vertices,
    std::vector<int> masters;        //       their four masters each (-1: unused)
    std::vector<double> weights;     //       and the weights of these
};

} // namespace mpm
