// SPDX-License-Identifier: GPL-2.0-or-later
// What an engine may be for others besides a stage of the step. Scene::role() hands these interfaces on, so no engine
// knows the class of another one.
#pragma once

#include "mpm/base/types.hpp"

#include <functional>
#include <vector>

namespace mpm {

template <int Dim> class Scene;
template <int Dim> class ImpulseResponse;

// It solves the equation of motion on the nodes.
class SolvingMotion {
  public:
    virtual ~SolvingMotion() = default;
    virtual double gravityAlong(int axis) const = 0; // acceleration, m/s2
    virtual double dampingOfParticles() const = 0;   // local damping, -
};

// It moves the particles.
class MovingParticles {
  public:
    virtual ~MovingParticles() = default;
    virtual double keptVelocity() const = 0; // what they keep of their own velocity: 1 is FLIP, 0 is PIC
};

// It makes velocities of the momenta that particles gave back to the nodes; the engine before it may let them do so.
class TakingMomenta {
  public:
    virtual ~TakingMomenta() = default;
};

// It couples the velocity fields of groups of bodies, and is asked once the velocities that strain are made.
class VelocityCoupling {
  public:
    virtual ~VelocityCoupling() = default;
    virtual void couple(Scene<2>& scene) = 0;
    virtual void couple(Scene<3>& scene) = 0;
};

// A part of its work needs nothing that the engine right before it changes, so that this one may let another thread
// do it meanwhile.
class LookingAhead {
  public:
    virtual ~LookingAhead() = default;
    virtual void lookAhead(const Scene<2>& scene) = 0;
    virtual void lookAhead(const Scene<3>& scene) = 0;
};

// Forces of its last solution act on the nodes from the start of the step, before it finds the new ones in its place.
class ActingAhead {
  public:
    virtual ~ActingAhead() = default;
    virtual void actAhead(Scene<2>& scene) = 0;
    virtual void actAhead(Scene<3>& scene) = 0;
};

// Nodes that move as one are joined once all forces are on them.
class JoiningNodes {
  public:
    virtual ~JoiningNodes() = default;
    virtual void join(Scene<2>& scene) = 0;
    virtual void join(Scene<3>& scene) = 0;
};

// Its bodies press on boxes.
class PressingOnBoxes {
  public:
    virtual ~PressingOnBoxes() = default;
    // f(number of the body of the scene, place) for the boxes that were pressed in the last step.
    virtual void forPressed(const std::function<void(int, const Vec3&)>& f) const = 0;
};

// It solves for implicit bodies, and answers for them to impulses on their nodes (StepState::implicitNodes).
template <int Dim> class ImplicitMotion {
  public:
    using Vectors = std::vector<Vec<Dim>>;

    virtual ~ImplicitMotion() = default;
    // Of a response whose nodes, each of which an implicit body moves, are given: tells these their unknowns, and
    // starts a way along each body; sites of contact have unknowns less than `span` apart.
    virtual void place(ImpulseResponse<Dim>& response) = 0;
    virtual void start(const Scene<Dim>& scene, ImpulseResponse<Dim>& response, int span) = 0;
    // Changes of the velocities of these nodes by impulses on them, in their order, m/s; nothing takes them.
    virtual void answer(const Scene<Dim>& scene, const ImpulseResponse<Dim>& response,
                        const Vectors& impulses, Vectors& changes) = 0;
    // Impulses on these nodes, in their order, and changes of their velocities that the particles do not take.
    virtual void take(Scene<Dim>& scene, const ImpulseResponse<Dim>& response, const Vectors& impulses,
                      const Vectors& unfelt) = 0;
    // Impulses that only strain the bodies: their particles have their velocities.
    virtual void strain(Scene<Dim>& scene, const ImpulseResponse<Dim>& response, const Vectors& impulses) = 0;
    // What shares nodes with implicit bodies is strained at these by the velocity that was solved for, as they are:
    // with another one the stiffness of both together would not be symmetric, and what they do to each other would
    // feed a motion that grows at any step (doc/explanation/implicit-bodies.md).
    virtual void strainNeighbours(Scene<Dim>& scene) const = 0;
    // Once the motion of the nodes is final: keeps the velocity that strains the bodies, and books the energy
    // that the solution took.
    virtual void finishMotion(Scene<Dim>& scene) = 0;
};

} // namespace mpm
