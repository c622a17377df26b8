// SPDX-License-Identifier: GPL-2.0-or-later
#include "mpm/check/growth.hpp"

#include <algorithm>

namespace mpm {

template <int Dim> PresentStiffness presentStiffness(const Grid<Dim>& grid, Body<Dim>& body) {
    PresentStiffness largest;
    const auto include = [&](double lambda, double mu, double factor) {
        largest.bulk = std::max(largest.bulk, factor * (lambda + 2.0 / 3 * mu));
        largest.shear = std::max(largest.shear, factor * mu);
    };
    const auto& particles = body.particles;
    const double *volume = particles.volume.plane(), *initial = particles.initialVolume.plane();
    const auto [lambda0, mu0] = body.material->lame();
    if (particles.size() == 0) include(lambda0, mu0, 1); // of what may come into it
    double lambda[chunkSize], mu[chunkSize];
    for (int begin = 0; begin < particles.size(); begin += chunkSize) {
        const int end = std::min(particles.size(), begin + chunkSize);
        body.stiffness(begin, end, lambda, mu);
        for (int p = begin; p < end; ++p) {
            double factor = volume[p] / initial[p];
            if (grid.isGraded()) {
                const Vec<Dim> size = grid.sizeAt(vectorAt<Dim>(particles.position, p));
                factor *= grid.smallestCell().cwiseQuotient(size).squaredNorm() / Dim;
            }
            include(lambda[p - begin], mu[p - begin], factor);
        }
    }
    return largest;
}

template PresentStiffness presentStiffness(const Grid<2>& grid, Body<2>& body);
template PresentStiffness presentStiffness(const Grid<3>& grid, Body<3>& body);

} // namespace mpm
