// SPDX-License-Identifier: GPL-2.0-or-later
// From the velocity gradient of a run of particles to their deformation and stress.
#pragma once

#include "mpm/scene/Body.hpp"

namespace mpm {

// Whether component (i, j) of a strain is there where N axes strain: with axial symmetry no shear along the third is.
template <int N, int Dim> constexpr bool isStrained(int i, int j) {
    return N == Dim || i == j || (i < Dim && j < Dim);
}

// F <- (I + dt L) F for particles [begin, end), along the N axes that strain. dilation: of tr L, by F-bar, of the
// first on: F, and with it the volume of boxes, follow what the stress sees.
template <bool dilates, int N, int Dim>
void deform(Particles<Dim>& particles, double dt, int begin, int end, const double* dilation) {
    const VelocityGradient<N> L(particles, begin);
    double* F[N * N];
    for (int i = 0; i < N; ++i)
        for (int j = 0; j < N; ++j) F[N * i + j] = particles.deformationGradient.plane(3 * i + j) + begin;
#pragma omp simd
    for (int p = 0; p < end - begin; ++p) {
        double change[N * N];
        for (int i = 0; i < N; ++i)
            for (int j = 0; j < N; ++j) {
                if (!isStrained<N, Dim>(i, j)) continue;
                double sum = 0;
                for (int k = 0; k < N; ++k)
                    if (isStrained<N, Dim>(i, k) && isStrained<N, Dim>(k, j))
                        sum += L(i, k, p) * F[N * k + j][p];
                if constexpr (dilates) sum += dilation[p] / N * F[N * i + j][p];
                change[N * i + j] = dt * sum;
            }
        for (int i = 0; i < N; ++i)
            for (int j = 0; j < N; ++j)
                if (isStrained<N, Dim>(i, j)) F[N * i + j][p] += change[N * i + j];
    }
}

// Rates of volume change of `count` particles: tr L.
template <int N> void traces(const VelocityGradient<N>& L, int count, double* trace) {
    std::fill_n(trace, count, 0.0);
    for (int k = 0; k < N; ++k)
        for (int p = 0; p < count; ++p) trace[p] += L(k, k, p);
}

// (det(I + dt L) - 1)/dt of `count` particles: their rate of volume change in a step.
template <int N> void volumeRates(const VelocityGradient<N>& gradient, double dt, int count, double* rate) {
    const auto& L = gradient.plane;
#pragma omp simd
    for (int p = 0; p < count; ++p) {
        if constexpr (N == 2) {
            rate[p] = L[0][p] + L[3][p] + dt * (L[0][p] * L[3][p] - L[1][p] * L[2][p]);
        } else {
            const double x = L[4][p] * L[8][p] - L[5][p] * L[7][p], y = L[3][p] * L[8][p] - L[5][p] * L[6][p],
                         z = L[3][p] * L[7][p] - L[4][p] * L[6][p];
            const double minors =
                L[0][p] * L[4][p] - L[1][p] * L[3][p] + L[0][p] * L[8][p] - L[2][p] * L[6][p] + x;
            rate[p] =
                L[0][p] + L[4][p] + L[8][p] + dt * (minors + dt * (L[0][p] * x - L[1][p] * y + L[2][p] * z));
        }
    }
}

// From the change of the rate of volume change, what L_kk changes by in sum: det(I + dt L + e I) has the slope
// 2 + tr g where two axes strain and 3 + 2 tr g + I2(g) where three do over e, with g = dt L.
template <int N> void toTraces(const VelocityGradient<N>& L, double dt, int count, double* change) {
    for (int p = 0; p < count; ++p) {
        double trace = 0, minors = 0;
        for (int i = 0; i < N; ++i) {
            trace += dt * L(i, i, p);
            for (int j = 0; j < i; ++j)
                minors += dt * dt * (L(i, i, p) * L(j, j, p) - L(i, j, p) * L(j, i, p));
        }
        change[p] *= N / (N == 2 ? 2 + trace : 3 + 2 * trace + minors);
    }
}

// sigma : L of a particle, sigma symmetric. N axes strain.
template <int N, int Dim> struct Power {
    const double *stress[9], *L[N * N];

    explicit Power(const MaterialPoints<N>& points) {
        std::copy(points.stress, points.stress + 9, stress);
        std::copy(points.velocityGradient, points.velocityGradient + N * N, L);
    }
    MPM_INLINE double operator()(int p) const {
        double sum = 0;
        MPM_UNROLL
        for (int i = 0; i < N; ++i) MPM_UNROLL
        for (int j = 0; j < N; ++j)
            if (isStrained<N, Dim>(i, j)) sum += stress[i <= j ? 3 * i + j : 3 * j + i][p] * L[N * i + j][p];
        return sum;
    }
};

// Bulk volumes of particles [begin, end) times det(I + dt L), before they deform; dilation as of deform(), or nullptr.
template <int N, int Dim>
void advanceVolumes(const Body<Dim>& body, double dt, int begin, int end, const double* dilation,
                    double* advanced) {
    VelocityGradient<N> L(body.particles, begin);
    double along[N][chunkSize];
    for (int k = 0; dilation && k < N; ++k) {
        for (int p = 0; p < end - begin; ++p) along[k][p] = L(k, k, p) + dilation[p] / N;
        L.plane[(N + 1) * k] = along[k];
    }
    volumeRates(L, dt, end - begin, advanced);
    const double* volume = body.particles.volume.plane() + begin;
    for (int p = 0; p < end - begin; ++p) advanced[p] = volume[p] * (1 + dt * advanced[p]);
    const int number = body.material->volumeRecord().opening;
    if (number < 0) return;
    const double* opening = body.particles.state[number].plane() + begin;
    for (int p = 0; p < end - begin; ++p)
        if (opening[p] > 0) advanced[p] *= std::exp(opening[p]);
}

// The volume of boxes [begin, end) is det F V0. Where the terms of det F cancel to less than a millionth, as in a box
// that stays under a tip and is stretched without end, round-off is in what is left of them: there it is `advanced`.
template <int Dim> void keepVolumes(Particles<Dim>& particles, int begin, int end, const double* advanced) {
    constexpr double most = 1e6; // half and twice of it change volumes by 1e-9
    const double* F[9];
    for (int i = 0; i < 9; ++i) F[i] = particles.deformationGradient.plane(i) + begin;
    double* V = particles.volume.plane() + begin;
    const double* V0 = particles.initialVolume.plane() + begin;
#pragma omp simd
    for (int p = 0; p < end - begin; ++p) {
        double terms = (std::abs(F[0][p] * F[4][p]) + std::abs(F[1][p] * F[3][p])) * std::abs(F[8][p]);
        if constexpr (Dim == 3)
            terms += std::abs(F[5][p]) * (std::abs(F[0][p] * F[7][p]) + std::abs(F[1][p] * F[6][p])) +
                     std::abs(F[2][p]) * (std::abs(F[3][p] * F[7][p]) + std::abs(F[4][p] * F[6][p]));
        V[p] = terms * V0[p] > most * std::abs(V[p]) ? advanced[p] : V[p];
    }
}

// The volume of particles [begin, end) without their opening: only the solid bears stress. In soil that
// stands open the other part is a gap (material/Material.hpp, VolumeRecord).
template <int Dim> void takeOutOpening(Body<Dim>& body, int begin, int end) {
    const int number = body.material->volumeRecord().opening;
    if (number < 0) return;
    const double* opening = body.particles.state[number].plane();
    double* volume = body.particles.volume.plane();
    for (int p = begin; p < end; ++p)
        if (opening[p] > 0) volume[p] *= std::exp(-opening[p]);
}

// Planes of numbers for a run of particles: a chunk, or a whole body (Material::takesWholeBody).
template <int planes> class RunBuffer {
  public:
    explicit RunBuffer(int count) : many_(count > chunkSize ? planes * size_t(count) : 0), count_(count) {}
    double* plane(int k) { return many_.empty() ? chunk_[k] : &many_[k * size_t(count_)]; }

  private:
    double chunk_[planes][chunkSize];
    std::vector<double> many_;
    int count_;
};

// Stress and solid volume of particles [begin, end), from deformation and bulk volume; returns their internal
// work V sigma : D dt, with the mean of old and new stress. N axes strain. state: memory for MaterialPoints. change: of
// tr L, by F-bar; isWork: the work is that of the changed L, for the forces are.
template <int N, int Dim>
double updateStress(Body<Dim>& body, double dt, int begin, int end, double** state, const double* change,
                    bool isWork) {
    const double* V = body.particles.volume.plane() + begin;
    RunBuffer<N + 1> buffer(end - begin);
    double *before = buffer.plane(N), *averaged[N];
    for (int k = 0; k < N; ++k) averaged[k] = buffer.plane(k);
    const std::vector<double> zeros(N > Dim && end - begin > chunkSize ? end - begin : 0);
    const MaterialPoints<N> points = body.template points<N>(
        begin, end, dt, state, zeros.empty() ? VelocityGradient<N>::none : zeros.data());
    MaterialPoints<N> averagedPoints = points;
    if (change)
        for (int k = 0; k < N; ++k) {
            const double* L = points.velocityGradient[(N + 1) * k];
            for (int i = 0; i < points.count; ++i) averaged[k][i] = L[i] + change[begin + i] / N;
            averagedPoints.velocityGradient[(N + 1) * k] = averaged[k];
        }
    const Power<N, Dim> power(isWork ? averagedPoints : points);
#pragma omp simd
    for (int i = 0; i < points.count; ++i) before[i] = power(i);
    body.material->update(averagedPoints);
    takeOutOpening(body, begin, end);
    double twice = 0;
#pragma omp simd reduction(+ : twice)
    for (int i = 0; i < points.count; ++i) twice += (before[i] + power(i)) * V[i];
    return 0.5 * dt * twice;
}

} // namespace mpm
