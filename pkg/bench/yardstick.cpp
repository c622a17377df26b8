// SPDX-License-Identifier: GPL-2.0-or-later
#include "bench/yardstick.hpp"

#include <algorithm>
#include <cmath>

namespace mpm {

// Quadratic B-splines of the three nodes along each axis, and the place in the first of the cells.
struct Yardstick::Weights {
    int first[2];
    double f[2], w[2][3];

    explicit Weights(const Particle& p) {
        for (int k = 0; k < 2; ++k) {
            const double at = p.x[k] / h;
            first[k] = int(at - 0.5);
            f[k] = at - first[k];
            w[k][0] = 0.5 * (1.5 - f[k]) * (1.5 - f[k]);
            w[k][1] = 0.75 - (f[k] - 1) * (f[k] - 1);
            w[k][2] = 0.5 * (f[k] - 0.5) * (f[k] - 0.5);
        }
    }
};

Yardstick::Yardstick(int cells)
    : nodes_(cells + 8), dt_(0.4 * h / std::sqrt((lambda + 2 * mu) / density)), mass_(density * h * h / 4),
      volume_(h * h / 4), grid_(size_t(nodes_) * nodes_) {
    for (int j = 0; j < 2 * cells; ++j)
        for (int i = 0; i < 2 * cells; ++i) {
            Particle p{};
            p.x = {(3 + 0.25 + 0.5 * i) * h, (3 + 0.25 + 0.5 * j) * h};
            p.v = {1e-6 * p.x[1], 1e-6};
            all_.push_back(p);
        }
}

void Yardstick::step() {
    std::fill(grid_.begin(), grid_.end(), Node{0, 0, 0});
    toNodes();
    for (Node& n : grid_)
        if (n.m > 0) {
            n.px /= n.m;
            n.py /= n.m;
        }
    fromNodes();
}

void Yardstick::toNodes() {
    const double scale = -dt_ * volume_ * 4 / (h * h);
    for (const Particle& p : all_) {
        const Weights at(p);
        const double a[4] = {scale * p.stress[0] + mass_ * p.C[0], scale * p.stress[2] + mass_ * p.C[1],
                             scale * p.stress[2] + mass_ * p.C[2], scale * p.stress[1] + mass_ * p.C[3]};
        for (int j = 0; j < 3; ++j)
            for (int i = 0; i < 3; ++i) {
                const double dx = (i - at.f[0]) * h, dy = (j - at.f[1]) * h, w = at.w[0][i] * at.w[1][j];
                Node& n = grid_[size_t(at.first[1] + j) * nodes_ + at.first[0] + i];
                n.px += w * (mass_ * p.v[0] + a[0] * dx + a[1] * dy);
                n.py += w * (mass_ * p.v[1] + a[2] * dx + a[3] * dy);
                n.m += w * mass_;
            }
    }
}

void Yardstick::fromNodes() {
    for (Particle& p : all_) {
        const Weights at(p);
        double v[2] = {0, 0}, B[4] = {0, 0, 0, 0};
        for (int j = 0; j < 3; ++j)
            for (int i = 0; i < 3; ++i) {
                const double dx = i - at.f[0], dy = j - at.f[1], w = at.w[0][i] * at.w[1][j];
                const Node& n = grid_[size_t(at.first[1] + j) * nodes_ + at.first[0] + i];
                v[0] += w * n.px;
                v[1] += w * n.py;
                B[0] += w * n.px * dx;
                B[1] += w * n.px * dy;
                B[2] += w * n.py * dx;
                B[3] += w * n.py * dy;
            }
        for (int c = 0; c < 4; ++c) p.C[c] = 4 / h * B[c];
        for (int k = 0; k < 2; ++k) {
            p.v[k] = v[k];
            p.x[k] += dt_ * v[k];
        }
        const double trace = dt_ * lambda * (p.C[0] + p.C[3]);
        p.stress[0] += trace + 2 * dt_ * mu * p.C[0];
        p.stress[1] += trace + 2 * dt_ * mu * p.C[3];
        p.stress[2] += dt_ * mu * (p.C[1] + p.C[2]);
    }
}

double Yardstick::momentum() const {
    double sum = 0;
    for (const Particle& p : all_) sum += mass_ * p.v[0];
    return sum;
}

} // namespace mpm
