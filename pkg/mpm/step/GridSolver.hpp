// SPDX-License-Identifier: GPL-2.0-or-later
// Step 3: the equation of motion on the nodes. Other stages ask it for gravity and damping.
#pragma once

#include "mpm/scene/Scene.hpp"

namespace mpm {

// What an engine may be besides: forces of its last solution act on the nodes from the start of the step, before it finds
// the new ones in its own place.
class ActingAhead {
  public:
    virtual ~ActingAhead() = default;
    virtual void actAhead(Scene<2>& scene) = 0;
    virtual void actAhead(Scene<3>& scene) = 0;
};

// Likewise: nodes that move as one are joined once all forces are on them.
class JoiningNodes {
  public:
    virtual ~JoiningNodes() = default;
    virtual void join(Scene<2>& scene) = 0;
    virtual void join(Scene<3>& scene) = 0;
};

class GridSolver : public EngineOf<GridSolver> {
  public:
    std::vector<double> gravity;
    double damping = 0;

    std::string className() const override { return "GridSolver"; }
    std::string doc() const override;
    std::vector<Parameter> attributes() override;
    void prepare(Scene<2>& scene) override { checkGravity(scene); }
    void prepare(Scene<3>& scene) override { checkGravity(scene); }

    template <int Dim> void act(Scene<Dim>& scene);

  private:
    // Reaction, moment and work of one constraint in one slab; the last entry of a slab collects energies.
    struct Tally {
        double force[3] = {0, 0, 0}, moment[3] = {0, 0, 0}, work = 0, gravity = 0;
        int nodes = 0;
    };
    std::vector<Tally> partial_;
    double flip_ = 1; // of GridToParticle

    template <int Dim> void checkGravity(Scene<Dim>&);
    template <int Dim>
    Quad solve(const Scene<Dim>& scene, NodalField<Dim>& field, int node, Quad g, double least,
               Tally* tally) const;
    template <int Dim>
    void hold(const Scene<Dim>& scene, const NodalField<Dim>& field, int node, const Quad& weight, Quad& v,
              Quad& a, Tally* tally) const;
    template <int Dim>
    static void react(const Scene<Dim>& scene, int constraint, int node, int axis, double force, double v,
                      Tally& tally);
    template <int Dim> void addUp(Scene<Dim>& scene);
};

// Acceleration of gravity in a scene, m/s2, and its local damping; zero where nothing solves.
template <int Dim> Vec<Dim> gravityOf(const Scene<Dim>& scene) {
    Vec<Dim> g = Vec<Dim>::Zero();
    if (const auto* solver = scene.template find<GridSolver>())
        for (int k = 0; k < Dim; ++k) g[k] = solver->gravity[k];
    return g;
}
template <int Dim> double dampingOf(const Scene<Dim>& scene) {
    const auto* solver = scene.template find<GridSolver>();
    return solver ? solver->damping : 0;
}

} // namespace mpm
