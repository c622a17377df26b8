// SPDX-License-Identifier: GPL-2.0-or-later
// F-bar: one increment of volumetric strain per cell of the grid and body, and one mean stress that is linear
// in it. tr L of a particle is replaced by its volume-weighted mean over the particles whose centres are in
// the same cell (de Souza Neto et al. 1996; for MPM Coombs et al. 2018), and after the stress update the mean
// stress by that of the cell and the slopes towards its neighbours. Without the latter the operator is not
// symmetric: mean stresses of yielding particles with friction part within a cell, and nothing brings them
// back. Without slopes the mean stress would be a staircase of cells.
//
// Boxes do not cover a cell evenly once they have flowed, and then sum V tr L over the particles is not what
// flows through the faces of the cells. Where material fills the cells all round, share s, the cell itself is
// the point of integration (doc/explanation/volumes.md):
//     r_c = s (V_c' - V_c)/(V_c dt) + (1 - s) sum V_p r_p / sum V_p,   r_p = (det(I + dt L_p) - 1)/dt
// with V_c' the volume between the corners of the cell as they move, and its mean stress acts by the cell, see
// CellForces.hpp. Determinants, for traces miss what fast rotation adds: 1 + (dt w)^2.
#pragma once

#include "mpm/base/parallel/ParallelRegion.hpp"
#include "mpm/particle/apdi/APDIShape.hpp"
#include "mpm/scene/Body.hpp"
#include "mpm/step/cover.hpp"

namespace mpm {

class CellAverage {
  public:
    // Before anything else; called by all threads.
    template <int Dim> void start(ParallelRegion& region, int particles, const Grid<Dim>& grid) {
        region.once([&] {
            for (int k = 0; k < Dim; ++k) {
                strides_[k] = grid.strides[k];
                edges_[k] = grid.smallestCell()[k];
                sizes_[k].clear();
                for (int line = 0; line < grid.nodes[k] - 1 && grid.isGraded(); ++line)
                    sizes_[k].push_back(grid.cellSize(k, line));
            }
            slabSize_ = grid.strides[Dim - 1];
            slabs_ = grid.slabs();
            cell_.resize(particles);
            value_.resize(particles);
            cells_.resize(grid.count);
            occupied_.resize(slabs_);
            slabsOf_.resize(chunksOf(particles));
        });
    }

    // Cells of particles [begin, end), a chunk.
    template <int Dim>
    void locate(const Particles<Dim>& particles, const Grid<Dim>& grid, int begin, int end) {
        std::fill(cell_.begin() + begin, cell_.begin() + end, 0);
        for (int k = 0; k < Dim; ++k) {
            const double *x = particles.position.plane(k), last = grid.nodes[k] - 2.0;
            // A particle that just left the grid, or has no place (nan), is found out by the next step.
            grid.alongAxis(k, [&](auto&& inCells) {
                for (int p = begin; p < end; ++p) {
                    const double c = std::min(std::max(1.0, inCells(x[p])), last);
                    cell_[p] += int(c) * grid.strides[k];
                }
            });
        }
        const auto extremes = std::minmax_element(cell_.begin() + begin, cell_.begin() + end);
        slabsOf_[begin / chunkSize] = {*extremes.first / slabSize_, *extremes.second / slabSize_};
    }

    // Of each particle: the value to be averaged, and after toMeans() or toLinear() what changes it to the
    // average.
    double* values() { return value_.data(); }

    // Sums of the values in each cell, in the order of the particles, by the thread that has this stretch of
    // the grid; called by all threads.
    template <bool withCentres, int Dim> void sum(ParallelRegion& region, const Particles<Dim>& particles) {
        region.once([&] {
            ++round_;
            std::vector<int> inSlab(slabs_, 0);
            for (const Range& slabs : slabsOf_) ++inSlab[(slabs.first + slabs.last) / 2];
            partitions_.set(slabs_, [&](int slab) { return inSlab[slab]; });
        });
        const double *volume = particles.volume.plane(), *x[Dim];
        for (int k = 0; k < Dim; ++k) x[k] = particles.position.plane(k);
        region.forOwnRange(partitions_, [&](int firstSlab, int endSlab) {
            const int first = firstSlab * slabSize_, end = endSlab * slabSize_;
            for (int slab = firstSlab; slab < endSlab; ++slab) occupied_[slab].clear();
            for (int c = 0; c < int(slabsOf_.size()); ++c)
                if (slabsOf_[c].last >= firstSlab && slabsOf_[c].first < endSlab)
                    for (int p = c * chunkSize; p < std::min(int(cell_.size()), (c + 1) * chunkSize); ++p) {
                        if (cell_[p] < first || cell_[p] >= end) continue;
                        Cell& cell = cells_[cell_[p]];
                        const bool isEmpty = cell.round != round_;
                        if (isEmpty) occupied_[cell_[p] / slabSize_].push_back(cell_[p]);
                        cell.round = round_;
                        cell.particles = isEmpty ? 1 : cell.particles + 1;
                        cell.volume = (isEmpty ? 0 : cell.volume) + volume[p];
                        cell.sum = (isEmpty ? 0 : cell.sum) + volume[p] * value_[p];
                        for (int k = 0; k < Dim && withCentres; ++k)
                            cell.moment[k] = (isEmpty ? 0 : cell.moment[k]) + volume[p] * x[k][p];
                    }
        });
    }

    // After sum(): which cells lie inside the material, and what of their mean acts by particles and by cells, see
    // CellForces.hpp.
    template <int Dim> void findInside(ParallelRegion& region, const Grid<Dim>& grid) {
        const auto volumeOf = [&](int c) { return cells_[c].round == round_ ? cells_[c].volume : 0; };
        region.forOwnRange(partitions_, [&](int firstSlab, int endSlab) {
            for (int slab = firstSlab; slab < endSlab; ++slab)
                for (int c : occupied_[slab]) {
                    Cell& cell = cells_[c];
                    cell.inside = insideBy(grid, c, volumeOf);
                    const double volume =
                        cell.inside * grid.edges(c).prod() + (1 - cell.inside) * cell.volume;
                    cell.byCell = cell.inside * volume * cell.mean();
                    cell.byParticles = (1 - cell.inside) * volume / cell.volume * cell.mean();
                }
        });
    }

    // For particles [begin, end): the rate of volume change of their cell, from those of the particles, which
    // volumeRates() gives, and from the nodal velocities.
    template <int Dim, class Velocity>
    void toRates(const Grid<Dim>& grid, const Velocity* nodes, double dt, int begin, int end) {
        for (int p = begin; p < end;) {
            const int number = cell_[p];
            const Cell& cell = cells_[number];
            double rate = cell.mean();
            if (cell.inside > 0)
                rate = cell.inside * growth(grid, nodes, dt, number) + (1 - cell.inside) * rate;
            for (; p < end && cell_[p] == number; ++p) value_[p] = rate - value_[p];
        }
    }

    // What acts of the mean of its cell by the volume of particle p.
    double actingByParticle(int p) const { return cells_[cell_[p]].byParticles; }

    // -sum V_c s_c mean_c grad phi_ic over the cells around a node: what acts by the cells.
    template <int Dim> Vec<Dim> force(const Grid<Dim>& grid, int node) const {
        Vec<Dim> sum = Vec<Dim>::Zero();
        for (int a = 0; a < corners<Dim>; ++a) { // the node is corner a of the cell
            int number = node;
            for (int k = 0; k < Dim; ++k) number -= cornerSign(a, k) > 0 ? grid.strides[k] : 0;
            if (number < 0 || cells_[number].round != round_) continue;
            const double acting = cells_[number].byCell;
            if (grid.isGraded())
                for (int k = 0; k < Dim; ++k) sum[k] -= cornerSign(a, k) * acting / grid.edges(number)[k];
            else
                for (int k = 0; k < Dim; ++k) sum[k] -= cornerSign(a, k) * acting;
        }
        return (grid.isGraded() ? sum : Vec<Dim>(sum.cwiseQuotient(grid.smallestCell()))) /
               (corners<Dim> / 2);
    }

    // For particles [begin, end): the mean of their cell.
    void toMeans(int begin, int end) {
        const int* cell = cell_.data();
        const Cell* cells = cells_.data();
        double* value = value_.data();
#pragma omp simd
        for (int p = begin; p < end; ++p) value[p] = cells[cell[p]].sum / cells[cell[p]].volume - value[p];
    }

    // For particles [begin, end): linear in their cell, with its mean.
    template <int Dim> void toLinear(const Particles<Dim>& particles, int begin, int end) {
        for (int p = begin; p < end;) {
            const int cell = cell_[p];
            if (cells_[cell].particles == 1) {
                value_[p++] = 0;
                continue;
            }
            const Linear<Dim> linear = linearIn<Dim>(cell);
            for (; p < end && cell_[p] == cell; ++p)
                value_[p] = linear.at(vectorAt<Dim>(particles.position, p)) - value_[p];
        }
    }

  private:
    struct Cell {
        long round = 0; // in which it was summed: else nothing is in it
        int particles = 0;
        double volume = 0, sum = 0, moment[3] = {};
        double inside = 0;                  // 1 inside the material, 0 at its surface
        double byCell = 0, byParticles = 0; // of the mean, times volume; of the mean

        double mean() const { return sum / volume; }
        double centre(int axis) const { return moment[axis] / volume; } // of the particles
    };
    template <int Dim> struct Linear {
        double mean;
        Vec<Dim> centre, slope;
        double at(const Vec<Dim>& x) const { return mean + slope.dot(x - centre); }
    };
    struct Range {
        int first, last;
    };

    // (V' - V_c)/(V_c dt), V' the volume between the corners of a cell after they moved for dt.
    template <int Dim, class Velocity>
    static double growth(const Grid<Dim>& grid, const Velocity* nodes, double dt, int number) {
        CornerNumbers<Dim> x;
        const Vec<Dim> edges = grid.edges(number);
        for (int a = 0; a < corners<Dim>; ++a) {
            int node = number;
            for (int k = 0; k < Dim; ++k) node += cornerSign(a, k) > 0 ? grid.strides[k] : 0;
            for (int k = 0; k < Dim; ++k)
                x[k][a] = 0.5 * cornerSign(a, k) + dt * nodes[node][k] / edges[k]; // in cells
        }
        return (ClosedShape<Dim>(x).volume - 1) / dt;
    }

    template <int Dim> Linear<Dim> linearIn(int number) const {
        const Cell& cell = cells_[number];
        Linear<Dim> linear{cell.mean(), Vec<Dim>::Zero(), Vec<Dim>::Zero()};
        for (int k = 0; k < Dim; ++k) {
            linear.centre[k] = cell.centre(k);
            linear.slope[k] =
                slope(cells_[number - strides_[k]], cell, cells_[number + strides_[k]], k, edge(number, k));
        }
        return linear;
    }

    // The mean of the slopes to both neighbours, and at most twice the smaller one: along an axis no value in
    // an evenly filled cell is beyond those of the neighbours (the monotonised central difference of van Leer
    // 1977). Zero at an extremum and where a neighbour is empty.
    double slope(const Cell& before, const Cell& cell, const Cell& after, int axis, double edge) const {
        if (before.round != round_ || after.round != round_) return 0;
        const auto between = [&](const Cell& a, const Cell& b) {
            return (b.mean() - a.mean()) / std::max(b.centre(axis) - a.centre(axis), 0.5 * edge);
        };
        const double left = between(before, cell), right = between(cell, after),
                     central = 0.5 * (left + right);
        if (left * right <= 0) return 0;
        return std::copysign(std::min({std::abs(central), 2 * std::abs(left), 2 * std::abs(right)}), central);
    }

    double edge(int cell, int axis) const { // m
        if (sizes_[axis].empty()) return edges_[axis];
        return sizes_[axis][cell / strides_[axis] % (sizes_[axis].size() + 1)];
    }

    int strides_[3] = {};          // from a cell to the next one
    double edges_[3] = {};         // m, of the smallest cell
    std::vector<double> sizes_[3]; // m, of the cells of a graded grid along each axis
    int slabSize_ = 0, slabs_ = 0; // nodes in a slab of the grid, and number of slabs
    long round_ = 0;               // number of sums so far
    std::vector<int> cell_;        // of each particle
    std::vector<double> value_;
    std::vector<Cell> cells_;
    std::vector<std::vector<int>> occupied_; // cells with particles, of each slab
    std::vector<Range> slabsOf_;             // of each chunk
    WorkPartition partitions_;               // of the slabs
};

} // namespace mpm
