// SPDX-License-Identifier: GPL-2.0-or-later
// Stress that the material cannot bear: an update without strain, of a copy, says so.
#pragma once

#include "mpm/scene/Body.hpp"

namespace mpm {

struct BeyondYield {
    int count = 0, worst = 0; // particles; the one whose stress changes most,
    double change = 0;        // a component by so much, kPa
};

// Particles of which the update changes the state and, by more than `tolerance` of its largest component, the
// stress.
template <int Dim> BeyondYield beyondYield(const Body<Dim>& body, double tolerance);

} // namespace mpm
