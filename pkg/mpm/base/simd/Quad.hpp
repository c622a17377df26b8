// SPDX-License-Identifier: GPL-2.0-or-later
// Four doubles that are treated alike.
#pragma once

#include "mpm/base/simd/compiler.hpp"

namespace mpm {

#ifdef __AVX__
// One vector register.
typedef double Quad __attribute__((vector_size(32)));

MPM_INLINE Quad alternating(double even, double odd) {
    return __builtin_shufflevector(Quad{even, even, even, even}, Quad{odd, odd, odd, odd}, 0, 5, 2, 7);
}
MPM_INLINE Quad evenLanes(const Quad& a, const Quad& b) { return __builtin_shufflevector(a, b, 0, 2, 4, 6); }
#else
// Two registers of two doubles. As one vector type that is wider than a register GCC 12 would move the lanes one by one
// through memory, and a step of uGIMP would take five times as long.
struct Quad {
    typedef double Pair __attribute__((vector_size(16)));
    Pair low, high;

    Quad() = default;
    MPM_INLINE Quad(Pair low, Pair high) : low(low), high(high) {}
    MPM_INLINE Quad(double a, double b, double c, double d) : low{a, b}, high{c, d} {}

    MPM_INLINE double operator[](int lane) const { return lane < 2 ? low[lane] : high[lane - 2]; }
    MPM_INLINE double& operator[](int lane) { return reinterpret_cast<double*>(this)[lane]; }

    MPM_INLINE Quad& operator+=(const Quad& other) {
        low += other.low;
        high += other.high;
        return *this;
    }
    MPM_INLINE Quad& operator-=(const Quad& other) {
        low -= other.low;
        high -= other.high;
        return *this;
    }
    MPM_INLINE friend Quad operator+(const Quad& a, const Quad& b) {
        return {a.low + b.low, a.high + b.high};
    }
    MPM_INLINE friend Quad operator*(const Quad& a, const Quad& b) {
        return {a.low * b.low, a.high * b.high};
    }
    MPM_INLINE friend Quad operator*(double s, const Quad& a) { return {s * a.low, s * a.high}; }
};

// {even, odd, even, odd}
MPM_INLINE Quad alternating(double even, double odd) { return {even, odd, even, odd}; }
// {a[0], a[2], b[0], b[2]}
MPM_INLINE Quad evenLanes(const Quad& a, const Quad& b) { return {a[0], a[2], b[0], b[2]}; }
#endif

} // namespace mpm
