// SPDX-License-Identifier: GPL-2.0-or-later
// Everything a step works on: grid, bodies, constraints, the clock, and the chain of engines.
#pragma once

#include "mpm/scene/Body.hpp"
#include "mpm/scene/Constraint.hpp"
#include "mpm/scene/Engine.hpp"
#include "mpm/scene/Scheme.hpp"
#include "mpm/scene/StepState.hpp"
#include "mpm/scene/roles.hpp"

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
    StepState<Dim> state;

    Body<Dim>* body(const std::string& name) {
        for (auto& b : bodies)
            if (b->name == name) return b.get();
        throw InputError("there is no body named '" + name + "'");
    }

    // f(role) for the engines that live and have it.
    template <class Role, class F> void forRoles(F&& f) const {
        for (auto& engine : engines)
            if (auto* found = as<Role>(*engine)) f(*found);
    }
    // The first of these; nullptr: there is none.
    template <class Role> Role* role() const {
        for (auto& engine : engines)
            if (auto* found = as<Role>(*engine)) return found;
        return nullptr;
    }
    // Of the next living engine behind this one; nullptr: it has not this role.
    template <class Role> Role* nextRole(const Engine& engine) const {
        bool isBehind = false;
        for (auto& other : engines) {
            if (isBehind && !other->dead) return as<Role>(*other);
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

    std::vector<std::string> groups; // of bodies with a velocity field each, by the number of the field
    std::vector<int> groupOf;        // of each field; second ones of soils come after those of all groups

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

  private:
    template <class Role> static Role* as(Engine& engine) {
        static_assert(!std::is_base_of_v<Engine, Role>, "ask for a role (scene/roles.hpp), not for a class");
        return engine.dead ? nullptr : dynamic_cast<Role*>(&engine);
    }
};

// Acceleration of gravity in a scene, m/s2, its local damping, and what particles keep of their own velocity; zero, zero
// and all where no engine has the role.
template <int Dim> Vec<Dim> gravityOf(const Scene<Dim>& scene) {
    Vec<Dim> g = Vec<Dim>::Zero();
    if (const auto* solver = scene.template role<SolvingMotion>())
        for (int k = 0; k < Dim; ++k) g[k] = solver->gravityAlong(k);
    return g;
}
template <int Dim> double dampingOf(const Scene<Dim>& scene) {
    const auto* solver = scene.template role<SolvingMotion>();
    return solver ? solver->dampingOfParticles() : 0;
}
template <int Dim> double flipOf(const Scene<Dim>& scene) {
    const auto* mover = scene.template role<MovingParticles>();
    return mover ? mover->keptVelocity() : 1;
}

// Whether the elastic forces of a body enter the solution.
template <int Dim> bool isSolvedImplicitly(const Scene<Dim>& scene, const Body<Dim>& body) {
    return body.isImplicit && scene.template role<ImplicitMotion<Dim>>();
}
// Whether bodies that are solved for implicitly share a velocity field with others.
template <int Dim> bool mixesImplicit(const Scene<Dim>& scene, int field) {
    bool hasImplicit = false, hasOther = false;
    for (auto& body : scene.bodies)
        if (body->velocityField == field) (isSolvedImplicitly(scene, *body) ? hasImplicit : hasOther) = true;
    return hasImplicit && hasOther;
}

} // namespace mpm
