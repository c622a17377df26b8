// SPDX-License-Identifier: GPL-2.0-or-later
// Domains of a mesh that are alone: where it has hardly deformed each cell has one, and so have the cells beside. What a
// cell would give them is what they have. Found by their centres, and for whole chunks.
#pragma once

#include "mpm/base/parallel/ParallelRegion.hpp"
#include "mpm/state/Grid.hpp"
#include "mpm/state/Particles.hpp"

#include <algorithm>
#include <vector>

namespace mpm {

template <int Dim> class LoneDomains {
  public:
    // Before find(), by one thread.
    void start(int particles, const Grid<Dim>& grid) {
        stay_ = round_ > 0 && int(cell_.size()) == particles;
        cell_.resize(particles);
        inCell_.resize(grid.count);
        isAlone_.resize(chunksOf(particles));
        hasChanged_.resize(chunksOf(particles));
    }
    // Called by all threads.
    void find(ParallelRegion& region, const Particles<Dim>& particles, const Grid<Dim>& grid) {
        region.chunks(int(cell_.size()), [&](int begin, int end) { findCells(particles, grid, begin, end); });
        region.once([&] {
            stay_ &=
                std::none_of(hasChanged_.begin(), hasChanged_.end(), [](char changed) { return changed; });
            if (!stay_) ++round_;
        });
        if (stay_) return;
        region.once([&] { count(); });
        region.chunks(int(cell_.size()), [&](int begin, int end) {
            isAlone_[begin / chunkSize] = std::none_of(cell_.begin() + begin, cell_.begin() + end,
                                                       [&](int cell) { return isBesideMore(grid, cell); });
        });
    }

    bool isAlone(int chunk) const { return isAlone_[chunk]; }
    bool hasAny(int cell) const { return inCell_[cell].round == round_; }

  private:
    struct InCell {
        long round = 0;
        int domains = 0;
    };

    // Of particles [begin, end), a chunk.
    void findCells(const Particles<Dim>& particles, const Grid<Dim>& grid, int begin, int end) {
        int found[chunkSize] = {};
        for (int k = 0; k < Dim; ++k)
            grid.addCells(k, particles.position.plane(k) + begin, end - begin, found);
        hasChanged_[begin / chunkSize] = !std::equal(found, found + end - begin, cell_.begin() + begin);
        if (hasChanged_[begin / chunkSize]) std::copy(found, found + end - begin, cell_.begin() + begin);
    }
    void count() {
        for (int cell : cell_) {
            InCell& in = inCell_[cell];
            in.domains = in.round == round_ ? in.domains + 1 : 1;
            in.round = round_;
        }
    }
    bool hasMore(int cell) const { return hasAny(cell) && inCell_[cell].domains > 1; }
    bool isBesideMore(const Grid<Dim>& grid, int cell) const {
        bool is = hasMore(cell);
        for (int stride : grid.strides) is |= hasMore(cell - stride) || hasMore(cell + stride);
        return is;
    }

    long round_ = 0; // number of calls of find() in which a domain was in another cell than before
    bool stay_ = false;
    std::vector<int> cell_; // of each domain
    std::vector<InCell> inCell_;
    std::vector<char> isAlone_, hasChanged_; // of each chunk
};

} // namespace mpm
