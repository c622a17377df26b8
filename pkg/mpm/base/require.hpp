// SPDX-License-Identifier: GPL-2.0-or-later
// Errors at the boundary: who, what was given, what is allowed, what to do.
#pragma once

#include "mpm/base/public.hpp"

#include <sstream>
#include <stdexcept>
#include <string>

namespace mpm {

// A wrong input: Python sees a ValueError.
struct MPM_PUBLIC InputError : std::invalid_argument {
    using std::invalid_argument::invalid_argument;
};

// A state that cannot be continued: Python sees a RuntimeError.
struct MPM_PUBLIC RunError : std::runtime_error {
    using std::runtime_error::runtime_error;
};

// What does not fit into memory: Python sees a MemoryError.
struct MPM_PUBLIC MemoryError : std::runtime_error {
    using std::runtime_error::runtime_error;
};

// With NUL, at which what() would end, as two characters.
template <class... Parts> std::string message(const Parts&... parts) {
    std::ostringstream out;
    out.precision(6);
    (out << ... << parts);
    std::string text;
    for (char c : out.str()) {
        if (c)
            text += c;
        else
            text += "\\0";
    }
    return text;
}

template <class... Parts> void require(bool holds, const Parts&... parts) {
    if (!holds) throw InputError(message(parts...));
}

template <class Vector> std::string place(const Vector& x) {
    std::ostringstream out;
    out.precision(6);
    out << "(";
    for (int k = 0; k < int(x.size()); ++k) out << (k ? ", " : "") << x[k];
    out << ")";
    return out.str();
}

} // namespace mpm
