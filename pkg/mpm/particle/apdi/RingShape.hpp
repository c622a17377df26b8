// SPDX-License-Identifier: GPL-2.0-or-later
// Corner weights, gradient vectors and volume of one APDI domain of an axisymmetric scene, and the shape
// that a domain has in each geometry.
#pragma once

#include "mpm/particle/apdi/APDIShape.hpp"

namespace mpm {

// The ring that a quadrilateral makes round the axis, r = x: means over the volume, dV = 2 pi r dA,
//     w_a = 1/V int N_a dV,   g_a = 1/V int grad N_a dV,   hoop_a = 1/V int N_a/r dV.
// With r and z bilinear, r = r0 + r1 xi + r2 eta + r3 xi eta, the determinant is j0 + j1 xi + j2 eta, and all
// integrals are closed. g_a V + hoop_a V e_r is the slope of V over the position of corner a.
struct RingShape {
    // Of r, z and the determinant.
    struct Coefficients {
        double r0, r1, r2, r3, z1, z2, z3, j0, j1, j2;

        MPM_INLINE explicit Coefficients(const CornerNumbers<2>& X) {
            const auto &x = X[0], &y = X[1];
            r0 = 0.25 * (x[0] + x[1] + x[2] + x[3]);
            r1 = 0.25 * (x[1] - x[0] + x[2] - x[3]);
            r2 = 0.25 * (x[2] - x[0] + x[3] - x[1]);
            r3 = 0.25 * (x[0] - x[1] + x[2] - x[3]);
            z1 = 0.25 * (y[1] - y[0] + y[2] - y[3]);
            z2 = 0.25 * (y[2] - y[0] + y[3] - y[1]);
            z3 = 0.25 * (y[0] - y[1] + y[2] - y[3]);
            j0 = r1 * z2 - r2 * z1;
            j1 = r1 * z3 - r3 * z1;
            j2 = r3 * z2 - r2 * z3;
        }
        // int r dA / 4, with a part of the second moments over xi and eta.
        MPM_INLINE double moment(double part) const { return r0 * j0 + part / 3 * (r1 * j1 + r2 * j2); }
    };

    double w[4], g[4][2], hoop[4], volume, overVolume;
    double smallestCorner;      // that of the quadrilateral times the mean thickness
    std::array<double, 3> skew; // w_a = 1/4 + what follows from it
    double pattern[1][2], steepness[1];

    MPM_INLINE static std::array<double, 4> weights(const std::array<double, 3>& k) {
        return {0.25 - k[0] - k[1] + k[2], 0.25 + k[0] - k[1] - k[2], 0.25 + k[0] + k[1] + k[2],
                0.25 - k[0] + k[1] - k[2]};
    }

    // The volume with a part of the second moments over xi and eta: 1 is exact, see Grid::ringMoment().
    static double volumeOf(const CornerNumbers<2>& X, double part) {
        return 8 * M_PI * Coefficients(X).moment(part);
    }

    MPM_INLINE explicit RingShape(const CornerNumbers<2>& X) {
        const QuadrilateralShape flat(X);
        const Coefficients of(X);
        const auto& [r0, r1, r2, r3, z1, z2, z3, j0, j1, j2] = of;
        constexpr double third = 1.0 / 3, ninth = 1.0 / 9;
        const double moment = of.moment(1), over = 1 / moment;
        volume = 8 * M_PI * moment;
        overVolume = 1 / volume;
        smallestCorner = flat.smallestCorner * volume * flat.overVolume;
        const double share = 0.25 * over;
        skew = {share * (third * (r0 * j1 + r1 * j0) + ninth * r3 * j2),
                share * (third * (r0 * j2 + r2 * j0) + ninth * r3 * j1),
                share * ninth * (r1 * j2 + r2 * j1 + r3 * j0)};
        const double rXi = r0 * z2 + third * r1 * z3, rEta = -r0 * z1 - third * r2 * z3,
                     rBoth = third * (r2 * z2 - r1 * z1), zXi = -r0 * r2 - third * r1 * r3,
                     zEta = r0 * r1 + third * r2 * r3, zBoth = third * (r1 * r1 - r2 * r2);
        const auto fromSkew = weights(skew);
        MPM_UNROLL
        for (int a = 0; a < 4; ++a) {
            const double s = cornerSign(a, 0), t = cornerSign(a, 1);
            w[a] = fromSkew[a];
            g[a][0] = share * (s * rXi + t * rEta + s * t * rBoth);
            g[a][1] = share * (s * zXi + t * zEta + s * t * zBoth);
            hoop[a] = share * (j0 + third * (s * j1 + t * j2));
        }
        pattern[0][0] = r3;
        pattern[0][1] = z3;
        steepness[0] = flat.steepness[0];
    }
};

MPM_INLINE double hoopOf(const RingShape& shape, int a) { return shape.hoop[a]; }
template <class Closed> MPM_INLINE double hoopOf(const Closed&, int) { return 0; }

MPM_INLINE double smallestCorner(const RingShape& shape, const CornerNumbers<2>&) {
    return shape.smallestCorner;
}

template <int Dim, bool isRound> using DomainShape = std::conditional_t<isRound, RingShape, ClosedShape<Dim>>;

} // namespace mpm
