// SPDX-License-Identifier: GPL-2.0-or-later
#include "mpm/base/require.hpp"

namespace mpm {

std::string joined(std::initializer_list<Part> parts) {
    std::ostringstream out;
    out.precision(6);
    for (const Part& part : parts) part.write(out);
    std::string text;
    for (char c : out.str()) {
        if (c)
            text += c;
        else
            text += "\\0";
    }
    return text;
}

void refuse(std::initializer_list<Part> parts) { throw InputError(joined(parts)); }

} // namespace mpm
