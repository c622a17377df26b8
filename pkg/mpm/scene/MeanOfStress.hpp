// SPDX-License-Identifier: GPL-2.0-or-later
// The mean stress of particles.
#pragma once

#include "mpm/base/simd/compiler.hpp"
#include "mpm/state/Field.hpp"

namespace mpm {

// Of the stress of particle p, kPa.
struct MeanOfStress {
    const double* diagonal[3];
    explicit MeanOfStress(const Field& stress) {
        for (int k = 0; k < 3; ++k) diagonal[k] = stress.plane(4 * k);
    }
    MPM_INLINE double operator()(int p) const {
        return (diagonal[0][p] + diagonal[1][p] + diagonal[2][p]) / 3;
    }
};

} // namespace mpm
