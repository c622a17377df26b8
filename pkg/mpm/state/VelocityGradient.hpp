// SPDX-License-Identifier: GPL-2.0-or-later
// The velocity gradient of a run of particles as planes N i + j. In plane strain N is 2, in space 3. With axial symmetry N
// is 3, too: the third axis is round the axis of symmetry, L_33 = v_r/r, and what would shear along it is zero. So one
// kinematics serves all three.
#pragma once

#include "mpm/base/parallel/WorkPartition.hpp"
#include "mpm/state/Particles.hpp"

namespace mpm {

// Axes along which particles strain.
template <int Dim, bool isAxisymmetric> constexpr int strainedAxes = isAxisymmetric ? 3 : Dim;

template <int N> struct VelocityGradient {
    static constexpr double none[chunkSize] = {};
    const double* plane[N * N];

    // From particle `begin` on; zeros: as many as the run is long.
    template <int Dim>
    VelocityGradient(const Particles<Dim>& particles, int begin, const double* zeros = none) {
        for (const double*& each : plane) each = zeros;
        for (int i = 0; i < Dim; ++i)
            for (int j = 0; j < Dim; ++j)
                plane[N * i + j] = particles.velocityGradient.plane(Dim * i + j) + begin;
        if constexpr (N > Dim) plane[N * N - 1] = particles.hoopRate.plane() + begin;
    }
    MPM_INLINE double operator()(int i, int j, int p) const { return plane[N * i + j][p]; }
};

} // namespace mpm
