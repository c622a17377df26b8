// SPDX-License-Identifier: GPL-2.0-or-later
// Quadratic B-splines once more, as somebody else would write them.
#include <mpm/particle/StencilDomains.hpp>

namespace {

struct Spline {
    static constexpr const char* name = "BSplineOutside";
    static constexpr const char* doc =
        "Points with quadratic B-splines, from a plugin.\n\n"
        "Source: Steffen, Kirby & Berzins 2008, Int. J. Numer. Meth. Eng. 76(6), 922-948.";
    static constexpr int support = 3;

    static mpm::AxisWeights<support> along(double c, double /*l*/) {
        const double below = 0.5 - c, above = 0.5 + c;
        return {{0.5 * below * below, 0.75 - c * c, 0.5 * above * above}, {-below, -2 * c, above}};
    }
};

using BSplineOutside = mpm::StencilType<Spline>;
MPM_REGISTER(mpm::ParticleType, BSplineOutside);

} // namespace
