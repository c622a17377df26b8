// SPDX-License-Identifier: GPL-2.0-or-later
// Domains taken out of a mesh, as they are converted.
#pragma once

#include "mpm/particle/apdi/DomainMesh.hpp"

namespace mpm {

// A hanging vertex whose coarse neighbour goes is free again.
template <int Dim> void releaseSlaves(DomainMesh<Dim>& mesh, const std::vector<int>& gone) {
    constexpr int NC = corners<Dim>;
    auto& hanging = mesh.vertices.hanging;
    hanging.select([&](int s) {
        return std::none_of(gone.begin(), gone.end(), [&](int p) {
            bool all = true;
            hanging.eachMaster(s, [&](int v, double) {
                all &= std::count(&mesh.corner[NC * p], &mesh.corner[NC * p] + NC, v) > 0;
            });
            return all;
        });
    });
}

// Vertices that no domain uses, nor a hanging vertex that one uses, go too; the others get new numbers.
template <int Dim> void removeUnusedVertices(DomainMesh<Dim>& mesh) {
    auto& vertices = mesh.vertices;
    std::vector<char> used(vertices.size(), 0);
    for (int v : mesh.corner) used[v] = 1;
    for (int s = 0; s < vertices.hanging.count(); ++s)
        if (used[vertices.hanging.slaves[s]])
            vertices.hanging.eachMaster(s, [&](int v, double) { used[v] = 1; });
    std::vector<int> kept, number(vertices.size(), -1);
    for (int v = 0; v < vertices.size(); ++v) {
        if (!used[v]) continue;
        number[v] = int(kept.size());
        kept.push_back(v);
    }
    for (int& v : mesh.corner) v = number[v];
    vertices.hanging.select([&](int s) { return used[vertices.hanging.slaves[s]] != 0; });
    vertices.hanging.renumber(number);
    vertices.select(kept);
}

// Returns the numbers of the domains that stay.
template <int Dim> std::vector<int> removeDomains(DomainMesh<Dim>& mesh, const std::vector<int>& gone) {
    constexpr int NC = corners<Dim>;
    releaseSlaves(mesh, gone);
    std::vector<char> stays(mesh.domains(), 1);
    for (int p : gone) stays[p] = 0;
    std::vector<int> kept, corner;
    for (int p = 0; p < mesh.domains(); ++p) {
        if (!stays[p]) continue;
        kept.push_back(p);
        corner.insert(corner.end(), &mesh.corner[NC * p], &mesh.corner[NC * p] + NC);
    }
    mesh.corner = corner;
    removeUnusedVertices(mesh);
    return kept;
}

} // namespace mpm
