// SPDX-License-Identifier: GPL-2.0-or-later
// The normal at each contact node, from the first group to the second.
#include "mpm/contact/PairSearch.hpp"

namespace mpm {

namespace {

// Flatness over that of the flatter surface from which on both count: planes differ by round-off and by how
// their vertices lie round a node, and their mean is wanted.
constexpr double equallyFlat = 0.99;
// Size of a sum of unit vectors below which it has no direction: two normals that cancel leave round-off,
// 1e-16.
constexpr double leastSum = 1e-6;
// Flatness above which a surface is a plane: from an edge to a plane it counts as one more and more, as soil under the
// tip of a pile is in between, and a normal that jumps is an impact. The same for the cosine between two normals that
// face each other.
constexpr double planeFlatness = 0.98;
constexpr double facingFully = 0.05;
// Steps of the grid round an edge over which velocities are averaged: the boxes at the edge itself have already
// been given its velocity by contact. With 2 instead of 4 the tip of a sheet pile takes a third more energy, and
// up to four times as much is missing from the balance.
constexpr int meanReach = 4;
// Speed, in cells per step, of which all facets of an edge count besides: at rest velocities are noise, and the
// normal is that of the whole surface. A sheet pile moves a hundred times as fast.
constexpr double restSpeed = 1e-7;
// Part of the velocity with which edges last moved that counts besides how they move now.
constexpr double lastShare = 0.5;

// Boxes have faces along the axes: of two groups of them those count that look at each other, the smaller of
// both.
template <int Dim> Vec<Dim> normalOfBoxes(const Vec<Dim> outward[2]) {
    Vec<Dim> sum = Vec<Dim>::Zero();
    for (int k = 0; k < Dim; ++k)
        if (const double a = outward[0][k], b = outward[1][k]; a * b > 0)
            sum[k] = std::abs(a) < std::abs(b) ? a : b;
    return unit<Dim>(sum, 0.0);
}

// From 0 to 1 as x goes from `first` to `last`.
double rise(double x, double first, double last) {
    return std::clamp((x - first) / (last - first), 0.0, 1.0);
}

// At an edge of a mesh boxes count as far as they are flatter, plane and face it. Else boxes caught inside the mesh
// would hide the surface of the others.
double shareOfBoxes(double mesh, double boxes, double facing) {
    if (!(boxes > 0)) return 0;
    const double alike = (1 - equallyFlat) * boxes;
    return rise(boxes - mesh, alike, 2 * alike) * rise(boxes, edgeFlatness, planeFlatness) *
           rise(facing, 0, facingFully);
}

// At an edge of one group the flatter surface of the other counts. Of equals the mesh counts, else their
// mean.
template <int Dim> void setNormal(const PairSearch<Dim>& pair, ContactNode<Dim>& contact) {
    const Vec<Dim> outward[2] = {contact.surface[0].outward,
                                 -contact.surface[1].outward}; // along the normal, both
    if (!pair.isExplicit[0] && !pair.isExplicit[1]) {
        contact.normal = normalOfBoxes<Dim>(outward);
        return;
    }
    double size[2], flatness[2];
    for (int side = 0; side < 2; ++side) {
        size[side] = outward[side].norm();
        const double extent =
            pair.isExplicit[side] ? contact.surface[side].extent : outward[side].template lpNorm<1>();
        flatness[side] = size[side] / std::max(extent, 1e-300); // m2, no area at all
    }
    const double flattest = std::max(flatness[0], flatness[1]);
    bool counts[2];
    for (int side = 0; side < 2; ++side)
        counts[side] = size[side] > 0 && flatness[side] > equallyFlat * flattest;
    if (pair.isExplicit[0] != pair.isExplicit[1]) {
        const int mesh = pair.isExplicit[0] ? 0 : 1;
        const double facing = outward[0].dot(outward[1]) / std::max(size[0] * size[1], 1e-300);
        contact.shareOfBoxes = shareOfBoxes(flatness[mesh], flatness[1 - mesh], facing);
        counts[mesh] = size[mesh] > 0 && contact.shareOfBoxes < 1;
        counts[1 - mesh] = !counts[mesh];
    }
    Vec<Dim> sum = Vec<Dim>::Zero();
    for (int side = 0; side < 2; ++side)
        if (counts[side]) sum += outward[side] / size[side];
    contact.normal = unit<Dim>(sum, leastSum);
    for (int side = 0; side < 2; ++side)
        if (counts[side] && pair.isExplicit[side] && !pair.isExplicit[1 - side] &&
            flatness[side] < planeFlatness) {
            contact.edgeOf = side;
            contact.sharpness = 1 - rise(flatness[side], edgeFlatness, planeFlatness);
        }
}

// f(node) for the nodes at most `reach` steps from one along each axis that the particles of a field touched.
template <int Dim, class F>
void forNodesRound(const Grid<Dim>& grid, const NodalField<Dim>& field, int node, int reach, F&& f) {
    const Index<Dim> at = grid.indices(node);
    const int firstSlab = std::max(at[Dim - 1] - reach, 0);
    const int lastSlab = std::min(at[Dim - 1] + reach, grid.slabs() - 1);
    for (int slab = firstSlab; slab <= lastSlab; ++slab) {
        auto box = field.extents[slab];
        for (int k = 0; k < Dim - 1; ++k) {
            box.first[k] = std::max(box.first[k], at[k] - reach);
            box.last[k] = std::min(box.last[k], at[k] + reach);
        }
        grid.forNodes(box, slab, f);
    }
}

// The planes of symmetry near a node: of those rollers that hold a group on their node nearest to it, the line of the
// grid along each axis, on its lower and its upper side.
template <int Dim> struct NearbyRollers {
    static constexpr int none = -1;
    Index<Dim> at;
    std::array<Index<Dim>, 2> line;

    NearbyRollers(const PairSearch<Dim>& pair, int side, int node) : at(pair.grid().indices(node)) {
        const Grid<Dim>& grid = pair.grid();
        for (int k = 0; k < Dim; ++k)
            for (int end = 0; end < 2; ++end) {
                const int face = grid.ghost + end * grid.cells[k];
                const int holder = pair.fieldOf(side).holder[node + (face - at[k]) * grid.strides[k]][k];
                line[end][k] = pair.scene->state.mirrors.isRoller(holder) ? face : none;
            }
    }
    // How many images along an axis a node has up to `reach` steps away; a node on a roller is its own.
    int imagesOf(const Index<Dim>& near, int axis, int reach) const {
        int count = 0;
        for (const auto& lines : line)
            count += lines[axis] != none && std::abs(2 * lines[axis] - near[axis] - at[axis]) <= reach;
        return count;
    }
};

// Mean velocity of a group round a node at the start of the step: what the forces of this step add is left out,
// since they balance the contact force of the step before, and a normal that follows them turns with dt. Images
// behind rollers count, too. Of a soil that a wall parts, both fields round a node where it is one; else that of the
// node, and what is one.
template <int Dim> Vec<Dim> meanVelocity(const PairSearch<Dim>& pair, int side, int node) {
    const Grid<Dim>& grid = pair.grid();
    const NearbyRollers<Dim> rollers(pair, side, node);
    Vec<Dim> momentum = Vec<Dim>::Zero();
    double mass = 0;
    const auto add = [&](int number, bool isWhole) {
        const NodalField<Dim>& field = grid.fields[number];
        forNodesRound(grid, field, node, meanReach, [&](int near) {
            if (!isWhole && !pair.isBonded(near)) return;
            const Index<Dim> place = grid.indices(near);
            double all = 1;
            Vec<Dim> mean; // of the node and its images, of the velocity along each axis
            for (int k = 0; k < Dim; ++k) {
                const int images = rollers.imagesOf(place, k, meanReach);
                all *= 1 + images;
                mean[k] = (1.0 - images) / (1 + images);
            }
            mass += all * field.sum[near][NodalField<Dim>::mass];
            for (int k = 0; k < Dim; ++k)
                momentum[k] += all * mean[k] * field.sum[near][NodalField<Dim>::momentum + k];
        });
    };
    add(pair.field[side], true);
    const int partner = pair.scene->state.parted.partnerOf(pair.field[side]);
    if (partner >= 0) add(partner, pair.isBonded(node));
    return momentum / mass; // the node itself has some
}

// How an edge moves towards the other group, m/s, along the axes that are not held for both.
template <int Dim> Vec<Dim> approachOf(const PairSearch<Dim>& pair, int side, int node) {
    Vec<Dim> velocity = meanVelocity(pair, side, node) - meanVelocity(pair, 1 - side, node);
    for (int k = 0; k < Dim; ++k)
        if (pair.areBothHeld(node, k)) velocity[k] = 0;
    return velocity;
}

// At an edge of a mesh against boxes the facets count as far as they move towards these: the tip of a pile
// pushes what lies below it down, not aside.
template <int Dim> void turnAtEdges(PairSearch<Dim>& pair, int side) {
    std::vector<Vec<Dim>> approach(pair.nodes->size() - pair.first);
    for (size_t i = 0; i < approach.size(); ++i) {
        const ContactNode<Dim>& contact = (*pair.nodes)[pair.first + i];
        if (contact.edgeOf != side) continue;
        approach[i] = approachOf(pair, side, contact.node);
        pair.motion[side] += approach[i];
        ++pair.edges[side];
        approach[i] += lastShare * pair.lastMotion[side];
    }
    if (pair.edges[side] == 0) return;
    pair.motion[side] /= pair.edges[side];
    // All facets of an edge count as if they closed with this speed besides, m/s.
    const auto leastSpeed = [&](int node) {
        return restSpeed * pair.grid().meanSize(node).minCoeff() / pair.scene->dt;
    };
    std::vector<Vec<Dim>> sum(approach.size(), Vec<Dim>::Zero());
    pair.forSurfaces(side, [&](Body<Dim>& body, const ExplicitSurface<Dim>& surface) {
        surface.forParts(body, [&](const auto& vertex, const Vec<Dim>& part, bool isHidden) {
            const double area = part.norm();
            for (int corner = 0; corner < vertex.around.size; ++corner) {
                const int number = vertex.around.contact[corner];
                if (number < 0 || (*pair.nodes)[number].edgeOf != side) continue;
                if (isHidden && !pair.isBonded((*pair.nodes)[number].node)) continue;
                const size_t i = number - pair.first;
                const double least = leastSpeed((*pair.nodes)[number].node);
                const double closing = std::max(0.0, part.dot(approach[i]) / area) + least;
                const double speed = approach[i].norm() + least;
                const double sharpness = (*pair.nodes)[number].sharpness;
                sum[i] += vertex.around.S[corner] * (sharpness * closing + (1 - sharpness) * speed) * part;
            }
        });
    });
    for (size_t i = pair.first; i < pair.nodes->size(); ++i) {
        ContactNode<Dim>& contact = (*pair.nodes)[i];
        Vec<Dim>& n = sum[i - pair.first];
        for (int k = 0; k < Dim; ++k)
            if (pair.areBothHeld(contact.node, k)) n[k] = 0;
        if (contact.edgeOf == side && !n.isZero(0)) contact.normal = (side == 0 ? 1 : -1) * n.normalized();
    }
}

template <int Dim> void addBoxes(ContactNode<Dim>& contact, int boxes) {
    if (contact.shareOfBoxes == 0 || contact.shareOfBoxes == 1) return;
    const Vec<Dim> theirs = (boxes == 0 ? 1 : -1) * contact.surface[boxes].outward.normalized();
    contact.normal =
        unit<Dim>((1 - contact.shareOfBoxes) * contact.normal + contact.shareOfBoxes * theirs, leastSum);
}

} // namespace

template <int Dim> void findNormals(PairSearch<Dim>& pair, const SearchRule& rule) {
    pair.forNodes([&](ContactNode<Dim>& contact) { setNormal(pair, contact); });
    for (int side = 0; side < 2; ++side)
        if (rule.turnsAtEdges) turnAtEdges(pair, side);
    if (pair.isExplicit[0] != pair.isExplicit[1])
        pair.forNodes([&](ContactNode<Dim>& contact) { addBoxes(contact, pair.isExplicit[0] ? 1 : 0); });
}

template void findNormals(PairSearch<2>&, const SearchRule&);
template void findNormals(PairSearch<3>&, const SearchRule&);

} // namespace mpm
