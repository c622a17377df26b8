// SPDX-License-Identifier: GPL-2.0-or-later
#include "mpm/contact/ContactSearch.hpp"

namespace mpm {

template <int Dim> void ContactSearch<Dim>::clear() {
    nodes.clear();
    points.clear();
    pairs.clear();
}

template <int Dim> void ContactSearch<Dim>::prepare(const Scene<Dim>& scene) {
    clear();
    pair_.nearby.prepare(scene.grid);
    pair_.surfaces.resize(scene.bodies.size()); // bodies stay; a mesh that loses domains is looked at anew
    pair_.asksForSolution = false;
    step_ = -1;
}

// Which groups have explicit surfaces, and which outlines.
template <int Dim> void ContactSearch<Dim>::look(const Scene<Dim>& scene) {
    isExplicit_.assign(scene.groups.size(), true);
    hasOutline_.assign(scene.groups.size(), false);
    for (auto& body : scene.bodies) {
        if (!ExplicitSurface<Dim>::isOf(*body) && body->particles.size() > 0)
            isExplicit_[body->velocityField] = false;
        if (auto* boxes = body->domains->boxes(); boxes && boxes->outline())
            hasOutline_[body->velocityField] = true;
    }
}

template <int Dim>
void ContactSearch<Dim>::find(const Scene<Dim>& scene, const SearchRule& rule, bool isSolved) {
    clear();
    look(scene);
    step_ = scene.step;
    pair_.isSolved = isSolved;
    pair_.asksForSolution = false;
    pair_.scene = &scene;
    pair_.nodes = &nodes;
    const int groups = int(scene.groups.size());
    for (int a = 0; a < groups; ++a)
        for (int b = a + 1; b < groups; ++b) {
            const size_t firstPoint = points.size();
            pair_.first = nodes.size();
            for (int side = 0; side < 2; ++side) {
                const int field = pair_.field[side] = side == 0 ? a : b;
                pair_.isExplicit[side] = isExplicit_[field];
                pair_.hasOutline[side] = hasOutline_[field];
            }
            for (int side = 0; side < 2; ++side) {
                pair_.lastMotion[side] = rule.edgeMotions->template of<Dim>(pairOf(a, b), side);
                pair_.motion[side].setZero();
                pair_.edges[side] = 0;
            }
            pair_.ownsFacets =
                rule.owned == OwnedFacets::all || (rule.owned == OwnedFacets::ofMeshes && pair_.hasMesh());
            if (!findNodes(pair_)) continue;
            findSurfaces(pair_);
            findNormals(pair_, rule);
            findGaps(pair_);
            findPoints(pair_, points);
            pairs.push_back({pair_.first,
                             nodes.size(),
                             firstPoint,
                             points.size(),
                             pair_.ownsFacets,
                             {a, b},
                             {pair_.motion[0], pair_.motion[1]},
                             {pair_.edges[0] > 0, pair_.edges[1] > 0}});
        }
    if (scene.grid.isAxisymmetric) {
        for (auto& node : nodes) node.area *= scene.grid.thicknessAt(node.position[0]);
        for (auto& point : points) point.area *= scene.grid.thicknessAt(point.position[0]);
    }
    for (const auto& point : points)
        for (int corner = 0; corner < point.size; ++corner)
            nodes[point.contact[corner]].areaOfPoints += point.S[corner] * point.area;
}

template <int Dim> void ContactSearch<Dim>::findAhead(const Scene<Dim>& scene, const SearchRule& rule) {
    if (isFound(scene) || pair_.asksForSolution) return;
    find(scene, rule, false);
    if (pair_.asksForSolution) step_ = -1;
}

template class ContactSearch<2>;
template class ContactSearch<3>;

} // namespace mpm
