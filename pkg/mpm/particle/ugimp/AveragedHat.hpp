// SPDX-License-Identifier: GPL-2.0-or-later
// The kernel of uGIMP by its definition: the hat function of a node, averaged over a box of half edge l (in
// cells),
//     S = 1/(2l) int hat dx,   G = 1/(2l) [hat at the ends of the box]       Bardenhagen & Kober 2004.
// With StencilDomains it makes uGIMP in its plainest form, which BoxTransfers is tested against.
#pragma once

#include "mpm/particle/StencilDomains.hpp"

#include <algorithm>

namespace mpm {

struct AveragedHat {
    static constexpr const char* name = "UGIMP";
    static constexpr const char* doc = "Particles with fixed box domains (uniform GIMP).";
    static constexpr int support = 3;

    static AxisWeights<support> along(double c, double l) {
        AxisWeights<support> weights;
        for (int i = 0; i < support; ++i) {
            const double first = c - l - (i - 1), last = c + l - (i - 1); // ends of the box, from node i
            weights.S[i] = (integral(last) - integral(first)) / (2 * l);
            weights.G[i] = (hat(last) - hat(first)) / (2 * l);
            weights.R[i] = 0.5 * (hat(first) + hat(last)) - weights.S[i]; // l dS/dl
        }
        return weights;
    }

  private:
    static double hat(double x) { return std::max(0.0, 1 - std::abs(x)); }
    static double integral(double x) { // of the hat, from its left end
        const double inside = std::clamp(x, -1.0, 1.0);
        return 0.5 + inside - 0.5 * inside * std::abs(inside);
    }
};

} // namespace mpm
