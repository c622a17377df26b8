// SPDX-License-Identifier: GPL-2.0-or-later
// Loops over a batch of particles or domains, a vector of them at a time.
#pragma once

#include "mpm/base/simd/compiler.hpp"

namespace mpm {

#ifdef __AVX512F__
// From element 8 - n on: n ones, then zeros, which tell the lanes of a last vector that are used. They are
// read from memory since the compiler would understand p < count, and end the loop there.
inline constexpr double onesThenZeros[16] = {1, 1, 1, 1, 1, 1, 1, 1};
#endif

// f(p) for all p < count. With AVX-512 the rest behind the last whole vector is one more vector of which only
// some lanes are used. GCC 12 would go on with half a vector and then one by one, and a row of 55 domains
// would take as long as one of 80.
template <class F> MPM_INLINE void forEachSimd(int count, F&& f) {
#ifdef __AVX512F__
    const int whole = count & ~7, rest = count - whole;
#pragma omp simd
    for (int p = 0; p < whole; ++p) f(p);
    if (rest == 0) return;
#pragma omp simd
    for (int p = whole; p < whole + 8; ++p)
        if (onesThenZeros[8 - rest + p - whole] > 0) f(p);
#else
#pragma omp simd
    for (int p = 0; p < count; ++p) f(p);
#endif
}

} // namespace mpm
