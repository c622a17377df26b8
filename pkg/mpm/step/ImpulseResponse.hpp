// SPDX-License-Identifier: GPL-2.0-or-later
// What implicit bodies answer to impulses on some of their nodes: an impulse on one moves them all, for the
// bodies are stiff. It is the part of the inverse of M + dt^2 K that belongs to these nodes (Delassus matrix).
#pragma once

#include "mpm/base/types.hpp"

#include <vector>

namespace mpm {

template <int Dim> class ImpulseResponse {
  public:
    struct Node {
        int field, node;
    };
    std::vector<Node> nodes; // those that respond: a row and a column each

    bool isEmpty() const { return nodes.empty(); }
    int size() const { return Dim * int(nodes.size()); }

    // Velocity of a node per impulse on another one, or on itself, 1/Mg; zero between bodies that share no node.
    using Part = Eigen::Map<const Mat<Dim>, 0, Eigen::OuterStride<>>;
    Part of(int node, int pushed) const {
        return Part(values_.data() + size_t(Dim) * pushed * size() + Dim * node,
                    Eigen::OuterStride<>(size()));
    }

    void clear() {
        nodes.clear();
        values_.clear();
    }
    // For nodes to be given columns.
    void reset() { values_.assign(size_t(size()) * size(), 0.0); }
    double* column(int unknown) { return values_.data() + size_t(unknown) * size(); }

  private:
    std::vector<double> values_; // column by column
};

} // namespace mpm
