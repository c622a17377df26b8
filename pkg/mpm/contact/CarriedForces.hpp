// SPDX-License-Identifier: GPL-2.0-or-later
// The forces with which shared cells press groups together, at the sites of contact. They act on the nodes already
// (scene/SharedCells.hpp); the sites count them for friction, and do not part before they are used up. A node hands its
// force to itself and to the points round it along their normals, by the areas that they stand for: each face at an
// edge of a body bears its own component, and what acts along a plane surface is borne by none. Together they press
// along no normal more than the force does: they may hold the surfaces with all of it, and nothing must pull.
#pragma once

#include "mpm/contact/ContactSearch.hpp"
#include "mpm/scene/SharedCells.hpp"

#include <array>

namespace mpm {

template <int Dim> class CarriedForces {
  public:
    void find(const SharedCells<Dim>& cells, ContactSearch<Dim>& search) {
        for (const ContactPair<Dim>& pair : search.pairs) {
            takeForces(cells, search, pair);
            takeSites(search, pair);
            for (auto first = shares_.begin(); first != shares_.end();) {
                const auto last = std::find_if(first, shares_.end(),
                                               [&](const Share& share) { return share.node != first->node; });
                hand(first, last);
                first = last;
            }
            for (const Share& share : shares_) share.site->carried = std::max(0.0, share.site->carried);
        }
    }

  private:
    struct Share {
        size_t node; // of the pair
        ContactSite<Dim>* site;
        double area;      // that the site stands for there, m2
        double along = 0; // its normal, of the force of the node, kN
    };
    std::vector<Vec<Dim>> forces_; // on the second group, at the contact nodes of a pair, kN
    std::vector<Share> shares_;    // by their nodes

    void takeForces(const SharedCells<Dim>& cells, const ContactSearch<Dim>& search,
                    const ContactPair<Dim>& pair) {
        forces_.assign(pair.endNode - pair.firstNode, Vec<Dim>::Zero());
        const auto first = search.nodes.begin() + pair.firstNode, end = search.nodes.begin() + pair.endNode;
        using Place = std::array<int, 3>; // both fields and the node: the order of contact nodes
        const auto placeOf = [](const auto& its) { return Place{its.field[0], its.field[1], its.node}; };
        for (const auto& part : cells.forces()) {
            const bool isSecond = part.solid == pair.group[1];
            const Place at =
                isSecond ? Place{part.soil, part.solid, part.node} : Place{part.solid, part.soil, part.node};
            const auto node = std::lower_bound(
                first, end, at, [&](const auto& its, const Place& p) { return placeOf(its) < p; });
            if (node != end && placeOf(*node) == at)
                forces_[node - first] += (isSecond ? 1 : -1) * part.force;
        }
    }
    void takeSites(ContactSearch<Dim>& search, const ContactPair<Dim>& pair) {
        shares_.clear();
        const auto add = [&](size_t node, ContactSite<Dim>& site, double weight) {
            site.carried = 0;
            if (weight * site.area > 0) shares_.push_back({node, &site, weight * site.area});
        };
        for (size_t i = pair.firstNode; i < pair.endNode; ++i)
            if (!search.nodes[i].isLeftOut) add(i - pair.firstNode, search.nodes[i], 1);
        for (size_t i = pair.firstPoint; i < pair.endPoint; ++i) {
            auto& point = search.points[i];
            for (int corner = 0; corner < point.size; ++corner)
                add(point.contact[corner] - pair.firstNode, point, point.S[corner]);
        }
        std::stable_sort(shares_.begin(), shares_.end(),
                         [](const Share& a, const Share& b) { return a.node < b.node; });
    }
    template <class At> void hand(At first, At last) {
        const Vec<Dim>& force = forces_[first->node];
        Vec<Dim> all = Vec<Dim>::Zero();
        for (At share = first; share != last; ++share) {
            double facing = 0; // area that looks the same way
            for (At other = first; other != last; ++other) {
                const double alike = std::max(0.0, share->site->normal.dot(other->site->normal));
                facing += other->area * alike * alike;
            }
            if (!(facing > 0)) continue;
            share->along = share->area / facing * force.dot(share->site->normal);
            if (share->along > 0) all += share->along * share->site->normal;
        }
        double part = 1;
        for (At share = first; share != last; ++share)
            if (const Vec<Dim>& n = share->site->normal; share->along > 0 && force.dot(n) < part * all.dot(n))
                part = force.dot(n) / all.dot(n);
        for (At share = first; share != last; ++share) share->site->carried += part * share->along;
    }
};

} // namespace mpm
