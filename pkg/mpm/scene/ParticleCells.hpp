// SPDX-License-Identifier: GPL-2.0-or-later
// Which cell of the grid each point of a body is in (CellPoints), for sums cell by cell. Slabs of the grid belong to
// threads, and each goes through the points in their order: the same sums on any number of threads.
#pragma once

#include "mpm/scene/CellPoints.hpp"
#include "mpm/scene/LoneDomains.hpp"

#include <algorithm>
#include <vector>

namespace mpm {

template <int Dim> class ParticleCells {
  public:
    // Before locate(), by one thread. mayBeAlone: they are domains of a mesh; inParts: the mesh whose domains count in
    // parts.
    void start(const Particles<Dim>& particles, const Grid<Dim>& grid, bool mayBeAlone, Mesh<Dim>* inParts) {
        points_.start(particles, inParts);
        stays_ = round_ > 0 && mayBeAlone_ == mayBeAlone && int(cell_.size()) == points_.size() &&
                 particles_ == particles.size();
        mayBeAlone_ = mayBeAlone;
        located_ = true;
        particles_ = particles.size();
        slabSize_ = grid.strides[Dim - 1];
        cell_.resize(points_.size());
        const int chunks = chunksOf(particles_);
        slabsOf_.resize(chunks);
        hasChanged_.resize(chunks);
    }
    // Called by all threads. In most steps no point of a body that hardly moves enters another cell: then all stays.
    void locate(ParallelRegion& region, const Grid<Dim>& grid) {
        region.chunks(particles_, [&](int begin, int end) { findCells(grid, begin, end); });
        region.once([&] {
            stays_ &=
                std::none_of(hasChanged_.begin(), hasChanged_.end(), [](char changed) { return changed; });
            if (stays_) return;
            ++round_;
            divide(grid.slabs());
        });
        if (mayBeAlone_ && !stays_) lone_.find(region, grid, cell_);
    }
    // Whether start() was called for so many since forget().
    bool areLocated(int particles) const { return located_ && particles_ == particles; }
    void forget() { located_ = false; }

    // Number of calls of locate() so far in which a point was in another cell than before, and whether none was in
    // the last one.
    long round() const { return round_; }
    bool stay() const { return stays_; }

    const CellPoints<Dim>& points() const { return points_; }
    int operator[](int point) const { return cell_[point]; }
    int slabOf(int cell) const { return cell / slabSize_; }
    // Whether the particles from `begin` on, a chunk, are one in each cell, and those in the cells beside, too.
    bool areAlone(int begin) const { return mayBeAlone_ && lone_.isAlone(begin / chunkSize); }
    // Whether the particles may be alone, and some are in a cell.
    bool hasLone(int cell) const { return mayBeAlone_ && lone_.hasAny(cell); }

    // f(first slab, end) on each thread with the slabs that it owns.
    template <class F> void forOwn(ParallelRegion& region, F&& f) const { region.forOwnRange(partition_, f); }
    // f(point, its particle, its cell) for those in some slabs, in their order, but for chunks that are alone.
    template <class F> void forEach(int firstSlab, int endSlab, F&& f) const {
        const int first = firstSlab * slabSize_, end = endSlab * slabSize_;
        for (int c = 0; c < int(slabsOf_.size()); ++c) {
            if (slabsOf_[c].last < firstSlab || slabsOf_[c].first >= endSlab || areAlone(c * chunkSize))
                continue;
            for (int p = c * chunkSize; p < std::min(particles_, (c + 1) * chunkSize); ++p)
                for (int point = points_.at(p), last = point + points_.per(p); point < last; ++point)
                    if (cell_[point] >= first && cell_[point] < end) f(point, p, cell_[point]);
        }
    }

  private:
    struct Range {
        int first, last;
    };
    // Of particles [begin, end), a chunk.
    void findCells(const Grid<Dim>& grid, int begin, int end) {
        int found[corners<Dim> * chunkSize];
        points_.place(grid, begin, end, found);
        const int c = begin / chunkSize, first = points_.at(begin), count = points_.at(end) - first;
        hasChanged_[c] = !std::equal(found, found + count, cell_.begin() + first);
        if (!hasChanged_[c]) return;
        std::copy(found, found + count, cell_.begin() + first);
        const auto extremes = std::minmax_element(found, found + count);
        slabsOf_[c] = {*extremes.first / slabSize_, *extremes.second / slabSize_};
    }

    // The slabs among the threads.
    void divide(int slabs) {
        std::vector<int> inSlab(slabs, 0);
        for (const Range& range : slabsOf_) ++inSlab[(range.first + range.last) / 2];
        partition_.set(slabs, [&](int slab) { return inSlab[slab]; });
    }

    int particles_ = 0;
    int slabSize_ = 0; // nodes in a slab of the grid
    long round_ = 0;
    bool located_ = false, stays_ = false, mayBeAlone_ = false;
    CellPoints<Dim> points_;
    LoneDomains<Dim> lone_;
    std::vector<char> hasChanged_; // of each chunk, whether a point entered another cell
    std::vector<Range> slabsOf_;   // of each chunk
    std::vector<int> cell_;        // of each point
    WorkPartition partition_;      // of the slabs
};

} // namespace mpm
