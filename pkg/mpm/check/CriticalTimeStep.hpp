// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "mpm/scene/Scene.hpp"

namespace mpm {

struct CriticalStep {
    double dt = 0;     // s, the smaller one of 2/omega_max of the grid problem and the longest stable step
    double ofGrid = 0; // s, 2/omega_max
    double longestStable = 0; // s, of the scheme, with flip and local damping
    int iterations = 0;
    std::string stiffest; // body in which the fastest mode moves most
};

// Of the scene as it stands, linear elastic: doc/explanation/time-step.md. Of bodies that are solved for implicitly the mass
// counts and the stiffness does not, unless they are to count like the others (asIfExplicit).
template <int Dim>
CriticalStep criticalTimeStep(Scene<Dim>& scene, double tolerance = 1e-4, int most = 300,
                              bool asIfExplicit = false);

} // namespace mpm
