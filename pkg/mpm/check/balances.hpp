// SPDX-License-Identifier: GPL-2.0-or-later
// Sums over nodes and particles as the last step left them, for checks and certificates. One after the other
// on one thread: the same last digits for any number of threads.
#pragma once

#include "mpm/scene/Scene.hpp"

namespace mpm {

// f(field, node) for all nodes that particles touch.
template <int Dim, class F> void forTouchedNodes(const Scene<Dim>& scene, F&& f) {
    for (const auto& field : scene.grid.fields)
        for (int slab = 0; slab < scene.grid.slabs(); ++slab)
            scene.grid.forNodes(field, slab, [&](int node) { f(field, node); });
}

// Of the last ParticleToGrid.
template <int Dim> struct NodalTotals {
    double mass = 0;                                                // Mg
    Vec<Dim> momentum = Vec<Dim>::Zero(), force = Vec<Dim>::Zero(); // kN s, kN
};
template <int Dim> NodalTotals<Dim> nodalTotals(const Scene<Dim>& scene);

// Kinetic energy of all nodes as the solution or contact left them, kJ.
template <int Dim> double nodalEnergy(const Scene<Dim>& scene);

// How far the last step was from rest: inertia against stress.
struct Balance {
    double inertia = 0;  // sum of |m a| over the nodes, kN
    int nodes = 0;       // that have mass
    double stressed = 0; // sum of V |sigma| / h over the particles, kN, h the smallest edge of the cell
};
template <int Dim> Balance balanceOf(const Scene<Dim>& scene);

// Of the particles of a body, without inertial scaling.
template <int Dim> struct BodyMotion {
    Vec<Dim> momentum = Vec<Dim>::Zero(); // kN s
    double kineticEnergy = 0;             // kJ
};
template <int Dim> BodyMotion<Dim> motionOf(const Body<Dim>& body);

// Height and mean stress of a particle.
struct MeanStress {
    double height, stress; // m, kPa
};
// Of the particles of a 2D body within `reach` of the vertical line at x, between two heights.
template <int Dim>
std::vector<MeanStress> meanStressesAlong(const Body<Dim>& body, double x, double reach, double lower,
                                          double upper);

// Number of particles with det F <= 0. Of a box that is stretched without end round-off leaves no det F: its volume
// is kept beside (keepVolumes).
template <int Dim> int invertedParticles(const Body<Dim>& body);

// Volume of the particles in the cells that lie inside the material, and of these cells, m3 (2D: m2): those that
// hold a particle's centre, as all cells around them do; what is outside of the grid does not count.
struct InnerVolumes {
    double particles = 0, cells = 0;
};
template <int Dim> InnerVolumes innerVolumes(const Scene<Dim>& scene);

} // namespace mpm
