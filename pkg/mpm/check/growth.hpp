// SPDX-License-Identifier: GPL-2.0-or-later
// What may have made the vibrations of a body faster since its critical step was estimated.
#pragma once

#include "mpm/scene/Scene.hpp"

namespace mpm {

struct Growth {
    double volume = 1;   // largest V/V0
    double fineness = 1; // largest mean over the axes of (smallest cell of the grid/cell of the particle)^2
};

template <int Dim> Growth growthOf(const Grid<Dim>& grid, const Particles<Dim>& particles) {
    const double *volume = particles.volume.plane(), *initial = particles.initialVolume.plane();
    if (particles.size() == 0) return {};
    Growth largest{0, grid.isGraded() ? 0.0 : 1.0};
    for (int p = 0; p < particles.size(); ++p) {
        largest.volume = std::max(largest.volume, volume[p] / initial[p]);
        if (!grid.isGraded()) continue;
        const Vec<Dim> size = grid.sizeAt(vectorAt<Dim>(particles.position, p));
        largest.fineness =
            std::max(largest.fineness, grid.smallestCell().cwiseQuotient(size).squaredNorm() / Dim);
    }
    return largest;
}

} // namespace mpm
