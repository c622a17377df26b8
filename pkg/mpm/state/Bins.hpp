// SPDX-License-Identifier: GPL-2.0-or-later
// Points sorted into bins by counting, and the bins that are the cells of the grid.
#pragma once

#include "mpm/state/Grid.hpp"

#include <algorithm>
#include <numeric>

namespace mpm {

// Points of a bin stand together, in the order of their numbers, and bins follow each other.
class Bins {
  public:
    // bin[i]: of point i.
    void fill(int bins, const std::vector<int>& bin) {
        start_.assign(bins + 1, 0);
        for (int b : bin) ++start_[b + 1];
        std::partial_sum(start_.begin(), start_.end(), start_.begin());
        next_.assign(start_.begin(), start_.end() - 1);
        point_.resize(bin.size());
        for (int i = 0; i < int(bin.size()); ++i) point_[next_[bin[i]]++] = i;
    }

    int begin(int bin) const { return start_[bin]; }
    int end(int bin) const { return start_[bin + 1]; }
    int point(int place) const { return point_[place]; }
    int count() const { return int(point_.size()); }

  private:
    std::vector<int> start_; // of the points of each bin, and one past the last
    std::vector<int> point_; // numbers of the points, bin by bin
    std::vector<int> next_;  // scratch of fill()
};

// Bins that are the cells of the grid, with a layer of bins around them for the points outside.
template <int Dim> class CellBins {
  public:
    // position(i, k): coordinate k of point i.
    template <class Position> void fill(const Grid<Dim>& grid, int count, Position&& position) {
        int bins = 1;
        for (int k = 0; k < Dim; ++k) {
            bins *= grid.cells[k] + 2;
            lowest_[k] = grid.cells[k] + 1;
            highest_[k] = 0;
        }
        bin_.assign(count, 0);
        for (int i = 0; i < count; ++i)
            for (int k = Dim - 1; k >= 0; --k) {
                const int cell = cellAlong(grid, position(i, k), k);
                bin_[i] = bin_[i] * (grid.cells[k] + 2) + cell;
                lowest_[k] = std::min(lowest_[k], cell);
                highest_[k] = std::max(highest_[k], cell);
            }
        bins_.fill(bins, bin_);
    }

    const Bins& bins() const { return bins_; }

    // Where points are along an axis, m; infinite where some are outside the grid.
    double lowerEnd(const Grid<Dim>& grid, int k) const {
        if (lowest_[k] == 0) return -std::numeric_limits<double>::infinity();
        return grid.line(k, lowest_[k] - 1 + grid.ghost);
    }
    double upperEnd(const Grid<Dim>& grid, int k) const {
        if (highest_[k] == grid.cells[k] + 1) return std::numeric_limits<double>::infinity();
        return grid.line(k, highest_[k] + grid.ghost);
    }

    // The occupied cells that a box reaches into; false: none.
    bool range(const Grid<Dim>& grid, const Vec<Dim>& lower, const Vec<Dim>& upper, Index<Dim>& first,
               Index<Dim>& last) const {
        for (int k = 0; k < Dim; ++k) {
            first[k] = std::max(lowest_[k], cellAlong(grid, lower[k], k));
            last[k] = std::min(highest_[k], cellAlong(grid, upper[k], k));
            if (first[k] > last[k]) return false;
        }
        return true;
    }

    // f(bin, cell) for all cells of a range, first axis fastest, until one returns true. Returns whether one
    // did.
    template <class F>
    static bool anyOf(const Grid<Dim>& grid, const Index<Dim>& first, const Index<Dim>& last, F&& f) {
        Index<Dim> cell = first;
        for (;;) {
            int bin = 0;
            for (int k = Dim - 1; k >= 0; --k) bin = bin * (grid.cells[k] + 2) + cell[k];
            for (cell[0] = first[0]; cell[0] <= last[0]; ++cell[0], ++bin)
                if (f(bin, cell)) return true;
            cell[0] = first[0];
            int k = 1;
            for (; k < Dim; ++k) {
                if (++cell[k] <= last[k]) break;
                cell[k] = first[k];
            }
            if (k == Dim) return false;
        }
    }

    static Vec<Dim> centre(const Grid<Dim>& grid, const Index<Dim>& cell) {
        Index<Dim> fromGhosts;
        for (int k = 0; k < Dim; ++k) fromGhosts[k] = cell[k] - 1 + grid.ghost;
        return grid.centre(fromGhosts);
    }

  private:
    Bins bins_;
    std::vector<int> bin_;
    Index<Dim> lowest_, highest_; // occupied cells, counted from the layer outside

    static int cellAlong(const Grid<Dim>& grid, double x, int k) {
        const double cell = std::floor(grid.fromLower(x, k)) + 1;
        return cell > 0 ? int(std::min(cell, grid.cells[k] + 1.0)) : 0;
    }
};

} // namespace mpm
