// SPDX-License-Identifier: GPL-2.0-or-later
// The scene of the benchmark: a square (cubic) block of soil, two particles per cell and direction, that is
// squeezed from above at a constant rate and yields in every step.
//
// The stress at the start is geostatic and, below a few particles, beyond yield; squeezing keeps it there.
// The inertia is scaled up so far that stress and weight hardly change the motion: it stays the one given,
// hence every particle yields however many steps are taken, the block nowhere breaks or flows, and uGIMP,
// APDI and both materials go through the same motion. It is slow, 2e-7 of strain per step, so that 2 million
// particles in 2D stay in the grid for 28,000 steps and smaller blocks longer. No particle leaves its cell:
// what re-sorting costs a scene that flows is not in the figures.
#pragma once

#include "mpm/scene/Scene.hpp"

namespace mpm {

// type: ugimp, apdi, or hybrid (lower half APDI); material: name of a class; particles: about that many.
template <int Dim>
std::unique_ptr<Scene<Dim>> soilBlock(const std::string& type, const std::string& material, int particles);

} // namespace mpm
