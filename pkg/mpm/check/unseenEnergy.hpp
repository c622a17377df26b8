// SPDX-License-Identifier: GPL-2.0-or-later
// Kinetic energy that particles have and nodes do not feel: of their motion against the velocity field of the nodes.
#pragma once

#include "mpm/scene/Scene.hpp"

namespace mpm {

// kinetic: energy of the particles, kJ. Particles of a node with the velocity v, the mean of theirs or prescribed, have
// sum m (v_p - v)^2 / 2 of their own.
template <int Dim> double unseenEnergy(Scene<Dim>& scene, double kinetic);

} // namespace mpm
