// SPDX-License-Identifier: GPL-2.0-or-later
// Products with the gradient of a weight, side by side in the lanes of a Quad.
//
//   2D: one Quad for both components i,  { B_11, B_12, B_21, B_22 }
//   3D: one Quad for each component i,   { B_i1, B_i2, B_i3, B_i }
//
// Multiplied lane by lane with of(phi, grad phi) = { d1, d2, d1, d2 } or { d1, d2, d3, phi } and folded, they give
// sum_k d_k phi B_ik. Since phi is a product over the axes, so are these lanes: of(phi, grad phi) is the product of
// ofAxis<k>(S_k, G_k), in which the lanes of d_k hold the gradient G_k of axis k and all others its weight S_k.
#pragma once

#include "mpm/base/types.hpp"

namespace mpm {

template <int Dim> struct Lanes {
    static constexpr int quads = Dim == 2 ? 1 : 3;
    using Set = std::array<Quad, quads>;

    MPM_INLINE static Set zero() {
        Set z;
        z.fill(Quad{0, 0, 0, 0});
        return z;
    }

    template <int axis> MPM_INLINE static Quad ofAxis(double S, double G) {
        typedef int64_t Mask __attribute__((vector_size(32)));
        const Quad value{S, S, S, S}, gradient{G, G, G, G};
        const Mask isGradient{-(axis == 0), -(axis == 1), -(axis == (Dim == 2 ? 0 : 2)), -(Dim == 2 && axis == 1)};
        return isGradient ? gradient : value;
    }

    MPM_INLINE static Quad of(double phi, const Vec<Dim>& gradient) {
        if constexpr (Dim == 2)
            return Quad{gradient[0], gradient[1], gradient[0], gradient[1]};
        else
            return Quad{gradient[0], gradient[1], gradient[2], phi};
    }

    // Sums over the gradient lanes: component i at NodalField::lane(i); in 3D B_1 of the first Quad comes last.
    MPM_INLINE static Quad fold(const Set& B) {
        if constexpr (Dim == 2) {
            const Quad b = B[0];
            return b + Quad{b[1], b[0], b[3], b[2]};
        } else {
            Quad f{0, 0, 0, B[0][3]};
            for (int i = 0; i < 3; ++i) f[i] = B[i][0] + B[i][1] + B[i][2];
            return f;
        }
    }

    // Without the gradient's lanes.
    MPM_INLINE static Set onlyValue(const Set& B) {
        Set b = zero();
        if constexpr (Dim == 3)
            for (int i = 0; i < 3; ++i) b[i][3] = B[i][3];
        return b;
    }

    // A vector in the lanes of NodalField::Velocity, from value(component).
    template <class F> MPM_INLINE static Quad vector(F&& value) {
        if constexpr (Dim == 2)
            return Quad{value(0), value(0), value(1), value(1)};
        else
            return Quad{value(0), value(1), value(2), 0};
    }

    // A vector as in NodalField::Velocity, each component in all its lanes.
    MPM_INLINE static Set spread(const Pack<4>& v) {
        if constexpr (Dim == 2)
            return {v.part[0]};
        else
            return {Quad{v[0], v[0], v[0], v[0]}, Quad{v[1], v[1], v[1], v[1]}, Quad{v[2], v[2], v[2], v[2]}};
    }

    // Where the gradient d_j v_i is in the product with such a vector, in lanes from the start of the Set.
    static constexpr int laneOf(int i, int j) { return Dim == 2 ? 2 * i + j : 4 * i + j; }

    // Which component a lane of a vector holds, and how many lanes are in use.
    static constexpr int component(int lane) { return Dim == 2 ? lane / 2 : lane; }
    static constexpr int used = Dim == 2 ? 4 : 3;
};

} // namespace mpm
