// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "mpm/scene/Scene.hpp"

namespace mpm {

struct CriticalStep {
    double dt = 0; // s, the scheme's stabilityLimit times 2 / omega_max
    int iterations = 0;
    std::string stiffest; // body in which the fastest mode moves most
};

// Largest stable time step of the scene as it stands: 2/omega_max of M^-1 K, K the elastic stiffness of the
// assembled grid problem (ElasticOperator.hpp).
template <int Dim> CriticalStep criticalTimeStep(Scene<Dim>& scene, double tolerance = 1e-4, int most = 300);

} // namespace mpm
