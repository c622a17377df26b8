// SPDX-License-Identifier: GPL-2.0-or-later
// Vertices of fine domains in the middle of an edge (3D: or face) of a coarse one: slaves, that go with
// weighted means of their masters, and hand them what they get.
#pragma once

#include "mpm/base/parallel/ParallelRegion.hpp"
#include "mpm/state/Field.hpp"

#include <algorithm>
#include <numeric>

namespace mpm {

class HangingVertices {
  public:
    static constexpr int most = 4;    // masters of one slave
    std::vector<int> slaves, masters; // slaves in order; `most` masters per slave, -1: none
    Field weight{"masterWeight", "-", "Weights of the masters of a hanging vertex.", {most}};

    int count() const { return int(slaves.size()); }

    void set(const std::vector<int>& theSlaves, const std::vector<int>& theMasters,
             const std::vector<double>& weights) {
        slaves = theSlaves;
        masters = theMasters;
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
        const auto slave = std::lower_bound(slaves.begin(), slaves.end(), v);
        if (slave == slaves.end() || *slave != v) return f(v, 1.0);
        eachMaster(int(slave - slaves.begin()), f);
    }

    // f(number, vertex) for the slaves among vertices [begin, end).
    template <class F> void within(int begin, int end, F&& f) const {
        for (int s = firstSlave_[begin / chunkSize]; s < count() && slaves[s] < end; ++s)
            if (slaves[s] >= begin) f(s, slaves[s]);
    }

    bool isSlave(int v) const { return std::binary_search(slaves.begin(), slaves.end(), v); }

    // f(master, slave, weight) for the masters among vertices [begin, end).
    template <class F> void shares(int begin, int end, F&& f) const {
        for (size_t i = firstShare_[begin / chunkSize]; i < shares_.size() && shares_[i].master < end; ++i)
            if (const Share& share = shares_[i]; share.master >= begin)
                f(share.master, share.slave, share.weight);
    }

    // Of a plane of numbers at the vertices, the weighted mean over the masters of slave number s.
    double mean(int s, const double* x) const {
        double sum = 0;
        eachMaster(s, [&](int master, double w) { sum += w * x[master]; });
        return sum;
    }

    // The transpose: masters among vertices [begin, end) add what their slaves hold.
    template <size_t n> void collect(int begin, int end, const std::array<double*, n>& plane) const {
        for (size_t i = firstShare_[begin / chunkSize]; i < shares_.size() && shares_[i].master < end; ++i)
            if (const Share& share = shares_[i]; share.master >= begin)
                for (double* x : plane) x[share.master] += share.weight * x[share.slave];
    }

    // After slaves, masters or weights were set. vertices: their number.
    void restored(int vertices) {
        shares_.clear();
        for (int s = 0; s < count(); ++s)
            eachMaster(s, [&](int master, double w) { shares_.push_back({master, slaves[s], w}); });
        std::stable_sort(shares_.begin(), shares_.end(),
                         [](const Share& a, const Share& b) { return a.master < b.master; });
        firstSlave_.assign(chunksOf(vertices) + 1, 0);
        firstShare_ = firstSlave_;
        for (int v : slaves) ++firstSlave_[v / chunkSize + 1];
        for (const Share& share : shares_) ++firstShare_[share.master / chunkSize + 1];
        std::partial_sum(firstSlave_.begin(), firstSlave_.end(), firstSlave_.begin());
        std::partial_sum(firstShare_.begin(), firstShare_.end(), firstShare_.begin());
    }

    // Those with keep(number) stay; the others are free vertices from now on.
    template <class Keep> void select(Keep&& keep) {
        std::vector<int> kept, keptMasters, numbers;
        for (int s = 0; s < count(); ++s) {
            if (!keep(s)) continue;
            kept.push_back(slaves[s]);
            numbers.push_back(s);
            keptMasters.insert(keptMasters.end(), masters.begin() + most * s,
                               masters.begin() + most * s + most);
        }
        slaves = kept;
        masters = keptMasters;
        weight.select(numbers);
    }

    void renumber(const std::vector<int>& number) {
        for (int& v : slaves) v = number[v];
        for (int& v : masters)
            if (v >= 0) v = number[v];
    }

  private:
    struct Share {
        int master, slave;
        double weight;
    };
    std::vector<Share> shares_;                // by master
    std::vector<int> firstSlave_, firstShare_; // in or behind each chunk of vertices
};

} // namespace mpm
