// SPDX-License-Identifier: GPL-2.0-or-later
// Vectors of a multiple of four doubles, which one multiply-add treats alike.
#pragma once

#include "mpm/base/simd/Quad.hpp"

#include <cmath>
#include <cstdint>

namespace mpm {

// The widest vector that W lanes fill: a register of eight where there is one, else a Quad. InPack is the
// same type where it names memory that is also read as Quads.
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

// W lanes of nodal or particle data that get the same weight, such as mass, momentum and force of a node. W
// is a multiple of four.
template <int W> struct alignas(8 * W) Pack {
    using Wide = typename Widest<W>::InPack;
    static constexpr int wides = 8 * W / int(sizeof(Wide));
    Quad part[W / 4];

    // The same lanes as wide vectors. Do not read a wide vector right after a Quad of it was written: the
    // load would have to wait until the stores have reached the cache.
    MPM_INLINE Wide& wide(int k) { return reinterpret_cast<Wide*>(part)[k]; }
    MPM_INLINE const Wide& wide(int k) const { return reinterpret_cast<const Wide*>(part)[k]; }

    // Copied vector by vector. GCC 12 copies plain bytes in halves, which makes the next wide load wait.
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
