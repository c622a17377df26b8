// SPDX-License-Identifier: GPL-2.0-or-later
// The nodes on which a pair of groups meets, and those next to them.
#pragma once

#include "mpm/state/Grid.hpp"

#include <algorithm>

namespace mpm {

// f(node, steps from the middle along each axis) for the 3^Dim nodes round one.
template <int Dim, class F> MPM_INLINE void forNeighbours(const Grid<Dim>& grid, int node, F&& f) {
    if constexpr (Dim == 2) {
        for (int j = -1; j <= 1; ++j)
            for (int i = -1; i <= 1; ++i) f(node + i + j * grid.strides[1], Index<2>{i, j});
    } else
        for (int l = -1; l <= 1; ++l)
            for (int j = -1; j <= 1; ++j)
                for (int i = -1; i <= 1; ++i)
                    f(node + i + j * grid.strides[1] + l * grid.strides[2], Index<3>{i, j, l});
}

template <int Dim> int nearestNode(const Grid<Dim>& grid, const Vec<Dim>& x) {
    int node = 0;
    for (int k = 0; k < Dim; ++k) node += int(grid.inCells(x[k], k) + 0.5) * grid.strides[k];
    return node;
}

// The same for points begin ... begin + count - 1 at once.
template <int Dim>
void nearestNodes(const Grid<Dim>& grid, const Field& position, int begin, int count, int* node) {
    std::fill(node, node + count, 0);
    for (int k = 0; k < Dim; ++k) {
        const double* x = position.plane(k) + begin;
        const int stride = grid.strides[k];
#pragma omp simd
        for (int i = 0; i < count; ++i) node[i] += int(grid.inCells(x[i], k) + 0.5) * stride;
    }
}

// The nodes round a point: their numbers among the meets, -1 where it is none, and their hat functions.
template <int Dim> struct NodesRound {
    static constexpr int size = 1 << Dim;
    int meet[size];
    double S[size];
};

template <int Dim> class Neighbourhood {
  public:
    Vec<Dim> lower, upper; // of a box that holds all that is near

    void prepare(const Grid<Dim>& grid) {
        meet_.assign(grid.count, -1), near_.assign(grid.count, -1), nodes_.clear();
    }

    void clear() {
        for (int node : nodes_) meet_[node] = near_[node] = -1;
        nodes_.clear(), lower.setConstant(1e300), upper = -lower;
    }

    // Before finish(): the groups meet on this node, `number` among the meets.
    void add(const Grid<Dim>& grid, int node, int number) {
        meet_[node] = number;
        const Vec<Dim> x = grid.nodePosition(node);
        lower = lower.cwiseMin(x - 2 * grid.cell), upper = upper.cwiseMax(x + 2 * grid.cell);
        forNeighbours(grid, node, [&](int other, const Index<Dim>&) {
            if (near_[other] < 0) near_[other] = 0, nodes_.push_back(other);
        });
    }
    void finish() {
        std::sort(nodes_.begin(), nodes_.end());
        for (size_t i = 0; i < nodes_.size(); ++i) near_[nodes_[i]] = int(i);
    }

    int size() const { return int(nodes_.size()); }
    int meet(int node) const { return meet_[node]; } // -1: the groups do not meet there
    int number(int node) const {
        return near_[node];
    } // of a node that is near, which grows with the node; -1: it is not

    bool holds(const Grid<Dim>& grid, const Vec<Dim>& x) const {
        return (x.array() >= lower.array()).all() && (x.array() <= upper.array()).all() &&
               near_[nearestNode(grid, x)] >= 0;
    }

    NodesRound<Dim> round(const Grid<Dim>& grid, const Vec<Dim>& x) const {
        int first = 0;
        double part[Dim];
        for (int k = 0; k < Dim; ++k) {
            const double c = grid.inCells(x[k], k), below = std::floor(c);
            first += int(below) * grid.strides[k], part[k] = c - below;
        }
        NodesRound<Dim> round;
        for (int corner = 0; corner < round.size; ++corner) {
            int node = first;
            double S = 1;
            for (int k = 0; k < Dim; ++k) {
                const bool upper = corner >> k & 1;
                node += upper ? grid.strides[k] : 0, S *= upper ? part[k] : 1 - part[k];
            }
            round.meet[corner] = meet_[node], round.S[corner] = S;
        }
        return round;
    }

  private:
    std::vector<int> meet_, near_; // of all nodes of the grid
    std::vector<int> nodes_;       // that are near, those on which the groups meet among them; in order
};

} // namespace mpm
