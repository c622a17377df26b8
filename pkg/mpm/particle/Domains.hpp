// SPDX-License-Identifier: GPL-2.0-or-later
// The contract of a particle type. A ParticleType holds the user's choices; for every body it makes
// Domains, which own the geometry of the body's particle domains and its transfers to and from the grid.
// Dispatch is one virtual call per body and stage; every such call is made by all threads of a region.
#pragma once

#include "mpm/base/parallel/ParallelRegion.hpp"
#include "mpm/base/parameters.hpp"
#include "mpm/base/registry.hpp"
#include "mpm/particle/Outline.hpp"
#include "mpm/state/BlockOrder.hpp"
#include "mpm/state/Particles.hpp"

#include <functional>
#include <limits>
#include <memory>
#include <numeric>

namespace mpm {

// What a body is made from: a lattice of equal boxes, or a mesh.
template <int Dim> struct Geometry {
    std::vector<Vec<Dim>> positions; // lattice: centres of the domains
    Vec<Dim> halfSize;               // lattice: half edges of a domain
    std::vector<int> carriers;       // lattice: facets of its outline, by the number of a domain,
    std::vector<Vec<Dim>> offsets;   //          where they are from its centre,
    std::vector<Vec<Dim>> areas;     //          and their area vectors
    std::vector<Vec<Dim>> points;    // mesh: vertices
    std::vector<int> cells;          // mesh: corners of every domain (VTK order)
    std::vector<int> slaves;         // mesh: hanging vertices,
    std::vector<int> masters;        //       their four masters each (-1: unused)
    std::vector<double> weights;     //       and the weights of these
};

// A domain that is too distorted to go on with.
struct Distorted {
    int particle;
    double quality; // smallest corner area over domain area: 1 for a parallelogram, <= 0 concave
};

// Domains of poor quality: their number, and the worst of all.
struct QualityReport {
    int count = 0;
    Distorted worst{-1, 1};
};

// A small uGIMP-like piece of a domain: what conversion hands over.
template <int Dim> struct Piece {
    int parent;
    Vec<Dim> position;
    double fraction; // of the parent's volume and mass
};

// How particles follow the nodes; flip = 1: FLIP, 0: PIC. Local damping acts on the acceleration of the particles.
struct Move {
    double dt, flip, damping, inertiaScale;
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
    // Cell and local position of everything that transfers, and whether it is inside the grid; once per step. The threads
    // do not wait for each other at the end.
    virtual void locate(ParallelRegion& region) = 0;
    // What the grid is touched by, then; returns true when particles have been sorted and must be located again. One thread.
    virtual bool resort() = 0;
    // Node += phi * {momentum, mass, body force} - V sigma grad phi + forces of hourglass control.
    virtual void addSum(ParallelRegion& region, typename NF::Sum* nodes, double inertiaScale,
                        bool withForce) = 0;
    // Particle velocity and position from nodal velocity and acceleration (nullptr: they stay). Then
    // node += phi * momentum + dt * forces of hourglass control, with weights and forces of the step's start
    // (nullptr: not wanted).
    virtual void move(ParallelRegion& region, const typename NF::Motion* nodes,
                      typename NF::Velocity* momentum, const Move& how) = 0;
    // Energy that local damping took in the last move(), kJ.
    double dampedEnergy() const { return std::accumulate(damped_.begin(), damped_.end(), 0.0); }
    // The velocity that whatever the domain consists of moves with, if that is not the particle itself ...
    virtual void takeVelocity(ParallelRegion&, const typename NF::Velocity*) {}
    // ... and from it the velocity gradient of particles [begin, end); dt = 0: nothing else.
    virtual void takeGradient(int begin, int end, const typename NF::Velocity* nodes, double dt) = 0;
    // Volume of particles [begin, end) from F after the step; of meshed domains takeGradient() has found it already.
    virtual void volumes(int /*begin*/, int /*end*/) {}
    // How long that takes for particles [begin, end), in about the time of one.
    virtual double workOf(int begin, int end) const { return end - begin; }
    // Moves the domains; last in the step.
    virtual void advance(ParallelRegion&, double /*dt*/) {}

    // --- besides the step ---------------------------------------------------------------------------
    // Force of node += -V tensor grad phi + internal stiffness of the domain against unit-time motion: the elastic
    // operator of the critical time step. `tensor`: planes 3*i + j.
    virtual void addForce(ParallelRegion& region, typename NF::Sum* nodes, const double* const tensor[9]) = 0;
    // nodal[node] += phi * mass of the given particles; nodes that were at zero are appended to `touched`.
    // One thread.
    virtual void addMass(const std::vector<int>& which, double* nodal, std::vector<int>& touched) const = 0;
    // Weights and gradients of one particle, by the plain definition.
    virtual void weights(int p, const std::function<void(int, double, const Vec<Dim>&)>& each) const = 0;
    // Half size of the box drawn for a particle, or zero where corners() says more.
    virtual Vec<Dim> halfSize() const { return Vec<Dim>::Zero(); }
    // The surface of boxes that were cut from a region; nullptr where there is none.
    virtual const Outline<Dim>* outline() const { return nullptr; }
    // Corner numbers (VTK order) of every domain into vertexPositions(); nullptr for boxes.
    virtual const std::vector<int>* cornerTable() const { return nullptr; }
    virtual Field* vertexPositions() { return nullptr; }
    virtual Field* vertexVelocities() { return nullptr; }
    // Node += share of a force on one vertex.
    virtual void addVertexForce(int /*vertex*/, const Vec<Dim>& /*force*/, typename NF::Sum*) const {}

    // Distorted domains found in takeGradient(); empty for types that cannot distort.
    virtual std::vector<Distorted> distorted() const { return {}; }
    // Domains whose quality is at most `limit`, and the worst of all; boxes keep theirs.
    virtual QualityReport qualityReport(double /*limit*/) const { return {}; }
    virtual std::vector<Piece<Dim>> split(int /*particle*/, const Vec<Dim>& /*halfSize*/) const { return {}; }
    virtual void remove(const std::vector<int>& /*sorted particles*/) {}
    virtual void grown() {} // after particles were appended
    // Cuts particles that are too long in two; returns whether there were any.
    virtual bool splitStretched() { return false; }
    // Smallest corner Jacobian over initial volume, and largest hourglass amplitude over edge; types that cannot
    // distort have none.
    virtual double minJacobian() const { return std::numeric_limits<double>::quiet_NaN(); }
    virtual double hourglass() const { return 0; }
    // Longest edge of a domain, m, and what it was when the displacement was zero.
    virtual double longestEdge(int p) const = 0;
    virtual double initialEdge(int p) const { return longestEdge(p); }
    virtual size_t bytes() const { return 0; }

    Particles<Dim>& particles;
    const Grid<Dim>& grid;
    BlockOrder<Dim> order;
    std::string bodyName;
    long step = 0;
    std::array<double, 2> lame{0, 0}; // of the body's material, kPa (hourglass stiffness)

  protected:
    std::vector<double> damped_; // energy taken by damping, per piece of work
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
