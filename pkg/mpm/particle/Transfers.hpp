// SPDX-License-Identifier: GPL-2.0-or-later
// What one particle gives to its nodes and takes from them, the same for all particle types. A type supplies the loops
// and the weights: with phi_ip and its gradient,
//
//   node_i += sum_p phi_ip { momentum, mass ... }_p - V_p sigma_p grad phi_ip        values(), forces()
//   node_i += sum_p phi_ip { momentum }_p                                            momenta()
//   v_p, x_p from sum_i phi_ip { v, a }_i                                            move()
//   L_p = sum_i v_i (x) grad phi_ip                                                  setGradients()
#pragma once

#include "mpm/particle/Domains.hpp"
#include "mpm/particle/Lanes.hpp"

namespace mpm {

template <int Dim> class Transfers : public Domains<Dim> {
  public:
    using Base = Domains<Dim>;
    using NF = typename Base::NF;
    using L = Lanes<Dim>;
    using Base::Base;
    using Base::particles;

    void addMass(const std::vector<int>& which, double* nodal, std::vector<int>& touched) const override {
        const double* mass = particles.mass.plane();
        for (int p : which)
            this->weights(p, [&](int node, double phi, const Vec<Dim>&) {
                if (phi == 0) return;
                if (nodal[node] == 0) touched.push_back(node);
                nodal[node] += phi * mass[p];
            });
    }

  protected:
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

        // The following fill, or read, one entry of four lanes (or a few of them) for each of `count` particles from `first`
        // on. Value lanes of NodalField::Sum: momentum and mass; in 2D also the weight mass, which in 3D is a lane of B.
        void values(int first, int count, double inertiaScale, Quad* out) const {
            const Planes q = *this;
            double* lanes = reinterpret_cast<double*>(out);
#pragma omp simd
            for (int i = 0; i < count; ++i) {
                const double w = q.mass[first + i], m = inertiaScale * w;
                MPM_UNROLL
                for (int k = 0; k < Dim; ++k) lanes[4 * i + k] = m * q.velocity[k][first + i];
                lanes[4 * i + Dim] = m;
                if (Dim == 2) lanes[4 * i + 3] = w;
            }
        }

        // B = - V tensor, for its products with grad phi; in 3D with the weight mass. tensor: planes 3*i + j, upper triangle.
        void forces(int first, int count, const double* const tensor[9], typename L::Set* out) const {
            double* lanes = reinterpret_cast<double*>(out);
            const double *xx = tensor[0], *xy = tensor[1], *xz = tensor[2], *yy = tensor[4], *yz = tensor[5], *zz = tensor[8];
            const double *volume = this->volume, *mass = this->mass;
#pragma omp simd
            for (int i = 0; i < count; ++i) {
                const int p = first + i;
                const double V = -volume[p];
                if constexpr (Dim == 2) {
                    lanes[4 * i] = V * xx[p], lanes[4 * i + 1] = lanes[4 * i + 2] = V * xy[p], lanes[4 * i + 3] = V * yy[p];
                } else {
                    double* B = lanes + 16 * i;
                    B[0] = V * xx[p], B[1] = B[4] = V * xy[p], B[2] = B[8] = V * xz[p], B[3] = 0;
                    B[5] = V * yy[p], B[6] = B[9] = V * yz[p], B[7] = 0;
                    B[10] = V * zz[p], B[11] = B[12] = B[13] = B[14] = 0, B[15] = mass[p];
                }
            }
        }

        // Momentum, in the lanes of NodalField::Velocity.
        void momenta(int first, int count, double inertiaScale, Quad* out) const {
            const Planes q = *this;
            double* lanes = reinterpret_cast<double*>(out);
#pragma omp simd
            for (int i = 0; i < count; ++i) {
                const double m = inertiaScale * q.mass[first + i];
                MPM_UNROLL
                for (int l = 0; l < 4; ++l) lanes[4 * i + l] = l < L::used ? m * q.velocity[L::component(l)][first + i] : 0;
            }
        }

        // v_p <- flip (v_p + dt a) + (1 - flip) v ;  x_p <- x_p + dt v  (v, a interpolated from the nodes), with
        // a <- a [1 - damping sgn(a (v_p + dt a / 2))] for each component, and v less what that takes from a.
        // Returns the energy that damping took.
        double move(int first, int count, const typename NF::Motion* motion, const Move& m) const {
            return m.damping > 0 ? move<true>(first, count, motion, m) : move<false>(first, count, motion, m);
        }

        template <bool damped> double move(int first, int count, const typename NF::Motion* motion, const Move& how) const {
            const Planes q = *this; // pointers of its own: the compiler need not fear that the loop overwrites them
            constexpr int stride = sizeof(typename NF::Motion) / sizeof(double);
            const double* lanes = reinterpret_cast<const double*>(motion);
            const double dt = how.dt, flip = how.flip, damping = how.damping;
            double taken = 0;
#pragma omp simd reduction(+ : taken)
            for (int i = 0; i < count; ++i) {
                double power = 0;
                MPM_UNROLL
                for (int k = 0; k < Dim; ++k) {
                    double &velocity = q.velocity[k][first + i], v = lanes[stride * i + k], a = lanes[stride * i + Dim + k];
                    const double before = velocity;
                    if (damped) {
                        const double resisting = damping * std::copysign(std::abs(a), before + 0.5 * dt * a);
                        v -= dt * resisting, a -= resisting;
                        power += resisting * (before + 0.5 * dt * a);
                    }
                    velocity = flip * (before + dt * a) + (1 - flip) * v;
                    q.position[k][first + i] += dt * v;
                }
                taken += q.mass[first + i] * power;
            }
            return how.inertiaScale * dt * taken;
        }

        void setGradients(int first, int count, const typename L::Gradient* in) const {
            constexpr int stride = sizeof(typename L::Gradient) / sizeof(double);
            const Planes q = *this;
            const double* lanes = reinterpret_cast<const double*>(in);
#pragma omp simd
            for (int p = 0; p < count; ++p)
                MPM_UNROLL
                for (int c = 0; c < Dim * Dim; ++c) q.velocityGradient[c][first + p] = lanes[stride * p + L::laneOf(c / Dim, c % Dim)];
        }

        // The columns k of -V tensor, one lane per component: their products with d_k phi add up to the force.
        void forceColumns(int first, int count, const double* const tensor[9], Quad (*out)[Dim]) const {
            const double* V = volume + first;
            const double* planes[Dim][Dim];
            for (int l = 0; l < Dim; ++l)
                for (int k = 0; k < Dim; ++k) planes[l][k] = tensor[l <= k ? 3 * l + k : 3 * k + l] + first;
            double* lanes = reinterpret_cast<double*>(out);
#pragma omp simd
            for (int i = 0; i < count; ++i)
                MPM_UNROLL
                for (int k = 0; k < Dim; ++k)
                    MPM_UNROLL
                    for (int l = 0; l < 4; ++l)
                        lanes[4 * (Dim * i + k) + l] =
                            l < Dim ? -V[i] * planes[l][k][i] : 0;
        }

        // Body force, one lane per component; in 3D the weight mass comes last.
        MPM_INLINE Quad weight(int p, bool hasBodyForce) const {
            Quad w{0, 0, 0, Dim == 3 ? mass[p] : 0};
            for (int k = 0; k < Dim && hasBodyForce; ++k) w[k] = mass[p] * bodyForce[k][p];
            return w;
        }
    };

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

    [[noreturn]] void outside(const char* what, int64_t number, const Vec<Dim>& x) const {
        throw RunError(message("step ", Base::step, ": ", what, " ", number, " of '", Base::bodyName, "' at ", place(x),
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
            origin[k] = grid.lower[k], overCell[k] = 1 / grid.cell[k], highest[k] = ghost + grid.cells[k] + 0.5;
        }
        int wrong = 0, changed = 0;
#pragma omp simd reduction(| : wrong, changed)
        for (int p = begin; p < end; ++p) {
            int node = 0;
            MPM_UNROLL
            for (int k = 0; k < Dim; ++k) {
                const double c = (at[k][p] - origin[k]) * overCell[k] + ghost, base = std::floor(c - offset);
                inside[k][p] = c - base;
                node += stride[k] * int(base);
                wrong |= !(c >= lowest && c <= highest[k]);
            }
            changed |= cell[p] != node;
            cell[p] = node;
        }
        if (wrong) throwOutside(begin, end, x, what, number);
        return changed;
    }

  private:
    [[noreturn]] void throwOutside(int begin, int end, double* const x[Dim], const char* what, const int64_t* number) const {
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
