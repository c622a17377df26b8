// SPDX-License-Identifier: GPL-2.0-or-later
// Ratios of two sums on nodes, both weighted with w = exp(-r^2/l^2) of the nodes around. w is what a density becomes by
// diffusion over l^2/4 (time by diffusivity), on graded grids and round an axis, too; sums over the volumes of nodes are
// densities. Less of the variance, see NeighbourMeans.hpp.
#pragma once

#include "mpm/base/parallel/ParallelRegion.hpp"
#include "mpm/state/Grid.hpp"

#include <algorithm>
#include <cmath>

namespace mpm {

template <int Dim> class NodeSmoothing {
  public:
    using Extent = typename NodalField<Dim>::Extent;

    void start(const Grid<Dim>& grid, double length) {
        if (length_ == length && int(upper_[0].size()) == grid.count) return;
        length_ = length;
        strides_ = grid.strides;
        for (int k = 0; k < Dim; ++k) findRows(grid, k);
        for (auto* values : {lower_, upper_, from_, to_})
            for (int i = 0; i < 2; ++i) values[i].assign(grid.count, 0.0);
    }
    // To the corners of a cell; one thread for each slab of cells.
    void add(int cell, const double (&sums)[2][corners<Dim>]) {
        for (int i = 0; i < 2; ++i)
            for (int a = 0; a < corners<Dim>; ++a) {
                const bool isUpper = a >> (Dim - 1); // these nodes are lower ones of the next slab
                (isUpper ? upper_ : lower_)[i][cornerOf(cell, a)] += sums[i][a];
            }
    }
    // Nodes outside of the extent have no sums. Called by all threads.
    void smooth(ParallelRegion& region, const Extent& extent) {
        const auto slabs = [&](auto&& f) {
            const int first = extent.first[Dim - 1];
            region.forPieces(partition_, [&](int i) { f(first + i); });
        };
        region.once(
            [&] { partition_.set(extent.last[Dim - 1] - extent.first[Dim - 1] + 1, [](int) { return 1; }); });
        slabs([&](int slab) {
            forRows(extent, slab, [&](int begin, int end, int) {
                for (int i = 0; i < 2; ++i)
                    for (int node = begin; node < end; ++node) {
                        from_[i][node] = lower_[i][node] + upper_[i][node];
                        lower_[i][node] = upper_[i][node] = 0;
                    }
            });
        });
        for (int k = 0; k < Dim; ++k) {
            slabs([&](int slab) {
                forRows(extent, slab, [&](int begin, int end, int row) {
                    for (int i = 0; i < 2; ++i)
                        k == 0
                            ? sumWithin(from_[i], to_[i], begin, end, extent)
                            : sumAcross(from_[i], to_[i], begin, end, k, k == Dim - 1 ? slab : row, extent);
                });
            });
            region.once([&] {
                for (int i = 0; i < 2; ++i) from_[i].swap(to_[i]);
            });
        }
        slabs([&](int slab) {
            forRows(extent, slab, [&](int begin, int end, int) {
                for (int node = begin; node < end; ++node)
                    to_[0][node] = from_[0][node] > 0 ? from_[1][node] / from_[0][node] : 0;
            });
        });
    }
    // The ratio, in corner a of a cell.
    double mean(int cell, int a) const { return to_[0][cornerOf(cell, a)]; }

  private:
    static constexpr double least = 1e-4; // of the largest weight of a node: less is left out
    struct Row {                          // weights of the nodes from `first` on, along an axis
        int first;
        std::vector<double> weights;
    };

    int cornerOf(int cell, int a) const {
        for (int k = 0; k < Dim; ++k) cell += a >> k & 1 ? strides_[k] : 0;
        return cell;
    }
    // f(first node, end, place along the second axis) for the rows of nodes in a slab.
    template <class F> void forRows(const Extent& extent, int slab, F&& f) const {
        const int first = extent.first[0], end = extent.last[0] + 1, start = slab * strides_[Dim - 1];
        if (Dim == 2) return f(start + first, start + end, slab);
        for (int j = extent.first[1]; j <= extent.last[1]; ++j)
            f(start + j * strides_[1] + first, start + j * strides_[1] + end, j);
    }
    void sumWithin(const std::vector<double>& from, std::vector<double>& to, int begin, int end,
                   const Extent& extent) const {
        const int start = begin - extent.first[0];
        for (int node = begin; node < end; ++node) {
            const Row& row = rows_[0][node - start];
            const int low = std::max(start + row.first, begin),
                      high = std::min(start + row.first + int(row.weights.size()), end);
            const double* weight = row.weights.data() - start - row.first;
            double sum = 0;
            for (int n = low; n < high; ++n) sum += weight[n] * from[n];
            to[node] = sum;
        }
    }
    void sumAcross(const std::vector<double>& from, std::vector<double>& to, int begin, int end, int axis,
                   int index, const Extent& extent) const {
        std::fill(to.begin() + begin, to.begin() + end, 0.0);
        const Row& row = rows_[axis][index];
        for (int i = 0; i < int(row.weights.size()); ++i) {
            const int there = row.first + i;
            if (there < extent.first[axis] || there > extent.last[axis]) continue;
            const double weight = row.weights[i], *source = &from[0] + (there - index) * strides_[axis];
            for (int node = begin; node < end; ++node) to[node] += weight * source[node];
        }
    }

    // Along an axis: rates between nodes beside each other, by the variance that is left; volumes of the nodes.
    struct Rates {
        std::vector<double> up, down, volume;
        double fastest = 0, widest = 0; // widest: deviation over the cell

        Rates(const Grid<Dim>& grid, int axis, double variance) : up(grid.nodes[axis]), down(up), volume(up) {
            const bool isRadius = axis == 0 && grid.isAxisymmetric;
            const auto within = [&](double r) { return isRadius ? 0.5 * std::max(r, 0.0) * r : r; };
            const auto face = [&](double r) { return isRadius ? std::max(r, 0.0) : 1; };
            const int last = grid.nodes[axis] - 1;
            for (int i = 0; i <= last; ++i) {
                const double x = grid.line(axis, i), below = i > 0 ? x - grid.line(axis, i - 1) : 0,
                             above = i < last ? grid.line(axis, i + 1) - x : 0, h = std::max(above, below),
                             left = std::max(0.0, variance - h * h / 3);
                const double low = x - 0.5 * below, high = x + 0.5 * above;
                volume[i] = within(high) - within(low);
                if (volume[i] <= 0) continue; // beyond the axis of symmetry
                if (above > 0) up[i] = 0.5 * left / (volume[i] * above) * face(high);
                if (below > 0) down[i] = 0.5 * left / (volume[i] * below) * face(low);
                fastest = std::max(fastest, up[i] + down[i]);
                widest = std::max(widest, std::sqrt(left) / h);
            }
        }
    };
    // exp of the rates, by many small steps: row by row, over the volumes of the nodes.
    void findRows(const Grid<Dim>& grid, int axis) {
        const Rates rates(grid, axis, 0.5 * length_ * length_);
        const int count = grid.nodes[axis], steps = int(std::ceil(10 * rates.fastest)),
                  reach = int(std::ceil(5 * rates.widest)) + 1;
        rows_[axis].clear();
        for (int i = 0; i < count; ++i) {
            const int first = std::max(0, i - reach), end = std::min(count, i + reach + 1);
            std::vector<double> weights(end - first, 0.0), next;
            weights[i - first] = 1;
            for (int step = 0; step < steps; ++step) {
                next = weights;
                for (int j = first; j < end; ++j) {
                    const double given = weights[j - first] / steps;
                    next[j - first] -= given * (rates.up[j] + rates.down[j]);
                    if (j + 1 < end) next[j + 1 - first] += given * rates.up[j];
                    if (j > first) next[j - 1 - first] += given * rates.down[j];
                }
                weights.swap(next);
            }
            for (int j = first; j < end; ++j)
                weights[j - first] = rates.volume[j] > 0 ? weights[j - first] / rates.volume[j] : 0;
            rows_[axis].push_back(shortened({first, std::move(weights)}));
        }
    }
    static Row shortened(const Row& row) {
        const double bound = least * *std::max_element(row.weights.begin(), row.weights.end());
        int low = 0, high = int(row.weights.size());
        while (low < high - 1 && row.weights[low] < bound) ++low;
        while (high > low + 1 && row.weights[high - 1] < bound) --high;
        return {row.first + low, {row.weights.begin() + low, row.weights.begin() + high}};
    }

    double length_ = 0; // m
    Index<Dim> strides_;
    std::vector<Row> rows_[Dim];
    // Of volume and of what is averaged, on the nodes: sums of the cells above and below; before and after an axis.
    std::vector<double> lower_[2], upper_[2], from_[2], to_[2];
    WorkPartition partition_;
};

} // namespace mpm
