// SPDX-License-Identifier: GPL-2.0-or-later
// Resolution at interfaces: where a mesh meets uGIMP particles, or the mesh of another group (within one cell), its
// edges must not be longer than a cell, for the nodes between its vertices do not feel it. Edges of twice the cell were
// measured to falsify the stress there by 24-89 %.
#pragma once

#include "mpm/scene/Scene.hpp"

namespace mpm {

struct InterfaceFault {
    bool found = false;
    std::string meshed, other; // names of the bodies
    std::string where;
    double edge = 0, initialEdge = 0; // m
    double cell = 1;                  // m, shortest edge of the cell there
};

// limit: longest edge allowed, in cells of the place where it is. The longest edge beyond it, in these cells, is reported.
template <int Dim> InterfaceFault checkInterface(const Scene<Dim>& scene, double limit);

} // namespace mpm
