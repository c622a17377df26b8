// SPDX-License-Identifier: GPL-2.0-or-later
// The mean stress of particles over the axes that strain: in plane strain two, else three. It is what does the work of a
// rate of volume change that these axes share.
#pragma once

#include "mpm/base/simd/compiler.hpp"
#include "mpm/state/Field.hpp"
#include "mpm/state/Grid.hpp"

namespace mpm {

// Of the stress of particle p, kPa.
template <int Dim> struct MeanOfStress {
    const double* diagonal[3];
    bool isPlane;
    MeanOfStress(const Field& stress, const Grid<Dim>& grid) : isPlane(Dim == 2 && !grid.isAxisymmetric) {
        for (int k = 0; k < 3; ++k) diagonal[k] = stress.plane(4 * k);
    }
    MPM_INLINE double operator()(int p) const {
        const double inPlane = diagonal[0][p] + diagonal[1][p];
        return isPlane ? inPlane / 2 : (inPlane + diagonal[2][p]) / 3;
    }
};

} // namespace mpm
