// SPDX-License-Identifier: GPL-2.0-or-later
// The water table at one instant, and the hydrostatic pressure below it.
#pragma once

#include "mpm/base/types.hpp"

#include <algorithm>
#include <limits>
#include <vector>

namespace mpm {

struct WaterTable {
    std::vector<double> rows; // (x, level), m, linear between them; empty: no table
    double weight;            // of water, kN/m3; 0 without gravity

    bool isLevel() const { return rows.size() <= 2; }
    template <int Dim> double level(const Vec<Dim>& x) const {
        if (rows.empty()) return -std::numeric_limits<double>::infinity();
        if (rows.size() == 2) return rows[1];
        size_t next = 0;
        while (next < rows.size() && rows[next] <= x[0]) next += 2;
        const size_t above = std::min(next, rows.size() - 2), below = next > 0 ? next - 2 : 0;
        const double share = above > below ? (x[0] - rows[below]) / (rows[above] - rows[below]) : 0;
        return rows[below + 1] + share * (rows[above + 1] - rows[below + 1]);
    }
    template <int Dim> double pressure(const Vec<Dim>& x) const {
        return weight > 0 ? weight * std::max(0.0, level<Dim>(x) - x[Dim - 1]) : 0;
    }
    // Of the water outside of the soil, or of a surface that drips, kPa.
    template <int Dim> double head(const Vec<Dim>& x) const { return pressure<Dim>(x) + weight * x[Dim - 1]; }
};

} // namespace mpm
