// SPDX-License-Identifier: GPL-2.0-or-later
// Domains of a mesh that are alone: where it has hardly deformed each cell has one, and so have the cells beside. What a
// cell would give them is what they have. Found by their centres, and for whole chunks.
#pragma once

#include "mpm/base/parallel/ParallelRegion.hpp"
#include "mpm/state/Grid.hpp"

#include <algorithm>
#include <vector>

namespace mpm {

template <int Dim> class LoneDomains {
  public:
    // Called by all threads. cells: of the domains, by their centres.
    void find(ParallelRegion& region, const Grid<Dim>& grid, const std::vector<int>& cells) {
        region.once([&] {
            inCell_.resize(grid.count);
            isAlone_.resize(chunksOf(int(cells.size())));
            ++round_;
            for (int cell : cells) {
                InCell& in = inCell_[cell];
                in.domains = in.round == round_ ? in.domains + 1 : 1;
                in.round = round_;
            }
        });
        region.chunks(int(cells.size()), [&](int begin, int end) {
            isAlone_[begin / chunkSize] = std::none_of(cells.begin() + begin, cells.begin() + end,
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

    bool hasMore(int cell) const { return hasAny(cell) && inCell_[cell].domains > 1; }
    bool isBesideMore(const Grid<Dim>& grid, int cell) const {
        bool is = hasMore(cell);
        for (int stride : grid.strides) is |= hasMore(cell - stride) || hasMore(cell + stride);
        return is;
    }

    long round_ = 0; // number of calls of find()
    std::vector<InCell> inCell_;
    std::vector<char> isAlone_; // of each chunk
};

} // namespace mpm
