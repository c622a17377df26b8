// SPDX-License-Identifier: GPL-2.0-or-later
// Quadratic B-splines (Steffen, Kirby & Berzins 2008, IJNME 76, 922-948). Boundaries are not treated.
#include "mpm/particle/StencilDomains.hpp"

namespace mpm {

struct QuadraticBSpline {
    static constexpr const char* name = "BSpline";
    static constexpr const char* doc =
        "Points with quadratic B-splines, a smooth kernel: no noise when particles cross from cell to "
        "cell.\n\n"
        "S = 3/4 - c^2 within half a cell of a node, (3/2 - |c|)^2 / 2 out to one and a half. Splines are\n"
        "not treated at boundaries: a held node acts as far as its spline reaches. The plain example of\n"
        "doc/development/adding-a-particle-type.md: a step takes two to three times as long as with UGIMP.\n"
        "Source: Steffen, Kirby & Berzins 2008, Int. J. Numer. Meth. Eng. 76(6), 922-948.";
    static constexpr int support = 3;

    static AxisWeights<support> along(double c, double l) {
        const double below = 0.5 - c, above = 0.5 + c, bend = 0.5 * l * l; // l^2 S''/2 of the outer nodes
        return {{0.5 * below * below, 0.75 - c * c, 0.5 * above * above},
                {-below, -2 * c, above},
                {bend, -2 * bend, bend}};
    }
};

using BSpline = StencilType<QuadraticBSpline>;
MPM_REGISTER(ParticleType, BSpline);

} // namespace mpm
