// SPDX-License-Identifier: GPL-2.0-or-later
// The factor on the moduli of a step that is the one of the stress which they lead to.
#pragma once

#include <cmath>
#include <limits>

namespace mpm {

// k = next(k), from `first` on, by the secant method between bounds, else by their mean in ln k. least: next(k) is not
// below it. One call of next() where `first` is the root, two where next() is constant.
class RootOfFactor {
  public:
    RootOfFactor(double first, double least) : k_(first), low_(least) {}

    // To be tried next; after the last try the root.
    double factor() const { return k_; }
    // Whether this was the last try. next: next(factor()).
    bool endsWith(double next) {
        constexpr double roundOff = 1e-13; // of k
        constexpr int most = 100;
        const double gain = next - k_;
        if (!(std::abs(gain) > roundOff * k_)) return true; // or no number
        (gain > 0 ? low_ : high_) = k_;
        double to = tries_ == 0 ? next : k_ - gain * (k_ - last_) / (gain - lastGain_);
        if (!(to >= low_ && to <= high_)) to = std::isinf(high_) ? next : std::sqrt(low_ * high_);
        if (to == k_ || ++tries_ == most) return true;
        last_ = k_;
        lastGain_ = gain;
        k_ = to;
        return false;
    }

  private:
    double k_, low_, high_ = std::numeric_limits<double>::infinity(), last_ = 0, lastGain_ = 0;
    int tries_ = 0;
};

} // namespace mpm
