// SPDX-License-Identifier: GPL-2.0-or-later
// What Contact tells of a step: rows of its table, forces between groups, and impulses on the facets of structures.
#include "mpm/contact/Contact.hpp"

namespace mpm {

namespace {

template <int Dim> Vec<Dim> middleOf(const Grid<Dim>& grid, int cell) {
    return grid.nodePosition(cell) + 0.5 * grid.edges(cell);
}

} // namespace

// With the velocities that strain the groups. Nodes that a body hardly feels may have quite another one
// in the solution.
template <int Dim>
void Contact::record(Scene<Dim>& scene, const ContactNode<Dim>& contact, const NodeMotion<Dim>& node) {
    const double rubbed = contact.friction[0].dot(node.v[0]) - contact.friction[1].dot(node.v[1]);
    frictionWork += rubbed;
    scene.energies.contact += rubbed;
    const auto inSpace = [](const Vec<Dim>& v) {
        Vec3 all = Vec3::Zero();
        all.head<Dim>() = v;
        return all;
    };
    const int first = scene.groupOf[contact.field[0]], second = scene.groupOf[contact.field[1]];
    table.push_back({first, second, inSpace(contact.position), inSpace(contact.normal), contact.gap,
                     contact.area + contact.areaOfPoints, inSpace(contact.impulse[1] / scene.dt),
                     inSpace(node.v[0] - node.v[1])});
    double* force = &forces[3 * pairOf(first, second)];
    for (int k = 0; k < Dim; ++k) force[k] += contact.impulse[1][k] / scene.dt;
    if (!contact.hasPoints) largestPenetration = std::max(largestPenetration, contact.overlap);
    sliding += contact.slides;
}

// What each facet of a structure takes in the step.
template <int Dim> void Contact::addToFacets(const Scene<Dim>& scene, State<Dim>& state) {
    const ContactSearch<Dim>& search = state.search;
    state.facets.find(scene, search, facetImpulses);
    const auto isIn = [&](const ContactSite<Dim>& site) {
        return !site.J.all.isZero(0) || !site.J.agreeing.isZero(0);
    };
    for (const ContactPair<Dim>& pair : search.pairs)
        for (int side = 0; side < 2; ++side) {
            if (!search.isOfMeshes(pair.group[side])) continue;
            const double sign = side == 0 ? -1 : 1;
            const auto takenBy = [&](const ContactSite<Dim>& site) {
                return Vec<Dim>(sign * (site.J.all - (1 - loss()) * site.J.agreeing));
            };
            for (size_t i = pair.firstNode; i < pair.endNode; ++i)
                if (const auto& node = search.nodes[i]; isIn(node))
                    state.facets.add(scene, pair.group[side], node.position, -sign * node.normal,
                                     takenBy(node));
            for (size_t i = pair.firstPoint; i < pair.endPoint; ++i) {
                const auto& point = search.points[i];
                if (!isIn(point)) continue;
                point.side == side&& point.vertex >= 0
                    ? state.facets.addAt(search.surfaceOf(point.body), point, -sign * point.normal,
                                         takenBy(point))
                    : state.facets.add(scene, pair.group[side], point.position, -sign * point.normal,
                                       takenBy(point));
            }
        }
    for (const auto& part : scene.state.sharedCells->forcesOfCells())
        if (search.isOfMeshes(part.solid))
            state.facets.add(scene, part.solid, middleOf(scene.grid, part.node), -unit<Dim>(part.force, 0.0),
                             scene.dt * part.force);
}

// What shared cells put on the groups is force of contact, too: pressure, in rows of their own, at nodes that may lie
// inside the meshes.
template <int Dim> void Contact::recordShared(const Scene<Dim>& scene) {
    using Place = std::tuple<int, int, int>;    // first and second group, node
    std::vector<std::pair<Place, Vec<Dim>>> on; // the second group
    for (const auto& part : scene.state.sharedCells->forces()) {
        const int soil = scene.groupOf[part.soil];
        const auto [first, second] = std::minmax(soil, part.solid);
        on.push_back({{first, second, part.node}, (part.solid > soil ? 1 : -1) * part.force});
    }
    std::stable_sort(on.begin(), on.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    for (size_t i = 0; i < on.size();) {
        const Place at = on[i].first;
        const auto [first, second, node] = at;
        Vec<Dim> force = Vec<Dim>::Zero();
        for (; i < on.size() && on[i].first == at; ++i) force += on[i].second;
        ContactRecord row;
        row.first = first;
        row.second = second;
        row.node.template head<Dim>() = scene.grid.nodePosition(node);
        row.normal.template head<Dim>() = unit<Dim>(force, 0.0);
        row.force.template head<Dim>() = force;
        for (int k = 0; k < Dim; ++k) forces[3 * pairOf(first, second) + k] += force[k];
        table.push_back(row);
    }
}

template void Contact::record(Scene<2>&, const ContactNode<2>&, const NodeMotion<2>&);
template void Contact::record(Scene<3>&, const ContactNode<3>&, const NodeMotion<3>&);
template void Contact::addToFacets(const Scene<2>&, State<2>&);
template void Contact::addToFacets(const Scene<3>&, State<3>&);
template void Contact::recordShared(const Scene<2>&);
template void Contact::recordShared(const Scene<3>&);

} // namespace mpm
