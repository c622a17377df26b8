// SPDX-License-Identifier: GPL-2.0-or-later
// The gap between the surfaces at each contact node, and the area on which they meet. With A = n . int phi n
// dA, a group reaches n . int phi d n^T dA n / A along n; a mesh as far as the tangent plane at its nearest
// vertex.
#include "mpm/contact/PairSearch.hpp"

namespace mpm {

namespace {

// Cosine between the normals of a vertex and of the node above which the surface there faces the other group
// at all, and above which its tangent plane crosses the normal of the node near enough to be taken; else the
// vertex itself counts.
constexpr double leastFacing = 0.5;
constexpr double planeFacing = 0.9;
// Surface of a group along the normal over the area in contact above which it tells how far the group
// reaches: below, moment over area is noise.
constexpr double leastOwnArea = 0.05;
// Gap between boxes, in cells, below which they do not cross but face away from each other.
constexpr double deepestGap = -0.5;
// Area over that of a face of the cell below which a node hardly feels a surface, and takes normal and gap of
// its neighbours.
constexpr double leastArea = 0.05;
// Size of a mean of unit normals below which it has no direction.
constexpr double leastMeanNormal = 0.1;

// Where the tangent plane of the nearest vertex crosses the normal through a node, for groups that are
// meshes; vertices at edges have no such plane, and count by themselves. Of vertices that are equally near but for
// round-off the one whose plane reaches farther counts, whichever comes first. A vertex a cell away does not count.
template <int Dim> void findPlanes(PairSearch<Dim>& pair, int side) {
    if (!pair.isExplicit[side]) return;
    const Grid<Dim>& grid = pair.grid();
    const double sign = side == 0 ? 1 : -1;
    pair.forSurfaces(side, [&](const Body<Dim>&, const ExplicitSurface<Dim>& surface) {
        for (const auto& one : surface.near) {
            const auto vertex = pair.withoutPlanes(one);
            forNeighbours(grid, vertex.node, [&](int node, const Index<Dim>&) {
                ContactNode<Dim>* const contact = pair.at(node);
                if (!contact) return;
                NodalSurface<Dim>& seen = contact->surface[side];
                const double h = grid.meanSize(node).minCoeff();
                const Vec<Dim> d = vertex.position - contact->position;
                const double along = sign * d.dot(contact->normal);
                const double beside = std::max(0.0, d.squaredNorm() - along * along);
                const Vec<Dim> outward =
                    pair.isBonded(node) ? Vec<Dim>(vertex.outward + vertex.hidden) : vertex.outward;
                const double size = outward.norm(), facing = sign * outward.dot(contact->normal) / size;
                const double alike = PlaceInCell::roundOff * h * h; // m2, round-off of `beside`
                if (beside > h * h - alike || beside > seen.nearest + alike || !(facing > leastFacing))
                    return;
                const double reach = facing > planeFacing ? d.dot(outward) / (facing * size) : along;
                seen.reach = beside < seen.nearest - alike ? reach : std::max(seen.reach, reach);
                seen.nearest = std::min(seen.nearest, beside);
            });
        }
    });
}

// Boxes against a mesh: where the centre of one has crossed its face, the gap is closed, whatever the others
// do.
template <int Dim> void findIntruders(PairSearch<Dim>& pair, int side) {
    if (pair.isExplicit[side] || !pair.isExplicit[1 - side]) return;
    const double sign = side == 0 ? 1 : -1;
    pair.forNodes([&](ContactNode<Dim>& contact) {
        const NodalSurface<Dim>& mesh = contact.surface[1 - side];
        if (!mesh.hasPlane()) return;
        const auto crossed = [&](const NearbyBoxes<Dim>& boxes) {
            return boxes.isEmpty() ? -farAway
                                   : boxes.crossed(pair.grid(), pair.nearby, contact.node, contact.position,
                                                   sign * contact.normal, -mesh.reach,
                                                   pair.grid().meanSize(contact.node).minCoeff());
        };
        contact.surface[side].intruded = crossed(pair.boxes[side]);
        if (pair.isBonded(contact.node))
            contact.surface[side].intruded =
                std::max(contact.surface[side].intruded, crossed(pair.partners[side]));
    });
}

// Whether a node feels more than a small part of the face of a cell. Of a face across a plane of symmetry half lies
// on this side.
template <int Dim> bool isFelt(const PairSearch<Dim>& pair, const ContactNode<Dim>& contact) {
    const Grid<Dim>& grid = pair.grid();
    const Index<Dim> at = grid.indices(contact.node);
    double face = std::pow(grid.meanSize(contact.node).minCoeff(), Dim - 1);
    for (int k = 0; k < Dim; ++k)
        if (const int cell = at[k] - grid.ghost; cell == 0 || cell == grid.cells[k])
            face *= pair.areBothHeld(contact.node, k) ? 0.5 : 1.0;
    return contact.weight > leastArea * face;
}

// How far each group reaches along the normal. At an edge of a mesh that is no overlap: boxes beside one face are
// behind the plane of the other one.
template <int Dim> void setGap(const PairSearch<Dim>& pair, ContactNode<Dim>& contact) {
    const Vec<Dim>& n = contact.normal;
    const double area[2] = {contact.areaOf(0), contact.areaOf(1)};
    contact.area = std::max(0.0, std::min(area[0], area[1]));
    const bool isIntruded = contact.surface[0].isIntruded() || contact.surface[1].isIntruded();
    contact.weight = isIntruded ? area[pair.isExplicit[0] ? 0 : 1] : contact.area;
    if (!(contact.weight > 0)) return;
    double reach[2];
    for (int side = 0; side < 2; ++side) {
        const NodalSurface<Dim>& seen = contact.surface[side];
        reach[side] = pair.isExplicit[side] && seen.hasPlane()     ? seen.reach
                      : area[side] > leastOwnArea * contact.weight ? n.dot(seen.moment * n) / area[side]
                                                                   : -farAway;
        reach[side] = std::max(reach[side], seen.intruded);
    }
    contact.gap = -reach[1] - reach[0];
    if (!pair.isExplicit[0] && !pair.isExplicit[1] &&
        contact.gap < deepestGap * pair.grid().meanSize(contact.node).minCoeff())
        contact.weight = 0;
    const bool isEdge = contact.edgeOf >= 0 || contact.shareOfBoxes > 0;
    contact.overlap = isEdge || !isFelt(pair, contact) ? 0 : -contact.gap;
}

template <int Dim> void borrow(const PairSearch<Dim>& pair) {
    const Grid<Dim>& grid = pair.grid();
    pair.forNodes([&](ContactNode<Dim>& contact) {
        if (isFelt(pair, contact)) return;
        Vec<Dim> normal = Vec<Dim>::Zero();
        double weight = 0, gap = 0;
        forNeighbours(grid, contact.node, [&](int node, const Index<Dim>&) {
            const ContactNode<Dim>* const other = pair.at(node);
            if (!other || !isFelt(pair, *other) || pair.isBonded(node) != pair.isBonded(contact.node)) return;
            normal += other->weight * other->normal;
            weight += other->weight;
            gap += other->weight * other->gap;
        });
        contact.normal = unit<Dim>(normal, leastMeanNormal * weight);
        contact.gap = weight > 0 ? gap / weight : 0;
    });
}

} // namespace

template <int Dim> void findGaps(PairSearch<Dim>& pair) {
    for (int side = 0; side < 2; ++side) findPlanes(pair, side);
    for (int side = 0; side < 2; ++side) findIntruders(pair, side);
    pair.forNodes([&](ContactNode<Dim>& contact) { setGap(pair, contact); });
    borrow(pair);
}

template void findGaps(PairSearch<2>&);
template void findGaps(PairSearch<3>&);

} // namespace mpm
