// SPDX-License-Identifier: GPL-2.0-or-later
// What implicit bodies answer to impulses on some of their nodes: an impulse on one moves them all, for the
// bodies are stiff. It is the part of the inverse of M + dt^2 K that belongs to these nodes (Delassus matrix).
#pragma once

#include "mpm/base/types.hpp"

#include <algorithm>
#include <vector>

namespace mpm {

template <int Dim> class ImpulseResponse {
  public:
    struct Node {
        int field, node;
    };
    std::vector<Node> nodes; // those that respond: a row and a column each

    std::vector<int> rows; // of each, the first of its rows in the matrix, in which it has columns, too

    bool isEmpty() const { return nodes.empty(); }
    int size() const { return size_; } // of the matrix; some of its rows may belong to other nodes

    // Velocity of a node per impulse on another one, or on itself, 1/Mg; zero between bodies that share no node.
    using Part = Eigen::Map<const Mat<Dim>, 0, Eigen::OuterStride<>>;
    Part of(int node, int pushed) const {
        return Part(column(rows[pushed]) + rows[node], Eigen::OuterStride<>(size_));
    }
    const double* column(int unknown) const { return values_.data() + size_t(unknown) * size_; }
    double* column(int unknown) { return values_.data() + size_t(unknown) * size_; }

    void clear() {
        nodes.clear();
        rows.clear();
        size_ = 0;
    }
    // For nodes to be given rows, and columns. All values have to be written.
    void setSize(int size) {
        size_ = size;
        values_.resize(size_t(size) * size);
    }
    void clearValues() { std::fill(values_.begin(), values_.end(), 0.0); }

  private:
    int size_ = 0;
    std::vector<double> values_; // column by column
};

} // namespace mpm
