// SPDX-License-Identifier: GPL-2.0-or-later
// Between planes (an array for each component) and lanes (a Quad with all components of an entry).
#pragma once

#include "mpm/base/simd/Pack.hpp"

#include <array>
#include <cstring>

namespace mpm {

#ifdef __AVX__
// Rows become columns. The shuffles are written out, since GCC 12 would take three times as many.
MPM_INLINE void transpose(Quad& a, Quad& b, Quad& c, Quad& d) {
    const Quad abEven = __builtin_shufflevector(a, b, 0, 4, 2, 6);
    const Quad abOdd = __builtin_shufflevector(a, b, 1, 5, 3, 7);
    const Quad cdEven = __builtin_shufflevector(c, d, 0, 4, 2, 6);
    const Quad cdOdd = __builtin_shufflevector(c, d, 1, 5, 3, 7);
    a = __builtin_shufflevector(abEven, cdEven, 0, 1, 4, 5);
    b = __builtin_shufflevector(abOdd, cdOdd, 0, 1, 4, 5);
    c = __builtin_shufflevector(abEven, cdEven, 2, 3, 6, 7);
    d = __builtin_shufflevector(abOdd, cdOdd, 2, 3, 6, 7);
}
#else
MPM_INLINE void transpose(Quad& a, Quad& b, Quad& c, Quad& d) {
    Quad* row[4] = {&a, &b, &c, &d};
    for (int i = 0; i < 4; ++i)
        for (int j = 0; j < i; ++j) std::swap((*row[i])[j], (*row[j])[i]);
}
#endif

template <class Vector> MPM_INLINE Vector load(const double* from) {
    Vector v;
    std::memcpy(&v, from, sizeof v);
    return v;
}
template <class Vector> MPM_INLINE void store(double* to, const Vector& v) { std::memcpy(to, &v, sizeof v); }

// From planes to lanes: out[stride * i] = {plane[0][i], ..., plane[3][i]} for i < count.
MPM_INLINE void interleave(const std::array<const double*, 4>& plane, int count, Quad* out, int stride = 1) {
    int i = 0;
    for (; i + 4 <= count; i += 4) {
        Quad a = load<Quad>(plane[0] + i);
        Quad b = load<Quad>(plane[1] + i);
        Quad c = load<Quad>(plane[2] + i);
        Quad d = load<Quad>(plane[3] + i);
        transpose(a, b, c, d);
        out[stride * i] = a;
        out[stride * (i + 1)] = b;
        out[stride * (i + 2)] = c;
        out[stride * (i + 3)] = d;
    }
    for (; i < count; ++i) out[stride * i] = Quad{plane[0][i], plane[1][i], plane[2][i], plane[3][i]};
}

// From lanes to planes: plane[k][i] = in[stride * i][k] for i < count and k < n.
template <size_t n>
MPM_INLINE void separate(const Quad* in, int stride, int count, const std::array<double*, n>& plane) {
    int i = 0;
    for (; i + 4 <= count; i += 4) {
        Quad lane[4] = {in[stride * i], in[stride * (i + 1)], in[stride * (i + 2)], in[stride * (i + 3)]};
        transpose(lane[0], lane[1], lane[2], lane[3]);
        MPM_UNROLL
        for (size_t k = 0; k < n; ++k) store(plane[k] + i, lane[k]);
    }
    for (; i < count; ++i)
        for (size_t k = 0; k < n; ++k) plane[k][i] = in[stride * i][k];
}

} // namespace mpm
