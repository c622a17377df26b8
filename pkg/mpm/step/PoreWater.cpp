// SPDX-License-Identifier: GPL-2.0-or-later
#include "mpm/step/PoreWater.hpp"

#include "mpm/step/timeTable.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

namespace mpm {

namespace {

constexpr int mostIterations = 5000;
constexpr double firstOverSecond = 10; // error of the solutions: the second mends what the first leaves

} // namespace

std::array<Field, PoreState::count> PoreState::fields(int dim) {
    return {{{"porePressure", "kPa", "Pressure of the pore water, compression positive."},
             {"saturation", "-", "1 where the pores are full of water, 0 where they are dry."},
             {"permeability", "m/s", "Hydraulic conductivity."},
             {"porosity", "-", "Volume of the pores over that of the soil."},
             {"flowVelocity", "m/s", "Flow of water through an area of soil over the area (Darcy).", {dim}}}};
}

std::string PoreWater::doc() const {
    return "Water in the pores of soil: flow by Darcy's law, pressure as one implicit unknown per cell.\n\n"
           "Stress is effective, tension positive; total stress is stress - porePressure I. The time step is "
           "that of the\n"
           "soil without water. Stands behind GridSolver; needs the scheme MUSL. See doc/theory/water.md.";
}

std::vector<Parameter> PoreWater::attributes() {
    return {
        {"table", "m", "Rows (x, level) of the water table, linear between them.", &table},
        {"levels", "s, m", "Rows (time, level at each row of the table), of a table that changes.", &levels},
        {"rise", "s, m", "Rows (time, height) that the table rises by.", &rise},
        {"heads", "m", "Rows (face, time, level of the water behind it); others are closed.", &heads},
        {"drained", "", "Numbers of faces with water to the table behind them.", &drained},
        {"inflows", "m/s", "Rows (face, flow through it into the soil).", &inflows},
        {"wells", "m3/s", "Rows (well, a cell of it, what the well takes).", &wells},
        {"drains", "m", "Rows (cell, head above which water leaves it).", &drains},
        {"kozenyCarman", "", "The permeability follows the volume, as n^3/(1 - n)^2.", &kozenyCarman},
        {"permeability", "m/s", "Hydraulic conductivity of the soil that it is given to; 0: undrained.",
         &permeability, Range::notNegative()},
        {"porosity", "-", "Volume of the pores over that of this soil.", &porosity, Range::inside(0, 1)},
        {"sealed", "", "No water passes the surface of the soil.", &sealed},
        {"bulkModulus", "kPa", "Bulk modulus of water.", &bulkModulus, Range::positive()},
        {"density", "Mg/m3", "Density of water.", &density, Range::positive()},
        {"tolerance", "kPa", "Largest error of the pressure that a step may leave to the next one.",
         &tolerance, Range::positive()},
        {"iterations", "", "Iterations of the last step.", &iterations},
        {"outflow", "m3/s", "What left the soil in the last step (2D: m2/s).", &outflow},
        {"inflow", "m3/s", "What entered it.", &inflow},
        {"waits", "", "Its tables wait, while the scene settles.", &waits},
        {"waitsAt", "s", "Where they wait.", &waitsAt},
        {"waited", "s", "What settle took: by that the tables run late.", &waited},
        {"debt", "m3/s", "Rows (cell, what the last solution left over).", &debt},
        {"changes", "kPa", "Rows (cell, change of its pressure in the first and in the second solution).",
         &changes}};
}

void PoreWater::finish() {
    checkTable("PoreWater", "table", table, 2);
    checkTable("PoreWater", "rise", rise, 2);
    checkTable("PoreWater", "levels", levels, 1 + table.size() / 2);
    checkTable("PoreWater", "inflows", inflows, 2);
    require(wells.size() % 3 == 0 && drains.size() % 2 == 0 && heads.size() % 3 == 0,
            "PoreWater: wells, drains and heads have other numbers than rows of three, two and three; give "
            "regions, and a dict of faces");
}

// Nodes between the corners of a domain that is larger than a cell have no mass, and the pressure of its
// cells would strain nothing.
template <int Dim> void PoreWater::checkSizes(const Scene<Dim>& scene, const Body<Dim>& body) {
    constexpr double most = 1.01; // over the cell
    if (!body.domains->mesh()) return;
    for (int p = 0; p < body.particles.size(); ++p) {
        const Vec<Dim> x = vectorAt<Dim>(body.particles.position, p);
        require(
            body.particles.initialVolume.plane()[p] <=
                most * scene.grid.sizeAt(x).prod() * scene.grid.thicknessAt(x[0]),
            "PoreWater: domains of '", body.name,
            "' are larger than the cells around them; give particles=mpm.APDI(size=...) of at most a cell");
    }
}

template <int Dim> void PoreWater::check(Scene<Dim>& scene) {
    if (dead) return;
    require(scene.scheme->name == "MUSL", "PoreWater: needs the scheme MUSL, not ", scene.scheme->name);
    const Vec<Dim> g = gravityOf(scene);
    require(
        heads.empty() || tableAt(scene, 0).weight > 0,
        "PoreWater: heads are given, and there is no gravity: water of any level has no pressure; give gravity");
    for (const auto& engine : scene.engines)
        require(
            engine->dead || engine->className() != "UniformAlong",
            "PoreWater: UniformAlong makes rows of nodes alike before the water presses on them; leave one "
            "out, e.g. give the ground rollers left and right");
    require(g.template head<Dim - 1>().isZero() && !(g[Dim - 1] > 0),
            "PoreWater: gravity does not point down; give "
            "gravity along the last axis alone");
    const Body<Dim>* first = nullptr;
    const auto checkCells = [&](const char* name, const std::vector<double>& rows, size_t width, size_t at) {
        for (size_t i = at; i < rows.size(); i += width)
            require(rows[i] >= 0 && rows[i] < scene.grid.count, "PoreWater: ", name, " has the cell ",
                    rows[i], ", and the grid has ", scene.grid.count,
                    "; give regions, or a whole checkpoint");
    };
    checkCells("debt", debt, 2, 0);
    checkCells("changes", changes, 3, 0);
    checkCells("wells", wells, 3, 1);
    checkCells("drains", drains, 2, 0);
    auto& state = std::get<State<Dim>>(states_);
    state.owed.assign(scene.grid.count, 0.0);
    for (size_t i = 0; i + 1 < debt.size(); i += 2) state.owed[int(debt[i])] = debt[i + 1];
    for (auto& one : state.guesses) one.assign(scene.grid.count, 0.0);
    for (size_t i = 0; i + 2 < changes.size(); i += 3)
        for (int k = 0; k < 2; ++k) state.guesses[k][int(changes[i])] = changes[i + 1 + k];
    for (auto& body : scene.bodies) {
        if (PoreState::in(body->particles) < 0) continue;
        if (!first) first = body.get();
        require(first->velocityField == body->velocityField, "PoreWater: '", first->name, "' and '",
                body->name, "' have water and are in different groups; give them one");
        state.field = body->velocityField;
    }
    if (!first) return;
    for (auto& body : scene.bodies)
        if (PoreState::in(body->particles) >= 0 || body->velocityField != state.field)
            checkSizes(scene, *body);
    liftAll(scene, scene.time, true);
}

template <int Dim> WaterTable PoreWater::tableAt(const Scene<Dim>& scene, double sceneTime) const {
    const double time = tableTime(sceneTime);
    WaterTable water{table, -density * gravityOf(scene)[Dim - 1]};
    const std::vector<double> now =
        levels.empty() ? std::vector<double>() : rowAt(levels, 1 + table.size() / 2, time);
    const double risen = rise.empty() ? 0 : rowAt(rise, 2, time)[0];
    for (size_t i = 0; i + 1 < table.size(); i += 2)
        water.rows[i + 1] = (now.empty() ? table[i + 1] : now[i / 2]) + risen;
    return water;
}

// Finds the cells, and loads the nodes with the pressure that is there: what holds or meets them in this
// step, and implicit bodies, know it. Else contact would stop what the water will stop, or the other way
// round.
template <int Dim> void PoreWater::loadNodes(Scene<Dim>& scene) {
    auto& state = std::get<State<Dim>>(states_);
    auto& wet = state.fill.wet;
    wet.clear();
    for (auto& body : scene.bodies)
        if (PoreState::in(body->particles) >= 0 && body->particles.size() > 0) wet.emplace_back(*body);
    if (wet.empty()) return;
    state.fill.find(scene, tableAt(scene, scene.time), kozenyCarman);
    state.solids.find(scene, state.field, state.fill);
    addCells(scene, state);
    addFlow(scene, state);
    addWells(state);
    addDrains(scene, state);
    state.system.addNodes(scene.grid);
    state.system.finish();
    findMovers(scene, state);
    findForces(scene, state, state.before);
    for (Mover<Dim>& mover : state.movers) {
        const auto& node = state.system.nodes[mover.node];
        mover.force = mover.part * state.system.foundForce(node, state.acting);
        auto& sum = scene.grid.fields[mover.group].sum[node.number];
        for (int k = 0; k < Dim; ++k) NodalField<Dim>::addForce(sum, k, mover.force[k]);
    }
}

// What changes in the step.
template <int Dim> void PoreWater::act(Scene<Dim>& scene) {
    auto& state = std::get<State<Dim>>(states_);
    if (state.fill.wet.empty()) return;
    auto& system = state.system;
    iterations = 0;
    for (auto* vector : {&state.given, &state.right, &state.residual, &state.flow})
        vector->resize(system.unknowns);
    system.flowAway(state.before, state.away);
    for (int c = 0; c < system.unknowns; ++c)
        state.given[c] = system.cells[c].source - state.away[c] - state.owed[system.cells[c].number];
    state.allowed = allowedError(state);
    setSteps(scene, state);
    state.velocity.assign(system.nodes.size(), Vec<Dim>::Zero());
    for (const Mover<Dim>& mover : state.movers) {
        const auto& motion = scene.grid.fields[mover.group].motion[system.nodes[mover.node].number];
        for (int k = 0; k < Dim; ++k) state.velocity[mover.node][k] += mover.part * motion[k];
    }
    state.change.assign(system.unknowns, 0.0);
    state.excess = state.before;
    closeBalance(scene, state, 0);
    accelerate(scene, state);
    if (!state.response.nodes.empty()) moveStiff(scene, state);
}

// A part of what drives the water, the largest difference of head in it and to the water outside; not more than
// the tolerance.
template <int Dim> double PoreWater::allowedError(const State<Dim>& state) const {
    constexpr double part = 5e-4, least = 1e-4; // least: of the tolerance, where the water is at rest
    double lowest = std::numeric_limits<double>::infinity(), highest = -lowest;
    const auto take = [&](int c, double excess) {
        const double head = state.fill[state.numbers[c]].head + excess;
        lowest = std::min(lowest, head);
        highest = std::max(highest, head);
    };
    for (int c = 0; c < state.system.unknowns; ++c) take(c, state.before[c]);
    for (const auto& outlet : state.system.outlets)
        if (outlet.conductance > 0) take(outlet.cell, outlet.source / outlet.conductance);
    return std::clamp(part * (highest - lowest), least * tolerance, tolerance);
}

// The change of the pressure with which the balance closes for the velocity that is there. It begins with
// that of the step before: waves and loads last for several steps, and a third of the iterations or more is saved.
template <int Dim> void PoreWater::closeBalance(Scene<Dim>& scene, State<Dim>& state, int solution) {
    auto& system = state.system;
    parallel(scene.threads,
             [&](ParallelRegion& region) { system.flowOut(region, state.velocity, scene.dt, state.flow); });
    auto& last = state.guesses[solution];
    for (int c = 0; c < system.unknowns; ++c) {
        state.right[c] = state.given[c] - state.flow[c];
        state.change[c] = last[state.numbers[c]];
    }
    solve(scene, state, solution == 0 ? firstOverSecond * state.allowed : state.allowed, state.change);
    for (int c = 0; c < system.unknowns; ++c) {
        state.excess[c] += state.change[c];
        last[state.numbers[c]] = state.change[c];
    }
    if (solution == 0) { // as the other one finds it
        system.flowAway(state.change, state.away);
        for (int c = 0; c < system.unknowns; ++c)
            state.given[c] -= system.cells[c].storage * state.change[c] + state.away[c];
    }
    findForces(scene, state, state.change);
}

// Of a pressure on the nodes.
template <int Dim>
void PoreWater::findForces(const Scene<Dim>& scene, State<Dim>& state, const std::vector<double>& pressure) {
    state.system.findActing(pressure, state.acting);
    parallel(scene.threads, [&](ParallelRegion& region) { state.system.findForces(region, state.acting); });
}

template <int Dim>
void PoreWater::solve(Scene<Dim>& scene, State<Dim>& state, double allowed, std::vector<double>& u) {
    int needed = 0;
    parallel(scene.threads, [&](ParallelRegion& region) {
        const int found =
            state.matrix.solve(region, state.system, state.right, allowed, mostIterations, u, state.residual);
        region.once([&] { needed = found; });
    });
    if (needed < 0)
        throw RunError(message("step ", scene.step, ": PoreWater: the pressure is not found in ",
                               mostIterations, " iterations; lower dt or raise tolerance, ", tolerance,
                               " kPa"));
    iterations += needed;
}

// On the nodes of implicit bodies.
template <int Dim>
void PoreWater::findImpulses(const Scene<Dim>& scene, State<Dim>& state, const std::vector<double>& acting) {
    for (const Mover<Dim>& mover : state.movers)
        if (mover.stiff >= 0)
            state.impulses[mover.stiff] =
                mover.part * scene.dt * state.system.force(state.system.nodes[mover.node], acting);
}

// What the change of the pressure does to the motion of the nodes, and to what holds them; and the work of all of it.
template <int Dim> void PoreWater::accelerate(Scene<Dim>& scene, State<Dim>& state) {
    using NF = NodalField<Dim>;
    const Vec<Dim> gravity = gravityOf(scene);
    for (Mover<Dim>& mover : state.movers) {
        const auto& node = state.system.nodes[mover.node];
        auto& field = scene.grid.fields[mover.group];
        const auto& sum = field.sum[node.number];
        const Vec<Dim> force = mover.part * state.system.foundForce(node, state.acting);
        mover.force += force;
        auto& motion = field.motion[node.number];
        for (int k = 0; k < Dim; ++k) {
            if (mover.step[k] == 0) {
                const int holder = field.holder[node.number][k];
                Constraint& constraint = *scene.constraints[holder];
                addReaction<Dim>(scene.grid.nodePosition(node.number), constraint.centre, k, -force[k],
                                 constraint.reaction, constraint.moment);
                constraint.work -=
                    force[k] * scene.heldMean(holder, k, NF::velocityAtStart(sum, k)) * scene.dt;
                continue;
            }
            if (mover.stiff >= 0) continue;
            const double more = mover.step[k] * force[k];
            motion.set(NF::acceleration + k, motion[NF::acceleration + k] + more / scene.dt);
            motion.set(k, motion[k] + more);
            if (gravity[k] != 0)
                scene.energies.gravity += sum[NF::weightMass] * gravity[k] * 0.5 * more * scene.dt;
        }
        if (mover.stiff < 0) addWork(scene, mover, node.number);
    }
}

// Of all of the pressure.
template <int Dim> void PoreWater::addWork(Scene<Dim>& scene, const Mover<Dim>& mover, int number) {
    const auto& field = scene.grid.fields[mover.group];
    for (int k = 0; k < Dim; ++k) {
        const double own = NodalField<Dim>::velocityAtStart(field.sum[number], k);
        const double mean = mover.step[k] == 0 ? scene.heldMean(field.holder[number][k], k, own)
                                               : 0.5 * (own + field.motion[number][k]);
        scene.energies.loads += mover.force[k] * mean * scene.dt;
    }
}

template <int Dim> void PoreWater::moveStiff(Scene<Dim>& scene, State<Dim>& state) {
    findImpulses(scene, state, state.acting);
    const std::vector<Vec<Dim>> none(state.impulses.size(), Vec<Dim>::Zero());
    scene.template role<ImplicitMotion<Dim>>()->take(scene, state.response, state.impulses, none);
    for (const Mover<Dim>& mover : state.movers)
        if (mover.stiff >= 0) addWork(scene, mover, state.system.nodes[mover.node].number);
}

// Once more with the velocity that strains the soil, behind Contact: the balance of water closes for what the
// particles get. The change strains implicit bodies, too. Were they at rest here, they would feel the inertia of the
// water beside them a step late, and those lighter than it would shake.
template <int Dim> void PoreWater::coupleAs(Scene<Dim>& scene) {
    auto& state = std::get<State<Dim>>(states_);
    if (state.fill.wet.empty()) return;
    auto& system = state.system;
    state.velocity.assign(system.nodes.size(), Vec<Dim>::Zero());
    for (const Mover<Dim>& mover : state.movers) {
        const auto& field = scene.grid.fields[mover.group];
        const int number = system.nodes[mover.node].number;
        for (int k = 0; k < Dim; ++k)
            state.velocity[mover.node][k] +=
                mover.part * (mover.stiff < 0 ? field.velocityOf(number, k) : field.motion[number][k]);
    }
    closeBalance(scene, state, 1);
    for (const Mover<Dim>& mover : state.movers) {
        if (mover.stiff >= 0) continue;
        const auto& node = system.nodes[mover.node];
        auto& field = scene.grid.fields[mover.group];
        const Vec<Dim> more = mover.part * mover.step.cwiseProduct(system.foundForce(node, state.acting));
        for (int k = 0; k < Dim; ++k)
            if (more[k] != 0) field.setVelocity(node.number, k, field.velocityOf(node.number, k) + more[k]);
    }
    if (!state.response.nodes.empty()) {
        findImpulses(scene, state, state.acting);
        scene.template role<ImplicitMotion<Dim>>()->strain(scene, state.response, state.impulses);
    }
    for (size_t i = 0; i + 1 < debt.size(); i += 2) state.owed[int(debt[i])] = 0;
    for (int c = 0; c < system.unknowns; ++c) state.owed[state.numbers[c]] = -state.residual[c];
    keepForNext(state);
    outflow = inflow = 0;
    for (const auto& outlet : system.outlets) {
        const double out = outlet.conductance * state.excess[outlet.cell] - outlet.source;
        (out > 0 ? outflow : inflow) += std::abs(out);
    }
    giveToParticles(scene, state);
    liftAll(scene, scene.time + scene.dt, false);
}

// What a checkpoint has to know.
template <int Dim> void PoreWater::keepForNext(const State<Dim>& state) {
    debt.resize(2 * state.system.unknowns);
    changes.resize(3 * state.system.unknowns);
    for (int c = 0; c < state.system.unknowns; ++c) {
        const int number = state.numbers[c];
        debt[2 * c] = changes[3 * c] = number;
        debt[2 * c + 1] = -state.residual[c];
        for (int k = 0; k < 2; ++k) changes[3 * c + 1 + k] = state.guesses[k][number];
    }
}

template void PoreWater::findImpulses(const Scene<2>& scene, State<2>& state,
                                      const std::vector<double>& acting);
template void PoreWater::findImpulses(const Scene<3>& scene, State<3>& state,
                                      const std::vector<double>& acting);
template void PoreWater::act(Scene<2>&);
template void PoreWater::act(Scene<3>&);
template WaterTable PoreWater::tableAt(const Scene<2>& scene, double time) const;
template WaterTable PoreWater::tableAt(const Scene<3>& scene, double time) const;

MPM_REGISTER(Engine, PoreWater);

} // namespace mpm
