// SPDX-License-Identifier: GPL-2.0-or-later
// Bodies whose elastic forces at the end of the step enter the solution on the nodes, so that their stiffness
// does not limit the step: doc/explanation/implicit-bodies.md. The scene puts the engine behind GridSolver.
#pragma once

#include "mpm/step/ImplicitSystem.hpp"
#include "mpm/step/RigidRows.hpp"

namespace mpm {

// For scenes of one dimension.
template <int Dim> class ImplicitSolution : public ImplicitMotion<Dim> {
  public:
    using Vectors = typename ImplicitMotion<Dim>::Vectors;

    static void check(const Scene<Dim>& scene);
    // next: what may look ahead meanwhile; nullptr: nothing.
    void find(Scene<Dim>& scene, LookingAhead* next);

    void place(ImpulseResponse<Dim>& response) override;
    void start(const Scene<Dim>& scene, ImpulseResponse<Dim>& response, int span) override;
    void answer(const Scene<Dim>& scene, const ImpulseResponse<Dim>& response, const Vectors& impulses,
                Vectors& changes) override;
    void take(Scene<Dim>& scene, const ImpulseResponse<Dim>& response, const Vectors& impulses,
              const Vectors& unfelt) override;
    void strain(Scene<Dim>& scene, const ImpulseResponse<Dim>& response, const Vectors& impulses) override;
    void strainNeighbours(Scene<Dim>& scene) const override;
    void finishMotion(Scene<Dim>& scene) override;

  private:
    // Some particles of a body.
    struct Piece {
        Body<Dim>* body;
        int begin, end;
        StrainedNodes<Dim> strained;
    };
    std::vector<Piece> pieces_;                        // of all bodies that are implicit
    std::vector<ImplicitSystem<Dim>> systems_, spare_; // spare: of the step before
    std::vector<RigidRows<Dim>> rigidRows_;            // of each velocity field with implicit bodies
    std::vector<int> scratch_;                         // -1 for each node

    void solve(Scene<Dim>& scene);
    void findSystems(Scene<Dim>& scene);
    void clear(Scene<Dim>& scene);
    void cut(Scene<Dim>& scene);
    static void look(const Scene<Dim>& scene, const RigidRows<Dim>& rows, double least, Piece& piece);
    std::vector<int> groups(int fields);
    void addSystem(Scene<Dim>& scene, int field, const std::vector<StrainedNodes<Dim>*>& members);
    template <class F> void withNumbers(const ImplicitSystem<Dim>& system, F&& f);
};

class ImplicitBodies : public EngineOf<ImplicitBodies>,
                       public ImplicitSolution<2>,
                       public ImplicitSolution<3> {
  public:
    std::string className() const override { return "ImplicitBodies"; }
    std::string doc() const override;
    void prepare(Scene<2>& scene) override { prepareAs(scene); }
    void prepare(Scene<3>& scene) override { prepareAs(scene); }
    template <int Dim> void act(Scene<Dim>& scene) {
        auto* const next = scene.threads > 1 ? scene.template nextRole<LookingAhead>(*this) : nullptr;
        ImplicitSolution<Dim>::find(scene, next);
    }

  private:
    template <int Dim> void prepareAs(const Scene<Dim>& scene) {
        if (!dead) ImplicitSolution<Dim>::check(scene);
    }
};

} // namespace mpm
