// SPDX-License-Identifier: GPL-2.0-or-later
// Sites that pressed on each other in the last step, and whether they stuck. Under USF the stress comes before the
// impulses: what strains as one then is what pressed last.
#pragma once

#include "mpm/contact/ContactSearch.hpp"

#include <array>
#include <map>

namespace mpm {

class PressedSites {
  public:
    static constexpr int perSite = 5; // numbers: a name (see forSites), and 1 where it stuck
    std::vector<double> numbers;

    template <int Dim> void note(const ContactSearch<Dim>& search) {
        numbers.clear();
        forSites(search, [&](const ContactSite<Dim>& site, const Name& name) {
            if (!site.presses) return;
            for (int part : name) numbers.push_back(part);
            numbers.push_back(site.sticks);
        });
    }
    // Where a gap has opened since, none do, if they may part: the law would close it while particles strain.
    template <int Dim> void recall(ContactSearch<Dim>& search, bool mayPart) const {
        std::map<Name, bool> last;
        for (size_t i = 0; i < numbers.size(); i += perSite)
            last[{int(numbers[i]), int(numbers[i + 1]), int(numbers[i + 2]), int(numbers[i + 3])}] =
                numbers[i + 4] != 0;
        forSites(search, [&](ContactSite<Dim>& site, const Name& name) {
            const auto found = last.find(name);
            const bool isClosed = !mayPart || site.gap + site.tolerated <= 0;
            site.presses = found != last.end() && isClosed && !site.normal.isZero(0);
            site.sticks = site.presses && found->second;
        });
    }
    // What was found for the stress, before the impulses of a pair are.
    template <int Dim> static void forget(ContactSearch<Dim>& search, const ContactPair<Dim>& pair) {
        const auto forget = [](ContactSite<Dim>& site) {
            site.J = {};
            site.presses = site.sticks = site.parts = false;
        };
        for (size_t i = pair.firstNode; i < pair.endNode; ++i) forget(search.nodes[i]);
        for (size_t i = pair.firstPoint; i < pair.endPoint; ++i) forget(search.points[i]);
    }

  private:
    // Pair of groups; body of a mesh, vertex and its face (see ContactPoint), or -1, node, 0.
    using Name = std::array<int, 4>;

    template <class Search, class Visit> static void forSites(Search& search, Visit&& visit) {
        for (const auto& pair : search.pairs) {
            const int number = int(pairOf(pair.group[0], pair.group[1]));
            for (size_t i = pair.firstNode; i < pair.endNode; ++i)
                visit(search.nodes[i], Name{number, -1, search.nodes[i].node, 0});
            for (size_t i = pair.firstPoint; i < pair.endPoint; ++i) {
                auto& point = search.points[i];
                visit(point, Name{number, point.body, point.vertex, point.face()});
            }
        }
    }
};

} // namespace mpm
