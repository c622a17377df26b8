// SPDX-License-Identifier: GPL-2.0-or-later
// A small system for groups of cells, as a part of the preconditioner of the pore pressure (step/PoreMatrix.hpp): one
// pressure for each block of the grid, with the sums of the matrix over its cells. The diagonal alone carries a
// pressure by a cell in an iteration, the blocks carry it all the way (Nicolaides 1987).
#pragma once

#include "mpm/step/BandMatrix.hpp"
#include "mpm/step/PorePlaces.hpp"

#include <algorithm>
#include <vector>

namespace mpm {

template <int Dim> class PoreCoarse {
  public:
    // places: of the unknowns in an array of `size`; first: number in the grid of place 0.
    void start(const std::vector<int>& places, int size, int first, const Index<Dim>& strides) {
        groups_.assign(size, 0);
        std::vector<int> blocks(places.size());
        Index<Dim> lowest = indicesOf(places.empty() ? 0 : first + places[0], strides), highest = lowest;
        for (int p : places) {
            const Index<Dim> cell = indicesOf(first + p, strides);
            for (int k = 0; k < Dim; ++k) {
                lowest[k] = std::min(lowest[k], cell[k]);
                highest[k] = std::max(highest[k], cell[k]);
            }
        }
        int most = 1;
        Index<Dim> wide; // blocks along each axis
        for (width_ = leastWidth;; width_ *= 2) {
            most = 1;
            for (int k = 0; k < Dim; ++k) most *= wide[k] = highest[k] / width_ - lowest[k] / width_ + 1;
            const double band = most / wide[Dim - 1];
            if (most * band * band <= workOverCells * places.size() + 1e6) break;
        }
        for (size_t c = 0; c < places.size(); ++c) {
            const Index<Dim> cell = indicesOf(first + places[c], strides);
            int& block = blocks[c] = 0;
            for (int k = Dim - 1; k >= 0; --k)
                block = block * wide[k] + cell[k] / width_ - lowest[k] / width_;
        }
        numbers_.assign(most, 0);
        for (int block : blocks) numbers_[block] = 1;
        int count = 0;
        for (int& number : numbers_) number = number ? count++ : -1;
        segments_.clear();
        firstSegment_.clear();
        for (size_t c = 0; c < places.size(); ++c) {
            const int p = places[c], group = numbers_[blocks[c]];
            groups_[p] = group;
            if (c % PorePlaces<Dim>::blockSize == 0) firstSegment_.push_back(int(segments_.size()));
            if (c % PorePlaces<Dim>::blockSize == 0 || p != places[c - 1] + 1 ||
                group != segments_.back().group)
                segments_.push_back({p, p, group});
            segments_.back().last = p + 1;
        }
        firstSegment_.push_back(int(segments_.size()));
        count_ = count;
        band_ = 0;
        const int ahead = Dim == 2 ? 4 : 13; // blocks beyond one, of those round it
        for (int s = 1; s <= ahead; ++s) {
            int step = 0, rest = s + ahead;
            for (int k = 0, stride = 1; k < Dim; stride *= wide[k++], rest /= 3)
                step += (rest % 3 - 1) * stride;
            for (int block = 0; step > 0 && block + step < most;
                 ++block) // 0 or less: one block is as wide as all
                if (numbers_[block] >= 0 && numbers_[block + step] >= 0)
                    band_ = std::max(band_, numbers_[block + step] - numbers_[block]);
        }
    }
    void clear() { entries_.clear(); }
    // What two places have of the matrix, once for both; at equal places: of the diagonal.
    void add(int a, int b, double value) {
        const int row = std::max(groups_[a], groups_[b]), column = std::min(groups_[a], groups_[b]);
        if (row == column && a != b) value *= 2;
        if (!entries_.empty() && entries_.back().row == row && entries_.back().column == column)
            entries_.back().value += value;
        else
            entries_.push_back({row, column, value});
    }
    // Behind those.
    void reset() {
        int band = band_;
        for (const Entry& entry : entries_) band = std::max(band, entry.row - entry.column);
        matrix_.reset(count_, band);
        for (const Entry& entry : entries_) matrix_.at(entry.row, entry.column) += entry.value;
    }
    // What each place has of the matrix with the one that is a step beyond it; step 0: of the diagonal.
    void addAll(const double* values, int step) {
        for (const auto& [first, last, group] : segments_)
            for (int p = first; p < last;) {
                const int other = groups_[p + step];
                double sum = 0;
                for (; p < last && groups_[p + step] == other; ++p) sum += values[p];
                if (sum == 0) continue; // where there is no other
                const bool isOne = group == other && step != 0;
                matrix_.at(std::max(group, other), std::min(group, other)) += isOne ? 2 * sum : sum;
            }
    }
    void factorise() {
        isGood_ = matrix_.factorise();
        pressure_.assign(matrix_.padded(), 0.0);
    }
    // What the blocks do against a residual; returns its product with that.
    double solve(const std::vector<double>& residuals) {
        const double* const residual = residuals.data();
        std::fill(pressure_.begin(), pressure_.end(), 0.0);
        if (!isGood_) return 0;
        for (const auto& [first, last, group] : segments_) {
            double sum = 0;
#pragma omp simd reduction(+ : sum)
            for (int p = first; p < last; ++p) sum += residual[p];
            pressure_[group] += sum;
        }
        sums_.assign(pressure_.begin(), pressure_.end());
        matrix_.solve(pressure_.data());
        double product = 0;
        for (int i = 0; i < count_; ++i) product += sums_[i] * pressure_[i];
        return product;
    }
    // Of the diagonal, that the matrix has for what is narrower than a block; 0: the blocks carry nothing.
    double leastPart() const { return isGood_ ? 1.0 / (double(width_) * width_) : 0; }
    // f(first place, end, pressure) for the unknowns of a block.
    template <class F> void forSegments(int begin, F&& f) const {
        const int block = begin / PorePlaces<Dim>::blockSize;
        for (int i = firstSegment_[block]; i < firstSegment_[block + 1]; ++i)
            f(segments_[i].first, segments_[i].last, pressure_[segments_[i].group]);
    }

  private:
    static constexpr int leastWidth = Dim == 2 ? 8 : 4; // of a block, in cells
    // Products to factorise the blocks for each cell, at most: as many as twenty iterations take.
    static constexpr double workOverCells = 1000;
    struct Segment {
        int first, last, group; // places side by side
    };
    struct Entry {
        int row, column;
        double value;
    };

    int count_ = 0, width_ = leastWidth;
    int band_ = 0; // of the sums over neighbours in the grid
    bool isGood_ = false;
    std::vector<int> groups_;  // of each place
    std::vector<int> numbers_; // of the blocks of the grid, -1: no unknown
    std::vector<Segment> segments_;
    std::vector<int> firstSegment_; // of each block, and the end
    std::vector<Entry> entries_;
    BandMatrix matrix_;
    std::vector<double> pressure_, sums_; // of the groups

    static Index<Dim> indicesOf(int number, const Index<Dim>& strides) {
        Index<Dim> cell;
        for (int k = Dim - 1; k >= 0; --k) {
            cell[k] = number / strides[k];
            number -= cell[k] * strides[k];
        }
        return cell;
    }
};

} // namespace mpm
