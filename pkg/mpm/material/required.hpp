// SPDX-License-Identifier: GPL-2.0-or-later
// Parameters that a material cannot do without.
#pragma once

#include "mpm/base/require.hpp"

#include <cmath>
#include <initializer_list>
#include <string>
#include <utility>

namespace mpm {

inline void requireDensity(const std::string& who, double density) {
    require(density > 0, who, ": density is required; give density in Mg/m3");
}

// Values that are not a number have not been given.
inline void requireGiven(const std::string& who,
                         std::initializer_list<std::pair<double, const char*>> parameters) {
    for (auto& [value, name] : parameters)
        require(!std::isnan(value), who, ": ", name, " is required; give it");
}

} // namespace mpm
