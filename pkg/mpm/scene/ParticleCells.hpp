// SPDX-License-Identifier: GPL-2.0-or-later
// Which cell of the grid each point of a body is in (CellPoints), and which points are in each cell, for sums cell by
// cell. Slabs of the grid belong to threads, and a cell has its points in their order: the same sums on any number of
// threads. In most steps few points enter another cell, and only the slabs of these are listed anew.
#pragma once

#include "mpm/scene/CellPoints.hpp"
#include "mpm/scene/LoneDomains.hpp"

#include <algorithm>
#include <utility>
#include <vector>

namespace mpm {

// Where a wall parts a soil the particles on its second side have cells of their own, with numbers from Grid::count on:
// those of cells that have nodes on which the soil is two.
struct SecondCells {
    const char *isSecond = nullptr, *isParted = nullptr; // each particle; each cell. nullptr: there are none
};

template <int Dim> class ParticleCells {
  public:
    // Before locate(), by one thread. mayBeAlone: they are domains of a mesh; inParts: the mesh whose domains count in
    // parts.
    void start(const Particles<Dim>& particles, const Grid<Dim>& grid, bool mayBeAlone, Mesh<Dim>* inParts,
               const SecondCells& second = {}) {
        points_.start(particles, inParts);
        second_ = second;
        const int halves = second.isSecond ? 2 : 1;
        isKept_ = mayBeAlone_ == mayBeAlone && int(cell_.size()) == points_.size() &&
                  particles_ == particles.size() && int(isListed_.size()) == halves * grid.slabs();
        mayBeAlone_ = mayBeAlone;
        located_ = true;
        particles_ = particles.size();
        slabSize_ = grid.strides[Dim - 1];
        cell_.resize(points_.size());
        const int chunks = chunksOf(particles_);
        slabsOf_.resize(chunks);
        changed_.resize(chunks);
        inCell_.resize(halves * grid.count);
        occupied_.resize(halves * grid.slabs());
        lists_.resize(halves * grid.slabs());
        isListed_.resize(halves * grid.slabs());
    }
    // Called by all threads.
    void locate(ParallelRegion& region, const Grid<Dim>& grid) {
        region.chunks(particles_, [&](int begin, int end) { findCells(grid, begin, end); });
        region.once([&] {
            const bool hasChanged = std::any_of(changed_.begin(), changed_.end(),
                                                [](const Range& slabs) { return !slabs.isEmpty(); });
            isKept_ = isKept_ && !(mayBeAlone_ && hasChanged); // who is alone depends on others
            std::fill(isListed_.begin(), isListed_.end(), isKept_);
            for (const Range& slabs : changed_)
                for (int slab = slabs.first; slab <= slabs.last; ++slab) isListed_[slab] = false;
            if (hasChanged || !isKept_) divide(int(isListed_.size()));
        });
        if (mayBeAlone_ && !isKept_) lone_.find(region, grid, cell_);
        forOwn(region, [&](int firstSlab, int endSlab) {
            for (int slab = firstSlab; slab < endSlab; ++slab) {
                const int first = slab;
                while (slab < endSlab && !isListed_[slab]) ++slab;
                if (slab > first) list(first, slab);
            }
        });
    }
    // Whether start() was called for so many since forget().
    bool areLocated(int particles) const { return located_ && particles_ == particles; }
    void forget() { located_ = false; }

    // Whether locate() has found the points of a slab in the cells where they were.
    bool hasKept(int slab) const { return isListed_[slab]; }
    // The cells of a slab that points are in.
    const std::vector<int>& occupied(int slab) const { return occupied_[slab]; }
    bool has(int cell) const { return !inCell_.empty() && inCell_[cell].count > 0; }
    // f(point, its particle) for those in a cell.
    template <class F> void forPoints(int cell, F&& f) const {
        const Points& in = inCell_[cell];
        for (int i = 0; i < in.count; ++i) f(in.first[i], points_.particleOf(in.first[i]));
    }

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
        int first = 0, last = -1;
        bool isEmpty() const { return last < first; }
    };
    struct Points {
        int* first = nullptr; // in lists_
        int count = 0;
    };
    // The points of some slabs, cell by cell.
    void list(int firstSlab, int endSlab) {
        for (int slab = firstSlab; slab < endSlab; ++slab) {
            for (int cell : occupied_[slab]) inCell_[cell].count = 0;
            occupied_[slab].clear();
        }
        forEach(firstSlab, endSlab, [&](int, int, int cell) {
            if (inCell_[cell].count++ == 0) occupied_[slabOf(cell)].push_back(cell);
        });
        for (int slab = firstSlab; slab < endSlab; ++slab) {
            size_t size = 0;
            for (int cell : occupied_[slab]) size += inCell_[cell].count;
            lists_[slab].resize(size);
            int* first = lists_[slab].data();
            for (int cell : occupied_[slab]) {
                inCell_[cell].first = first;
                first += std::exchange(inCell_[cell].count, 0);
            }
        }
        forEach(firstSlab, endSlab, [&](int point, int, int cell) {
            Points& in = inCell_[cell];
            in.first[in.count++] = point;
        });
    }
    // Of particles [begin, end), a chunk.
    void findCells(const Grid<Dim>& grid, int begin, int end) {
        int found[corners<Dim> * chunkSize];
        points_.place(grid, begin, end, found);
        for (int p = begin; p < end && second_.isSecond; ++p)
            if (int& cell = found[p - begin]; second_.isSecond[p] && second_.isParted[cell])
                cell += grid.count;
        const int c = begin / chunkSize, first = points_.at(begin), count = points_.at(end) - first;
        changed_[c] = {};
        if (std::equal(found, found + count, cell_.begin() + first)) return;
        std::copy(found, found + count, cell_.begin() + first);
        const auto extremes = std::minmax_element(found, found + count);
        const Range before = slabsOf_[c], now{*extremes.first / slabSize_, *extremes.second / slabSize_};
        changed_[c] = before.isEmpty()
                          ? now
                          : Range{std::min(before.first, now.first), std::max(before.last, now.last)};
        slabsOf_[c] = now;
    }

    // The slabs among the threads.
    void divide(int slabs) {
        std::vector<int> inSlab(slabs, 0);
        for (const Range& range : slabsOf_) ++inSlab[(range.first + range.last) / 2];
        partition_.set(slabs, [&](int slab) { return inSlab[slab]; });
    }

    int particles_ = 0;
    int slabSize_ = 0; // nodes in a slab of the grid
    bool located_ = false, mayBeAlone_ = false;
    bool isKept_ = false; // whether the lists hold but for slabs that points of chunks have changed in
    SecondCells second_;
    CellPoints<Dim> points_;
    LoneDomains<Dim> lone_;
    std::vector<Range> slabsOf_, changed_;   // of each chunk; in which a point has entered another cell
    std::vector<int> cell_;                  // of each point
    std::vector<Points> inCell_;             // of each cell of the grid
    std::vector<std::vector<int>> occupied_; // of each slab: its cells with points,
    std::vector<std::vector<int>> lists_;    // its points, cell by cell,
    std::vector<char> isListed_;             // and whether these are those of the last step
    WorkPartition partition_;                // of the slabs
};

} // namespace mpm
