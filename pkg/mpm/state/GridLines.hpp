// SPDX-License-Identifier: GPL-2.0-or-later
// The lines of nodes across one axis of a graded grid, and the coordinate that counts its cells,
//     xi(x) = i + (x - x_i)/(x_{i+1} - x_i)   in the cell between lines i and i + 1:
// the hat function of node i is hat(xi - i), as on equal cells.
#pragma once

#include "mpm/base/require.hpp"
#include "mpm/base/simd/compiler.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace mpm {

class GridLines {
  public:
    GridLines() = default;

    // inside: positions of the lines of the grid, m; so many ghost lines at either end go on with its cell.
    GridLines(const std::vector<double>& inside, int ghosts, int axis) {
        require(inside.size() >= 2, "Scene: ", inside.size(), " grid lines along axis ", axis,
                "; give two or more");
        for (size_t i = 0; i < inside.size(); ++i)
            require(std::isfinite(inside[i]) && (i == 0 || inside[i] > inside[i - 1]), "Scene: grid line ", i,
                    " along axis ", axis, " is at ", inside[i], " m; give finite positions that grow");
        const double first = inside[1] - inside[0], last = inside.back() - inside[inside.size() - 2];
        for (int i = ghosts; i > 0; --i) x_.push_back(inside.front() - i * first);
        x_.insert(x_.end(), inside.begin(), inside.end());
        for (int i = 1; i <= ghosts; ++i) x_.push_back(inside.back() + i * last);
        for (size_t i = 0; i + 1 < x_.size(); ++i) {
            size_.push_back(x_[i + 1] - x_[i]);
            overSize_.push_back(1 / size_.back());
        }
        smallest_ = *std::min_element(size_.begin(), size_.end());
        largest_ = *std::max_element(size_.begin(), size_.end());
        fillBins(axis);
    }

    double position(int line) const { return x_[line]; }
    double size(int line) const { return size_[line]; } // of the cell above a line
    double smallest() const { return smallest_; }       // of all cells
    double largest() const { return largest_; }

    // Whether the cells on both sides of a line have the smallest size, but for round-off.
    bool isEven(int line) const {
        constexpr double roundOff = 1e-10; // of a cell, between lines at some thousand cells from zero
        return std::max(size_[line - 1], size_[line]) <= (1 + roundOff) * smallest_;
    }

    // Beyond the last line the outermost cell goes on; not a number stays that.
    MPM_INLINE double inCells(double x) const {
        const int line = below(x);
        return line + (x - x_[line]) * overSize_[line];
    }
    // The line below a place, or the outermost one beyond that has a cell; the first for not a number.
    MPM_INLINE int below(double x) const {
        const double place = (x - x_[0]) * perBin_;
        const int bin = place > 0 ? int(place < lastBin_ ? place : lastBin_) : 0;
        const int line = lineOf_[bin];
        return line + (line < lastCell_ && x >= x_[line + 1]);
    }

  private:
    // Equal bins, so narrow that at most one line is in each.
    void fillBins(int axis) {
        constexpr double mostBins = 1e8;
        lastCell_ = int(size_.size()) - 1;
        perBin_ = 2 / smallest_;
        lastBin_ = std::floor((x_.back() - x_[0]) * perBin_);
        require(lastBin_ < mostBins, "Scene: cells along axis ", axis, " are from ", smallest_, " to ",
                largest_, " m long; give sizes that differ less");
        lineOf_.assign(size_t(lastBin_) + 1, 0);
        for (int line = 0; line <= lastCell_; ++line)
            for (size_t bin = size_t((x_[line] - x_[0]) * perBin_) + 1; bin < lineOf_.size(); ++bin) {
                if (bin > size_t((x_[line + 1] - x_[0]) * perBin_)) break;
                lineOf_[bin] = line;
            }
    }

    std::vector<double> x_, size_, overSize_;
    double smallest_ = 0, largest_ = 0, perBin_ = 0, lastBin_ = 0;
    int lastCell_ = 0;
    std::vector<int> lineOf_; // the last line before each bin
};

} // namespace mpm
