// SPDX-License-Identifier: GPL-2.0-or-later
// Small vectors of doubles: Quad (four lanes) and Pack (a multiple of four).
#pragma once

#include "mpm/base/simd/compiler.hpp"

#include <cmath>
#include <cstdint>

namespace mpm {

// Four doubles: one vector register where the machine has those, else two of two doubles each. As one vector type wider than
// a register GCC 12 would move them through memory lane by lane, and a step of uGIMP would take five times as long.
#ifdef __AVX__
typedef double Quad __attribute__((vector_size(32)));

// even and odd lanes from two numbers
MPM_INLINE Quad alternating(double even, double odd) {
    return __builtin_shufflevector(Quad{even, even, even, even}, Quad{odd, odd, odd, odd}, 0, 5, 2, 7);
}
// the even lanes of two
MPM_INLINE Quad evenLanes(const Quad& a, const Quad& b) { return __builtin_shufflevector(a, b, 0, 2, 4, 6); }
#else
struct Quad {
    typedef double Pair __attribute__((vector_size(16)));
    Pair low, high;

    Quad() = default;
    MPM_INLINE Quad(Pair low, Pair high) : low(low), high(high) {}
    MPM_INLINE Quad(double a, double b, double c, double d) : low{a, b}, high{c, d} {}

    MPM_INLINE double operator[](int lane) const { return lane < 2 ? low[lane] : high[lane - 2]; }
    MPM_INLINE double& operator[](int lane) { return reinterpret_cast<double*>(this)[lane]; }

    MPM_INLINE Quad& operator+=(const Quad& other) { return low += other.low, high += other.high, *this; }
    MPM_INLINE Quad& operator-=(const Quad& other) { return low -= other.low, high -= other.high, *this; }
    MPM_INLINE friend Quad operator+(const Quad& a, const Quad& b) {
        return {a.low + b.low, a.high + b.high};
    }
    MPM_INLINE friend Quad operator*(const Quad& a, const Quad& b) {
        return {a.low * b.low, a.high * b.high};
    }
    MPM_INLINE friend Quad operator*(double s, const Quad& a) { return {s * a.low, s * a.high}; }
};

MPM_INLINE Quad alternating(double even, double odd) { return {even, odd, even, odd}; }
MPM_INLINE Quad evenLanes(const Quad& a, const Quad& b) { return {a[0], a[2], b[0], b[2]}; }
#endif

// The widest vectors that W lanes fill; InPack where these are also Quads.
template <int W> struct Widest {
    using Vector = Quad;
    using InPack = Quad;
};
#ifdef __AVX512F__
template <> struct Widest<8> {
    typedef double Vector __attribute__((vector_size(64)));
    typedef Vector InPack __attribute__((may_alias));
};
#endif

// W lanes of nodal or particle data that are weighted together: one multiply-add treats mass,
// momentum and force of a node alike. W is a multiple of four.
template <int W> struct alignas(8 * W) Pack {
    using Wide = typename Widest<W>::InPack;
    static constexpr int wides = 8 * W / int(sizeof(Wide));
    Quad part[W / 4];

    // The same lanes. What was written by parts must not be read whole at once: the load would wait for the stores.
    MPM_INLINE Wide& wide(int k) { return reinterpret_cast<Wide*>(part)[k]; }
    MPM_INLINE const Wide& wide(int k) const { return reinterpret_cast<const Wide*>(part)[k]; }

    // Copied by vectors: as plain bytes GCC 12 moves halves of them through memory, which stalls the next load.
    Pack() = default;
    MPM_INLINE Pack(const Pack& other) { *this = other; }
    MPM_INLINE Pack& operator=(const Pack& other) {
        for (int k = 0; k < wides; ++k) wide(k) = other.wide(k);
        return *this;
    }

    MPM_INLINE double operator[](int lane) const { return part[lane / 4][lane % 4]; }
    MPM_INLINE void set(int lane, double value) { part[lane / 4][lane % 4] = value; }

    MPM_INLINE static Pack zero() {
        Pack z;
        for (int k = 0; k < wides; ++k) z.wide(k) = Wide{};
        return z;
    }
    MPM_INLINE Pack& operator+=(const Pack& other) {
        for (int k = 0; k < wides; ++k) wide(k) += other.wide(k);
        return *this;
    }
    // this += s * other
    MPM_INLINE void add(double s, const Pack& other) {
        for (int k = 0; k < wides; ++k) wide(k) += s * other.wide(k);
    }
};

template <int W> MPM_INLINE Pack<W> operator*(double s, const Pack<W>& a) {
    Pack<W> r;
    for (int k = 0; k < Pack<W>::wides; ++k) r.wide(k) = s * a.wide(k);
    return r;
}

} // namespace mpm
