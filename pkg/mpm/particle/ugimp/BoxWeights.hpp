// SPDX-License-Identifier: GPL-2.0-or-later
// The weights of box domains for a batch of particles at once, in vectors: what AveragedHat says, written
// without branches.
#pragma once

#include "mpm/particle/ParticlePlanes.hpp"

#include <algorithm>

namespace mpm {

// One direction of a box: half size l in cells, in (0, 1/2], and what follows from it and the cell size h.
struct BoxAxis {
    double l, quarter, slope; // l, 1/(4 l), 1/(2 l h)

    BoxAxis() = default;
    BoxAxis(double half, double h) : l(half / h), quarter(h / (4 * half)), slope(0.5 / half) {}
};

// Weights of the three nodes that each particle of a batch reaches in one direction, and their gradients. c:
// position in cells from the middle one, in [-1/2, 1/2). `below` and `above` are the lengths of the box on
// either side of the middle node, `left` and `right` how far the box is from it. `lanes` beyond the batch are
// zero, see BoxTransfers.
template <int size, int lanes> struct alignas(64) BoxAxisWeights {
    double S[3][size], G[3][size];

    void set(const double* position, int count, const BoxAxis& axis) {
        const double l = axis.l, quarter = axis.quarter, slope = axis.slope;
#pragma omp simd
        for (int p = 0; p < count; ++p) {
            const double c = position[p] - 1, cut = c < l ? c : l, middle = cut > -l ? cut : -l,
                         beyond = c - middle;
            const double below = l - middle, above = l + middle, right = beyond > 0 ? beyond : 0,
                         left = right - beyond;
            const double first = below * below * quarter + left, last = above * above * quarter + right;
            S[0][p] = first;
            S[1][p] = 1 - first - last;
            S[2][p] = last;
            G[0][p] = -slope * below;
            G[1][p] = -2 * slope * middle;
            G[2][p] = slope * above;
        }
        for (int i = 0; i < 3; ++i) {
            std::fill_n(S[i] + count, lanes, 0.0);
            std::fill_n(G[i] + count, lanes, 0.0);
        }
    }

    // Of particle p alone, where the cells below and above the middle node have the edges a and b, m: the
    // hats of the outer nodes are -x/a and x/b at x from it.
    void set(int p, double c, double half, double a, double b) {
        const double x = c * (c < 0 ? a : b), from = x - half, to = x + half, share = 0.5 / half;
        const double fromBelow = std::min(from, 0.0), toBelow = std::min(to, 0.0),
                     fromAbove = std::max(from, 0.0), toAbove = std::max(to, 0.0);
        S[0][p] = share * 0.5 / a * (fromBelow * fromBelow - toBelow * toBelow);
        S[2][p] = share * 0.5 / b * (toAbove * toAbove - fromAbove * fromAbove);
        S[1][p] = 1 - S[0][p] - S[2][p];
        G[0][p] = -share / a * (toBelow - fromBelow);
        G[2][p] = share / b * (toAbove - fromAbove);
        G[1][p] = -G[0][p] - G[2][p];
    }
};

// Weights of a batch of particles, short enough to stay in the first cache while it is used.
template <int Dim> struct BoxWeights {
    // A lane for each particle of a support, where there are two along each axis.
    using Several = typename Widest<corners<Dim>>::Vector;
    static constexpr int lanes = sizeof(Several) / sizeof(double);
    static constexpr int batch = ParticlePlanes<Dim>::largestBatch;
    static constexpr int padded = batch + 8; // room for all lanes from each one on; whole cache lines

    BoxAxisWeights<padded, lanes> axis[Dim];

    // local: positions from the lowest nodes of the supports, in cells; half: of a box, m.
    BoxWeights(const Field& local, const Field& half, const Vec<Dim>& cell, int first, int count) {
        for (int k = 0; k < Dim; ++k)
            axis[k].set(local.plane(k) + first, count, BoxAxis(half.plane()[k], cell[k]));
    }

    // Across a row of three nodes along the first axis, of particle p and of all lanes from there on.
    MPM_INLINE Across<Dim> across(int row, int p) const {
        const auto &y = axis[1], &z = axis[Dim - 1];
        const int j = row % 3, k = row / 3;
        if constexpr (Dim == 2)
            return {y.S[j][p], {y.G[j][p]}};
        else
            return {y.S[j][p] * z.S[k][p], {y.G[j][p] * z.S[k][p], y.S[j][p] * z.G[k][p]}};
    }
    MPM_INLINE Across<Dim, Several> acrossSeveral(int row, int p) const {
        const auto &y = axis[1], &z = axis[Dim - 1];
        const int j = row % 3, k = row / 3;
        const Several S = load<Several>(y.S[j] + p), G = load<Several>(y.G[j] + p);
        if constexpr (Dim == 2)
            return {S, {G}};
        else {
            const Several Sz = load<Several>(z.S[k] + p);
            return {S * Sz, {G * Sz, S * load<Several>(z.G[k] + p)}};
        }
    }

    // Along a row.
    MPM_INLINE std::array<Several, 3> alongS(int p) const { return severalOf(axis[0].S, p); }
    MPM_INLINE std::array<Several, 3> alongG(int p) const { return severalOf(axis[0].G, p); }

  private:
    MPM_INLINE static std::array<Several, 3> severalOf(const double (&weight)[3][padded], int p) {
        return {load<Several>(weight[0] + p), load<Several>(weight[1] + p), load<Several>(weight[2] + p)};
    }
};

} // namespace mpm
