// SPDX-License-Identifier: GPL-2.0-or-later
// What one particle gives to its nodes and takes from them, the same for all particle types. A type supplies the loops
// and the weights: with phi_ip and its gradient,
//
//   node_i += sum_p phi_ip { momentum, mass ... }_p - V_p sigma_p grad phi_ip        values(), forces()
//   node_i += sum_p phi_ip { momentum }_p                                            momenta()
//   v_p, x_p from sum_i phi_ip { v, a }_i                                            move()
//   L_p = sum_i v_i (x) grad phi_ip                                                  setGradients()
#pragma once

#include "mpm/base/simd/Lanes.hpp"
#include "mpm/base/simd/transpose.hpp"
#include "mpm/particle/Domains.hpp"

namespace mpm {

template <int Dim> class Transfers : public Domains<Dim> {
  public:
    using Base = Domains<Dim>;
    using NF = typename Base::NF;
    using L = Lanes<Dim>;
    using Base::Base;
    using Base::particles;

  protected:
    static void addMassTo(int node, double mass, double* nodal, std::vector<int>& touched) {
        if (mass == 0) return;
        if (nodal[node] == 0) touched.push_back(node);
        nodal[node] += mass;
    }

    static constexpr int largestBatch = 64; // particles that are treated together, at most

    // The arrays of the particles, hoisted out of the loops.
    struct Planes {
        double *mass, *volume, *position[Dim], *velocity[Dim], *bodyForce[Dim], *velocityGradient[Dim * Dim];
        explicit Planes(Particles<Dim>& p) : mass(p.mass.plane()), volume(p.volume.plane()) {
            for (int i = 0; i < Dim; ++i) {
                position[i] = p.position.plane(i), velocity[i] = p.velocity.plane(i);
                bodyForce[i] = p.bodyForce.plane(i);
            }
            for (int i = 0; i < Dim * Dim; ++i) velocityGradient[i] = p.velocityGradient.plane(i);
        }

        // What `count` particles from `first` on give, plane by plane: momentum and inertial mass, -V tensor (planes 3*i + j, upper
        // triangle), body force.
        template <size_t most>
        void momenta(int first, int count, double inertiaScale, double (&out)[Dim + 1][most]) const {
            const Planes q = *this;
#pragma omp simd
            for (int i = 0; i < count; ++i) {
                const double m = inertiaScale * q.mass[first + i];
                MPM_UNROLL
                for (int k = 0; k < Dim; ++k) out[k][i] = m * q.velocity[k][first + i];
                out[Dim][i] = m;
            }
        }
        template <size_t most>
        void tension(int first, int count, const double* const tensor[9],
                     double (&out)[Dim][Dim][most]) const {
            const double *V = volume + first, *sigma[Dim][Dim];
            for (int i = 0; i < Dim; ++i)
                for (int j = 0; j < Dim; ++j) sigma[i][j] = tensor[i <= j ? 3 * i + j : 3 * j + i] + first;
#pragma omp simd
            for (int p = 0; p < count; ++p) MPM_UNROLL
            for (int i = 0; i < Dim; ++i) MPM_UNROLL
            for (int j = 0; j < Dim; ++j) out[i][j][p] = -V[p] * sigma[i][j][p];
        }
        template <size_t most> void bodyForces(int first, int count, double (&out)[Dim][most]) const {
            for (int k = 0; k < Dim; ++k)
                for (int p = 0; p < count; ++p) out[k][p] = mass[first + p] * bodyForce[k][first + p];
        }

        // The same in the lanes of the nodes. Value lanes of NodalField::Sum: momentum and mass; in 2D also the weight mass, which
        // in 3D is a lane of B.
        void values(int first, int count, double inertiaScale, Quad* out) const {
            double p[Dim + 1][largestBatch];
            momenta(first, count, inertiaScale, p);
            interleave({p[0], p[1], p[2], Dim == 2 ? mass + first : p[Dim]}, count, out);
        }
        // B = - V tensor, for its products with grad phi; in 3D with the weight mass.
        void forces(int first, int count, const double* const tensor[9], typename L::Set* out) const {
            double B[Dim][Dim][largestBatch];
            tension(first, count, tensor, B);
            if constexpr (Dim == 2)
                interleave({B[0][0], B[0][1], B[1][0], B[1][1]}, count, &out[0][0]);
            else {
                const double zero[largestBatch] = {};
                for (int k = 0; k < Dim; ++k)
                    interleave({B[0][k], B[1][k], B[2][k], zero}, count, &out[0][k], 4);
                interleave({zero, zero, zero, mass + first}, count, &out[0][3], 4);
            }
        }
        // v_p <- flip (v_p + dt a) + (1 - flip) v ;  x_p <- x_p + dt v  (v, a interpolated from the nodes: motion(k, i)), with
        // a <- a [1 - damping sgn(a (v_p + dt a / 2))] for each component, and v less what that takes from a.
        // Returns the energy that damping took.
        template <class Motion> double move(int first, int count, const Move& m, Motion&& motion) const {
            return m.damping > 0 ? move<true>(first, count, m, motion) : move<false>(first, count, m, motion);
        }

        template <bool damped, class Motion>
        double move(int first, int count, const Move& how, Motion&& motion) const {
            const Planes q =
                *this; // pointers of its own: the compiler need not fear that the loop overwrites them
            const double dt = how.dt, flip = how.flip, damping = how.damping;
            double taken = 0;
#pragma omp simd reduction(+ : taken)
            for (int i = 0; i < count; ++i) {
                double power = 0;
                MPM_UNROLL
                for (int k = 0; k < Dim; ++k) {
                    double &velocity = q.velocity[k][first + i], v = motion(k, i), a = motion(Dim + k, i);
                    const double before = velocity;
                    if constexpr (damped) {
                        const double resisting = damping * std::copysign(std::abs(a), before + 0.5 * dt * a);
                        v -= dt * resisting, a -= resisting;
                        power += resisting * (before + 0.5 * dt * a);
                    }
                    velocity = flip * (before + dt * a) + (1 - flip) * v;
                    q.position[k][first + i] += dt * v;
                }
                if constexpr (damped) taken += q.mass[first + i] * power;
            }
            return how.inertiaScale * dt * taken;
        }
    };

    // Between the lanes of the nodes and planes, plane[k] being an array: as in NodalField::Velocity, the force of NodalField::Sum, and
    // NodalField::Motion.
    static constexpr double none[chunkSize] = {};
    template <class Planes> static void packMomenta(const Planes& plane, int count, Quad* out) {
        interleave({plane[0], plane[1], Dim == 2 ? none : plane[Dim - 1], none}, count, out);
    }
    template <class Planes> static void packForces(const Planes& plane, int count, Quad* out) {
        interleave({plane[0], Dim == 2 ? none : plane[1], plane[Dim - 1], none}, count, out);
    }
    static void unpackVelocity(const typename NF::Velocity* in, int count,
                               const std::array<double*, Dim>& plane) {
        separate(in->part, 1, count, plane);
    }
    template <class Planes>
    static void unpackMotion(const typename NF::Motion* in, int count, Planes& plane) {
        constexpr int parts = sizeof(typename NF::Motion) / sizeof(Quad);
        separate(in->part, parts, count, std::array<double*, 4>{plane[0], plane[1], plane[2], plane[3]});
        if constexpr (Dim == 3)
            separate(in->part + 1, parts, count, std::array<double*, 2>{plane[4], plane[5]});
    }

    // Creates n particles with the given centres and volumes, numbered in order.
    void create(const std::vector<Vec<Dim>>& positions, const std::vector<double>& volumes) {
        particles.resize(int(positions.size()));
        for (int p = 0; p < particles.size(); ++p) {
            particles.id.integers()[p] = p;
            for (int k = 0; k < Dim; ++k)
                particles.position.plane(k)[p] = particles.reference.plane(k)[p] = positions[p][k];
            particles.volume.plane()[p] = particles.initialVolume.plane()[p] = volumes[p];
            for (int i = 0; i < 3; ++i) particles.deformationGradient.plane(4 * i)[p] = 1;
        }
    }

    // The step's own arrays of stress, for Planes::force.
    std::array<const double*, 9> stressPlanes() const {
        std::array<const double*, 9> planes;
        for (int c = 0; c < 9; ++c) planes[c] = particles.stress.plane(c);
        return planes;
    }

    // V = J V0 of particles [begin, end).
    void volumesFromGradient(int begin, int end) {
        const double* F[9];
        for (int i = 0; i < 9; ++i) F[i] = particles.deformationGradient.plane(i);
        double* V = particles.volume.plane();
        const double* V0 = particles.initialVolume.plane();
#pragma omp simd
        for (int p = begin; p < end; ++p) {
            if (Dim == 2)
                V[p] = V0[p] * (F[0][p] * F[4][p] - F[1][p] * F[3][p]) * F[8][p];
            else
                V[p] = V0[p] * (F[0][p] * (F[4][p] * F[8][p] - F[5][p] * F[7][p]) -
                                F[1][p] * (F[3][p] * F[8][p] - F[5][p] * F[6][p]) +
                                F[2][p] * (F[3][p] * F[7][p] - F[4][p] * F[6][p]));
        }
    }

    [[noreturn]] void outside(const char* what, int64_t number, const Vec<Dim>& x) const {
        throw RunError(message("step ", Base::step, ": ", what, " ", number, " of '", Base::bodyName, "' at ",
                               place(x),
                               x.allFinite() ? " is outside the grid " : " has no finite position; grid ",
                               place(Base::grid.lower), " to ", place(Base::grid.upper),
                               "; enlarge the grid, hold the body with boundary conditions, or lower dt"));
    }

    // Lowest nodes of the supports of points [begin, end), which start at floor(c - offset) in each direction, and the
    // positions in them. Returns whether any of these nodes is another one than before. Throws for the first point that
    // is more than half a cell outside the grid or not a number.
    bool support(int begin, int end, double* const x[Dim], double offset, int* cell, double* const local[Dim],
                 const char* what, const int64_t* number) const {
        const auto& grid = Base::grid;
        const double ghost = grid.ghost, lowest = ghost - 0.5;
        double *at[Dim], *inside[Dim], origin[Dim], overCell[Dim], highest[Dim];
        int stride[Dim];
        for (int k = 0; k < Dim; ++k) {
            at[k] = x[k], inside[k] = local[k], stride[k] = grid.strides[k];
            origin[k] = grid.lower[k], overCell[k] = 1 / grid.cell[k],
            highest[k] = ghost + grid.cells[k] + 0.5;
        }
        int wrong = 0, changed = 0;
#pragma omp simd reduction(| : wrong, changed)
        for (int p = begin; p < end; ++p) {
            int node = 0;
            MPM_UNROLL
            for (int k = 0; k < Dim; ++k) {
                const double c = (at[k][p] - origin[k]) * overCell[k] + ghost;
                const bool isInside = c >= lowest && c <= highest[k];
                const double base =
                    isInside ? std::floor(c - offset) : 0; // nan and what is far away are no whole numbers
                inside[k][p] = c - base;
                node += stride[k] * int(base);
                wrong |= !isInside;
            }
            changed |= cell[p] != node;
            cell[p] = node;
        }
        if (wrong) throwOutside(begin, end, x, what, number);
        return changed;
    }

  private:
    [[noreturn]] void throwOutside(int begin, int end, double* const x[Dim], const char* what,
                                   const int64_t* number) const {
        const auto& grid = Base::grid;
        for (int p = begin;; ++p) {
            Vec<Dim> at;
            bool isInside = true;
            for (int k = 0; k < Dim; ++k) {
                at[k] = x[k][p];
                const double c = grid.inCells(at[k], k);
                isInside &= c >= grid.ghost - 0.5 && c <= grid.ghost + grid.cells[k] + 0.5;
            }
            if (!isInside || p == end - 1) outside(what, number ? number[p] : p, at);
        }
    }
};

} // namespace mpm
