// SPDX-License-Identifier: GPL-2.0-or-later
// B of the pore pressure (step/PoreSystem.hpp) by the corners of the cells with an unknown, in arrays by place
// (step/PorePlaces.hpp): loops over it vectorise.
#pragma once

#include "mpm/base/types.hpp"
#include "mpm/state/cover.hpp"
#include "mpm/step/PorePlaces.hpp"

namespace mpm {

template <int Dim> class PoreRuns {
  public:
    PorePlaces<Dim> places;
    // Of the corners on both sides of each cell along the first axis, without the signs of the corners, m2.
    std::array<std::array<std::vector<double>, Dim>, 2> flows;

    // numbers: of the cells, sorted.
    void start(const std::vector<int>& numbers, const Index<Dim>& strides) {
        places.find(numbers, strides);
        for (auto* one : {&acting_, &overVolume_}) one->assign(places.size, 0.0);
        for (int k = 0; k < Dim; ++k)
            for (auto* one : {&flows[0][k], &flows[1][k], &velocities_[k], &forces_[k]})
                one->assign(places.size, 0.0);
    }
    // The volume that the pressure of a cell acts with, m3, and the slopes of the hat functions there, 1/m.
    void set(int place, double volume, const std::array<Vec<Dim>, 2>& slopes) {
        overVolume_[place] = volume > 0 ? 1 / volume : 0;
        for (int side = 0; side < 2; ++side)
            for (int k = 0; k < Dim; ++k) flows[side][k][place] = volume * slopes[side][k];
    }
    void setVelocity(int node, const Vec<Dim>& velocity) {
        const int place = node + places.offset;
        if (place < 0 || place >= places.size) return; // of no cell with an unknown
        for (int k = 0; k < Dim; ++k) velocities_[k][place] = velocity[k];
    }
    // What flows out of each cell as the nodes move for dt, m3/s, see PoreSystem::flowOut().
    void flowOut(ParallelRegion& region, double dt, std::vector<double>& out) const {
        places.forBlocks(region, [&](int begin, int) {
            double* to = out.data() + begin;
            places.forRuns(begin, [&](int first, int last) {
                flowOfRun(first, last, dt, to);
                to += last - first;
            });
        });
    }
    // What pressures of the cells do to all nodes; then force() knows it.
    void findForces(ParallelRegion& region, const std::vector<double>& acting) {
        region.once([&] { places.spread(acting, acting_); });
        const int first = places.toCorner.back();
        region.chunks(places.size - first, [&](int begin, int end) {
            for (int k = 0; k < Dim; ++k) forcesOfRun(k, first + begin, first + end);
        });
    }
    // On a node, kN.
    Vec<Dim> force(int node) const {
        Vec<Dim> f;
        for (int k = 0; k < Dim; ++k) f[k] = forces_[k][node + places.offset];
        return f;
    }

  private:
    static constexpr int NC = corners<Dim>;

    std::vector<double> acting_, overVolume_; // pressure, kPa; 1/m3, 0 where the corners have none
    std::array<std::vector<double>, Dim> velocities_, forces_; // of the nodes, m/s and kN

    static constexpr int firstSide(int corner) { return cornerSign(corner, 0) > 0; }
    void flowOfRun(int first, int last, double dt, double* out) const {
        std::array<const double*, Dim> flow[2], v[NC];
        for (int k = 0; k < Dim; ++k) {
            for (int side = 0; side < 2; ++side) flow[side][k] = flows[side][k].data();
            for (int a = 0; a < NC; ++a) v[a][k] = velocities_[k].data() + places.toCorner[a];
        }
        const double* const over = overVolume_.data();
        double sign[NC][Dim];
        for (int a = 0; a < NC; ++a)
            for (int k = 0; k < Dim; ++k) sign[a][k] = cornerSign(a, k);
#pragma omp simd
        for (int p = first; p < last; ++p) {
            double L[Dim][Dim]; // V L
#pragma GCC unroll 3
            for (int k = 0; k < Dim; ++k)
#pragma GCC unroll 3
                for (int l = 0; l < Dim; ++l) {
                    double sum = 0;
#pragma GCC unroll 8
                    for (int a = 0; a < NC; ++a) sum += sign[a][l] * flow[firstSide(a)][l][p] * v[a][k][p];
                    L[k][l] = sum;
                }
            const double step = dt * over[p];
            if constexpr (Dim == 2) {
                out[p - first] = L[0][0] + L[1][1] + step * (L[0][0] * L[1][1] - L[0][1] * L[1][0]);
            } else {
                const double xx = L[1][1] * L[2][2] - L[1][2] * L[2][1],
                             yy = L[0][0] * L[2][2] - L[0][2] * L[2][0],
                             zz = L[0][0] * L[1][1] - L[0][1] * L[1][0];
                const double determinant = L[0][0] * xx - L[0][1] * (L[1][0] * L[2][2] - L[1][2] * L[2][0]) +
                                           L[0][2] * (L[1][0] * L[2][1] - L[1][1] * L[2][0]);
                out[p - first] = L[0][0] + L[1][1] + L[2][2] + step * (xx + yy + zz + step * determinant);
            }
        }
    }
    void forcesOfRun(int k, int first, int last) {
        double* const f = forces_[k].data();
        const double* const acting = acting_.data();
        std::fill(f + first, f + last, 0.0);
        for (int a = 0; a < NC; ++a) {
            const double* const flow = flows[firstSide(a)][k].data();
            const int step = places.toCorner[a];
            const double sign = cornerSign(a, k);
#pragma GCC ivdep
            for (int p = first; p < last; ++p) f[p] += sign * flow[p - step] * acting[p - step];
        }
    }
};

} // namespace mpm
