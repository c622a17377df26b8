// SPDX-License-Identifier: GPL-2.0-or-later
// Which points of the scene overlap with rigid bodies, and what they were in the step before.
#pragma once

#include "mpm/contact/rigid/BodyPoints.hpp"
#include "mpm/contact/rigid/RigidContactPoint.hpp"

namespace mpm {

// Points that overlap or nearly do. points: of each body of the scene.
template <int Dim>
std::vector<RigidContactPoint>
findNearContacts(const Scene<Dim>& scene, const std::vector<BodyPoints<Dim>>& points,
                 const std::vector<RigidShape>& shapes, const std::vector<RigidState>& states);

// Of points that nearly overlap, those that do where they would be had they moved as they are strained.
template <int Dim>
void moveToStrainedPlaces(const Scene<Dim>& scene, std::vector<RigidContactPoint>& contacts);

// Of the contacts of a pair that look the same way only the deepest counts (flush boxes of a clump,
// neighbouring facets), and none at an edge that is hidden in the surface of a shape which is touched more
// deeply. Sorts them.
void dropRepeats(std::vector<RigidContactPoint>& contacts, const std::vector<RigidShape>& shapes);

// Slip and last place of contacts that were there in the step before; the slip turns with the normal. Both
// are sorted.
void remember(std::vector<RigidContactPoint>& contacts, const std::vector<RigidContactPoint>& before);

} // namespace mpm
