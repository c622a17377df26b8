// SPDX-License-Identifier: GPL-2.0-or-later
// Pieces of the step that more than one engine uses; all are called by every thread of a team.
#pragma once

#include "mpm/state/Scene.hpp"

namespace mpm {

// f(node) for every node the particles touch, slab by slab.
template <int Dim, class F> void forActiveNodes(Team& team, const Scene<Dim>& scene, F&& f) {
    team.forEach(scene.grid.slabs(), [&](int slab) { scene.grid.forNodes(slab, f); });
}

// Sums of mass, momentum and force on the nodes, from the particles where locate() found them.
template <int Dim> void sumOnNodes(Team& team, Scene<Dim>& scene, bool withForce) {
    for (auto& field : scene.grid.fields)
        forActiveNodes(team, scene, [&](int node) { field.sum[node] = NodalField<Dim>::Sum::zero(); });
    for (auto& body : scene.bodies)
        body->domains->addSum(team, scene.grid.fields[body->velocityField].sum.data(), body->inertiaScale, withForce);
}

// Turns nodal momentum {p} into the velocity that enters the velocity gradient, boundary values imposed.
template <int Dim, class Momentum>
void velocityFrom(Team& team, Scene<Dim>& scene, NodalField<Dim>& field, double time, Momentum&& momentum) {
    using NF = NodalField<Dim>;
    const double least = scene.leastMass();
    forActiveNodes(team, scene, [&](int node) {
        const double m = field.sum[node][NF::mass];
        Pack<4> v = Pack<4>::zero();
        if (m > least)
            for (int k = 0; k < Dim; ++k) {
                const int c = scene.holder[k][node];
                v.set(k, c < 0 ? momentum(node, k) / m : scene.prescribed(c, k, time));
            }
        field.velocity[node] = v;
    });
}

} // namespace mpm
