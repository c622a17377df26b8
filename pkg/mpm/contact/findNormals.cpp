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
// Part of a normal that is left where constraints hold both groups along the others; with less it has no
// direction.
constexpr double leastFree = 0.1;

// Boxes have faces along the axes: of two groups of them those count that look at each other, the smaller of
// both.
template <int Dim> Vec<Dim> normalOfBoxes(const Vec<Dim> outward[2]) {
    Vec<Dim> sum = Vec<Dim>::Zero();
    for (int k = 0; k < Dim; ++k)
        if (const double a = outward[0][k], b = outward[1][k]; a * b > 0)
            sum[k] = std::abs(a) < std::abs(b) ? a : b;
    return unit<Dim>(sum, 0.0);
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
        // Boxes count where they are flat and the mesh has an edge, or at a plane of symmetry.
        const int mesh = pair.isExplicit[0] ? 0 : 1;
        const bool isHeld = pair.fieldOf(0).isHeld(contact.node) || pair.fieldOf(1).isHeld(contact.node);
        // Else boxes caught inside the mesh hide the surface of the others.
        const bool doFace = outward[0].dot(outward[1]) > 0;
        if (counts[mesh] || (!isHeld && (!doFace || flatness[1 - mesh] < edgeFlatness))) {
            counts[mesh] = size[mesh] > 0;
            counts[1 - mesh] = !counts[mesh];
        }
    }
    Vec<Dim> sum = Vec<Dim>::Zero();
    for (int side = 0; side < 2; ++side)
        if (counts[side]) sum += outward[side] / size[side];
    contact.normal = unit<Dim>(sum, leastSum);
    for (int side = 0; side < 2; ++side)
        if (counts[side] && pair.isExplicit[side] && !pair.isExplicit[1 - side] &&
            flatness[side] < edgeFlatness)
            contact.edgeOf = side;
}

template <int Dim> void setNormalByMass(const PairSearch<Dim>& pair, ContactNode<Dim>& contact) {
    const Grid<Dim>& grid = pair.grid();
    Vec<Dim> slope[2] = {Vec<Dim>::Zero(), Vec<Dim>::Zero()};
    for (int side = 0; side < 2; ++side)
        forNeighbours(grid, contact.node, [&](int node, const Index<Dim>& at) {
            const Vec<Dim> step =
                Eigen::Map<const Eigen::Matrix<int, Dim, 1>>(at.data()).template cast<double>();
            const double even = std::pow(0.5, step.squaredNorm()); // 1 2 1 across
            const double mass = pair.fieldOf(side).sum[node][NodalField<Dim>::mass];
            slope[side] += even * mass * step.cwiseQuotient(grid.cell);
        });
    contact.normal = unit<Dim>(unit<Dim>(slope[1], 0.0) - unit<Dim>(slope[0], 0.0), leastSum);
}

// At an edge of a mesh against boxes the facets count as far as they move towards these: the tip of a pile
// pushes what lies below it down, not aside.
template <int Dim> void turnAtEdges(PairSearch<Dim>& pair, int side) {
    bool isAny = false;
    pair.forNodes([&](const ContactNode<Dim>& contact) { isAny |= contact.edgeOf == side; });
    if (!isAny) return;
    std::vector<Vec<Dim>> sum(pair.nodes->size() - pair.first, Vec<Dim>::Zero());
    const auto &own = pair.fieldOf(side).motion, &others = pair.fieldOf(1 - side).motion;
    pair.forSurfaces(side, [&](Body<Dim>& body, const ExplicitSurface<Dim>& surface) {
        surface.forParts(body, [&](const auto& vertex, const Vec<Dim>& part) {
            for (int corner = 0; corner < vertex.around.size; ++corner) {
                const int number = vertex.around.contact[corner];
                if (number < 0 || (*pair.nodes)[number].edgeOf != side) continue;
                const int node = (*pair.nodes)[number].node;
                double closing = 0;
                for (int k = 0; k < Dim; ++k) closing += part[k] * (own[node][k] - others[node][k]);
                if (closing > 0)
                    sum[number - pair.first] += vertex.around.S[corner] * closing / part.norm() * part;
            }
        });
    });
    for (size_t i = pair.first; i < pair.nodes->size(); ++i) {
        ContactNode<Dim>& contact = (*pair.nodes)[i];
        if (contact.edgeOf == side && !sum[i - pair.first].isZero(0))
            contact.normal = (side == 0 ? 1 : -1) * sum[i - pair.first].normalized();
    }
}

// Where a constraint holds both groups along an axis they do not push each other along it: at a plane of
// symmetry an outline has facets on that plane, and the normal would tilt.
template <int Dim> void straighten(const PairSearch<Dim>& pair, ContactNode<Dim>& contact) {
    Vec<Dim> free = contact.normal;
    for (int k = 0; k < Dim; ++k)
        if (pair.fieldOf(0).holder[contact.node][k] >= 0 && pair.fieldOf(1).holder[contact.node][k] >= 0)
            free[k] = 0;
    if (free.norm() > leastFree) contact.normal = free.normalized();
}

} // namespace

template <int Dim> void findNormals(PairSearch<Dim>& pair, bool byMass) {
    pair.forNodes([&](ContactNode<Dim>& contact) {
        byMass ? setNormalByMass(pair, contact) : setNormal(pair, contact);
    });
    turnAtEdges(pair, 0);
    turnAtEdges(pair, 1);
    if (pair.hasOutline[0] || pair.hasOutline[1])
        pair.forNodes([&](ContactNode<Dim>& contact) { straighten(pair, contact); });
}

template void findNormals(PairSearch<2>&, bool);
template void findNormals(PairSearch<3>&, bool);

} // namespace mpm
