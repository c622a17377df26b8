// SPDX-License-Identifier: GPL-2.0-or-later
// The nodes that implicit bodies move, and the velocity that strains these bodies.
#pragma once

#include "mpm/state/NodalField.hpp"

namespace mpm {

template <int Dim> class ImplicitNodes {
  public:
    using Velocity = typename NodalField<Dim>::Velocity;

    // Of velocity fields with so many nodes; none is moved yet.
    void reset(size_t fields, int nodes) {
        for (const auto& [field, node] : moved_) isMoved_[field][node] = 0;
        moved_.clear();
        isMoved_.resize(fields);
        for (auto& isMoved : isMoved_) isMoved.resize(nodes, 0);
        velocity_.resize(fields);
        for (auto& velocity : velocity_) velocity.resize(nodes, Velocity::zero());
    }
    void setMoved(int field, int node) {
        isMoved_[field][node] = 1;
        moved_.emplace_back(field, node);
    }
    void setVelocity(int field, int node, int k, double v) { velocity_[field][node].set(k, v); }

    // Whether an implicit body moves a node of a velocity field.
    bool moves(int field, int node) const { return isMoved_[field][node]; }
    const Velocity& velocityAt(int field, int node) const { return velocity_[field][node]; }
    const Velocity* velocities(int field) const { return velocity_[field].data(); }

  private:
    std::vector<std::vector<char>> isMoved_;
    std::vector<std::pair<int, int>> moved_;      // fields and nodes
    std::vector<std::vector<Velocity>> velocity_; // m/s
};

} // namespace mpm
