// SPDX-License-Identifier: GPL-2.0-or-later
// Vertices of fine domains in the middle of an edge (3D: or face) of a coarse one: slaves, that go with weighted means of their
// masters, and hand them what they get.
#pragma once

#include "mpm/base/threads.hpp"
#include "mpm/state/Field.hpp"

#include <algorithm>

namespace mpm {

class HangingVertices {
  public:
    static constexpr int most = 4;    // masters of one slave
    std::vector<int> slaves, masters; // slaves in order; `most` masters per slave, -1: none
    Field weight{"masterWeight", "-", "Weights of the masters of a hanging vertex.", {most}};

    int count() const { return int(slaves.size()); }

    void set(const std::vector<int>& theSlaves, const std::vector<int>& theMasters, const std::vector<double>& weights) {
        slaves = theSlaves, masters = theMasters;
        weight.resize(count());
        for (int s = 0; s < count(); ++s)
            for (int m = 0; m < most; ++m) weight.plane(m)[s] = weights[most * s + m];
    }

    // f(master, weight) for the masters of slave number s.
    template <class F> void eachMaster(int s, F&& f) const {
        for (int m = 0; m < most; ++m)
            if (const int master = masters[most * s + m]; master >= 0) f(master, weight.plane(m)[s]);
    }

    // f(vertex, share): the vertex itself, or its masters if it hangs.
    template <class F> void through(int v, F&& f) const {
        const auto slave = std::find(slaves.begin(), slaves.end(), v);
        if (slave == slaves.end()) return f(v, 1.0);
        eachMaster(int(slave - slaves.begin()), f);
    }

    // f(number, vertex) for the slaves among vertices [begin, end).
    template <class F> void within(int begin, int end, F&& f) const {
        for (auto s = std::lower_bound(slaves.begin(), slaves.end(), begin); s != slaves.end() && *s < end; ++s)
            f(int(s - slaves.begin()), *s);
    }

    // Of a plane of numbers at the vertices, the weighted mean over the masters of slave number s.
    double mean(int s, const double* x) const {
        double sum = 0;
        eachMaster(s, [&](int master, double w) { sum += w * x[master]; });
        return sum;
    }

    // The transpose: slaves hand what they have to their masters.
    template <size_t n> void give(Team& team, const std::array<double*, n>& plane) const {
        if (slaves.empty()) return;
        team.once([&] {
            for (double* x : plane)
                for (int s = 0; s < count(); ++s) {
                    eachMaster(s, [&](int master, double w) { x[master] += w * x[slaves[s]]; });
                    x[slaves[s]] = 0;
                }
        });
    }

    // Those with keep(number) stay; the others are free vertices from now on.
    template <class Keep> void select(Keep&& keep) {
        std::vector<int> kept, keptMasters, numbers;
        for (int s = 0; s < count(); ++s) {
            if (!keep(s)) continue;
            kept.push_back(slaves[s]), numbers.push_back(s);
            keptMasters.insert(keptMasters.end(), masters.begin() + most * s, masters.begin() + most * s + most);
        }
        slaves = kept, masters = keptMasters;
        weight.select(numbers);
    }

    void renumber(const std::vector<int>& number) {
        for (int& v : slaves) v = number[v];
        for (int& v : masters)
            if (v >= 0) v = number[v];
    }
};

} // namespace mpm
