// SPDX-License-Identifier: GPL-2.0-or-later
// Which cell of the grid each particle of a body is in, for sums cell by cell. Slabs of the grid belong to threads,
// and each goes through the particles in their order: the same sums on any number of threads.
#pragma once

#include "mpm/base/parallel/ParallelRegion.hpp"
#include "mpm/state/Grid.hpp"
#include "mpm/state/Particles.hpp"

#include <algorithm>
#include <vector>

namespace mpm {

template <int Dim> class ParticleCells {
  public:
    // Before locate(), by one thread.
    void start(int particles, const Grid<Dim>& grid) {
        stays_ = round_ > 0 && int(cell_.size()) == particles;
        located_ = true;
        slabSize_ = grid.strides[Dim - 1];
        cell_.resize(particles);
        slabsOf_.resize(chunksOf(particles));
        alone_.resize(chunksOf(particles));
        hasChanged_.resize(chunksOf(particles));
    }
    // Called by all threads. In most steps no particle of a body that hardly moves enters another cell: then all stays.
    // mayBeAlone: particles may be one in each cell, as domains of meshes are.
    void locate(ParallelRegion& region, const Particles<Dim>& particles, const Grid<Dim>& grid,
                bool mayBeAlone) {
        region.chunks(particles.size(), [&](int begin, int end) { findCells(particles, grid, begin, end); });
        region.once([&] {
            stays_ &=
                std::none_of(hasChanged_.begin(), hasChanged_.end(), [](char changed) { return changed; });
            if (stays_) return;
            ++round_;
            std::fill(alone_.begin(), alone_.end(), 0);
            divide(grid.slabs());
        });
        if (mayBeAlone && !stays_) findAlone(region, grid);
    }
    // Whether start() was called for so many since forget().
    bool areLocated(int particles) const { return located_ && int(cell_.size()) == particles; }
    void forget() { located_ = false; }

    // Number of calls of locate() so far in which a particle was in another cell than before, and whether none was in
    // the last one.
    long round() const { return round_; }
    bool stay() const { return stays_; }

    int operator[](int p) const { return cell_[p]; }
    int slabOf(int cell) const { return cell / slabSize_; }
    // Whether the particles from `begin` on, a chunk, are one in each cell, and those in the cells beside, too.
    bool areAlone(int begin) const { return alone_[begin / chunkSize]; }
    // Whether the particles may be alone, and some are in a cell.
    bool areCounted() const { return !count_.empty(); }
    bool hasAny(int cell) const { return count_[cell].round == round_; }

    // f(first slab, end) on each thread with the slabs that it owns.
    template <class F> void forOwn(ParallelRegion& region, F&& f) const { region.forOwnRange(partition_, f); }
    // f(particle, its cell) for those in some slabs, in their order, but for chunks that are alone.
    template <class F> void forEach(int firstSlab, int endSlab, F&& f) const {
        const int first = firstSlab * slabSize_, end = endSlab * slabSize_, count = int(cell_.size());
        for (int c = 0; c < int(slabsOf_.size()); ++c) {
            if (slabsOf_[c].last < firstSlab || slabsOf_[c].first >= endSlab || alone_[c]) continue;
            for (int p = c * chunkSize; p < std::min(count, (c + 1) * chunkSize); ++p)
                if (cell_[p] >= first && cell_[p] < end) f(p, cell_[p]);
        }
    }

  private:
    struct Range {
        int first, last;
    };
    struct Count {
        long round = 0;
        int particles = 0;
    };

    // Of particles [begin, end), a chunk.
    void findCells(const Particles<Dim>& particles, const Grid<Dim>& grid, int begin, int end) {
        int found[chunkSize] = {};
        for (int k = 0; k < Dim; ++k)
            grid.addCells(k, particles.position.plane(k) + begin, end - begin, found);
        hasChanged_[begin / chunkSize] = !std::equal(found, found + end - begin, cell_.begin() + begin);
        if (!hasChanged_[begin / chunkSize]) return;
        std::copy(found, found + end - begin, cell_.begin() + begin);
        const auto extremes = std::minmax_element(cell_.begin() + begin, cell_.begin() + end);
        slabsOf_[begin / chunkSize] = {*extremes.first / slabSize_, *extremes.second / slabSize_};
    }

    // The slabs among the threads.
    void divide(int slabs) {
        std::vector<int> inSlab(slabs, 0);
        for (const Range& range : slabsOf_) ++inSlab[(range.first + range.last) / 2];
        partition_.set(slabs, [&](int slab) { return inSlab[slab]; });
    }

    void findAlone(ParallelRegion& region, const Grid<Dim>& grid) {
        region.once([&] { count_.resize(grid.count); });
        forOwn(region, [&](int firstSlab, int endSlab) {
            forEach(firstSlab, endSlab, [&](int, int cell) {
                Count& count = count_[cell];
                count.particles = count.round == round_ ? count.particles + 1 : 1;
                count.round = round_;
            });
        });
        const auto hasMore = [&](int cell) {
            return count_[cell].round == round_ && count_[cell].particles > 1;
        };
        region.chunks(int(cell_.size()), [&](int begin, int end) {
            for (int p = begin; p < end; ++p) {
                bool isBesideMore = hasMore(cell_[p]);
                for (int k = 0; k < Dim; ++k)
                    isBesideMore |=
                        hasMore(cell_[p] - grid.strides[k]) || hasMore(cell_[p] + grid.strides[k]);
                if (isBesideMore) return;
            }
            alone_[begin / chunkSize] = 1;
        });
    }

    int slabSize_ = 0; // nodes in a slab of the grid
    long round_ = 0;
    bool located_ = false, stays_ = false;
    std::vector<char> hasChanged_; // of each chunk, whether a particle entered another cell
    std::vector<int> cell_;        // of each particle
    std::vector<Range> slabsOf_;   // of each chunk
    std::vector<char> alone_;      // of each chunk
    std::vector<Count> count_;     // of particles in each cell, for meshes
    WorkPartition partition_;      // of the slabs
};

} // namespace mpm
