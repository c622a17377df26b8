// SPDX-License-Identifier: GPL-2.0-or-later
// 3x3 tensors as plain numbers. A loop over particles that is written in them vectorises: every number
// becomes a register of several particles, which a loop over Eigen's matrices does not.
#pragma once

#include "mpm/base/simd/Pack.hpp"
#include "mpm/base/types.hpp"

#include <algorithm>
#include <array>

namespace mpm {

struct Tensor {
    double xx, xy, xz, yx, yy, yz, zx, zy, zz;
};

struct Symmetric {
    double xx, yy, zz, xy, xz, yz;

    MPM_INLINE operator Tensor() const { return {xx, xy, xz, xy, yy, yz, xz, yz, zz}; }
};

// The planes of n components, for a loop to hold on to: through MaterialPoints it may fail to see that they
// stay where they are, and then it does not vectorise.
template <int n, class Number> inline std::array<Number*, n> planes(Number* const* component) {
    std::array<Number*, n> all;
    std::copy(component, component + n, all.begin());
    return all;
}

// Tensor of particle p, component (i, j) from plane 3*i + j.
template <class Planes> MPM_INLINE Tensor gather(const Planes& component, int p) {
    return {component[0][p], component[1][p], component[2][p], component[3][p], component[4][p],
            component[5][p], component[6][p], component[7][p], component[8][p]};
}

// The upper triangle alone, of a symmetric tensor.
template <class Planes> MPM_INLINE Symmetric gatherUpper(const Planes& component, int p) {
    return {component[0][p], component[4][p], component[8][p],
            component[1][p], component[2][p], component[5][p]};
}

template <class Planes> MPM_INLINE void scatterUpper(const Symmetric& a, const Planes& component, int p) {
    component[0][p] = a.xx;
    component[4][p] = a.yy;
    component[8][p] = a.zz;
    component[1][p] = a.xy;
    component[2][p] = a.xz;
    component[5][p] = a.yz;
}

template <class Planes> MPM_INLINE void scatter(const Symmetric& a, const Planes& component, int p) {
    scatterUpper(a, component, p);
    component[3][p] = a.xy;
    component[6][p] = a.xz;
    component[7][p] = a.yz;
}

MPM_INLINE Tensor operator*(double s, const Tensor& a) {
    return {s * a.xx, s * a.xy, s * a.xz, s * a.yx, s * a.yy, s * a.yz, s * a.zx, s * a.zy, s * a.zz};
}

MPM_INLINE Symmetric operator*(double s, const Symmetric& a) {
    return {s * a.xx, s * a.yy, s * a.zz, s * a.xy, s * a.xz, s * a.yz};
}

MPM_INLINE Tensor operator+(const Tensor& a, const Tensor& b) {
    return {a.xx + b.xx, a.xy + b.xy, a.xz + b.xz, a.yx + b.yx, a.yy + b.yy,
            a.yz + b.yz, a.zx + b.zx, a.zy + b.zy, a.zz + b.zz};
}

MPM_INLINE Tensor operator-(const Tensor& a, const Tensor& b) {
    return {a.xx - b.xx, a.xy - b.xy, a.xz - b.xz, a.yx - b.yx, a.yy - b.yy,
            a.yz - b.yz, a.zx - b.zx, a.zy - b.zy, a.zz - b.zz};
}

MPM_INLINE Symmetric operator+(const Symmetric& a, const Symmetric& b) {
    return {a.xx + b.xx, a.yy + b.yy, a.zz + b.zz, a.xy + b.xy, a.xz + b.xz, a.yz + b.yz};
}

MPM_INLINE Symmetric operator-(const Symmetric& a, const Symmetric& b) {
    return {a.xx - b.xx, a.yy - b.yy, a.zz - b.zz, a.xy - b.xy, a.xz - b.xz, a.yz - b.yz};
}

// a + s I
MPM_INLINE Symmetric plusSpherical(const Symmetric& a, double s) {
    return {a.xx + s, a.yy + s, a.zz + s, a.xy, a.xz, a.yz};
}

MPM_INLINE Tensor plusSpherical(const Tensor& a, double s) {
    return {a.xx + s, a.xy, a.xz, a.yx, a.yy + s, a.yz, a.zx, a.zy, a.zz + s};
}

MPM_INLINE double trace(const Tensor& a) { return a.xx + a.yy + a.zz; }

// a : a / 2
MPM_INLINE double halfSquare(const Symmetric& a) {
    return 0.5 * (a.xx * a.xx + a.yy * a.yy + a.zz * a.zz) + (a.xy * a.xy + a.xz * a.xz + a.yz * a.yz);
}

// a adj(a) = det(a) I; its trace is the second invariant of a.
MPM_INLINE Tensor adjugate(const Tensor& a) {
    return {a.yy * a.zz - a.yz * a.zy, a.xz * a.zy - a.xy * a.zz, a.xy * a.yz - a.xz * a.yy,
            a.yz * a.zx - a.yx * a.zz, a.xx * a.zz - a.xz * a.zx, a.xz * a.yx - a.xx * a.yz,
            a.yx * a.zy - a.yy * a.zx, a.xy * a.zx - a.xx * a.zy, a.xx * a.yy - a.xy * a.yx};
}

MPM_INLINE Symmetric adjugate(const Symmetric& a) {
    return {a.yy * a.zz - a.yz * a.yz, a.xx * a.zz - a.xz * a.xz, a.xx * a.yy - a.xy * a.xy,
            a.xz * a.yz - a.xy * a.zz, a.xy * a.yz - a.xz * a.yy, a.xy * a.xz - a.xx * a.yz};
}

MPM_INLINE double determinant(const Tensor& a, const Tensor& adjugate) {
    return a.xx * adjugate.xx + a.xy * adjugate.yx + a.xz * adjugate.zx;
}

MPM_INLINE Tensor operator*(const Tensor& a, const Tensor& b) {
    return {a.xx * b.xx + a.xy * b.yx + a.xz * b.zx, a.xx * b.xy + a.xy * b.yy + a.xz * b.zy,
            a.xx * b.xz + a.xy * b.yz + a.xz * b.zz, a.yx * b.xx + a.yy * b.yx + a.yz * b.zx,
            a.yx * b.xy + a.yy * b.yy + a.yz * b.zy, a.yx * b.xz + a.yy * b.yz + a.yz * b.zz,
            a.zx * b.xx + a.zy * b.yx + a.zz * b.zx, a.zx * b.xy + a.zy * b.yy + a.zz * b.zy,
            a.zx * b.xz + a.zy * b.yz + a.zz * b.zz};
}

// a b^T, of which the caller knows that it is symmetric.
MPM_INLINE Symmetric timesTransposed(const Tensor& a, const Tensor& b) {
    return {a.xx * b.xx + a.xy * b.xy + a.xz * b.xz, a.yx * b.yx + a.yy * b.yy + a.yz * b.yz,
            a.zx * b.zx + a.zy * b.zy + a.zz * b.zz, a.xx * b.yx + a.xy * b.yy + a.xz * b.yz,
            a.xx * b.zx + a.xy * b.zy + a.xz * b.zz, a.yx * b.zx + a.yy * b.zy + a.yz * b.zz};
}

MPM_INLINE Symmetric square(const Symmetric& a) { return timesTransposed(a, a); }

// r a r^T
MPM_INLINE Symmetric congruence(const Tensor& r, const Symmetric& a) { return timesTransposed(r * a, r); }

// a + a^T
MPM_INLINE Symmetric plusTransposed(const Tensor& a) {
    return {2 * a.xx, 2 * a.yy, 2 * a.zz, a.xy + a.yx, a.xz + a.zx, a.yz + a.zy};
}

} // namespace mpm
