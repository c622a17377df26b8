// SPDX-License-Identifier: GPL-2.0-or-later
// Single cells of the grid inside the material of a body that no particle is in. Soil that flows leaves some, and
// what flows out of them would get lost: no particle feels it, no stress resists. The cells beside them take it,
//     r_n += q_n part_n s (V_h' - V_h)/dt / V_a,   q_n, V_a: see CellAverage,
// and their mean stress acts on the corners of the hole by the conjugate, f = - s V_h sum_n part_n p_n grad phi.
#pragma once

#include "mpm/state/cover.hpp"

#include <utility>
#include <vector>

namespace mpm {

// The cells of all slabs, sorted, each once; leaves none.
inline std::vector<int> takeAll(std::vector<std::vector<int>>& slabs) {
    std::vector<int> cells;
    for (auto& slab : slabs) {
        cells.insert(cells.end(), slab.begin(), slab.end());
        slab.clear();
    }
    std::sort(cells.begin(), cells.end());
    cells.erase(std::unique(cells.begin(), cells.end()), cells.end());
    return cells;
}

template <int Dim> struct Hole {
    int cell = 0;
    double volume = 0;                            // s times that of the cell, m3
    std::vector<std::pair<int, double>> takers{}; // cells of this body beside it, and what part goes to each
};

template <int Dim> class Holes {
  public:
    void resize(int slabs) { found_.resize(slabs); }

    // Beside an occupied cell, by the thread that owns its slab. coverOf(cell): of all that moves together.
    template <class Cover> void look(const Grid<Dim>& grid, int cell, int slab, Cover&& coverOf) {
        const Index<Dim> index = grid.indices(cell);
        for (int k = 0; k < Dim; ++k)
            for (int side : {-1, 1}) {
                const int at = index[k] + side - grid.ghost, hole = cell + side * grid.strides[k];
                if (at < 0 || at >= grid.cells[k] || coverOf(hole) > 0) continue;
                if (isEnclosed(grid, hole, coverOf)) found_[slab].push_back(hole);
            }
    }
    // What look() found, but for cells that another body may be in, or that have a corner without mass.
    // One thread. ownCover(cell): of this body. lackMass: see CellAverage::findInside().
    template <class Cover, class Own, class IsFree, class LackMass>
    void gather(const Grid<Dim>& grid, Cover&& coverOf, Own&& ownCover, IsFree&& isFree,
                LackMass&& lackMass) {
        const std::vector<int> cells = takeAll(found_), lacking = lackMass(cells);
        holes_.clear();
        for (int cell : cells) {
            if (!isFree(cell) || std::binary_search(lacking.begin(), lacking.end(), cell)) continue;
            Hole<Dim> hole{cell, insideBy(grid, cell, coverOf) * grid.volume(cell)};
            double sum = 0;
            for (int k = 0; k < Dim; ++k)
                for (int beside : {cell - grid.strides[k], cell + grid.strides[k]}) {
                    sum += coverOf(beside);
                    if (ownCover(beside) > 0) hole.takers.push_back({beside, ownCover(beside)});
                }
            for (auto& taker : hole.takers) taker.second /= sum;
            holes_.push_back(std::move(hole));
        }
    }
    bool empty() const { return holes_.empty(); }
    auto begin() const { return holes_.begin(); }
    auto end() const { return holes_.end(); }

  private:
    // Whether there is material beyond all faces of a cell but those at the walls of the grid: a crack is no hole.
    template <class Cover> static bool isEnclosed(const Grid<Dim>& grid, int cell, Cover&& coverOf) {
        const Index<Dim> index = grid.indices(cell);
        bool is = true;
        for (int k = 0; k < Dim; ++k)
            for (int side : {-1, 1}) {
                const int at = index[k] + side - grid.ghost;
                is = is && (at < 0 || at >= grid.cells[k] || coverOf(cell + side * grid.strides[k]) > 0);
            }
        return is;
    }

    std::vector<Hole<Dim>> holes_;
    std::vector<std::vector<int>> found_; // by the slabs of the cells beside them
};

} // namespace mpm
