// SPDX-License-Identifier: GPL-2.0-or-later
// The arrays of the particles, hoisted out of the loops, and what one particle gives to its nodes and takes
// from them, the same for all particle types. With phi_ip and its gradient,
//
//   node_i += sum_p phi_ip { momentum, mass ... }_p - V_p sigma_p grad phi_ip        values(), forces()
//   node_i += sum_p phi_ip { momentum }_p                                            momenta()
//   v_p, x_p from sum_i phi_ip { v, a }_i                                            move()
#pragma once

#include "mpm/base/simd/Lanes.hpp"
#include "mpm/base/simd/transpose.hpp"
#include "mpm/particle/Domains.hpp"

namespace mpm {

template <int Dim> struct ParticlePlanes {
    using L = Lanes<Dim>;
    static constexpr int largestBatch = 64; // particles that are treated together, at most

    double* hoopRate;
    double *mass, *volume, *position[Dim], *velocity[Dim], *bodyForce[Dim], *velocityGradient[Dim * Dim];
    bool hasBodyForce;
    explicit ParticlePlanes(Particles<Dim>& p)
        : hoopRate(p.isAxisymmetric ? p.hoopRate.plane() : nullptr), mass(p.mass.plane()),
          volume(p.volume.plane()), hasBodyForce(p.hasBodyForce) {
        for (int i = 0; i < Dim; ++i) {
            position[i] = p.position.plane(i);
            velocity[i] = p.velocity.plane(i);
            bodyForce[i] = p.bodyForce.plane(i);
        }
        for (int i = 0; i < Dim * Dim; ++i) velocityGradient[i] = p.velocityGradient.plane(i);
    }

    // What `count` particles from `first` on give, plane by plane: momentum and inertial mass, -V tensor
    // (planes 3*i + j, upper triangle), body force.
    template <size_t most>
    void momenta(int first, int count, double inertiaScale, double (&out)[Dim + 1][most]) const {
        const ParticlePlanes q = *this;
#pragma omp simd
        for (int i = 0; i < count; ++i) {
            const double m = inertiaScale * q.mass[first + i];
            MPM_UNROLL
            for (int k = 0; k < Dim; ++k) out[k][i] = m * q.velocity[k][first + i];
            out[Dim][i] = m;
        }
    }
    template <size_t most>
    void tension(int first, int count, const ActingStress& stress, double (&out)[Dim][Dim][most]) const {
        stress.spherical ? tension<true>(first, count, stress, out)
                         : tension<false>(first, count, stress, out);
    }
    template <bool hasSpherical, size_t most>
    void tension(int first, int count, const ActingStress& stress, double (&out)[Dim][Dim][most]) const {
        const double *V = volume + first, *sigma[Dim][Dim],
                     *spherical = stress.spherical + (hasSpherical ? first : 0);
        for (int i = 0; i < Dim; ++i)
            for (int j = 0; j < Dim; ++j) sigma[i][j] = stress.planes[i <= j ? 3 * i + j : 3 * j + i] + first;
#pragma omp simd
        for (int p = 0; p < count; ++p) MPM_UNROLL
        for (int i = 0; i < Dim; ++i) MPM_UNROLL
        for (int j = 0; j < Dim; ++j)
            out[i][j][p] = -V[p] * (hasSpherical && i == j ? sigma[i][j][p] + spherical[p] : sigma[i][j][p]);
    }
    template <size_t most> void bodyForces(int first, int count, double (&out)[Dim][most]) const {
        for (int k = 0; k < Dim; ++k)
            for (int p = 0; p < count; ++p) out[k][p] = mass[first + p] * bodyForce[k][first + p];
    }

    // The same in the lanes of the nodes. Value lanes of NodalField::Sum: momentum and mass; in 2D also the
    // weight mass, which in 3D is a lane of B.
    void values(int first, int count, double inertiaScale, Quad* out) const {
        double p[Dim + 1][largestBatch];
        momenta(first, count, inertiaScale, p);
        interleave({p[0], p[1], p[2], Dim == 2 ? mass + first : p[Dim]}, count, out);
    }
    // B = - V tensor, for its products with grad phi; in 3D with the weight mass.
    void forces(int first, int count, const ActingStress& stress, typename L::Set* out) const {
        double B[Dim][Dim][largestBatch];
        tension(first, count, stress, B);
        if constexpr (Dim == 2)
            interleave({B[0][0], B[0][1], B[1][0], B[1][1]}, count, &out[0][0]);
        else {
            const double zero[largestBatch] = {};
            for (int k = 0; k < Dim; ++k) interleave({B[0][k], B[1][k], B[2][k], zero}, count, &out[0][k], 4);
            interleave({zero, zero, zero, mass + first}, count, &out[0][3], 4);
        }
    }
    // v_p <- flip (v_p + dt a) + (1 - flip) v ;  x_p <- x_p + dt v  (v, a interpolated from the nodes:
    // motion(k, i)), with a <- a [1 - damping sgn(a (v_p + dt a / 2))] for each component, and v less what
    // that takes from a. Returns the energy that damping took, and what body forces gave.
    template <class Motion> MovedEnergy move(int first, int count, const Move& m, Motion&& motion) const {
        if (hasBodyForce)
            return m.damping > 0 ? move<true, true>(first, count, m, motion)
                                 : move<false, true>(first, count, m, motion);
        return m.damping > 0 ? move<true, false>(first, count, m, motion)
                             : move<false, false>(first, count, m, motion);
    }

    template <bool damped, bool pushed, class Motion>
    MovedEnergy move(int first, int count, const Move& how, Motion&& motion) const {
        const ParticlePlanes q =
            *this; // pointers of its own: the compiler need not fear that the loop overwrites them
        const double dt = how.dt, flip = how.flip, damping = how.damping;
        double taken = 0, given = 0;
#pragma omp simd reduction(+ : taken, given)
        for (int i = 0; i < count; ++i) {
            double power = 0;
            MPM_UNROLL
            for (int k = 0; k < Dim; ++k) {
                double &velocity = q.velocity[k][first + i], v = motion(k, i), a = motion(Dim + k, i);
                const double before = velocity;
                if constexpr (pushed) // with the mean of the velocities at the nodes
                    given += q.mass[first + i] * q.bodyForce[k][first + i] * (v - 0.5 * dt * a);
                if constexpr (damped) {
                    const double resisting = damping * std::copysign(std::abs(a), before + 0.5 * dt * a);
                    v -= dt * resisting;
                    a -= resisting;
                    power += resisting * (before + 0.5 * dt * a);
                }
                velocity = flip * (before + dt * a) + (1 - flip) * v;
                q.position[k][first + i] += dt * v;
            }
            if constexpr (damped) taken += q.mass[first + i] * power;
        }
        return {how.inertiaScale * dt * taken, dt * given};
    }
};

} // namespace mpm
