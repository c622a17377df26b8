// SPDX-License-Identifier: GPL-2.0-or-later
// Soil that has opened bears nothing until it has closed: laws with a highest mean stress keep by how much it stands
// open. State variables of the law: 1 plastic volumetric strain, 2 opening.
#pragma once

#include "mpm/material/Material.hpp"

namespace mpm {

inline StateVariable openingVariable() {
    return {"opening", "-",
            "volumetric strain by which the soil stands open, at the apex or the tension cut-off"};
}

// Trial stress in, stress out. The mean stress of soil that is open is that at which it opened, until what the
// trial stress closes, (mostTension - p)/K, has used the opening up. bulkOf, most: of particle i.
template <class Bulk, class Most, int Dim>
void closeUp(Bulk bulkOf, Most most, const MaterialPoints<Dim>& points) {
    double *xx = points.stress[0], *yy = points.stress[4], *zz = points.stress[8];
    double *plasticVolumetric = points.state[1], *opening = points.state[2];
    const int count = points.count;
#pragma omp simd
    for (int i = 0; i < count; ++i) {
        const double bulk = bulkOf(i), compliance = 1 / bulk;
        const double below = (most(i) - (xx[i] + yy[i] + zz[i]) / 3) * compliance;
        const double closed = std::min(std::max(below, 0.0), opening[i]), p = bulk * closed;
        xx[i] += p;
        yy[i] += p;
        zz[i] += p;
        plasticVolumetric[i] -= closed;
        opening[i] -= closed;
    }
}

// After closeUp(): what takes the mean stress of a trial beyond the apex or the tension cut-off opens the soil.
template <class Bulk, class Most, int Dim>
void openUp(Bulk bulkOf, Most most, const MaterialPoints<Dim>& points) {
    const double *xx = points.stress[0], *yy = points.stress[4], *zz = points.stress[8];
    double* opening = points.state[2];
    const int count = points.count;
#pragma omp simd
    for (int i = 0; i < count; ++i)
        opening[i] += std::max((xx[i] + yy[i] + zz[i]) / 3 - most(i), 0.0) * (1 / bulkOf(i));
}

} // namespace mpm
