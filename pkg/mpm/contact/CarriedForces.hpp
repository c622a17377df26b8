// SPDX-License-Identifier: GPL-2.0-or-later
// The forces with which shared cells press groups together, at the sites of contact. They act on the nodes already
// (scene/SharedCells.hpp); the sites count them for friction, and do not part before they are used up. A node hands its
// force to itself and to the points round it by the areas that they stand for, so that none is counted twice.
#pragma once

#include "mpm/contact/ContactSearch.hpp"

namespace mpm {

template <int Dim> class CarriedForces {
  public:
    void find(const SharedCells<Dim>& cells, ContactSearch<Dim>& search) {
        for (const ContactPair<Dim>& pair : search.pairs) {
            takeForces(cells, search, pair);
            takeAreas(search, pair);
            hand(search, pair);
        }
    }

  private:
    std::vector<Vec<Dim>> forces_; // on the second group, at the contact nodes of a pair, kN
    std::vector<double> areas_;    // of all sites that act on them, m2

    void takeForces(const SharedCells<Dim>& cells, const ContactSearch<Dim>& search,
                    const ContactPair<Dim>& pair) {
        forces_.assign(pair.endNode - pair.firstNode, Vec<Dim>::Zero());
        const auto first = search.nodes.begin() + pair.firstNode, end = search.nodes.begin() + pair.endNode;
        for (const auto& part : cells.forcesAcross()) {
            if (std::min(part.soil, part.solid) != first->field[0] ||
                std::max(part.soil, part.solid) != first->field[1])
                continue;
            const auto node =
                std::lower_bound(first, end, part.node, [](const auto& its, int n) { return its.node < n; });
            if (node != end && node->node == part.node)
                forces_[node - first] += (part.solid > part.soil ? 1 : -1) * part.force;
        }
    }
    // f(site, node, weight) for the sites of a node and for the points with a weight on it.
    template <class F> static void forSites(ContactSearch<Dim>& search, const ContactPair<Dim>& pair, F&& f) {
        for (size_t i = pair.firstNode; i < pair.endNode; ++i)
            if (!search.nodes[i].isLeftOut) f(search.nodes[i], i - pair.firstNode, 1.0);
        for (size_t i = pair.firstPoint; i < pair.endPoint; ++i) {
            auto& point = search.points[i];
            for (int corner = 0; corner < point.size; ++corner)
                f(point, point.contact[corner] - pair.firstNode, point.S[corner]);
        }
    }
    void takeAreas(ContactSearch<Dim>& search, const ContactPair<Dim>& pair) {
        areas_.assign(forces_.size(), 0.0);
        forSites(search, pair, [&](ContactSite<Dim>& site, size_t node, double weight) {
            areas_[node] += weight * site.area;
            site.carried = 0;
        });
    }
    void hand(ContactSearch<Dim>& search, const ContactPair<Dim>& pair) {
        forSites(search, pair, [&](ContactSite<Dim>& site, size_t node, double weight) {
            if (areas_[node] > 0)
                site.carried += weight * site.area / areas_[node] * forces_[node].dot(site.normal);
        });
        forSites(search, pair,
                 [&](ContactSite<Dim>& site, size_t, double) { site.carried = std::max(0.0, site.carried); });
    }
};

} // namespace mpm
