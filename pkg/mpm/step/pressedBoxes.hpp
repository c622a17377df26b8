// SPDX-License-Identifier: GPL-2.0-or-later
// Boxes that rigid bodies press on: the parts of them that count in other cells, see scene/BoxParts.hpp. One thread.
#pragma once

#include "mpm/scene/Scene.hpp"

namespace mpm {

// Where boxes reach beyond a cell that acts whole, or into one, within two cells of those that were pressed.
template <int Dim> void findBoxParts(Scene<Dim>& scene) {
    const Grid<Dim>& grid = scene.grid;
    auto& parts = scene.state.pressed.parts;
    auto& pressed = scene.state.pressed.cells;
    parts.resize(scene.bodies.size());
    for (auto& of : parts) of.clear();
    for (auto& of : pressed) of.second.reset(grid);
    scene.template forRoles<PressingOnBoxes>([&](const PressingOnBoxes& pressing) {
        pressing.forPressed([&](int soil, const Vec3& where) {
            if (!actsByCells(*scene.bodies.at(soil)) || !scene.bodies[soil]->domains->boxes()) return;
            int number = 0;
            for (int k = 0; k < Dim; ++k) grid.addCells(k, &where[k], 1, &number);
            const auto [at, isNew] = pressed.try_emplace(soil);
            if (isNew) at->second.reset(grid);
            at->second.add(number);
        });
    });
    for (auto& [b, cells] : pressed) {
        if (cells.empty()) continue;
        const Body<Dim>& body = *scene.bodies[b];
        cells.widen(grid);
        cells.setInside([&](int cell) {
            double inside = 0;
            for (auto& other : scene.bodies)
                if (other->velocityField == body.velocityField && actsByCells(*other))
                    if (const auto* at = std::as_const(other->cellAverage).occupied(cell))
                        inside = std::max(inside, at->inside);
            return inside;
        });
        cells.findEdges(grid, [&](int cell) { return body.cellAverage.occupied(cell) != nullptr; });
        if (!cells.edges().empty()) parts[b].find(body, grid, cells);
    }
}

// The forces of the parts, once the nodes have those of the cells.
template <int Dim> void addBoxParts(Scene<Dim>& scene) {
    for (size_t b = 0; b < scene.state.pressed.parts.size(); ++b)
        if (const auto* parts = scene.state.pressed.of(b))
            parts->addForces(*scene.bodies[b], scene.grid.fields[scene.bodies[b]->velocityField].sum.data());
}

} // namespace mpm
