// SPDX-License-Identifier: GPL-2.0-or-later
// Pieces of the step that more than one engine uses; all are called by every thread of a region.
#pragma once

#include "mpm/scene/Scene.hpp"
#include "mpm/step/CellForces.hpp"

namespace mpm {

// f(node) for every node that the particles of a field touch, slab by slab.
template <int Dim, class F>
void forActiveNodes(ParallelRegion& region, const Scene<Dim>& scene, const NodalField<Dim>& field, F&& f) {
    region.forPieces(field.partition, [&](int slab) { scene.grid.forNodes(field, slab, f); });
}

// The images of nodes behind rollers strain particles as the nodes before them do.
template <int Dim> void reflectVelocity(Scene<Dim>& scene, int f) {
    auto& field = scene.grid.fields[f];
    scene.state.mirrors.reflectValues(
        f, [&](int node, int k) { return field.velocityOf(node, k); },
        [&](int ghost, int k, double v) { field.setVelocity(ghost, k, v); });
}

// Finds everything in the grid, and what part of the grid is touched. mayDecide: see PartedSoils::divide().
template <int Dim> void locateParticles(ParallelRegion& region, Scene<Dim>& scene, bool mayDecide) {
    do { // once more after sorting
        for (auto& body : scene.bodies) body->domains->locate(region);
        region.wait();
        region.once([&] {
            scene.state.sorted = false;
            if (region.failed()) return;
            for (auto& body : scene.bodies) scene.state.sorted |= body->domains->resort();
            if (scene.state.sorted) return;
            for (auto& field : scene.grid.fields) field.forgetExtents();
            for (auto& body : scene.bodies)
                body->domains->order.markExtents(scene.grid.fields[body->velocityField]);
            scene.state.parted.divide(scene, mayDecide);
            for (auto& field : scene.grid.fields) field.partitionNodes();
            scene.state.located = true;
        });
    } while (scene.state.sorted);
}

// Of some cells, sorted, those with a corner that the bodies of a field give no mass to.
template <int Dim>
std::vector<int> withMasslessCorners(const Scene<Dim>& scene, int field, std::vector<int> cells) {
    if (cells.empty()) return cells;
    const Grid<Dim>& grid = scene.grid;
    std::vector<char> isNear(grid.count); // cells whose particles may reach a corner
    for (int cell : cells)
        forAround(grid, cell, [&](int beside, int) {
            forAround(grid, beside, [&](int beyond, int) { isNear[beyond] = 1; });
        });
    std::vector<double> mass(grid.count);
    for (auto& body : scene.bodies) {
        const auto& particles = body->particles;
        for (int begin = 0; body->velocityField == field && begin < particles.size(); begin += chunkSize) {
            const int count = std::min(chunkSize, particles.size() - begin);
            int cell[chunkSize] = {};
            for (int k = 0; k < Dim; ++k) grid.addCells(k, particles.position.plane(k) + begin, count, cell);
            for (int i = 0; i < count; ++i) {
                if (!isNear[cell[i]]) continue;
                const double inertia = body->inertiaScale * particles.mass.plane()[begin + i];
                body->domains->weights(
                    begin + i, [&](int node, double phi, const Vec<Dim>&) { mass[node] += phi * inertia; });
            }
        }
    }
    const auto isWhole = [&, least = scene.leastMass()](int cell) {
        bool is = true;
        for (int a = 0; a < corners<Dim>; ++a) is &= mass[cornerOf(grid, cell, a)] > least;
        return is;
    };
    cells.erase(std::remove_if(cells.begin(), cells.end(), isWhole), cells.end());
    return cells;
}

template <int Dim> void findInside(ParallelRegion& region, const Scene<Dim>& scene, Body<Dim>& body) {
    if (!actsByCells(body)) return;
    std::vector<CellAverage<Dim>*> others;
    std::vector<const Body<Dim>*> strangers; // whose cells are not known
    for (auto& other : scene.bodies)
        if (other->fbar && other->velocityField == body.velocityField) {
            if (other.get() != &body) others.push_back(&other->cellAverage);
        } else {
            strangers.push_back(other.get());
        }
    const auto isFree = [&](int cell) {
        const Index<Dim> lowest = scene.grid.indices(cell);
        Index<Dim> highest = lowest;
        for (int k = 0; k < Dim; ++k) ++highest[k];
        return std::none_of(strangers.begin(), strangers.end(), [&](const Body<Dim>* other) {
            return other->domains->order.mayTouch(lowest, highest);
        });
    };
    const bool hasMesh = std::any_of(scene.bodies.begin(), scene.bodies.end(), [&](const auto& other) {
        return other->velocityField == body.velocityField && other->fbar && other->domains->mesh();
    }); // boxes give mass to all corners of their cells
    const auto lackMass = [&](const std::vector<int>& cells) {
        return hasMesh ? withMasslessCorners(scene, body.velocityField, cells) : std::vector<int>();
    };
    body.cellAverage.findInside(region, scene.grid, others, body.material->volumeRecord().opening >= 0,
                                isFree, lackMass);
}

// Which particles of a body with F-bar are in which cell.
template <int Dim> void locateCells(ParallelRegion& region, const Scene<Dim>& scene, Body<Dim>& body) {
    Mesh<Dim>* const mesh = body.domains->mesh();
    const bool isAmongBoxes =
        mesh && std::any_of(scene.bodies.begin(), scene.bodies.end(), [&](const auto& other) {
            return other->velocityField == body.velocityField && other->fbar && other->domains->boxes() &&
                   other->particles.size() > 0;
        });
    const auto* boxes = body.domains->boxes();
    const double half = boxes ? boxes->halfSize()[0] : 0;
    body.cellAverage.locate(region, body.particles, scene.grid, mesh, isAmongBoxes, half,
                            scene.state.parted.secondCells(body));
}

// Which particles are in which cell, for the bodies with F-bar, and how far inside of the material the cells of
// boxes lie: of all these bodies that move together, for a bonded neighbour is no surface.
template <int Dim> void locateCells(ParallelRegion& region, Scene<Dim>& scene) {
    for (auto& body : scene.bodies)
        if (body->fbar) locateCells(region, scene, *body);
    for (auto& body : scene.bodies) findInside(region, scene, *body);
}

// Sums of mass, momentum and force on the nodes, from the particles where locate() found them.
// cells: room for each body, with forces. isShared: whether cells of the grid may be shared.
template <int Dim>
void sumOnNodes(ParallelRegion& region, Scene<Dim>& scene, std::vector<CellForces>* cells, bool isShared) {
    const bool withForce = cells != nullptr;
    for (auto& field : scene.grid.fields)
        forActiveNodes(region, scene, field,
                       [&](int node) { field.sum[node] = NodalField<Dim>::Sum::zero(); });
    if (withForce) region.once([&] { cells->resize(scene.bodies.size()); });
    const auto add = [&](size_t b) {
        auto& body = *scene.bodies[b];
        auto& field = scene.grid.fields[body.velocityField];
        const bool byCells = withForce && actsByCells(body);
        const ActingStress stress =
            byCells ? (*cells)[b].divide(region, body, scene.grid, *scene.state.sharedCells)
                    : ActingStress(body.particles.stress);
        body.domains->addSum(region, field.sum.data(), body.inertiaScale, withForce ? &stress : nullptr);
        if (byCells) CellForces::add(region, body, scene.grid);
    };
    // Which cells are shared depends on the masses of the bodies that do not act by cells: those come first then.
    const auto comesLater = [&](const Body<Dim>& body) { return isShared && actsByCells(body); };
    for (size_t b = 0; b < scene.bodies.size(); ++b)
        if (!comesLater(*scene.bodies[b])) add(b);
    if (!isShared) return;
    region.once([&] { scene.state.sharedCells->find(scene); });
    for (size_t b = 0; b < scene.bodies.size(); ++b)
        if (comesLater(*scene.bodies[b])) add(b);
    region.once([&] {
        scene.state.sharedCells->takeVolumes(scene);
        if (withForce) scene.state.sharedCells->addForces(scene);
    });
}

} // namespace mpm
