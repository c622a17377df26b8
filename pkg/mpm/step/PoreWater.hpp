// SPDX-License-Identifier: GPL-2.0-or-later
// Water in the pores of soil. Its pressure acts before GridSolver; the change of it is solved for behind
// Contact, and once more behind VelocityRemap: see doc/theory/water.md.
#pragma once

#include "mpm/scene/Scene.hpp"
#include "mpm/step/ImpulseResponse.hpp"
#include "mpm/step/PoreMatrix.hpp"
#include "mpm/step/PoreSolids.hpp"

#include <tuple>

namespace mpm {

class PoreWater : public EngineOf<PoreWater>, public ActingAhead, public VelocityCoupling {
  public:
    std::vector<double> table, levels, rise, heads, drained, inflows, wells, drains, debt, changes;
    double permeability = 1e-7, porosity = 0.4; // of what is added with it
    double bulkModulus = 2.2e6, density = 1.0, tolerance = 0.01, outflow = 0, inflow = 0;
    int iterations = 0;
    bool sealed = false, kozenyCarman = false;
    bool waits = false;             // its tables, while the scene settles,
    double waitsAt = 0, waited = 0; // where they are then, and how much later than the scene they run, s

    std::string className() const override { return "PoreWater"; }
    bool needsOneField() const override { return true; }
    std::string doc() const override;
    std::vector<Parameter> attributes() override;
    void finish() override;
    void prepare(Scene<2>& scene) override { check(scene); }
    void prepare(Scene<3>& scene) override { check(scene); }

    void actAhead(Scene<2>& scene) override { loadNodes(scene); }
    void actAhead(Scene<3>& scene) override { loadNodes(scene); }
    template <int Dim> void act(Scene<Dim>& scene);
    void couple(Scene<2>& scene) override { coupleAs(scene); }
    void couple(Scene<3>& scene) override { coupleAs(scene); }

  private:
    // A group that moves a node of the system, by its part of the volume there.
    template <int Dim> struct Mover {
        int node, group;
        double part;
        int stiff = -1;                    // place in the response of implicit bodies, -1: none of theirs
        Vec<Dim> step = Vec<Dim>::Zero();  // dt over the mass where it may move, else 0, s/Mg
        Vec<Dim> force = Vec<Dim>::Zero(); // of the pressure on it, kN
    };
    // Excess and flow in a cell, both linear.
    template <int Dim> struct InCell {
        double excess;              // at the origin, kPa
        Vec<Dim> slope, flow, gain; // kPa/m; m/s at the origin; growth of each component along its axis, 1/s
    };
    template <int Dim> struct State {
        PoreSystem<Dim> system;
        PoreMatrix<Dim> matrix;
        PoreFill<Dim> fill;
        PoreSolids<Dim> solids;
        std::vector<int> numbers; // of the cells with an unknown
        std::vector<char> isDone; // of each cell of the grid, whether its particles need not act one by one
        std::vector<Mover<Dim>> movers; // in the order of the nodes
        ImpulseResponse<Dim> response;
        std::vector<Vec<Dim>> impulses, changes;                    // of the nodes that respond
        std::vector<Vec<Dim>> velocity;                             // of the nodes of the system
        std::vector<double> before, excess, change, residual, flow; // of the unknowns
        std::vector<double> given, right, away; // what the balance has besides the flow of the soil, and sums
        std::vector<double> acting;             // of the cells of the system
        std::vector<double> owed;               // of each cell of the grid
        std::array<std::vector<double>, 2> guesses; // of the changes in both solutions, of each cell
        std::vector<InCell<Dim>> inCells;           // of the unknowns
        double allowed = 0;                         // error of the pressure in the step, kPa
        int field = 0;
    };
    std::tuple<State<2>, State<3>> states_;

    double tableTime(double time) const { return waits ? waitsAt : time - waited; }
    template <int Dim> void check(Scene<Dim>& scene);
    template <int Dim> static void checkSizes(const Scene<Dim>& scene, const Body<Dim>& body);
    template <int Dim> WaterTable tableAt(const Scene<Dim>& scene, double time) const;
    template <int Dim> void loadNodes(Scene<Dim>& scene);
    template <int Dim> void addCells(Scene<Dim>& scene, State<Dim>& state);
    template <int Dim> static void addActing(State<Dim>& state, const WetBody<Dim>& wet);
    template <int Dim> static void mirrorParts(Scene<Dim>& scene, State<Dim>& state);
    template <int Dim> static void addHandingCells(const Scene<Dim>& scene, State<Dim>& state);
    template <int Dim>
    static double actingVolume(const Scene<Dim>& scene, const State<Dim>& state, int number);
    template <int Dim> static bool isHeld(const Scene<Dim>& scene, int field, int cell, int axis, int side);
    template <int Dim> void addFlow(const Scene<Dim>& scene, State<Dim>& state);
    template <int Dim>
    void addWall(const Scene<Dim>& scene, State<Dim>& state, const WaterTable& water, int c, int axis,
                 int side);
    template <int Dim> void addWells(State<Dim>& state);
    template <int Dim> void addDrains(const Scene<Dim>& scene, State<Dim>& state);
    template <int Dim> static void findMovers(const Scene<Dim>& scene, State<Dim>& state);
    template <int Dim> static void setSteps(Scene<Dim>& scene, State<Dim>& state);
    template <int Dim>
    static void findForces(const Scene<Dim>& scene, State<Dim>& state, const std::vector<double>& pressure);
    template <int Dim>
    static void findImpulses(const Scene<Dim>& scene, State<Dim>& state, const std::vector<double>& acting);
    template <int Dim> void closeBalance(Scene<Dim>& scene, State<Dim>& state, int solution);
    template <int Dim> double allowedError(const State<Dim>& state) const;
    template <int Dim>
    void solve(Scene<Dim>& scene, State<Dim>& state, double allowed, std::vector<double>& u);
    template <int Dim> void accelerate(Scene<Dim>& scene, State<Dim>& state);
    template <int Dim> static void addWork(Scene<Dim>& scene, const Mover<Dim>& mover, int number);
    template <int Dim> void moveStiff(Scene<Dim>& scene, State<Dim>& state);
    template <int Dim> void coupleAs(Scene<Dim>& scene);
    template <int Dim> void keepForNext(const State<Dim>& state);
    template <int Dim> void giveToParticles(Scene<Dim>& scene, State<Dim>& state);
    template <int Dim>
    static void giveBelowLevel(const State<Dim>& state, WetBody<Dim>& wet, const WaterTable& water, int begin,
                               int end);
    template <int Dim> Vec<Dim> slopeOf(const Scene<Dim>& scene, const State<Dim>& state, int cell) const;
    template <int Dim> InCell<Dim> inCell(const Scene<Dim>& scene, const State<Dim>& state, int cell) const;
    template <int Dim> void liftAll(Scene<Dim>& scene, double time, bool areWet);
    template <int Dim>
    static Vec<Dim> buoyancy(const Scene<Dim>& scene, const WaterTable& water, const Vec<Dim>& x);
    template <int Dim> void lift(const Scene<Dim>& scene, Body<Dim>& body, const WaterTable& water);
};

} // namespace mpm
