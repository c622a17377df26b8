// SPDX-License-Identifier: GPL-2.0-or-later
// What this machine can do with the least that an MPM step can be: one loop to the nodes, one back, on one
// thread.
#pragma once

#include <array>
#include <vector>

namespace mpm {

// Moving least squares MPM (Hu et al. 2018): quadratic B-splines over 3 x 3 nodes, affine velocities, linear
// elastic stress, no strain measure, no order of the particles, no check. Two particles per cell and
// direction, plane strain.
class Yardstick {
  public:
    explicit Yardstick(int cells);
    void step();
    int particles() const { return int(all_.size()); }
    double momentum() const; // along x, Mg m/s per metre

  private:
    struct Particle {
        std::array<double, 2> x, v;
        std::array<double, 4> C;      // affine velocity, 1/s
        std::array<double, 3> stress; // xx, yy, xy, kPa
    };
    struct Node {
        double px, py, m;
    };
    static constexpr double h = 0.25;                     // m, cell
    static constexpr double lambda = 9.48e3, mu = 6.31e3; // kPa
    static constexpr double density = 1.53;               // Mg/m3
    int nodes_;
    double dt_, mass_, volume_;
    std::vector<Particle> all_;
    std::vector<Node> grid_;

    struct Weights;
    void toNodes();
    void fromNodes();
};

} // namespace mpm
