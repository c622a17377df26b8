// SPDX-License-Identifier: GPL-2.0-or-later
// The natural logarithm, of numbers and of tensors, for loops over particles: without a branch and without a
// call, so that they vectorise.
#pragma once

#include "mpm/material/tensors.hpp"

#include <cstdint>
#include <cstring>
#include <limits>

namespace mpm {

// ln(1 + x) to 5e-16 relative, also for tiny x; NaN for x <= -1. 1 + x = 2^k m with m in [sqrt(1/2),
// sqrt(2)), and ln m = 2 atanh(s), s = (m - 1)/(m + 1), |s| < 0.172: ten terms of the series are enough.
// Every second one is summed apart, because the two sums can run side by side.
MPM_INLINE double logOnePlus(double x) {
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
    const double s = f / (2 + f), z = s * s, w = z * z;
    const double even = 1.0 / 3 + w * (1.0 / 7 + w * (1.0 / 11 + w * (1.0 / 15 + w * (1.0 / 19))));
    const double odd = 1.0 / 5 + w * (1.0 / 9 + w * (1.0 / 13 + w * (1.0 / 17 + w * (1.0 / 21))));
    const double series = even + z * odd;
    const double value = k * ln2High + (2 * s + (2 * s * z * series + k * ln2Low));
    return x > -1 ? value : std::numeric_limits<double>::quiet_NaN();
}

// exp(x) of |x| <= exponentialLimit, to 3e-16 relative: thirteen terms of the series.
constexpr double exponentialLimit = 0.35;

MPM_INLINE double smallExponential(double x) {
    double sum = 1;
#pragma GCC unroll 12
    for (int n = 12; n > 0; --n) sum = 1 + x * ((1.0 / n) * sum);
    return sum;
}

// a I + b y + c y^2
struct Quadratic {
    double a, b, c;
};

// 1/n + y/(n + 2) + y^2/(n + 4) + ... down to 1/last, by Horner's rule on three numbers: y with the
// invariants I1, I2, I3 obeys y^3 = I1 y^2 - I2 y + I3 I.
template <int n, int last> MPM_INLINE Quadratic oddReciprocals(double I1, double I2, double I3) {
    if constexpr (n == last)
        return {1.0 / n, 0, 0};
    else {
        const Quadratic rest = oddReciprocals<n + 2, last>(I1, I2, I3);
        return {rest.c * I3 + 1.0 / n, rest.a - rest.c * I2, rest.b + rest.c * I1};
    }
}

// ln(I + e) = 2 atanh(z) = 2 z (I + z^2/3 + z^4/5 + ...), where Cayley-Hamilton gives for z = e (2 I + e)^-1
// [2 e - adj(e) + (J2 + J3/2) I]/(det(2 I + e)/2) with the invariants J of e, and y^2 = adj(y) + I1 y - I2 I
// for y = z^2. Twelve terms are exact to round-off while no principal value of e exceeds the limit.
constexpr double logarithmLimit = 0.4;

MPM_INLINE Symmetric logOfIdentityPlus(const Symmetric& e) {
    const Symmetric adjE = adjugate(e);
    const double J1 = trace(e), J2 = trace(adjE), J3 = determinant(e, adjE);
    const double overDet = 1 / (4 + 2 * J1 + J2 + 0.5 * J3);
    const Symmetric z = overDet * plusSpherical(2 * e - adjE, J2 + 0.5 * J3);

    const Symmetric y = square(z), adjY = adjugate(y);
    const double I1 = trace(y), I2 = trace(adjY), I3 = determinant(y, adjY);
    const Quadratic q = oddReciprocals<1, 23>(I1, I2, I3);
    const Symmetric sum = plusSpherical((q.b + q.c * I1) * y + q.c * adjY, q.a - q.c * I2);
    return 2 * timesTransposed(z, sum);
}

} // namespace mpm
