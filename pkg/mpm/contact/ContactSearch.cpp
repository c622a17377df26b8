// SPDX-License-Identifier: GPL-2.0-or-later
#include "mpm/contact/ContactSearch.hpp"

#include <algorithm>
#include <array>

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
    step_ = -1;
}

// Which groups have explicit surfaces, and which outlines.
template <int Dim> void ContactSearch<Dim>::look(const Scene<Dim>& scene) {
    isExplicit_.assign(scene.groupOf.size(), true);
    hasOutline_.assign(scene.groupOf.size(), false);
    for (auto& body : scene.bodies) {
        if (!ExplicitSurface<Dim>::isOf(*body) && body->particles.size() > 0)
            isExplicit_[body->velocityField] = false;
        if (auto* boxes = body->domains->boxes(); boxes && boxes->outline())
            hasOutline_[body->velocityField] = true;
    }
    for (size_t field = 0; field < isExplicit_.size(); ++field)
        isExplicit_[field] = isExplicit_[scene.groupOf[field]];
}

template <int Dim> void ContactSearch<Dim>::find(const Scene<Dim>& scene, const SearchRule& rule) {
    clear();
    look(scene);
    step_ = scene.step;
    pair_.scene = &scene;
    pair_.nodes = &nodes;
    const int groups = int(scene.groups.size());
    for (int a = 0; a < groups; ++a)
        for (int b = a + 1; b < groups; ++b) findPair(a, b, rule);
    if (scene.grid.isAxisymmetric) {
        for (auto& node : nodes) node.area *= scene.grid.thicknessAt(node.position[0]);
        for (auto& point : points) point.area *= scene.grid.thicknessAt(point.position[0]);
    }
    for (const auto& point : points)
        for (int corner = 0; corner < point.size; ++corner)
            nodes[point.contact[corner]].areaOfPoints += point.S[corner] * point.area;
}

// Of two groups, with all their fields.
template <int Dim> void ContactSearch<Dim>::findPair(int a, int b, const SearchRule& rule) {
    ContactPair<Dim> pair{};
    pair.firstNode = nodes.size();
    pair.firstPoint = points.size();
    pair_.firstOfGroups = nodes.size();
    pair_.owner = 0;
    pair.group[0] = a;
    pair.group[1] = b;
    Vec<Dim> motion[2] = {Vec<Dim>::Zero(), Vec<Dim>::Zero()};
    int edges[2] = {0, 0};
    const auto& groupOf = pair_.scene->groupOf;
    for (int fieldA = 0; fieldA < int(groupOf.size()); ++fieldA)
        for (int fieldB = 0; fieldB < int(groupOf.size()); ++fieldB) {
            if (groupOf[fieldA] != a || groupOf[fieldB] != b || !findFields(pair, fieldA, fieldB, rule))
                continue;
            for (int side = 0; side < 2; ++side) {
                motion[side] += pair_.edges[side] * pair_.motion[side];
                edges[side] += pair_.edges[side];
            }
        }
    pair.endNode = nodes.size();
    pair.endPoint = points.size();
    if (pair.firstNode == pair.endNode) return;
    pair_.first = pair.firstNode;
    if (pair.ownsFacets) shareFacets(pair_, points, pair.firstPoint);
    for (int side = 0; side < 2; ++side) {
        pair.hasEdges[side] = edges[side] > 0;
        pair.motionOfEdges[side] = motion[side] / std::max(1, edges[side]);
    }
    findTwins(pair);
    pairs.push_back(pair);
}

// Of one field of each group; false: they do not meet.
template <int Dim>
bool ContactSearch<Dim>::findFields(ContactPair<Dim>& pair, int a, int b, const SearchRule& rule) {
    pair_.first = nodes.size();
    for (int side = 0; side < 2; ++side) {
        const int field = pair_.field[side] = side == 0 ? a : b;
        pair_.isExplicit[side] = isExplicit_[field];
        pair_.hasOutline[side] = hasOutline_[field];
        const size_t number = pairOf(pair.group[0], pair.group[1]);
        pair_.lastMotion[side] = rule.edgeMotions->template of<Dim>(number, side);
        pair_.lastDirection[side] = rule.edgeMotions->template directionOf<Dim>(number, side);
        pair_.motion[side].setZero();
        pair_.edges[side] = 0;
    }
    pair.ownsFacets = pair_.ownsFacets =
        rule.owned == OwnedFacets::all || (rule.owned == OwnedFacets::ofMeshes && pair_.hasMesh());
    if (!findNodes(pair_)) return false;
    findSurfaces(pair_);
    findNormals(pair_, rule);
    findGaps(pair_);
    findPoints(pair_, points);
    return true;
}

// A wall between two soils is in contact with both on one node.
template <int Dim> void ContactSearch<Dim>::findTwins(const ContactPair<Dim>& pair) {
    std::vector<std::array<int, 4>> rows; // field, node, row and side
    for (size_t i = pair.firstNode; i < pair.endNode; ++i)
        for (int side = 0; side < 2; ++side)
            rows.push_back({nodes[i].field[side], nodes[i].node, int(i), side});
    std::sort(rows.begin(), rows.end());
    for (size_t i = 1; i < rows.size(); ++i) {
        const auto [field, node, row, side] = rows[i - 1];
        const auto [otherField, otherNode, other, otherSide] = rows[i];
        if (field != otherField || node != otherNode) continue;
        nodes[row].twin[side] = other;
        nodes[other].twin[otherSide] = row;
    }
}

template class ContactSearch<2>;
template class ContactSearch<3>;

} // namespace mpm
