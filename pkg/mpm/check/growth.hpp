// SPDX-License-Identifier: GPL-2.0-or-later
// What the squares of the frequencies of a body are proportional to, as its particles stand.
#pragma once

#include "mpm/scene/Scene.hpp"

namespace mpm {

// Largest among the particles: the bulk and the shear modulus by Material::stiffness(), times V/V0 and the
// mean over the axes of (smallest cell of the grid/cell of the particle)^2, kPa.
struct PresentStiffness {
    double bulk = 0, shear = 0;
};

template <int Dim> PresentStiffness presentStiffness(const Grid<Dim>& grid, Body<Dim>& body);

// Of a body whose moduli follow the pressure (FollowingPressure) the largest bulk modulus among the particles, kPa: as they
// stand, and at most after a step in which a particle that is stopped by its neighbour is strained by its way over the
// smallest cell. Of others 0.
struct ReachedStiffness {
    double now = 0, reached = 0;
};

template <int Dim> ReachedStiffness reachedStiffness(const Grid<Dim>& grid, Body<Dim>& body, double dt);

} // namespace mpm
