// SPDX-License-Identifier: GPL-2.0-or-later
// Elastic moduli that a law answers with: of all particles of a run, or of each.
#pragma once

#include "mpm/material/hypoelastic.hpp"

namespace mpm {

// kPa. Number: double for all, const double* for planes; at(i) gives those of particle i, and at(at) what forEachSimdPair
// has at hand.
template <class Number> struct Moduli {
    Number lambda, mu, bulk;

    template <class At> MPM_INLINE auto at(const At& of) const {
        return Moduli<decltype(modulus(of, lambda))>{modulus(of, lambda), modulus(of, mu), modulus(of, bulk)};
    }
    MPM_INLINE Moduli<double> at(int i) const { return at(OneNumber{i}); }
};

} // namespace mpm
