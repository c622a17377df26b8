// SPDX-License-Identifier: GPL-2.0-or-later
// The nodes on which two groups are in contact, and the surfaces as these nodes see them: int phi n dA and
// int phi d n^T dA, d from the node. Both are sums over the facets of a mesh, or, by the theorem of Gauss,
// over boxes.
#include "mpm/contact/PairSearch.hpp"

namespace mpm {

template <int Dim> bool findNodes(PairSearch<Dim>& pair) {
    const Grid<Dim>& grid = pair.grid();
    const auto &fieldA = pair.fieldOf(0), &fieldB = pair.fieldOf(1);
    const double least = pair.scene->leastMass();
    pair.nearby.clear();
    for (int slab = 0; slab < grid.slabs(); ++slab) {
        auto both = fieldA.extents[slab];
        for (int k = 0; k < Dim - 1; ++k) {
            both.first[k] = std::max(both.first[k], fieldB.extents[slab].first[k]);
            both.last[k] = std::min(both.last[k], fieldB.extents[slab].last[k]);
        }
        grid.forNodes(both, slab, [&](int node) {
            if (!(fieldA.sum[node][NodalField<Dim>::mass] > least &&
                  fieldB.sum[node][NodalField<Dim>::mass] > least))
                return;
            pair.nearby.add(grid, node, int(pair.nodes->size()));
            pair.nodes->emplace_back();
            ContactNode<Dim>& contact = pair.nodes->back();
            contact.node = node;
            contact.field[0] = pair.field[0];
            contact.field[1] = pair.field[1];
            contact.position = grid.nodePosition(node);
        });
    }
    pair.nearby.finish();
    return pair.nodes->size() > pair.first;
}

namespace {

template <int Dim>
void addParts(PairSearch<Dim>& pair, int side,
              const std::vector<typename PairSearch<Dim>::Vertex>& vertices) {
    for (const auto& one : vertices) {
        const auto vertex = pair.withoutPlanes(one);
        for (int corner = 0; corner < vertex.around.size; ++corner) {
            if (vertex.around.contact[corner] < 0) continue;
            const double phi = vertex.around.S[corner];
            ContactNode<Dim>& contact = (*pair.nodes)[vertex.around.contact[corner]];
            NodalSurface<Dim>& surface = contact.surface[side];
            const bool isWhole = pair.isBonded(contact.node);
            const Vec<Dim> outward = isWhole ? Vec<Dim>(vertex.outward + vertex.hidden) : vertex.outward;
            surface.outward += phi * outward;
            surface.extent += phi * (vertex.extent + (isWhole ? vertex.hiddenExtent : 0));
            surface.moment += phi * (vertex.position - contact.position) * outward.transpose();
        }
    }
}

// Facets that look along an axis which constraints hold for both groups are no surface: beyond the plane of symmetry the
// bodies go on.
template <int Dim> void leaveOutHeld(const PairSearch<Dim>& pair, ContactNode<Dim>& contact) {
    for (int k = 0; k < Dim; ++k)
        if (pair.areBothHeld(contact.node, k))
            for (auto* surface :
                 {&contact.surface[0], &contact.surface[1], &contact.sides[0], &contact.sides[1]}) {
                surface->outward[k] = 0;
                surface->moment.col(k).setZero();
            }
}

} // namespace

template <int Dim> void findSurfaces(PairSearch<Dim>& pair) {
    const Grid<Dim>& grid = pair.grid();
    for (int side = 0; side < 2; ++side) {
        pair.boxes[side].find(*pair.scene, pair.field[side], pair.nearby);
        const int partner = pair.scene->state.parted.partnerOf(pair.field[side]);
        pair.partners[side].find(*pair.scene, partner, pair.nearby);
        pair.sided[side].find(*pair.scene, partner < 0 ? -1 : pair.field[side], pair.nearby, true);
        pair.forNodes([&](ContactNode<Dim>& contact) {
            if (!pair.boxes[side].isEmpty())
                pair.boxes[side].addTo(contact.surface[side], grid, pair.nearby, contact.node,
                                       contact.position);
            if (!pair.isBonded(contact.node) || pair.partners[side].isEmpty()) return;
            const auto add = [&](const NearbyBoxes<Dim>& boxes, NodalSurface<Dim>& surface) {
                if (!boxes.isEmpty()) boxes.addTo(surface, grid, pair.nearby, contact.node, contact.position);
            };
            add(pair.sided[side], contact.sides[0]);
            add(pair.partners[side], contact.sides[1]);
            contact.surface[side].outward += contact.sides[1].outward;
            contact.surface[side].moment += contact.sides[1].moment;
        });
        pair.forSurfaces(side, [&](Body<Dim>& body, ExplicitSurface<Dim>& surface) {
            surface.find(body, grid, pair.nearby, pair.hidden(side, body));
            addParts(pair, side, surface.parts(body));
        });
    }
    pair.forNodes([&](ContactNode<Dim>& contact) { leaveOutHeld(pair, contact); });
}

template bool findNodes(PairSearch<2>&);
template bool findNodes(PairSearch<3>&);
template void findSurfaces(PairSearch<2>&);
template void findSurfaces(PairSearch<3>&);

} // namespace mpm
