// SPDX-License-Identifier: GPL-2.0-or-later
#include "mpm/check/growth.hpp"

#include "mpm/material/FollowingPressure.hpp"

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

template <int Dim> ReachedStiffness reachedStiffness(const Grid<Dim>& grid, Body<Dim>& body, double dt) {
    ReachedStiffness largest;
    const auto* following = dynamic_cast<const FollowingPressure*>(body.material.get());
    if (!following) return largest;
    const auto& particles = body.particles;
    const Vec<Dim> cell = grid.smallestCell();
    std::vector<double*> state(particles.state.size());
    double now[chunkSize], strain[chunkSize];
    for (int begin = 0; begin < particles.size(); begin += chunkSize) {
        const int end = std::min(particles.size(), begin + chunkSize);
        for (int p = begin; p < end; ++p)
            strain[p - begin] =
                dt * vectorAt<Dim>(particles.velocity, p).cwiseQuotient(cell).cwiseAbs().maxCoeff();
        if (!following->findReached(body.points(begin, end, 0, state.data()), now, strain)) return largest;
        for (int i = 0; i < end - begin; ++i) {
            largest.now = std::max(largest.now, now[i]);
            largest.reached = std::max(largest.reached, strain[i]);
        }
    }
    return largest;
}

template ReachedStiffness reachedStiffness(const Grid<2>& grid, Body<2>& body, double dt);
template ReachedStiffness reachedStiffness(const Grid<3>& grid, Body<3>& body, double dt);
template PresentStiffness presentStiffness(const Grid<2>& grid, Body<2>& body);
template PresentStiffness presentStiffness(const Grid<3>& grid, Body<3>& body);

} // namespace mpm
