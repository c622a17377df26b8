// SPDX-License-Identifier: GPL-2.0-or-later
// Driven parts of bodies: the nodes of which half of the mass or more is driven take the velocity of the
// drive. The driven part is looked up in every step: a part defined by height must not dive with the body.
#pragma once

#include "mpm/scene/Scene.hpp"

#include <algorithm>

namespace mpm {

// Least share of the mass of a node that is driven: a half, less what sums in another order may differ by.
// Where a part ends on a line of the grid all nodes of that line have a half.
constexpr double leastDriven = 0.5 * (1 - 1e-9);

// Numbers of the particles that a drive holds now; sets the drive's centre to their centre of mass.
template <int Dim> std::vector<int> drivenPart(const Body<Dim>& body, Constraint& drive) {
    std::vector<int> part;
    const auto& particles = body.particles;
    double mass = 0, centre[3] = {0, 0, 0};
    for (int p = 0; p < particles.size(); ++p) {
        bool inside = drive.ids.empty() ||
                      std::binary_search(drive.ids.begin(), drive.ids.end(), particles.id.integers()[p]);
        for (int k = 0; k < Dim && inside && drive.ids.empty(); ++k) {
            const double x = particles.position.plane(k)[p];
            inside = x > drive.lower[k] && x <= drive.upper[k];
        }
        if (!inside) continue;
        const double m = particles.mass.plane()[p];
        part.push_back(p);
        mass += m;
        for (int k = 0; k < Dim; ++k) centre[k] += m * particles.position.plane(k)[p];
    }
    for (int k = 0; k < 3; ++k) drive.centre[k] = mass > 0 ? centre[k] / mass : 0;
    return part;
}

// Beside a roller the mass of a node and its image counts together, and the drive holds the node. A drive that moves a
// body across the plane of the roller holds the ghost nodes, which then are no images.
template <int Dim>
void foldDrivenMass(const Scene<Dim>& scene, const Body<Dim>& body, const Constraint& drive,
                    std::vector<double>& nodalMass, std::vector<int>& touched) {
    for (const auto& image : scene.state.mirrors.images()) {
        if (image.field != body.velocityField) continue;
        bool crosses = false;
        for (int k = 0; k < Dim; ++k) crosses |= image.sign[k] < 0 && std::abs(drive.velocity[k]) > 0;
        if (crosses) continue;
        if (nodalMass[image.node] == 0) touched.push_back(image.node);
        nodalMass[image.node] +=
            nodalMass[image.ghost] - leastDriven * image.sum[NodalField<Dim>::mass] / body.inertiaScale;
        nodalMass[image.ghost] = 0;
    }
}

// nodalMass: scratch, zero on entry and exit.
template <int Dim> void holdDrivenNodes(Scene<Dim>& scene, std::vector<double>& nodalMass) {
    for (auto held = scene.state.driven.rbegin(); held != scene.state.driven.rend(); ++held)
        scene.grid.fields[held->field].holder[held->node][held->axis] = held->before;
    scene.state.driven.clear();
    scene.state.mirrors.find(scene.grid);
    std::vector<int> touched;
    for (int c = 0; c < int(scene.constraints.size()); ++c) {
        Constraint& drive = *scene.constraints[c];
        if (!drive.drivesBody() || !drive.active) continue;
        nodalMass.resize(scene.grid.count, 0.0);
        const Body<Dim>& body = *scene.body(drive.body);
        touched.clear();
        body.domains->addQuantity(body.particles.mass.plane(), drivenPart(body, drive), nodalMass.data(),
                                  touched);
        foldDrivenMass(scene, body, drive, nodalMass, touched);
        auto& field = scene.grid.fields[body.velocityField];
        for (int node : touched) {
            const bool isDriven =
                body.inertiaScale * nodalMass[node] > leastDriven * field.sum[node][NodalField<Dim>::mass];
            const auto isHeldByRoller = [&](int k) { // and goes on to be, where the drive does not cross it
                return drive.velocity[k] == 0 && scene.state.mirrors.isRoller(field.holder[node][k]);
            };
            for (int k = 0; k < Dim && isDriven; ++k)
                if (!std::isnan(drive.velocity[k]) && !isHeldByRoller(k)) {
                    scene.state.driven.push_back({body.velocityField, node, k, field.holder[node][k]});
                    field.holder[node][k] = short(c);
                }
            nodalMass[node] = 0;
        }
    }
}

} // namespace mpm
