// SPDX-License-Identifier: GPL-2.0-or-later
// Loops over particles in which every number waits for the one before: roots, divisions, and what follows from them. With AVX-512 sixteen
// particles are taken at a time, as two vectors that each statement treats in turn: a processor looks ahead by some hundred instructions
// that wait, and the chain of one vector through a return mapping is longer. Roots and divisions then begin at an estimate of 14 bits.
#pragma once

#include "mpm/base/simd/Pack.hpp"

#ifdef __AVX512F__
#include <immintrin.h>
#endif

namespace mpm {

#ifdef __AVX512F__
struct Sixteen {
    using Eight = Widest<8>::Vector;
    Eight low, high;

    Sixteen() = default;
    MPM_INLINE Sixteen(Eight low, Eight high) : low(low), high(high) {}
    MPM_INLINE Sixteen(double x) : low(_mm512_set1_pd(x)), high(low) {}

    MPM_INLINE friend Sixteen operator-(const Sixteen& x) { return {-x.low, -x.high}; }
    MPM_INLINE friend Sixteen operator+(const Sixteen& x, const Sixteen& y) {
        return {x.low + y.low, x.high + y.high};
    }
    MPM_INLINE friend Sixteen operator-(const Sixteen& x, const Sixteen& y) {
        return {x.low - y.low, x.high - y.high};
    }
    MPM_INLINE friend Sixteen operator*(const Sixteen& x, const Sixteen& y) {
        return {x.low * y.low, x.high * y.high};
    }
    MPM_INLINE friend Sixteen operator/(const Sixteen& x, const Sixteen& y) {
        return {x.low / y.low, x.high / y.high};
    }
};

MPM_INLINE Sixteen whereGreater(const Sixteen& x, const Sixteen& y, const Sixteen& then,
                                const Sixteen& otherwise) {
    return {x.low > y.low ? then.low : otherwise.low, x.high > y.high ? then.high : otherwise.high};
}

// From y near 1/x with e = 1 - x y:  1/x = y (1 + e + e^2 + e^3 ...), to round-off for e < 2^-14.
MPM_INLINE Sixteen inverse(const Sixteen& x) {
    const Sixteen y{_mm512_rcp14_pd(x.low), _mm512_rcp14_pd(x.high)}, e = 1 - x * y, square = e * e;
    return y + y * ((e + square) + e * square);
}

// From y near 1/sqrt(x) with e = 1 - x y^2:  sqrt(x) = x y (1 + e/2 + 3/8 e^2 + 5/16 e^3 ...). 1e-150 at zero.
MPM_INLINE Sixteen root(const Sixteen& x) {
    const Sixteen safe = x + 1e-300, y{_mm512_rsqrt14_pd(safe.low), _mm512_rsqrt14_pd(safe.high)};
    const Sixteen t = safe * y, e = 1 - t * y;
    return t + (t * e) * ((0.3125 * e + 0.375) * e + 0.5);
}

// Sixteen particles from the first on, and the last of a run, which are fewer.
struct WholeSixteen {
    int first;

    MPM_INLINE Sixteen operator()(const double* plane) const {
        return {_mm512_loadu_pd(plane + first), _mm512_loadu_pd(plane + first + 8)};
    }
    MPM_INLINE void set(double* plane, const Sixteen& x) const {
        _mm512_storeu_pd(plane + first, x.low), _mm512_storeu_pd(plane + first + 8, x.high);
    }
};
struct PartOfSixteen {
    int first;
    __mmask8 low, high;

    MPM_INLINE PartOfSixteen(int first, int count)
        : first(first), low((1 << count) - 1), high(((1 << count) - 1) >> 8) {}
    MPM_INLINE Sixteen operator()(const double* plane) const {
        return {_mm512_maskz_loadu_pd(low, plane + first), _mm512_maskz_loadu_pd(high, plane + first + 8)};
    }
    MPM_INLINE void set(double* plane, const Sixteen& x) const {
        _mm512_mask_storeu_pd(plane + first, low, x.low),
            _mm512_mask_storeu_pd(plane + first + 8, high, x.high);
    }
};
#endif

MPM_INLINE double whereGreater(double x, double y, double then, double otherwise) {
    return x > y ? then : otherwise;
}
MPM_INLINE double inverse(double x) { return 1 / x; }
MPM_INLINE double root(double x) { return std::sqrt(x); }

struct OneParticle {
    int p;

    MPM_INLINE double operator()(const double* plane) const { return plane[p]; }
    MPM_INLINE void set(double* plane, double x) const { plane[p] = x; }
};

// f(at) for p < count; at(plane) is the number of the particles at hand in a plane, at.set(plane, x) writes it.
template <class F> MPM_INLINE void forEachSimdPair(int count, F&& f) {
#ifdef __AVX512F__
    int first = 0;
    for (; first + 16 <= count; first += 16) f(WholeSixteen{first});
    if (first < count) f(PartOfSixteen{first, count - first});
#else
#pragma omp simd
    for (int p = 0; p < count; ++p) f(OneParticle{p});
#endif
}

} // namespace mpm
