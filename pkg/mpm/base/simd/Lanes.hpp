// SPDX-License-Identifier: GPL-2.0-or-later
// Values and a tensor times weights, for a row of nodes along x, in as few vector operations as the dimension
// allows.
//
// The weight of node i is a product over the axes, phi_i = S(x) S(y) or S(x) S(y) S(z), and G is the
// derivative of an S. A node's sum takes phi_i times a Quad of values, and the tensor B times the gradient of
// phi_i. What all nodes of the row have in common (`Across`) is multiplied once, in Row; Row::add() then adds
// to the sums of a node, and finish(), after the last add(), adds these to the node by the same vectors that
// they were summed in.
//
// 2D: the lanes of one Quad hold the products with d_x phi and d_y phi for both components side by side, so
// component k of B grad phi is the sum of two lanes. 3D: there is a Quad for each axis, and a lane for each
// component.
#pragma once

#include "mpm/base/simd/Pack.hpp"
#include "mpm/base/types.hpp"

namespace mpm {

// Weights across a row of nodes: S of the other axes, and in [k - 1] the same with the derivative along axis
// k.
template <int Dim, class Number = double> struct Across {
    Number S, G[Dim - 1];
};

template <int Dim> struct Lanes;

template <> struct Lanes<2> {
    using Set = std::array<Quad, 1>; // { B_xx, B_xy, B_yx, B_yy }: B_ik takes d_k phi

#ifdef __AVX512F__ // value and product are the halves of one vector
    using Octo = Widest<8>::Vector;
    typedef int64_t Mask __attribute__((vector_size(64)));
    MPM_INLINE static Octo all(double a) { return Octo{a, a, a, a, a, a, a, a}; }

    struct Row {
        Octo both;
        MPM_INLINE Row(const Quad& value, const Set& B, const Across<2>& w)
            : both((Mask{0, 0, 0, 0, 0, -1, 0, -1} ? all(w.G[0]) : all(w.S)) *
                   __builtin_shufflevector(value, B[0], 0, 1, 2, 3, 4, 5, 6, 7)) {}
        // along: what takes phi itself, of the force along x.
        MPM_INLINE Row(const Quad& value, const Set& B, const Across<2>& w, double along) : Row(value, B, w) {
            both += Octo{0, 0, 0, 0, 0, w.S * along, 0, 0};
        }
        MPM_INLINE void add(Pack<8>& sum, double S, double G) const {
            sum.wide(0) += (Mask{0, 0, 0, 0, -1, 0, -1, 0} ? all(G) : all(S)) * both;
        }
    };
#else
    struct Row {
        Quad value, product; // of product: the even lanes take d_x phi, the odd ones d_y phi
        MPM_INLINE Row(const Quad& value, const Set& B, const Across<2>& w)
            : value(w.S * value), product(alternating(w.S, w.G[0]) * B[0]) {}
        // along: what takes phi itself, of the force along x.
        MPM_INLINE Row(const Quad& value, const Set& B, const Across<2>& w, double along) : Row(value, B, w) {
            product += Quad{0, w.S * along, 0, 0};
        }
        MPM_INLINE void add(Pack<8>& sum, double S, double G) const {
            sum.part[0] += S * value;
            sum.part[1] += alternating(G, S) * product;
        }
    };
#endif
    MPM_INLINE static void finish(const Pack<8>& sum, Pack<8>& node) { node += sum; }
};

template <> struct Lanes<3> {
    using Set =
        std::array<Quad, 4>; // { B_1k, B_2k, B_3k, 0 } for each axis k, and a Quad that takes phi itself

    struct Row {
        Quad value, withG, withS; // of B: what takes the derivative along x, and what takes the weight
        MPM_INLINE Row(const Quad& value, const Set& B, const Across<3>& w)
            : value(w.S * value), withG(w.S * B[0]), withS(w.G[0] * B[1] + w.G[1] * B[2] + w.S * B[3]) {}
        MPM_INLINE void add(Pack<8>& sum, double S, double G) const {
            sum.part[0] += S * value;
            sum.part[1] += G * withG;
            sum.part[1] += S * withS;
        }
    };
    MPM_INLINE static void finish(const Pack<8>& sum, Pack<8>& node) {
        node.part[0] += sum.part[0];
        node.part[1] += sum.part[1];
    }
};

} // namespace mpm
