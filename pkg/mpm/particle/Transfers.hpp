// SPDX-License-Identifier: GPL-2.0-or-later
// What is transferred, written once for all particle types. A type supplies two loops, where P, Q_k and N
// are packs (mass, momentum, force ... side by side):
//
//   scatter<W>(team, nodes, load):  node_i += sum_p ( phi_ip P_p + sum_k d_k phi_ip Q_pk ),  load(p, P, Q);
//                                   Q_k has four lanes, those of the force: the last of P. A last argument
//                                   is the factor on the domains' own forces (hourglass control), 0: none
//   gather<W, grads>(team, nodes, store):  store(p, sum_i phi_ip N_i, { sum_i d_k phi_ip N_i }_k)
//
// and the plain weights of one particle, eachWeight(p, f(node, phi, grad phi)).
#pragma once

#include "mpm/particle/Domains.hpp"

namespace mpm {

template <class Derived, int Dim> class Transfers : public Domains<Dim> {
  public:
    using Base = Domains<Dim>;
    using NF = typename Base::NF;
    using Base::Base;
    using Base::particles;

    void addSum(Team& team, typename NF::Sum* nodes, double inertiaScale, bool withForce) override {
        const Planes q(particles);
        auto load = [&](int p, typename NF::Sum& P, Pack<4>* Q) __attribute__((always_inline)) {
            const double m = inertiaScale * q.mass[p];
            P.set(NF::mass, m);
            P.set(NF::weightMass, q.mass[p]);
            for (int i = 0; i < Dim; ++i) P.set(NF::momentum + i, m * q.velocity[i][p]);
            if (particles.hasBodyForce)
                for (int i = 0; i < Dim; ++i) P.set(NF::force + i, q.mass[p] * q.bodyForce[i][p]);
            if (!withForce) return;
            for (int k = 0; k < Dim; ++k)
                for (int i = 0; i < Dim; ++i)
                    Q[k].set(i, -q.volume[p] * q.stress[i <= k ? 3 * i + k : 3 * k + i][p]);
        };
        derived().template scatter<NF::sumLanes>(team, nodes, load, withForce);
    }

    void addMomentum(Team& team, typename NF::Velocity* nodes, double inertiaScale, double dt) override {
        const Planes q(particles);
        auto load = [&](int p, typename NF::Velocity& P, Pack<4>*) __attribute__((always_inline)) {
            const double m = inertiaScale * q.mass[p];
            for (int i = 0; i < Dim; ++i) P.set(i, m * q.velocity[i][p]);
        };
        derived().template scatter<4, false>(team, nodes, load, dt);
    }

    // v_p <- flip (v_p + dt a) + (1 - flip) v ;  x_p <- x_p + dt v  (v, a interpolated from the nodes), with
    // a <- a [1 - damping sgn(a (v_p + dt a / 2))] for each component, and v less what that takes from a.
    void takeMotion(Team& team, const typename NF::Motion* nodes, double dt, double flip, double damping,
                    double inertiaScale, double* damped) override {
        const Planes q(particles);
        auto store = [&](int p, const typename NF::Motion& motion, const typename NF::Motion*) __attribute__((always_inline)) {
            double power = 0;
            for (int i = 0; i < Dim; ++i) {
                const double before = q.velocity[i][p], middle = before + 0.5 * dt * motion[Dim + i];
                const double resisting = damping * std::copysign(std::abs(motion[Dim + i]), middle);
                const double v = motion[i] - dt * resisting, a = motion[Dim + i] - resisting;
                q.velocity[i][p] = flip * (before + dt * a) + (1 - flip) * v;
                q.position[i][p] += dt * v;
                power += resisting * (before + 0.5 * dt * a);
            }
            damped[p / chunkSize] += inertiaScale * q.mass[p] * power * dt;
        };
        derived().template gather<NF::motionLanes, false>(team, nodes, store);
    }

    // L_ij = sum v_i d_j phi.
    void takeGradient(Team& team, const typename NF::Velocity* nodes) override {
        const Planes q(particles);
        auto store = [&](int p, const Pack<4>&, const Pack<4>* gradient) __attribute__((always_inline)) {
            for (int i = 0; i < Dim; ++i)
                for (int j = 0; j < Dim; ++j) q.velocityGradient[Dim * i + j][p] = gradient[j][i];
        };
        derived().template gather<4, true>(team, nodes, store);
    }

    void addForce(Team& team, typename NF::Velocity* nodes, const double* const tensor[9]) override {
        const Planes q(particles);
        auto load = [&](int p, Pack<4>&, Pack<4>* Q) __attribute__((always_inline)) {
            for (int k = 0; k < Dim; ++k)
                for (int i = 0; i < Dim; ++i) Q[k].set(i, -q.volume[p] * tensor[i <= k ? 3 * i + k : 3 * k + i][p]);
        };
        derived().template scatter<4>(team, nodes, load);
    }

    void addMass(const std::vector<int>& which, double* nodal, std::vector<int>& touched) const override {
        const double* mass = particles.mass.plane();
        for (int p : which)
            derived().eachWeight(p, [&](int node, double phi, const Vec<Dim>&) {
                if (phi == 0) return;
                if (nodal[node] == 0) touched.push_back(node);
                nodal[node] += phi * mass[p];
            });
    }

    void weights(int p, const std::function<void(int, double, const Vec<Dim>&)>& each) const override {
        derived().eachWeight(p, each);
    }

  protected:
    // Plane pointers hoisted out of the loops.
    struct Planes {
        double *mass, *volume, *position[Dim], *velocity[Dim], *bodyForce[Dim], *velocityGradient[Dim * Dim], *stress[9];
        explicit Planes(Particles<Dim>& p) : mass(p.mass.plane()), volume(p.volume.plane()) {
            for (int i = 0; i < Dim; ++i) {
                position[i] = p.position.plane(i), velocity[i] = p.velocity.plane(i);
                bodyForce[i] = p.bodyForce.plane(i);
            }
            for (int i = 0; i < Dim * Dim; ++i) velocityGradient[i] = p.velocityGradient.plane(i);
            for (int i = 0; i < 9; ++i) stress[i] = p.stress.plane(i);
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

    [[noreturn]] void outside(const char* what, int64_t number, const Vec<Dim>& x) const {
        throw RunError(message("step ", Base::step, ": ", what, " ", number, " of '", Base::bodyName, "' at ", place(x),
                               x.allFinite() ? " is outside the grid " : " has no finite position; grid ",
                               place(Base::grid.lower), " to ", place(Base::grid.upper),
                               "; enlarge the grid, hold the body with boundary conditions, or lower dt"));
    }

    // Lowest node of a support that starts at floor(c - offset) in each direction, and the position in
    // it; -1 if the point is more than half a cell outside the grid or not a number.
    int support(const Vec<Dim>& x, double offset, double* const local[Dim], int point) const {
        const auto& grid = Base::grid;
        int node = 0;
        for (int k = 0; k < Dim; ++k) {
            const double c = grid.inCells(x[k], k);
            if (!(c >= grid.ghost - 0.5 && c <= grid.ghost + grid.cells[k] + 0.5)) return -1;
            const int base = int(std::floor(c - offset));
            local[k][point] = c - base;
            node += base * grid.strides[k];
        }
        return node;
    }

  private:
    Derived& derived() { return static_cast<Derived&>(*this); }
    const Derived& derived() const { return static_cast<const Derived&>(*this); }
};

} // namespace mpm
