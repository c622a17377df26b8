// SPDX-License-Identifier: GPL-2.0-or-later
// F-bar: one increment of volumetric strain, and one mean stress, per cell of the grid and body. tr L of a particle is replaced
// by its volume-weighted mean over the particles whose centres are in the same cell (de Souza Neto et al. 1996; for MPM Coombs
// et al. 2018), and after the stress update so is the mean stress. Without the latter the operator is not symmetric: mean
// stresses of yielding particles with friction part within a cell, and nothing brings them back.
#pragma once

#include "mpm/base/threads.hpp"
#include "mpm/scene/Body.hpp"

namespace mpm {

class CellAverage {
  public:
    // Before anything else; called by all threads.
    template <int Dim> void start(Team& team, int particles, const Grid<Dim>& grid) {
        team.once([&] {
            slabSize_ = grid.strides[Dim - 1], slabs_ = grid.slabs();
            cell_.resize(particles), value_.resize(particles), cells_.resize(grid.count), slabsOf_.resize(chunksOf(particles));
        });
    }

    // Cells of particles [begin, end), a chunk.
    template <int Dim> void locate(const Particles<Dim>& particles, const Grid<Dim>& grid, int begin, int end) {
        std::fill(cell_.begin() + begin, cell_.begin() + end, 0);
        for (int k = 0; k < Dim; ++k) {
            const double *x = particles.position.plane(k), last = grid.nodes[k] - 1.0;
            for (int p = begin; p < end; ++p) { // a particle that just left the grid is found out by the next step
                const double c = std::min(std::max(grid.inCells(x[p], k), 0.0), last);
                cell_[p] += int(c) * grid.strides[k];
            }
        }
        const auto extremes = std::minmax_element(cell_.begin() + begin, cell_.begin() + end);
        slabsOf_[begin / chunkSize] = {*extremes.first / slabSize_, *extremes.second / slabSize_};
    }

    // Of each particle: the value to be averaged, and after toChanges() what makes it the mean of its cell.
    double* values() { return value_.data(); }

    // Sums of the values in each cell, in the order of the particles, by the thread that has this stretch of the grid; called by all threads.
    void sum(Team& team, const double* volume) {
        team.once([&] {
            std::vector<int> inSlab(slabs_, 0);
            for (const Range& slabs : slabsOf_) ++inSlab[(slabs.first + slabs.last) / 2];
            shares_.set(slabs_, [&](int slab) { return inSlab[slab]; });
        });
        team.inStretches(shares_, [&](int firstSlab, int endSlab) {
            const int first = firstSlab * slabSize_, end = endSlab * slabSize_;
            const auto each = [&](auto&& f) {
                for (int c = 0; c < int(slabsOf_.size()); ++c)
                    if (slabsOf_[c].last >= firstSlab && slabsOf_[c].first < endSlab)
                        for (int p = c * chunkSize; p < std::min(int(cell_.size()), (c + 1) * chunkSize); ++p)
                            if (cell_[p] >= first && cell_[p] < end) f(p, cells_[cell_[p]]);
            };
            each([&](int, Cell& cell) { cell = {}; });
            each([&](int p, Cell& cell) { cell.volume += volume[p], cell.sum += volume[p] * value_[p]; });
        });
    }

    // For particles [begin, end).
    void toChanges(int begin, int end) {
        const int* cell = cell_.data();
        const Cell* cells = cells_.data();
        double* value = value_.data();
#pragma omp simd
        for (int p = begin; p < end; ++p) value[p] = cells[cell[p]].sum / cells[cell[p]].volume - value[p];
    }

  private:
    struct Cell {
        double volume = 0, sum = 0;
    };
    struct Range {
        int first, last;
    };
    int slabSize_ = 0, slabs_ = 0; // nodes in a slab of the grid, and number of slabs
    std::vector<int> cell_;        // of each particle
    std::vector<double> value_;
    std::vector<Cell> cells_;
    std::vector<Range> slabsOf_; // of each chunk
    Shares shares_;              // of the slabs
};

} // namespace mpm
