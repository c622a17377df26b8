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
    // Cells of the particles. All functions are called by all threads.
    template <int Dim> void locate(Team& team, const Particles<Dim>& particles, const Grid<Dim>& grid) {
        const int n = particles.size();
        team.once([&] { cell_.resize(n), change_.resize(n), cells_.resize(grid.count); });
        team.chunks(n, [&](int begin, int end) {
            std::fill(cell_.begin() + begin, cell_.begin() + end, 0);
            for (int k = 0; k < Dim; ++k) {
                const double *x = particles.position.plane(k), last = grid.nodes[k] - 1.0;
                for (int p = begin; p < end; ++p) { // a particle that just left the grid is found out by the next step
                    const double c = std::min(std::max(grid.inCells(x[p], k), 0.0), last);
                    cell_[p] += int(c) * grid.strides[k];
                }
            }
        });
    }

    // Changes that make a value the same in a cell; value(begin, end, v) fills in v. The sums of a cell go in the order of the
    // particles, by one thread.
    template <class Value> void find(Team& team, const double* volume, Value&& value) {
        const int n = int(cell_.size());
        team.chunks(n, [&](int begin, int end) { value(begin, end, change_.data() + begin); });
        team.once([&] {
            for (int p = 0; p < n; ++p) cells_[cell_[p]] = {};
            for (int p = 0; p < n; ++p) {
                Cell& cell = cells_[cell_[p]];
                cell.volume += volume[p], cell.sum += volume[p] * change_[p];
            }
        });
        team.chunks(n, [&](int begin, int end) {
            for (int p = begin; p < end; ++p) change_[p] = cells_[cell_[p]].sum / cells_[cell_[p]].volume - change_[p];
        });
    }

    const double* change() const { return change_.data(); }

  private:
    struct Cell {
        double volume = 0, sum = 0;
    };
    std::vector<int> cell_; // of each particle
    std::vector<double> change_;
    std::vector<Cell> cells_;
};

} // namespace mpm
