// SPDX-License-Identifier: GPL-2.0-or-later
// Errors at the boundary: who, what was given, what is allowed, what to do.
#pragma once

#include "mpm/base/public.hpp"

#include <initializer_list>
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

// A part of a message, as long as the call lasts. Behind one type the text is made in one place: each call costs a
// compiler little, and there are hundreds.
class Part {
  public:
    Part(const char* text) : value_(text), write_(writeText) {}
    template <class T> Part(const T& value) : value_(&value), write_(writeValue<T>) {}
    void write(std::ostream& out) const { write_(out, value_); }

  private:
    const void* value_;
    void (*write_)(std::ostream&, const void*);

    static void writeText(std::ostream& out, const void* text) { out << static_cast<const char*>(text); }
    template <class T> static void writeValue(std::ostream& out, const void* value) {
        out << *static_cast<const T*>(value);
    }
};

// With NUL, at which what() would end, as two characters.
MPM_PUBLIC std::string joined(std::initializer_list<Part> parts);
[[noreturn]] MPM_PUBLIC void refuse(std::initializer_list<Part> parts); // throws InputError

template <class... Parts> std::string message(const Parts&... parts) { return joined({Part(parts)...}); }

template <class... Parts> void require(bool holds, const Parts&... parts) {
    if (!holds) refuse({Part(parts)...});
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
