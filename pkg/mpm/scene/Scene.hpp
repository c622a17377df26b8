// SPDX-License-Identifier: GPL-2.0-or-later
// Everything a step works on: grid, bodies, constraints, the clock, and the chain of engines.
#pragma once

#include "mpm/scene/Body.hpp"
#include "mpm/scene/Constraint.hpp"
#include "mpm/scene/Engine.hpp"
#include "mpm/scene/MirrorNodes.hpp"
#include "mpm/scene/PartedSoils.hpp"
#include "mpm/scene/Scheme.hpp"

#include <array>
#include <cmath>

namespace mpm {

struct Energies {
    double gravity = 0;  // work of gravity and body forces, kJ
    double loads = 0;    // work of boundary loads
    double damping = 0;  // energy taken out by local damping
    double contact = 0;  // energy lost to friction and impact between groups of bodies
    double implicit = 0; // energy taken by the implicit solution of bodies
};

template <int Dim> class SharedCells;

template <int Dim> class Scene {
  public:
    Scene(const Vec<Dim>& lower, const Vec<Dim>& upper, const Vec<Dim>& cell);
    explicit Scene(const typename Grid<Dim>::Lines& lines); // graded
    Scene(const Scene&) = delete;
    ~Scene();

    Grid<Dim> grid;
    std::vector<std::unique_ptr<Body<Dim>>> bodies;
    std::vector<std::shared_ptr<Constraint>> constraints;
    std::vector<std::shared_ptr<Engine>> engines;
    std::shared_ptr<const Scheme> scheme = Registry<Scheme>::make("MUSL");
    double time = 0, dt = 0;
    long step = 0;
    int threads = 1;
    Energies energies;
    bool sorted = false;  // whether particles were sorted, while they are located
    bool located = false; // whether particles are where they were found in the grid, since the last step

    struct Held {
        int field, node, axis;
        short before; // the holder that a drive took over from
    };
    std::vector<Held> driven;

    Body<Dim>* body(const std::string& name) {
        for (auto& b : bodies)
            if (b->name == name) return b.get();
        throw InputError("there is no body named '" + name + "'");
    }

    // The engine of a class or with an interface: the first that lives, or nullptr.
    template <class Wanted> Wanted* find() const {
        for (auto& engine : engines)
            if (auto* found = dynamic_cast<Wanted*>(engine.get()); found && !engine->dead) return found;
        return nullptr;
    }
    // The next living engine behind this one, if it is of that class or has that interface; else nullptr.
    template <class Wanted> Wanted* next(const Engine& engine) const {
        bool isBehind = false;
        for (auto& other : engines) {
            if (isBehind && !other->dead) return dynamic_cast<Wanted*>(other.get());
            isBehind |= other.get() == &engine;
        }
        return nullptr;
    }

    int particleCount() const {
        int n = 0;
        for (auto& b : bodies) n += b->particles.size();
        return n;
    }

    // A node with less mass than this takes no part. Towards the end of its support the weight of uGIMP falls
    // with the square of the overlap, its gradient linearly: a node left out at 1e-12 would still count 1e-6
    // in a gradient.
    double leastMass() const {
        double largest = 0;
        for (auto& b : bodies) largest = std::max(largest, b->largestInertialMass);
        return 1e-30 * largest;
    }

    MirrorNodes<Dim> mirrors;                            // behind rollers
    const std::unique_ptr<SharedCells<Dim>> sharedCells; // of soil and a body that it is in contact with
    std::vector<std::string> groups; // of bodies with a velocity field each, by the number of the field
    PartedSoils<Dim> parted;         // that have two: the second ones come after those of all groups
    std::vector<int> groupOf;        // of each field

    // Checks the chain and enters the static constraints; before the first step and after every change.
    void prepare();
    void separateGroups();
    // Takes up to `steps` steps, and no new one after `seconds` of wall time; returns how many it took.
    long advance(long steps, double seconds);
    // One engine, for a host that calls them one by one and then ends the step itself; the clock stands
    // still.
    void actAlone(Engine& engine);
    void endStep(double newTime);

    // Velocity of a node that a constraint holds, at the start of a step: as it prescribed last. One that begins
    // takes the node over with the velocity that it has, `own`.
    double heldAtStart(int constraint, int axis, double own) const {
        const Constraint& c = *constraints[constraint];
        return c.isWall ? 0 : std::isnan(c.before[axis]) ? own : c.before[axis];
    }
    // At the end of the step.
    double heldAtEnd(int constraint, int axis) const {
        const Constraint& c = *constraints[constraint];
        return c.velocityAt(axis, time + dt - c.began);
    }
    // The mean of both: the force of the constraint times it is the power that goes into the material.
    double heldMean(int constraint, int axis, double own) const {
        return 0.5 * (heldAtStart(constraint, axis, own) + heldAtEnd(constraint, axis));
    }
};

} // namespace mpm
