// SPDX-License-Identifier: GPL-2.0-or-later
// How the edges of each group last moved against each other one. Normals at edges are those of the faces that move
// towards the other group. At rest velocities are noise: without a memory the normal of a tip that stops turns, and soil
// creeps past its corners, a third of the load in a second. Kept are a direction, the mean of those of the way, and a
// speed, both forgotten by the factor e on a way of a quarter of a cell, however fast:
//     direction += (v/|v| - direction) part,   speed += (|v| - speed) part,   part = |v| dt / (cell/4).
#pragma once

#include "mpm/base/types.hpp"

#include <algorithm>
#include <vector>

namespace mpm {

class EdgeMotions {
  public:
    static constexpr int perPair = 8; // numbers: direction and speed, m/s, of the edges of either group
    std::vector<double> numbers;

    // Velocity, m/s, of the edges of one group of a pair, see pairOf().
    template <int Dim> Vec<Dim> of(size_t pair, int side) const {
        if ((pair + 1) * perPair > numbers.size()) return Vec<Dim>::Zero();
        const double* const own = &numbers[pair * perPair + side * perPair / 2];
        return own[3] * Eigen::Map<const Vec<Dim>>(own);
    }
    // Their direction: shorter than 1 while they have not gone far, zero at first.
    template <int Dim> Vec<Dim> directionOf(size_t pair, int side) const {
        if ((pair + 1) * perPair > numbers.size()) return Vec<Dim>::Zero();
        return Eigen::Map<const Vec<Dim>>(&numbers[pair * perPair + side * perPair / 2]);
    }
    // They move with a velocity for a step; cell: its size, m.
    template <int Dim> void add(size_t pair, int side, const Vec<Dim>& velocity, double dt, double cell) {
        const double speed = velocity.norm(), part = std::min(1.0, speed * dt / (way * cell));
        if (!(speed > 0)) return;
        if ((pair + 1) * perPair > numbers.size()) numbers.resize((pair + 1) * perPair, 0.0);
        double* const own = &numbers[pair * perPair + side * perPair / 2];
        Eigen::Map<Vec<Dim>> direction(own);
        direction += part * (velocity / speed - direction);
        own[3] += part * (speed - own[3]);
    }

  private:
    static constexpr double way = 0.25; // cells
};

} // namespace mpm
