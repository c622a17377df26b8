// SPDX-License-Identifier: GPL-2.0-or-later
// Water in the pores of soil, behind the solution on the nodes and once more behind VelocityRemap: see
// doc/theory/water.md.
#pragma once

#include "mpm/scene/Scene.hpp"
#include "mpm/step/PoreSystem.hpp"

#include <tuple>

namespace mpm {

// What the particles of a body with water have besides the state of their material, in this order.
struct PoreState {
    static constexpr int count = 4;
    static const Field* fields(); // pressure, saturation, permeability, porosity
    // Number of the first in the state of a body, -1: it has no water.
    template <int Dim> static int in(const Particles<Dim>& particles) {
        const int first = int(particles.state.size()) - count;
        return first >= 0 && particles.state[first].name == "porePressure" ? first : -1;
    }
    template <int Dim> static void addTo(Particles<Dim>& particles) {
        if (in(particles) >= 0) return;
        for (int i = 0; i < count; ++i) {
            particles.state.push_back(fields()[i]);
            particles.state.back().resize(particles.size());
        }
    }
};

class PoreWater : public EngineOf<PoreWater>, public VelocityCoupling {
  public:
    std::vector<double> table, rise, heads, debt;
    double bulkModulus = 2.2e6, density = 1.0, tolerance = 0.1, outflow = 0;
    int iterations = 0;
    bool sealed = false;

    std::string className() const override { return "PoreWater"; }
    std::string doc() const override;
    std::vector<Parameter> attributes() override;
    void finish() override;
    void prepare(Scene<2>& scene) override { check(scene); }
    void prepare(Scene<3>& scene) override { check(scene); }

    template <int Dim> void act(Scene<Dim>& scene);
    void couple(Scene<2>& scene) override { coupleAs(scene); }
    void couple(Scene<3>& scene) override { coupleAs(scene); }

  private:
    // A body with water: its particles' state, and which cell each point of it is in.
    template <int Dim> struct Wet {
        Body<Dim>* body;
        double *pressure, *saturation, *permeability, *porosity;
        CellPoints<Dim> points;
        std::vector<int> cell; // of each point

        explicit Wet(Body<Dim>& body);
    };
    // Sums over the saturated points in a cell, then means.
    template <int Dim> struct Fill {
        double saturated = 0, dry = 0,
               strange = 0; // volumes: of soil with and without water, of other bodies
        double excess = 0, head = 0, permeability = 0, porosity = 0;
        Vec<Dim> centre = Vec<Dim>::Zero();
        bool isInside = false;
    };
    template <int Dim> struct State {
        PoreSystem<Dim> system;
        std::vector<Wet<Dim>> wet;
        std::vector<Fill<Dim>> fill; // of each cell of the grid
        std::vector<int> touched;
        std::vector<double> before, excess, change, right, residual, flow; // of the unknowns
        std::vector<double> owed;                                          // of each cell of the grid
        int field = 0;
    };
    std::tuple<State<2>, State<3>> states_;

    template <int Dim> void check(Scene<Dim>& scene);
    template <int Dim> double levelAt(const Vec<Dim>& x, double time) const;
    template <int Dim> double reference(const Scene<Dim>& scene, const Vec<Dim>& x, double time) const;
    template <int Dim> double headAt(const Scene<Dim>& scene, const Vec<Dim>& x) const;
    template <int Dim> double unitWeight(const Scene<Dim>& scene) const;
    template <int Dim> void fillCells(Scene<Dim>& scene, State<Dim>& state);
    template <int Dim> void addPoints(const Scene<Dim>& scene, State<Dim>& state, Wet<Dim>& wet);
    template <int Dim> void addStrange(const Scene<Dim>& scene, State<Dim>& state);
    template <int Dim> void takeMeans(const Scene<Dim>& scene, State<Dim>& state);
    template <int Dim> void addCells(const Scene<Dim>& scene, State<Dim>& state);
    template <int Dim> static bool isHeld(const Scene<Dim>& scene, int field, int cell, int axis, int side);
    template <int Dim> void addFlow(const Scene<Dim>& scene, State<Dim>& state);
    template <int Dim> void addWall(const Scene<Dim>& scene, State<Dim>& state, int c, int axis, int side);
    template <int Dim> void setSteps(const Scene<Dim>& scene, State<Dim>& state);
    template <int Dim> void solve(Scene<Dim>& scene, State<Dim>& state, std::vector<double>& u);
    template <int Dim> void accelerate(Scene<Dim>& scene, State<Dim>& state);
    template <int Dim> void coupleAs(Scene<Dim>& scene);
    template <int Dim> void giveToParticles(Scene<Dim>& scene, State<Dim>& state);
    template <int Dim> Vec<Dim> slopeOf(const Scene<Dim>& scene, const State<Dim>& state, int cell) const;
    template <int Dim> void lift(Scene<Dim>& scene, Wet<Dim>& wet, double time);
};

} // namespace mpm
