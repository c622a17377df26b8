// SPDX-License-Identifier: GPL-2.0-or-later
// Loops over particles in which each number waits for the one before: roots, divisions, and what follows from
// them. With AVX-512 two vectors of eight particles are treated side by side, statement by statement. A
// processor looks only some hundred instructions ahead of those that wait, which is less than one vector's
// way through a return mapping. Roots and divisions begin with an estimate of 14 bits there.
#pragma once

#include "mpm/base/simd/Pack.hpp"

#ifdef __AVX512F__
#include <immintrin.h>
#endif

namespace mpm {

#ifdef __AVX512F__
// A number of each of sixteen particles.
struct SimdPair {
    using Eight = Widest<8>::Vector;
    Eight low, high;

    SimdPair() = default;
    MPM_INLINE SimdPair(Eight low, Eight high) : low(low), high(high) {}
    MPM_INLINE SimdPair(double x) : low(_mm512_set1_pd(x)), high(low) {}

    MPM_INLINE friend SimdPair operator-(const SimdPair& x) { return {-x.low, -x.high}; }
    MPM_INLINE friend SimdPair operator+(const SimdPair& x, const SimdPair& y) {
        return {x.low + y.low, x.high + y.high};
    }
    MPM_INLINE friend SimdPair operator-(const SimdPair& x, const SimdPair& y) {
        return {x.low - y.low, x.high - y.high};
    }
    MPM_INLINE friend SimdPair operator*(const SimdPair& x, const SimdPair& y) {
        return {x.low * y.low, x.high * y.high};
    }
    MPM_INLINE friend SimdPair operator/(const SimdPair& x, const SimdPair& y) {
        return {x.low / y.low, x.high / y.high};
    }
};

MPM_INLINE SimdPair whereGreater(const SimdPair& x, const SimdPair& y, const SimdPair& then,
                                 const SimdPair& otherwise) {
    return {x.low > y.low ? then.low : otherwise.low, x.high > y.high ? then.high : otherwise.high};
}

// From an estimate y of 1/x with e = 1 - x y:  1/x = y (1 + e + e^2 + e^3 + ...); e < 2^-14 leaves round-off.
MPM_INLINE SimdPair inverse(const SimdPair& x) {
    const SimdPair y{_mm512_rcp14_pd(x.low), _mm512_rcp14_pd(x.high)};
    const SimdPair e = 1 - x * y, square = e * e;
    return y + y * ((e + square) + e * square);
}

// From an estimate y of 1/sqrt(x) with e = 1 - x y^2:  sqrt(x) = x y (1 + 1/2 e + 3/8 e^2 + 5/16 e^3 + ...).
// The root of zero is 1e-150.
MPM_INLINE SimdPair root(const SimdPair& x) {
    const SimdPair safe = x + 1e-300;
    const SimdPair y{_mm512_rsqrt14_pd(safe.low), _mm512_rsqrt14_pd(safe.high)};
    const SimdPair t = safe * y, e = 1 - t * y;
    return t + (t * e) * ((0.3125 * e + 0.375) * e + 0.5);
}

// Reads and writes two vectors of a plane, from particle `first` on.
struct WholePair {
    int first;

    MPM_INLINE SimdPair operator()(const double* plane) const {
        return {_mm512_loadu_pd(plane + first), _mm512_loadu_pd(plane + first + 8)};
    }
    MPM_INLINE void set(double* plane, const SimdPair& x) const {
        _mm512_storeu_pd(plane + first, x.low);
        _mm512_storeu_pd(plane + first + 8, x.high);
    }
};

// The same for the last particles of a run, which are fewer than sixteen; the other lanes read zero.
struct PartOfPair {
    int first;
    __mmask8 low, high;

    MPM_INLINE PartOfPair(int first, int count)
        : first(first), low((1 << count) - 1), high(((1 << count) - 1) >> 8) {}
    MPM_INLINE SimdPair operator()(const double* plane) const {
        return {_mm512_maskz_loadu_pd(low, plane + first), _mm512_maskz_loadu_pd(high, plane + first + 8)};
    }
    MPM_INLINE void set(double* plane, const SimdPair& x) const {
        _mm512_mask_storeu_pd(plane + first, low, x.low);
        _mm512_mask_storeu_pd(plane + first + 8, high, x.high);
    }
};
#endif

MPM_INLINE double whereGreater(double x, double y, double then, double otherwise) {
    return x > y ? then : otherwise;
}
MPM_INLINE double inverse(double x) { return 1 / x; }
MPM_INLINE double root(double x) { return std::sqrt(x); }

// The same for a single particle, where the compiler makes the vectors.
struct OneNumber {
    int p;

    MPM_INLINE double operator()(const double* plane) const { return plane[p]; }
    MPM_INLINE void set(double* plane, double x) const { plane[p] = x; }
};

// Calls f(at) until all p < count have had their turn: at(plane) reads the numbers of the particles at hand
// from a plane, at.set(plane, x) writes them. They are of type SimdPair or double, so f is a generic lambda.
template <class F> MPM_INLINE void forEachSimdPair(int count, F&& f) {
#ifdef __AVX512F__
    int first = 0;
    for (; first + 16 <= count; first += 16) f(WholePair{first});
    if (first < count) f(PartOfPair{first, count - first});
#else
#pragma omp simd
    for (int p = 0; p < count; ++p) f(OneNumber{p});
#endif
}

} // namespace mpm
