// SPDX-License-Identifier: GPL-2.0-or-later
// How the edges of each group last moved against each other one, m/s. Normals at edges are those of the faces that move
// towards the other group. At rest velocities are noise: without a memory the normal of a tip that stops turns, and soil
// creeps past its corners, a third of the load in a second.
#pragma once

#include "mpm/base/types.hpp"

#include <algorithm>
#include <vector>

namespace mpm {

class EdgeMotions {
  public:
    std::vector<double> all; // three numbers for the edges of the first group of each pair, and of the second

    template <int Dim> Vec<Dim> of(size_t pair, int side) const {
        const size_t at = numberOf(pair, side);
        return at < all.size() ? Vec<Dim>(Eigen::Map<const Vec<Dim>>(&all[at])) : Vec<Dim>(Vec<Dim>::Zero());
    }
    // Turns to a new velocity on a way of `reach` cells; cell: its size, m.
    template <int Dim> void follow(size_t pair, int side, const Vec<Dim>& velocity, double dt, double cell) {
        const size_t at = numberOf(pair, side);
        if (at >= all.size()) all.resize(numberOf(pair + 1, 0), 0.0);
        Eigen::Map<Vec<Dim>> motion(&all[at]);
        motion += std::min(1.0, velocity.norm() * dt / (reach * cell)) * (velocity - motion);
    }

  private:
    static constexpr double reach = 0.25;

    static size_t numberOf(size_t pair, int side) { return 6 * pair + 3 * side; }
};

} // namespace mpm
