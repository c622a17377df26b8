// SPDX-License-Identifier: GPL-2.0-or-later
// The unknowns of the pore pressure by the places of their cells in the grid: cells side by side are a run, and so are
// their neighbours and the nodes at each corner of theirs, so loops over them vectorise.
#pragma once

#include "mpm/base/parallel/ParallelRegion.hpp"
#include "mpm/particle/apdi/APDIShape.hpp"
#include "mpm/state/Grid.hpp"

#include <algorithm>
#include <array>
#include <vector>

namespace mpm {

template <int Dim> class PorePlaces {
  public:
    static constexpr int blockSize = 512; // unknowns that a thread takes at once
    struct Run {
        int first, last; // places
    };

    int size = 0;                           // of an array by places
    int offset = 0;                         // from the number of a cell or node in the grid to its place
    std::array<int, corners<Dim>> toCorner; // from a cell to the node at each corner

    // numbers: of the cells with an unknown, sorted.
    void find(const std::vector<int>& numbers, const Index<Dim>& strides) {
        const int unknowns = int(numbers.size());
        int margin = 0;
        for (int k = 0; k < Dim; ++k) margin += strides[k];
        const int first = unknowns > 0 ? numbers[0] : 0;
        size = unknowns > 0 ? numbers[unknowns - 1] - first + 1 + 2 * margin : 0;
        offset = margin - first;
        runs_.clear();
        firstRun_.clear();
        for (int c = 0; c < unknowns; ++c) {
            const int place = numbers[c] + offset;
            if (c % blockSize == 0) firstRun_.push_back(int(runs_.size()));
            if (c % blockSize == 0 || place != runs_.back().last) runs_.push_back({place, place});
            runs_.back().last = place + 1;
        }
        firstRun_.push_back(int(runs_.size()));
        for (int a = 0; a < corners<Dim>; ++a) {
            toCorner[a] = 0;
            for (int k = 0; k < Dim; ++k) toCorner[a] += cornerSign(a, k) > 0 ? strides[k] : 0;
        }
        unknowns_ = unknowns;
        blocks_.set((unknowns + blockSize - 1) / blockSize, [](int) { return 1.0; });
    }

    // f(first unknown, end) for blocks of them, by all threads.
    template <class F> void forBlocks(ParallelRegion& region, F&& f) const {
        region.forPieces(blocks_, [&](int b) { f(b * blockSize, std::min(unknowns_, (b + 1) * blockSize)); });
    }
    // f(first place, end) for the runs of a block.
    template <class F> void forRuns(int begin, F&& f) const {
        const int block = begin / blockSize;
        for (int i = firstRun_[block]; i < firstRun_[block + 1]; ++i) f(runs_[i].first, runs_[i].last);
    }
    // From values by unknown to those by place, and back.
    void spread(const std::vector<double>& values, std::vector<double>& places) const {
        const double* from = values.data();
        for (const Run& run : runs_) {
            std::copy_n(from, run.last - run.first, places.data() + run.first);
            from += run.last - run.first;
        }
    }
    void collect(const std::vector<double>& places, std::vector<double>& values) const {
        values.resize(unknowns_);
        double* to = values.data();
        for (const Run& run : runs_) to = std::copy(places.data() + run.first, places.data() + run.last, to);
    }

  private:
    int unknowns_ = 0;
    std::vector<Run> runs_;     // cut at the ends of blocks
    std::vector<int> firstRun_; // of each block, and the end
    WorkPartition blocks_;
};

} // namespace mpm
