// SPDX-License-Identifier: GPL-2.0-or-later
// Hypoelastic trial stress (Jaumann rate) with the midpoint rotation of Hughes & Winget 1980:
//   sigma <- R sigma R^T + r (lambda tr(D) I + 2 mu D) r^T,  R = r r = (I - W/2)^-1 (I + W/2)
//   D, W = sym, skew of g (I + g/2)^-1,  g = dt L
#pragma once

#include "mpm/base/simd/forEachSimdPair.hpp"
#include "mpm/material/Material.hpp"
#include "mpm/material/tensors.hpp"

namespace mpm {

// Moduli are one number for all particles, or a plane with those of each.
template <class At> MPM_INLINE double modulus(const At&, double x) { return x; }
template <class At> MPM_INLINE auto modulus(const At& at, const double* plane) { return at(plane); }

// The plane in closed form, then what strains along its third axis. With D2 = det(I + g/2), Cayley-Hamilton gives
// g (I + g/2)^-1 = (g + det(g)/2 I)/D2, and R rotates by the angle whose half has the tangent spin/D2.
template <class Moduli>
void trialStress(const Moduli& lambdas, const Moduli& mus, const MaterialPoints<2>& points) {
    const double dt = points.dt;
    auto L = points.velocityGradient;
    const double *L11 = L[0], *L12 = L[1], *L21 = L[2], *L22 = L[3];
    double *xx = points.stress[0], *xy = points.stress[1], *yy = points.stress[4], *zz = points.stress[8];
    forEachSimdPair(points.count, [&](auto at) MPM_INLINE_LAMBDA {
        const auto lambda = modulus(at, lambdas), mu = modulus(at, mus);
        const auto g11 = dt * at(L11), g12 = dt * at(L12), g21 = dt * at(L21), g22 = dt * at(L22);
        const auto detG = g11 * g22 - g12 * g21, D2 = 1 + 0.5 * (g11 + g22) + 0.25 * detG;
        const auto spin = 0.25 * (g12 - g21), D4 = D2 * D2, norm = D4 + spin * spin;
        const auto overD2 = inverse(D2), overNorm = inverse(norm);
        const auto cosR = (D4 - spin * spin) * overNorm, sinR = 2 * spin * D2 * overNorm;
        // Of the double angle; this form keeps cos2^2 + sin2^2 = 1 best, hence the norm of the stress.
        const auto cos2 = 1 - 2 * sinR * sinR, sin2 = 2 * sinR * cosR;

        // As mean and half difference in the plane, shear, and out of plane.
        const auto half0 = 0.5 * (at(xx) - at(yy)), shear0 = at(xy);
        const auto volumetric = (g11 + g22 + detG) * overD2;
        const auto dHalf = mu * (g11 - g22) * overD2, dShear = mu * (g12 + g21) * overD2;
        const auto mean = 0.5 * (at(xx) + at(yy)) + (lambda + mu) * volumetric;
        const auto half = half0 * cos2 + shear0 * sin2 + dHalf * cosR + dShear * sinR;
        at.set(xx, mean + half);
        at.set(yy, mean - half);
        at.set(zz, at(zz) + lambda * volumetric);
        at.set(xy, shear0 * cos2 - half0 * sin2 + dShear * cosR - dHalf * sinR);
    });
    if (!points.hoopRate) return;
    for (int i = 0; i < points.count; ++i) {
        const double g = dt * points.hoopRate[i], D = g / (1 + 0.5 * g);
        const double lambda = modulus(OneNumber{i}, lambdas), mu = modulus(OneNumber{i}, mus);
        xx[i] += lambda * D;
        yy[i] += lambda * D;
        zz[i] += (lambda + 2 * mu) * D;
    }
}

struct Midpoint {
    Symmetric D;
    Tensor r;
};

// With h = g/2, its invariants t, m, d and D3 = det(I + h) = 1 + t + m + d, Cayley-Hamilton gives
//   h (I + h)^-1 = G/D3,  G = h - adj(h) + (m + d) I.
// Twice the skew part of G is (v x), and r rotates about v by the angle whose tangent is |v|/(2 D3).
// Rodrigues' formula in these terms:
//   r = I + (v x)/norm + (v x)^2/(norm (norm + 2 D3)),  norm^2 = 4 D3^2 + v^2.
MPM_INLINE Midpoint midpointOf(const Tensor& h) {
    const Tensor adj = adjugate(h);
    const double m = trace(adj), d = determinant(h, adj), D3 = 1 + (trace(h) + m) + d;
    const Tensor G = plusSpherical(h - adj, m + d);
    const Symmetric D = (1 / D3) * plusTransposed(G);

    const double x = G.zy - G.yz, y = G.xz - G.zx, z = G.yx - G.xy;
    const double xx = x * x, yy = y * y, zz = z * z;
    const double norm = std::sqrt(4 * D3 * D3 + (xx + yy + zz));
    const double a = 1 / norm, b = 1 / (norm * (norm + 2 * D3));
    const double ax = a * x, ay = a * y, az = a * z, xy = x * y, xz = x * z, yz = y * z;
    const Tensor r{1 - b * (yy + zz), b * xy - az,       b * xz + ay, //
                   b * xy + az,       1 - b * (xx + zz), b * yz - ax, //
                   b * xz - ay,       b * yz + ax,       1 - b * (xx + yy)};
    return {D, r};
}

// Stress of a particle as one tensor.
template <int Dim> Symmetric stressOf(const MaterialPoints<Dim>& points, int i) {
    double* const* s = points.stress;
    Symmetric all{s[0][i], s[4][i], s[8][i], s[1][i], 0, 0};
    if constexpr (Dim == 3) all.xz = s[2][i], all.yz = s[5][i];
    return all;
}
template <int Dim> void setStress(const MaterialPoints<Dim>& points, int i, const Symmetric& all) {
    double* const* s = points.stress;
    s[0][i] = all.xx, s[4][i] = all.yy, s[8][i] = all.zz;
    s[1][i] = s[3][i] = all.xy;
    if constexpr (Dim == 3) s[2][i] = s[6][i] = all.xz, s[5][i] = s[7][i] = all.yz;
}

// What a particle does in the step: strain in the axes at its end, and the rotation there from those at its start. A
// hypoelastic law is sigma <- R sigma R^T + C : strain, and tensors of state turn alike.
struct Increment {
    Symmetric strain;
    Tensor rotation;
};

template <int Dim> Increment incrementOf(const MaterialPoints<Dim>& points, int i) {
    const double h = 0.5 * points.dt;
    auto L = points.velocityGradient;
    Tensor half{h * L[0][i], h * L[1][i], 0, h * L[Dim][i], h * L[Dim + 1][i], 0, 0, 0, 0};
    if constexpr (Dim == 3) half = h * gather(L, i);
    const Midpoint step = midpointOf(half);
    return {congruence(step.r, step.D), step.r * step.r};
}

template <class Moduli>
void trialStress(const Moduli& lambdas, const Moduli& mus, const MaterialPoints<3>& points) {
    const double halfStep = 0.5 * points.dt;
    const auto L = planes<9>(points.velocityGradient);
    const auto stress = planes<9>(points.stress);
    const int count = points.count;
#pragma omp simd
    for (int i = 0; i < count; ++i) {
        const double lambda = modulus(OneNumber{i}, lambdas), mu = modulus(OneNumber{i}, mus);
        const Midpoint step = midpointOf(halfStep * gather(L, i));
        const Symmetric half = congruence(step.r, gatherUpper(stress, i)) + (2 * mu) * step.D;
        const Symmetric trial = plusSpherical(congruence(step.r, half), lambda * trace(step.D));
        scatterUpper(trial, stress, i);
    }
}

} // namespace mpm
