// SPDX-License-Identifier: GPL-2.0-or-later
// Small tensor pieces that several materials share.
#pragma once

#include "mpm/base/types.hpp"

#include <cstdint>
#include <cstring>
#include <limits>

namespace mpm {

// Tensor of particle p from planar arrays, component (i, j) at N*i + j.
template <int N, class Arrays>
inline Mat<N> gather(const Arrays& component, int p) {
    Mat<N> a;
    for (int i = 0; i < N; ++i)
        for (int j = 0; j < N; ++j)
            a(i, j) = component[N * i + j][p];
    return a;
}

// Symmetric tensor of particle p from the upper triangle of its planar arrays.
template <class Arrays>
inline Mat<3> gatherSymmetric(const Arrays& component, int p) {
    Mat<3> a;
    for (int i = 0; i < 3; ++i)
        for (int j = i; j < 3; ++j)
            a(i, j) = a(j, i) = component[3 * i + j][p];
    return a;
}

inline void scatterSymmetric(const Mat<3>& a, double* const* component, int p) {
    for (int i = 0; i < 3; ++i)
        for (int j = i; j < 3; ++j)
            component[3 * i + j][p] = component[3 * j + i][p] = a(i, j);
}

// ln(1 + x) to 5e-16 relative, also for tiny x; NaN for x <= -1. Unlike std::log1p it has no branch and
// no call, so that a loop over particles vectorises. 1 + x = 2^k m with m in [sqrt(1/2), sqrt(2)), and
// ln m = 2 atanh(s), s = (m - 1)/(m + 1), |s| < 0.172: ten terms of the series are enough.
inline double logOnePlus(double x) {
    constexpr std::uint64_t one = 0x3ff0000000000000, halfRoot = 0x3fe6a09e667f3bcd; // 1, sqrt(1/2)
    constexpr std::uint64_t mantissa = 0x000fffffffffffff, twoTo52 = 0x4330000000000000;
    constexpr double ln2High = 6.93147180369123816490e-01, ln2Low = 1.90821492927058770002e-10;

    const double u = 1 + x;
    std::uint64_t bits;
    std::memcpy(&bits, &u, sizeof u);
    const std::uint64_t shifted = bits + (one - halfRoot);
    const std::uint64_t mBits = (shifted & mantissa) + halfRoot, kBits = (shifted >> 52) | twoTo52;
    double m, k;
    std::memcpy(&m, &mBits, sizeof m);
    std::memcpy(&k, &kBits, sizeof k);
    k -= 4503599627370496.0 + 1023; // integer to double by way of 2^52: AVX2 has no instruction for it

    const double f = k == 0 ? x : m - 1; // the rounding of 1 + x matters only where the logarithm is small
    const double s = f / (2 + f), z = s * s;
    double series = 1.0 / 15 + z * (1.0 / 17 + z * (1.0 / 19 + z / 21));
    series = 1.0 / 3 +
             z * (1.0 / 5 + z * (1.0 / 7 + z * (1.0 / 9 + z * (1.0 / 11 + z * (1.0 / 13 + z * series)))));
    const double value = k * ln2High + (2 * s + (2 * s * z * series + k * ln2Low));
    return x > -1 ? value : std::numeric_limits<double>::quiet_NaN();
}

} // namespace mpm
