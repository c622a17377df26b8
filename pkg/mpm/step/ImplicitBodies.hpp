// SPDX-License-Identifier: GPL-2.0-or-later
// Bodies whose elastic forces at the end of the step enter the solution on the nodes, so that their stiffness
// does not limit the step: doc/explanation/implicit-bodies.md. The scene puts the engine behind GridSolver.
#pragma once

#include "mpm/step/ImplicitSystem.hpp"
#include "mpm/step/RigidRows.hpp"

namespace mpm {

class ImplicitBodies : public EngineOf<ImplicitBodies> {
  public:
    std::string className() const override { return "ImplicitBodies"; }
    std::string doc() const override;
    void prepare(Scene<2>& scene) override { check(scene); }
    void prepare(Scene<3>& scene) override { check(scene); }

    template <int Dim> void act(Scene<Dim>& scene);

    // Whether an implicit body moves a node of a velocity field.
    template <int Dim> bool moves(int field, int node) const;
    // Of a response whose nodes, each of which an implicit body moves, are given: tells these their unknowns, and
    // starts a way along each body; sites of contact have unknowns less than `span` apart.
    template <int Dim> void place(ImpulseResponse<Dim>& response);
    template <int Dim> void start(const Scene<Dim>& scene, ImpulseResponse<Dim>& response, int span);
    // Changes of the velocities of these nodes by impulses on them, in their order, m/s; nothing takes them.
    template <int Dim>
    void answer(const Scene<Dim>& scene, const ImpulseResponse<Dim>& response,
                const std::vector<Vec<Dim>>& impulses, std::vector<Vec<Dim>>& changes);
    // Impulses on these nodes, in their order, and changes of their velocities that the particles do not take.
    template <int Dim>
    void take(Scene<Dim>& scene, const ImpulseResponse<Dim>& response, const std::vector<Vec<Dim>>& impulses,
              const std::vector<Vec<Dim>>& unfelt);
    // Impulses that only strain the bodies: their particles have their velocities.
    template <int Dim>
    void strain(Scene<Dim>& scene, const ImpulseResponse<Dim>& response,
                const std::vector<Vec<Dim>>& impulses);

    // What shares nodes with implicit bodies is strained at these by the velocity that was solved for, as they are:
    // with another one the stiffness of both together would not be symmetric, and what they do to each other would
    // feed a motion that grows at any step (doc/explanation/implicit-bodies.md).
    template <int Dim> void strainNeighbours(Scene<Dim>& scene) const;
    // Once the motion of the nodes is final: keeps the velocity that strains the bodies, and books the energy
    // that the solution took.
    template <int Dim> void finishMotion(Scene<Dim>& scene);
    // The velocity of the nodes that strains an implicit body.
    template <int Dim> const typename NodalField<Dim>::Velocity* velocities(const Body<Dim>& body) const {
        return std::get<State<Dim>>(states_).velocity[body.velocityField].data();
    }
    template <int Dim> const typename NodalField<Dim>::Velocity& velocityAt(int field, int node) const {
        return std::get<State<Dim>>(states_).velocity[field][node];
    }

  private:
    // Some particles of a body.
    template <int Dim> struct Piece {
        Body<Dim>* body;
        int begin, end;
        StrainedNodes<Dim> strained;
    };
    template <int Dim> struct State {
        using Velocity = typename NodalField<Dim>::Velocity;
        std::vector<Piece<Dim>> pieces;                  // of all bodies that are implicit
        std::vector<ImplicitSystem<Dim>> systems, spare; // spare: of the step before
        std::vector<RigidRows<Dim>> rigidRows;           // of each velocity field with implicit bodies
        std::vector<int> scratch;                        // -1 for each node
        std::vector<std::vector<int>> owner;             // system of each node of a velocity field, -1: none
        std::vector<std::vector<Velocity>> velocity;     // of the nodes of each velocity field
    };
    std::tuple<State<2>, State<3>> states_;

    template <int Dim> void check(Scene<Dim>& scene);
    template <int Dim> void solve(Scene<Dim>& scene, State<Dim>& state);
    template <int Dim> void findSystems(Scene<Dim>& scene, State<Dim>& state);
    template <int Dim> void clear(const Scene<Dim>& scene, State<Dim>& state);
    template <int Dim> void cut(Scene<Dim>& scene, State<Dim>& state);
    template <int Dim>
    static void look(const Scene<Dim>& scene, const RigidRows<Dim>& rows, double least, Piece<Dim>& piece);
    template <int Dim> std::vector<int> groups(int fields, State<Dim>& state);
    template <int Dim>
    void addSystem(const Grid<Dim>& grid, int field, const std::vector<StrainedNodes<Dim>*>& members,
                   State<Dim>& state);
    template <int Dim, class F> void withNumbers(State<Dim>& state, const ImplicitSystem<Dim>& system, F&& f);
};

// Whether the elastic forces of a body enter the solution.
template <int Dim> bool isSolvedImplicitly(const Scene<Dim>& scene, const Body<Dim>& body) {
    return body.isImplicit && scene.template find<ImplicitBodies>();
}
// Whether bodies that are solved for implicitly share a velocity field with others.
template <int Dim> bool mixesImplicit(const Scene<Dim>& scene, int field) {
    bool hasImplicit = false, hasOther = false;
    for (auto& body : scene.bodies)
        if (body->velocityField == field) (isSolvedImplicitly(scene, *body) ? hasImplicit : hasOther) = true;
    return hasImplicit && hasOther;
}

} // namespace mpm
