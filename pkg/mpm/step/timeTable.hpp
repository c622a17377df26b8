// SPDX-License-Identifier: GPL-2.0-or-later
// Tables of loads over time: rows (time, values...).
#pragma once

#include "mpm/base/require.hpp"

#include <algorithm>
#include <vector>

namespace mpm {

// Row of a table at a time: linear between rows, the first and last value outside.
inline std::vector<double> rowAt(const std::vector<double>& table, size_t width, double time) {
    const size_t rows = table.size() / width;
    size_t next = 0; // the first row after the time
    for (size_t end = rows; next < end;) {
        const size_t middle = (next + end) / 2;
        if (table[middle * width] <= time)
            next = middle + 1;
        else
            end = middle;
    }
    const size_t above = std::min(next, rows - 1), below = next > 0 ? next - 1 : 0;
    const double *first = &table[below * width], *last = &table[above * width];
    const double share = above > below ? (time - first[0]) / (last[0] - first[0]) : 0;
    std::vector<double> values;
    for (size_t k = 1; k < width; ++k) values.push_back(first[k] + share * (last[k] - first[k]));
    return values;
}

inline void checkTable(const char* who, const char* name, const std::vector<double>& table, size_t width) {
    require(table.size() % width == 0, who, ": ", name, " has ", table.size(), " numbers; give rows of ",
            width, ", the time first");
    for (size_t row = width; row < table.size(); row += width)
        require(table[row] > table[row - width], who, ": times in ", name, " go from ", table[row - width],
                " to ", table[row], " s; give rows in the order of time");
}

} // namespace mpm
