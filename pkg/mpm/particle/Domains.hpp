// SPDX-License-Identifier: GPL-2.0-or-later
// The contract of a particle type. A ParticleType holds the user's choices; for every body it makes
// Domains, which own the geometry of the body's particle domains and its transfers to and from the grid.
// Dispatch is one virtual call per body and stage; every such call is made by all threads of a region.
// What only some types have is asked for by boxes(), mesh() and distortion().
#pragma once

#include "mpm/base/parallel/ParallelRegion.hpp"
#include "mpm/base/parameters.hpp"
#include "mpm/base/registry.hpp"
#include "mpm/particle/Distortion.hpp"
#include "mpm/particle/EqualBoxes.hpp"
#include "mpm/particle/Geometry.hpp"
#include "mpm/particle/Mesh.hpp"
#include "mpm/state/BlockOrder.hpp"
#include "mpm/state/Particles.hpp"
#include "mpm/state/SectionStiffness.hpp"

#include <array>
#include <functional>
#include <memory>
#include <numeric>

namespace mpm {

// How particles follow the nodes; flip = 1: FLIP, 0: PIC. Local damping acts on the acceleration of the
// particles.
struct Move {
    double dt, flip, damping, inertiaScale;
};
// kJ, what particles lost to local damping and got from body forces as they moved.
struct MovedEnergy {
    double damped = 0, byBodyForce = 0;

    MovedEnergy& operator+=(const MovedEnergy& other) {
        damped += other.damped;
        byBodyForce += other.byBodyForce;
        return *this;
    }
};

// A tensor of the particles, planes 3*i + j, that acts on the nodes by its divergence.
struct ActingStress {
    std::array<const double*, 9> planes;
    // kPa, added to its diagonal; nullptr: nothing is. With F-bar: what the particles bear of the mean stress of their
    // cells, less their own mean stress.
    const double* spherical = nullptr;

    explicit ActingStress(const double* const tensor[9]) { std::copy_n(tensor, 9, planes.begin()); }
    explicit ActingStress(Field& stress, const double* spherical = nullptr) : spherical(spherical) {
        for (int c = 0; c < 9; ++c) planes[c] = stress.plane(c);
    }
    double diagonal(int axis, int p) const {
        return spherical ? planes[4 * axis][p] + spherical[p] : planes[4 * axis][p];
    }
};

template <int Dim> class MPM_PUBLIC Domains {
  public:
    using NF = NodalField<Dim>;

    Domains(Particles<Dim>& particles, const Grid<Dim>& grid) : particles(particles), grid(grid) {}
    virtual ~Domains() = default;

    // --- making -------------------------------------------------------------------------------------
    // Creates the particles: position, volume, id; and the domains.
    virtual void build(const Geometry<Dim>& geometry) = 0;
    virtual void restored() = 0; // after fields and tables were read from a checkpoint
    virtual std::vector<Field*> fields() { return {}; }
    virtual std::vector<std::pair<std::string, std::vector<int>*>> tables() {
        return {{"blockStart", &order.start}, {"blockOrder", &order.order}};
    }

    // --- the step, in this order --------------------------------------------------------------------
    // Cell and local position of everything that transfers, and whether it is inside the grid; once per step.
    // The threads do not wait for each other at the end.
    virtual void locate(ParallelRegion& region) = 0;
    // What part of the grid is touched, then; returns true when particles have been sorted and must be
    // located again. One thread.
    virtual bool resort() = 0;
    // Node += phi * {momentum, mass, body force} - V sigma grad phi + forces of hourglass control; stress = nullptr:
    // without forces.
    virtual void addSum(ParallelRegion& region, typename NF::Sum* nodes, double inertiaScale,
                        const ActingStress* stress) = 0;
    // Particle velocity and position from nodal velocity and acceleration (nullptr: they stay). Then
    // node += phi * momentum, with weights of the step's start (nullptr: not wanted).
    virtual void move(ParallelRegion& region, const typename NF::Motion* nodes,
                      typename NF::Velocity* momentum, const Move& how) = 0;
    // The velocity gradient of particles [begin, end); dt = 0: nothing else.
    virtual void takeGradient(int begin, int end, const typename NF::Velocity* nodes, double dt) = 0;
    // Volume of particles [begin, end) from F after the step; of meshed domains takeGradient() has found it
    // already.
    virtual void volumes(int /*begin*/, int /*end*/) {}
    // Last: what resists by itself, not by the stress, notes its new state. Returns its work in the step, kJ. One thread.
    virtual double finishStep() { return 0; }

    // --- besides the step ---------------------------------------------------------------------------
    // Force of node += -V tensor grad phi + internal stiffness of the domain against unit-time motion: the
    // elastic operator of the critical time step. `tensor`: planes 3*i + j.
    virtual void addForce(ParallelRegion& region, typename NF::Sum* nodes, const double* const tensor[9]) = 0;
    // nodal[node] += phi * quantity of the given particles, such as their masses; nodes that were at zero are appended
    // to `touched`.
    // One thread.
    virtual void addQuantity(const double* quantity, const std::vector<int>& which, double* nodal,
                             std::vector<int>& touched) const = 0;
    // Weights and gradients of one particle, by the plain definition.
    virtual void weights(int p, const std::function<void(int, double, const Vec<Dim>&)>& each) const = 0;
    // each(node, force) for the forces of the stresses and of hourglass control on the nodes, kN; after locate(). The
    // stress of bodies that act by cells is not all in it. One thread.
    virtual void internalForces(const std::function<void(int, const Vec<Dim>&)>& each) {
        for (int p = 0; p < particles.size(); ++p) {
            Mat<Dim> tension;
            for (int i = 0; i < Dim; ++i)
                for (int j = 0; j < Dim; ++j)
                    tension(i, j) = -particles.volume.plane()[p] *
                                    particles.stress.plane(3 * std::min(i, j) + std::max(i, j))[p];
            const double hoop = -particles.volume.plane()[p] * particles.stress.plane(8)[p] * overRadius(p);
            weights(p, [&](int node, double phi, const Vec<Dim>& gradient) {
                each(node, tension * gradient + hoop * phi * Vec<Dim>::Unit(0));
            });
        }
    }
    virtual double overRadius(int /*p*/) const { return 0; } // 1/r with axial symmetry, 1/m; of boxes
    virtual size_t bytes() const { return 0; }               // of memory

    // --- what only some types have; nullptr: not this one -------------------------------------------
    virtual EqualBoxes<Dim>* boxes() { return nullptr; }
    virtual Mesh<Dim>* mesh() { return nullptr; }
    virtual Distortion<Dim>* distortion() { return nullptr; }

    // Of the last move(), over its pieces in their order.
    MovedEnergy movedEnergy() const {
        return std::accumulate(moved_.begin(), moved_.end(), MovedEnergy{},
                               [](MovedEnergy sum, const MovedEnergy& piece) { return sum += piece; });
    }

    Particles<Dim>& particles;
    const Grid<Dim>& grid;
    BlockOrder<Dim> order;
    std::string bodyName;
    long step = 0;
    // Lame constants of particles [begin, end) as their material gives them, kPa. Set by the body.
    std::function<void(int begin, int end, double* lambda, double* mu)> stiffness;
    // Shear stress that their material can bear, kPa; infinite where nothing yields. Set by the body.
    std::function<void(int begin, int end, double* strength)> shearStrength;

    // Of a beam, see Material::section().
    const SectionStiffness* section = nullptr;

  protected:
    std::vector<MovedEnergy> moved_; // per piece of work
};

class MPM_PUBLIC ParticleType : public Configurable {
  public:
    // Whether bodies are meshed (shared vertices) or a lattice of boxes.
    virtual bool isMeshed() const = 0;
    // Whether distorted domains become uGIMP particles instead of ending the run.
    virtual bool converts() const { return false; }
    virtual std::unique_ptr<Domains<2>> make(Particles<2>&, const Grid<2>&) const = 0;
    virtual std::unique_ptr<Domains<3>> make(Particles<3>&, const Grid<3>&) const = 0;
};

} // namespace mpm
