// SPDX-License-Identifier: GPL-2.0-or-later
// Points (particles or vertices) grouped by blocks of the grid. A block is scattered by one thread;
// blocks of one colour touch disjoint nodes. A point may wander `Grid::wander` nodes out of its block
// before the grouping is made anew, so the grouping is part of the state (and of a checkpoint).
#pragma once

#include "mpm/base/parallel/ColouredPieces.hpp"
#include "mpm/state/Grid.hpp"

#include <algorithm>
#include <numeric>

namespace mpm {

template <int Dim> class BlockOrder {
  public:
    // Nodes per axis that a point may reach. Points of a block stay within `wander` nodes of it, and the next
    // block of its colour begins two blocks further: with more, two threads would add to one node.
    static constexpr int largestSupport = Grid<Dim>::blockWidth - 2 * Grid<Dim>::wander + 1;

    std::vector<int> start; // first point of each block, and one past the last
    std::vector<int> order; // point numbers; empty: points are stored in this order already

    ColouredPieces coloured; // neighbouring blocks touch the same nodes

    int blocks() const { return int(start.size()) - 1; }
    // Not before the first grouping, nor from the checkpoint of a version with other blocks.
    bool isOf(const Grid<Dim>& grid) const { return blocks() == grid.blocks(); }
    int at(int i) const { return order.empty() ? i : order[i]; }

    // Groups points by block, within a block by cell if so wanted, and then by number.
    void group(const Grid<Dim>& grid, const std::vector<int>& cell, bool byCell = true) {
        isReady_ = false;
        order.resize(cell.size());
        std::iota(order.begin(), order.end(), 0);
        std::vector<int> block(cell.size());
        std::transform(cell.begin(), cell.end(), block.begin(),
                       [&](int c) { return grid.blockAt(grid.indices(c)); });
        std::stable_sort(order.begin(), order.end(), [&](int a, int b) {
            return block[a] != block[b] ? block[a] < block[b] : byCell && cell[a] < cell[b];
        });
        start.assign(grid.blocks() + 1, 0);
        for (int b : block) ++start[b + 1];
        for (size_t b = 1; b < start.size(); ++b) start[b] += start[b - 1];
    }

    // Before the first step with a new grouping. `support`: nodes per direction. One thread.
    bool isReady() const { return isReady_; }
    void prepare(const Grid<Dim>& grid, int support) {
        require(support >= 1 && support <= largestSupport, "a particle type whose points reach ", support,
                " nodes per axis was given; blocks of the grid allow 1 to ", largestSupport,
                ", or threads would add to the same node; use a narrower kernel");
        std::vector<std::vector<int>> beside(blocks());
        for (int b = 0; b < blocks(); ++b)
            grid.blocksBeside(b, [&](int other) { beside[b].push_back(other); });
        coloured.graph(beside);
        coloured.partition.set(blocks(), [&](int b) { return start[b + 1] - start[b]; });
        touched_.assign(blocks(), {});
        runs_.assign(blocks(), 0);
        support_ = support;
        isReady_ = true;
    }

    // Notes what part of the grid the points of block b touch, and how many runs of equal cells they make.
    // Needed only when a cell has changed since.
    void inspect(int b, const Grid<Dim>& grid, const std::vector<int>& cell) {
        Touched t;
        int runs = 0, last = -1;
        for (int i = start[b]; i < start[b + 1]; ++i) {
            const int here = cell[at(i)];
            if (here == last) continue;
            ++runs;
            last = here;
            const Index<Dim> index = grid.indices(here);
            for (int k = 0; k < Dim; ++k) {
                t.first[k] = std::min(t.first[k], index[k]);
                t.last[k] = std::max(t.last[k], index[k]);
            }
        }
        t.isKnown = true;
        touched_[b] = t;
        runs_[b] = runs;
    }
    bool isKnown(int b) const { return touched_[b].isKnown; }

    // Whether the part of the grid noted for block b has the support of a point in this cell.
    bool covers(int b, const Grid<Dim>& grid, int cell) const {
        const Index<Dim> index = grid.indices(cell);
        bool isInside = true;
        for (int k = 0; k < Dim; ++k)
            isInside &= index[k] >= touched_[b].first[k] && index[k] <= touched_[b].last[k];
        return isInside;
    }
    // Notes a point of block b that is in another cell now; what its old cell needed is kept.
    void extend(int b, const Grid<Dim>& grid, int cell) {
        const Index<Dim> index = grid.indices(cell);
        for (int k = 0; k < Dim; ++k) {
            touched_[b].first[k] = std::min(touched_[b].first[k], index[k]);
            touched_[b].last[k] = std::max(touched_[b].last[k], index[k]);
        }
    }

    // After `start` and `order` were set from outside.
    void forget() { isReady_ = false; }

    // A point left the neighbourhood of its block.
    bool broken(const Grid<Dim>& grid) const {
        for (int b = 0; b < blocks(); ++b) {
            const Index<Dim> begin = grid.blockBegin(b);
            for (int k = 1; k < Dim && start[b] < start[b + 1]; ++k)
                if (touched_[b].first[k] < begin[k] - grid.wander ||
                    touched_[b].last[k] >= begin[k] + grid.blockWidth + grid.wander)
                    return true;
        }
        return false;
    }

    // Number of runs of equal cells; grows as neighbours in memory drift apart.
    int runs() const { return std::accumulate(runs_.begin(), runs_.end(), 0); }

    void markExtents(NodalField<Dim>& field) const {
        for (int b = 0; b < blocks(); ++b)
            for (int slab = touched_[b].first[Dim - 1]; slab <= touched_[b].last[Dim - 1] + support_ - 1;
                 ++slab) {
                auto& extent = field.extents[slab];
                for (int k = 0; k < Dim - 1; ++k) {
                    extent.first[k] = std::min(extent.first[k], touched_[b].first[k]);
                    extent.last[k] = std::max(extent.last[k], touched_[b].last[k] + support_ - 1);
                }
            }
    }

    // Whether points may touch a node from `lowest` to `highest`: by the boxes round the blocks.
    bool mayTouch(const Index<Dim>& lowest, const Index<Dim>& highest) const {
        return std::any_of(touched_.begin(), touched_.begin() + blocks(), [&](const Touched& block) {
            bool may = true;
            for (int k = 0; k < Dim; ++k)
                may &= block.first[k] <= highest[k] && block.last[k] + support_ - 1 >= lowest[k];
            return may;
        });
    }

  private:
    struct Touched { // lowest and highest support corner of the block's points; none: first > last
        Index<Dim> first, last;
        bool isKnown = false;
        Touched() {
            first.fill(1 << 30);
            last.fill(-(1 << 30));
        }
    };
    bool isReady_ = false; // whether what follows is that of this grouping
    std::vector<Touched> touched_;
    std::vector<int> runs_;
    int support_ = 0;
};

} // namespace mpm
