// SPDX-License-Identifier: GPL-2.0-or-later
// Where soil is in the cells and on the nodes of the grid, for SharedCells.
#pragma once

#include "mpm/scene/Scene.hpp"

namespace mpm {

// f(cell, along how many axes it is beside) for the cells of the grid beside one.
template <int Dim, class F> void forCellsBeside(const Grid<Dim>& grid, int cell, F&& f) {
    forAround(grid, cell, [&](int other, int axes) {
        if (axes > 0) f(other, axes);
    });
}

// Of the bodies of a soil on a node, or so far of its meshes, m3. They have about one density: that of the first.
template <int Dim> double volumeOfSoil(const Scene<Dim>& scene, int group, int node, bool ofMeshes) {
    double density = 0;
    for (auto& body : scene.bodies)
        if (density == 0 && body->velocityField == scene.groupOf[group] &&
            (!ofMeshes || body->domains->mesh()))
            density = body->material->density;
    const auto& field = scene.grid.fields[group];
    return density > 0 && scene.grid.mayHaveMass(field, node)
               ? field.sum[node][NodalField<Dim>::weightMass] / density
               : 0;
}

// Volume of what has F-bar of a group in a cell over that of the cell.
template <int Dim> double coverOf(const Scene<Dim>& scene, int group, int cell) {
    double sum = 0;
    for (auto& body : scene.bodies)
        if (body->velocityField == group && body->fbar) sum += body->cellAverage.coverOf(cell);
    return sum;
}

// The volume of a parted soil in a cell, over that of the cell, on the side of the cell's number.
template <int Dim> double coverOnSide(const Scene<Dim>& scene, int group, int number) {
    double sum = 0;
    for (auto& body : scene.bodies) {
        if (body->velocityField != group || !body->fbar || body->particles.size() == 0) continue;
        if (const auto* cell = body->cellAverage.occupied(number)) sum += cell->volume / cell->whole;
    }
    return sum;
}

} // namespace mpm
