// SPDX-License-Identifier: GPL-2.0-or-later
// The factor on the moduli of a step that is the one of the stress which they lead to.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

namespace mpm {

// k = next(k), from `first` on, by the secant method in ln k between bounds, else by halves. least: next(k) is not below
// it. The last call of next() is that with the root. One call where `first` is the root, two where next() is constant.
template <class Next> void rootOfFactor(double first, double least, Next&& next) {
    constexpr double roundOff = 1e-13; // of k
    constexpr int most = 100;
    double low = std::log(least), high = std::numeric_limits<double>::infinity();
    double x = std::log(first), xLast = 0, yLast = 0;
    for (int i = 0; i < most; ++i) {
        const double k = i == 0 ? first : std::exp(x), y = std::log(next(k) / k);
        if (!(std::abs(y) > roundOff * std::max(1.0, std::abs(x)))) break; // or no number
        (y > 0 ? low : high) = x;
        double to = i == 0 ? x + y : x - y * (x - xLast) / (y - yLast);
        if (!(to >= low && to <= high)) to = std::isinf(high) ? x + y : 0.5 * (low + high);
        xLast = x;
        yLast = y;
        if (to == x) break;
        x = to;
    }
}

} // namespace mpm
