// SPDX-License-Identifier: GPL-2.0-or-later
// Refuses what does not fit into memory, before any of it is taken: Linux grants more than there is, and ends
// the process when it is used.
#pragma once

#include "mpm/base/require.hpp"

#include <cmath>
#include <string>

namespace mpm {

// Bytes that this process may still take: what the system has left, swap included, and what the process's
// limit of addresses (RLIMIT_AS) and the groups that it is in (containers) leave. Infinity where nobody says.
// root: of the files that the system tells it in.
double freeMemory(const std::string& root = "");

constexpr double largeArray = 1 << 28; // bytes: for less nobody is asked

// what: who takes how many bytes of what, for the error; advice: what to do.
inline void requireMemory(double bytes, const std::string& what, const std::string& advice) {
    if (bytes < largeArray) return;
    const double left = freeMemory();
    const auto gigabytes = [](double b) { return message(std::round(b / 1e7) / 100, " GB"); };
    if (bytes > left)
        throw MemoryError(message(what, " take ", gigabytes(bytes), " of memory, and ", gigabytes(left),
                                  " are free; ", advice));
}

} // namespace mpm
