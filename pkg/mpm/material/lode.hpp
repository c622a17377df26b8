// SPDX-License-Identifier: GPL-2.0-or-later
// Where a deviator lies between its principal values, and how far from the Mohr-Coulomb surface, without a spectrum.
#pragma once

#include "mpm/material/tensors.hpp"

#include <cmath>

namespace mpm {

// Lode's angle theta of a deviator s with q^2 = J2: cosine - correction is cos(theta), and sine sin(theta). The
// principal values are q (cos(theta) - sin(theta)/sqrt(3)), 2 q sin(theta)/sqrt(3) and
// -q (cos(theta) + sin(theta)/sqrt(3)). cos(3 theta) comes from the part of s^2 orthogonal to I and s,
// adj(s) + J2/3 I - 3 J3/(2 J2) s, whose norm is the root of the discriminant: from sin(3 theta) alone, half the digits
// would be lost near triaxial states.
//
// c = cos(theta) is the root of 4 c^3 - 3 c = cos(3 theta) in [sqrt(3)/2, 1], where the slope of the cubic
// lies in [6, 9]. From the parabola through the roots at cos(3 theta) = 0, 1/2 and 1, a step of Halley gets
// within 3e-10, and a step d of Newton to round-off. Then sin(theta) = sin(3 theta)/(4 c^2 - 1), three over
// the slope.
struct Lode {
    double cosine, correction, sine;
};

MPM_INLINE Lode lodeOf(const Symmetric& s, double J2, double q) {
    const double third = 1.0 / 3, root3 = std::sqrt(3.0);
    const double J4 = J2 * J2, overJ4 = 1 / (J4 + 1e-150); // q < 1e-37: none
    const Symmetric adj = adjugate(s);
    const double J3 = determinant(s, adj);
    const Symmetric orthogonal = plusSpherical(J2 * adj, third * J4) + (-1.5 * J3) * s;
    const double cos3 = std::sqrt(3 * halfSquare(orthogonal)) * overJ4;
    const double sin3 = -1.5 * root3 * (overJ4 * (q * J3));

    const double cos30 = 0.5 * root3, cos20 = 0.93969262078590838, bend = 2 - 4 * cos20 + 2 * cos30;
    const double guess = cos30 + cos3 * (1 - cos30 - bend + bend * cos3);
    const double error = (4 * guess * guess - 3) * guess - cos3, steep = 12 * guess * guess - 3;
    const double c = guess - error * steep / (steep * steep - 12 * guess * error);
    const double overSlope = 1 / (12 * c * c - 3), d = ((4 * c * c - 3) * c - cos3) * overSlope;
    const double sine = 3 * sin3 * overSlope * (1 + 24 * c * d * overSlope);
    return {c, d, sine};
}

// q A(theta) = q (cos(theta) - sin(theta) sin(phi)/sqrt(3))
MPM_INLINE double lodeStrength(const Symmetric& s, double J2, double q, double sinPhi) {
    const Lode lode = lodeOf(s, J2, q);
    return q * (lode.cosine - lode.correction - lode.sine * (sinPhi / std::sqrt(3.0)));
}

} // namespace mpm
