// SPDX-License-Identifier: GPL-2.0-or-later
// Loops over a batch of particles or domains by vectors of eight. With AVX-512 the rest is one vector more, of which some lanes count:
// GCC 12 would go on with half a vector and then number by number, and rows of 55 domains would take as long as rows of 80.
#pragma once

#include "mpm/base/simd/Pack.hpp"

namespace mpm {

#ifdef __AVX512F__
// From 8 - n on: n that count. Read from memory, for the compiler would see through p < count, and bound the loop by it.
inline constexpr double laneCounts[16] = {1, 1, 1, 1, 1, 1, 1, 1};
#endif

// f(p) for p < count.
template <class F> MPM_INLINE void forEachSimd(int count, F&& f) {
#ifdef __AVX512F__
    const int whole = count & ~7, rest = count - whole;
#pragma omp simd
    for (int p = 0; p < whole; ++p) f(p);
    if (rest == 0) return;
#pragma omp simd
    for (int p = whole; p < whole + 8; ++p)
        if (laneCounts[8 - rest + p - whole] > 0) f(p);
#else
#pragma omp simd
    for (int p = 0; p < count; ++p) f(p);
#endif
}

} // namespace mpm
