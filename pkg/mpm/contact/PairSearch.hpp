// SPDX-License-Identifier: GPL-2.0-or-later
// The pair of groups that is searched for contact, and the steps of that search: each is one file and fills
// in some members of the contact nodes. Side 0 is the first group, side 1 the second; normals point from 0 to
// 1.
#pragma once

#include "mpm/contact/ContactNode.hpp"
#include "mpm/contact/EdgeMotions.hpp"
#include "mpm/contact/NearbyBoxes.hpp"

#include <algorithm>

namespace mpm {

// Flatness below which a surface has an edge. Flatness is what a surface has left of its area when its
// directions are added up: 1 for a plane, 0.71 at a right edge.
constexpr double edgeFlatness = 0.9;

// Where each facet of a mesh belongs to a contact point or to nodes, never to both.
enum class OwnedFacets { none, ofMeshes, all };

// How contact is searched for.
struct SearchRule {
    bool turnsAtEdges; // normals towards where an edge of a mesh moves; not where surfaces cannot part
    OwnedFacets owned;
    const EdgeMotions* edgeMotions; // how edges last moved
};

template <int Dim> struct PairSearch {
    using Vertex = typename ExplicitSurface<Dim>::Vertex;

    const Scene<Dim>* scene = nullptr;
    std::vector<ContactNode<Dim>>* nodes = nullptr; // of all pairs; those of this pair come last,
    size_t first = 0;                               // from this one on,
    size_t firstOfGroups = 0; // after those of the same groups with other fields, from this one on
    int field[2];             // numbers of the groups
    int owner = 0;            // which of them owns facets
    bool isExplicit[2];       // whether their surface is explicit altogether
    bool hasOutline[2];       // whether they have boxes that carry an outline
    bool ownsFacets;          // see OwnedFacets
    Vec<Dim> lastMotion[2], lastDirection[2]; // of the edges of each group, see EdgeMotions,
    Vec<Dim> motion[2];                       // and how they move now, in the mean,
    int edges[2];                             // of so many nodes

    NearbyNodes<Dim> nearby;
    NearbyBoxes<Dim> boxes[2];
    NearbyBoxes<Dim> partners[2]; // of the other field of a soil, which counts where both are one,
    NearbyBoxes<Dim> sided[2];    // and those of this one that have a side
    std::vector<ExplicitSurface<Dim>> surfaces; // per body of the scene

    // Whether a soil that a wall parts is one on a node.
    bool isBonded(int node) const {
        return scene->state.parted.isBonded(field[0], node) || scene->state.parted.isBonded(field[1], node);
    }
    // The contact node of the first field where both fields of a soil are one; -1: there is none.
    int bondedNode(int node) const {
        const auto begin = nodes->begin() + firstOfGroups, end = nodes->begin() + first;
        const auto found =
            std::lower_bound(begin, end, node, [](const auto& contact, int n) { return contact.node < n; });
        return found != end && found->node == node && isBonded(node) ? int(found - nodes->begin()) : -1;
    }
    // A vertex as this field of a soil sees it. Where the soil is one on all nodes round it, its first field is all
    // there is. false: it does not see the vertex.
    bool see(const Body<Dim>& body, const ExplicitSurface<Dim>& surface, Vertex& vertex) const {
        if (scene->state.parted.partnerOf(field[0]) < 0 && scene->state.parted.partnerOf(field[1]) < 0)
            return true;
        bool isOne = true;
        double part[Dim];
        nearby.forCorners(grid(), vertex.position, part, [&](int corner, int node) {
            int& contact = vertex.around.contact[corner];
            if (contact < 0) contact = bondedNode(node);
            if (vertex.around.S[corner] > 0) isOne &= isBonded(node);
        });
        if (isOne && vertex.number >= 0) vertex = surface.whole(body, vertex);
        return !isOne || (scene->state.parted.isFirst(field[0]) && scene->state.parted.isFirst(field[1]));
    }
    // What the other group does not see of a body of a side, see PartedSoils.
    Vec<Dim> hidden(int side, const Body<Dim>& body) const {
        const auto is = [&](const auto& other) { return other.get() == &body; };
        const auto found = std::find_if(scene->bodies.begin(), scene->bodies.end(), is);
        return scene->state.parted.hiddenFrom(field[1 - side], int(found - scene->bodies.begin()));
    }

    const Grid<Dim>& grid() const { return scene->grid; }
    const NodalField<Dim>& fieldOf(int side) const { return scene->grid.fields[field[side]]; }

    // Whether constraints hold both groups along an axis, as at a plane of symmetry. A group that is driven
    // whole is held everywhere, and tells nothing of the other.
    bool areBothHeld(int node, int axis) const {
        return fieldOf(0).holder[node][axis] >= 0 && fieldOf(1).holder[node][axis] >= 0;
    }

    // Whether a vertex lies on a plane of symmetry across an axis: constraints hold both groups there.
    bool isOnPlane(const Vertex& vertex, int axis) const {
        return vertex.across[axis] > 0 && areBothHeld(vertex.node, axis) &&
               std::abs(vertex.position[axis] - grid().nodePosition(vertex.node)[axis]) <
                   PlaceInCell::roundOff * grid().sizeAt(vertex.position)[axis];
    }
    // Facets on a plane of symmetry are no surface: the surface goes on beyond.
    Vertex withoutPlanes(Vertex vertex) const {
        for (int k = 0; k < Dim; ++k) {
            if (!isOnPlane(vertex, k)) continue;
            vertex.outward[k] = 0;
            vertex.extent -= vertex.across[k];
        }
        vertex.size = vertex.outward.norm();
        return vertex;
    }

    // Whether one of them is of meshes alone, and none has boxes that carry an outline.
    bool hasMesh() const { return (isExplicit[0] || isExplicit[1]) && !hasOutline[0] && !hasOutline[1]; }

    // f(contact node) for those of this pair.
    template <class F> void forNodes(F&& f) const {
        for (size_t i = first; i < nodes->size(); ++i) f((*nodes)[i]);
    }
    // The contact node at a node of the grid; nullptr: there is none.
    ContactNode<Dim>* at(int node) const {
        const int number = nearby.contact(node);
        return number < 0 ? nullptr : &(*nodes)[number];
    }
    // f(body, surface) for those bodies of a group that have an explicit one, not for bodies that take what
    // these convert.
    template <class F> void forSurfaces(int side, F&& f) {
        for (size_t b = 0; b < scene->bodies.size(); ++b)
            if (Body<Dim>& body = *scene->bodies[b];
                body.velocityField == field[side] && ExplicitSurface<Dim>::isOf(body))
                f(body, surfaces[b]);
    }
};

// The nodes on which both groups have mass; false: there are none.
template <int Dim> bool findNodes(PairSearch<Dim>& pair);
// What the nodes see of the surfaces.
template <int Dim> void findSurfaces(PairSearch<Dim>& pair);
template <int Dim> void findNormals(PairSearch<Dim>& pair, const SearchRule& rule);
// Gaps and areas.
template <int Dim> void findGaps(PairSearch<Dim>& pair);
// Vertices of meshes between the nodes.
template <int Dim> void findPoints(PairSearch<Dim>& pair, std::vector<ContactPoint<Dim>>& points);
// What nodes and points have of the surface, those of all fields of two groups: points from number `first` on.
template <int Dim>
void shareFacets(const PairSearch<Dim>& pair, std::vector<ContactPoint<Dim>>& points, size_t first);

} // namespace mpm
