// SPDX-License-Identifier: GPL-2.0-or-later
// What one particle gives to a row of nodes along x, in as few vector operations as the dimension allows: products with a
// weight phi_i and with its gradient, where phi_i is a product over the axes, S(x) S(y) or S(x) S(y) S(z), and G stands for the
// derivative of an S.
//
//   Row     add() to the sums of each node of the row, finish() when all particles have given
//
// In 2D the lanes of one Quad hold the products with d_x phi and d_y phi for both components side by side, and a vector
// fills two lanes per component; in 3D there is a Quad for each axis, and a vector has one lane per component.
#pragma once

#include "mpm/base/types.hpp"

namespace mpm {

// Weights across a row of nodes: S of the other axes, and in [k - 1] the same with the derivative along axis k.
template <int Dim, class Number = double> struct Across {
    Number S, G[Dim - 1];
};

template <int Dim> struct Lanes;

template <> struct Lanes<2> {
    using Set = std::array<Quad, 1>; // { B_xx, B_xy, B_yx, B_yy }: B_ik takes d_k phi
    static constexpr int used = 4;   // lanes of a vector, and the component in each
    static constexpr int component(int lane) { return lane / 2; }

    // d_x phi in the even lanes, d_y phi in the odd ones, as a product of this for the axes.
    MPM_INLINE static Quad alongX(double S, double G) { return alternating(G, S); }
    MPM_INLINE static Quad alongY(double S, double G) { return alternating(S, G); }

    struct Row {
        Quad value, product;
        MPM_INLINE Row(const Quad& value, const Set& B, const Across<2>& w) : value(w.S * value), product(alongY(w.S, w.G[0]) * B[0]) {}
        MPM_INLINE void add(Pack<8>& sum, double S, double G) const { sum.part[0] += S * value, sum.part[1] += alongX(S, G) * product; }
        MPM_INLINE static void finish(const Pack<8>& sum, Pack<8>& node) {
            const Quad B = sum.part[1];
            node.part[0] += sum.part[0], node.part[1] += B + Quad{B[1], B[0], B[3], B[2]};
        }
    };
};

template <> struct Lanes<3> {
    using Set = std::array<Quad, 4>; // { B_1k, B_2k, B_3k, 0 } for each axis k, and what takes phi itself
    static constexpr int used = 3;
    static constexpr int component(int lane) { return lane; }

    struct Row {
        Quad value, withG, withS; // of B: what takes the derivative along the row, and what does not
        MPM_INLINE Row(const Quad& value, const Set& B, const Across<3>& w)
            : value(w.S * value), withG(w.S * B[0]), withS(w.G[0] * B[1] + w.G[1] * B[2] + w.S * B[3]) {}
        MPM_INLINE void add(Pack<8>& sum, double S, double G) const {
            sum.part[0] += S * value, sum.part[1] += G * withG, sum.part[1] += S * withS;
        }
        MPM_INLINE static void finish(const Pack<8>& sum, Pack<8>& node) { node += sum; }
    };
};

} // namespace mpm
