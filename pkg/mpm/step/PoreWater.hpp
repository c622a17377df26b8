// SPDX-License-Identifier: GPL-2.0-or-later
// Water in the pores of soil, behind the solution on the nodes and once more behind VelocityRemap: see
// doc/theory/water.md.
#pragma once

#include "mpm/step/PoreFill.hpp"
#include "mpm/step/PoreSystem.hpp"

#include <tuple>

namespace mpm {

class PoreWater : public EngineOf<PoreWater>, public VelocityCoupling {
  public:
    std::vector<double> table, rise, heads, debt;
    double permeability = 1e-7, porosity = 0.4; // of what is added with it
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
    template <int Dim> struct State {
        PoreSystem<Dim> system;
        PoreFill<Dim> fill;
        std::vector<double> before, excess, change, right, residual, flow; // of the unknowns
        std::vector<double> owed;                                          // of each cell of the grid
        int field = 0;
    };
    std::tuple<State<2>, State<3>> states_;

    template <int Dim> void check(Scene<Dim>& scene);
    template <int Dim> static void checkSizes(const Scene<Dim>& scene, const Body<Dim>& body);
    template <int Dim> WaterTable tableAt(const Scene<Dim>& scene, double time) const;
    template <int Dim> void addCells(const Scene<Dim>& scene, State<Dim>& state);
    template <int Dim> static void addActing(const WetBody<Dim>& wet, PoreSystem<Dim>& system);
    template <int Dim> static bool isHeld(const Scene<Dim>& scene, int field, int cell, int axis, int side);
    template <int Dim> void addFlow(const Scene<Dim>& scene, State<Dim>& state);
    template <int Dim> void addWall(const Scene<Dim>& scene, State<Dim>& state, int c, int axis, int side);
    template <int Dim> void setSteps(const Scene<Dim>& scene, State<Dim>& state);
    template <int Dim> void solve(Scene<Dim>& scene, State<Dim>& state, std::vector<double>& u);
    template <int Dim> void accelerate(Scene<Dim>& scene, State<Dim>& state);
    template <int Dim> void coupleAs(Scene<Dim>& scene);
    template <int Dim> void giveToParticles(Scene<Dim>& scene, State<Dim>& state);
    template <int Dim> Vec<Dim> slopeOf(const Scene<Dim>& scene, const State<Dim>& state, int cell) const;
    template <int Dim> void lift(const Scene<Dim>& scene, WetBody<Dim>& wet, const WaterTable& water);
};

} // namespace mpm
