// SPDX-License-Identifier: GPL-2.0-or-later
// From the velocity gradient of a run of particles to their deformation and stress.
#pragma once

#include "mpm/scene/Body.hpp"

namespace mpm {

// F <- (I + dt L) F for particles [begin, end); in plane strain only the in-plane block changes.
template <int Dim> void deform(Particles<Dim>& particles, double dt, int begin, int end) {
    const double* L[Dim * Dim];
    double* F[Dim * Dim];
    for (int i = 0; i < Dim; ++i)
        for (int j = 0; j < Dim; ++j) {
            L[Dim * i + j] = particles.velocityGradient.plane(Dim * i + j);
            F[Dim * i + j] = particles.deformationGradient.plane(3 * i + j);
        }
#pragma omp simd
    for (int p = begin; p < end; ++p) {
        double change[Dim * Dim];
        for (int i = 0; i < Dim; ++i)
            for (int j = 0; j < Dim; ++j) {
                double sum = 0;
                for (int k = 0; k < Dim; ++k) sum += L[Dim * i + k][p] * F[Dim * k + j][p];
                change[Dim * i + j] = dt * sum;
            }
        for (int c = 0; c < Dim * Dim; ++c) F[c][p] += change[c];
    }
}

// sigma : L of a particle, sigma symmetric.
template <int Dim> struct Power {
    const double *stress[9], *L[Dim * Dim];

    explicit Power(const MaterialPoints<Dim>& points) {
        std::copy(points.stress, points.stress + 9, stress);
        std::copy(points.velocityGradient, points.velocityGradient + Dim * Dim, L);
    }
    MPM_INLINE double operator()(int p) const {
        double sum = 0;
        MPM_UNROLL
        for (int i = 0; i < Dim; ++i) MPM_UNROLL
        for (int j = 0; j < Dim; ++j) sum += stress[i <= j ? 3 * i + j : 3 * j + i][p] * L[Dim * i + j][p];
        return sum;
    }
};

// Stress update of particles [begin, end); returns their internal work V sigma : D dt, with the mean
// of old and new stress. state: memory for MaterialPoints. change: of tr L, by F-bar.
template <int Dim>
double updateStress(Body<Dim>& body, double dt, int begin, int end, double** state, const double* change) {
    auto& particles = body.particles;
    const double* V = particles.volume.plane() + begin;
    double before[chunkSize], averaged[Dim][chunkSize];
    const MaterialPoints<Dim> points = body.points(begin, end, dt, state);
    MaterialPoints<Dim> averagedPoints = points;
    if (change)
        for (int k = 0; k < Dim; ++k) {
            const double* L = points.velocityGradient[(Dim + 1) * k];
            for (int i = 0; i < points.count; ++i) averaged[k][i] = L[i] + change[begin + i] / Dim;
            averagedPoints.velocityGradient[(Dim + 1) * k] = averaged[k];
        }
    const Power<Dim> power(points);
#pragma omp simd
    for (int i = 0; i < points.count; ++i) before[i] = power(i);
    body.material->update(averagedPoints);
    double twice = 0;
#pragma omp simd reduction(+ : twice)
    for (int i = 0; i < points.count; ++i) twice += (before[i] + power(i)) * V[i];
    return 0.5 * dt * twice;
}

} // namespace mpm
