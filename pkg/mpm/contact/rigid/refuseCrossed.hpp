// SPDX-License-Identifier: GPL-2.0-or-later
// Refuses what a penalty cannot push back to the side it came from.
#pragma once

#include "mpm/contact/rigid/BodyPoints.hpp"
#include "mpm/contact/rigid/RigidContactPoint.hpp"

namespace mpm {

// Throws RunError where a point of the scene is as deep in a rigid body as it is wide (of a box: half of that
// beyond its centre), or has passed through a thin shape. points: of its body.
template <int Dim>
void refuseCrossed(const Scene<Dim>& scene, const BodyPoints<Dim>& points, const RigidContactPoint& contact,
                   const RigidShape& shape, const std::vector<RigidContactPoint>& before);

} // namespace mpm
