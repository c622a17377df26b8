// SPDX-License-Identifier: GPL-2.0-or-later
#include "mpm/step/PoreWater.hpp"

#include "mpm/step/GridSolver.hpp"
#include "mpm/step/timeTable.hpp"

#include <algorithm>
#include <cmath>

namespace mpm {

namespace {

constexpr double standardGravity = 9.81; // m/s2, of the permeability in m/s
constexpr double leastCover = 0.05;      // of a cell, for the way to a surface
constexpr double leastWay = 0.25;        // in cells, between the middles of the soil in two cells
constexpr int mostIterations = 5000;

} // namespace

const Field* PoreState::fields() {
    static const Field all[count] = {
        {"porePressure", "kPa", "Pressure of the pore water, compression positive."},
        {"saturation", "-", "1 where the pores are full of water, 0 where they are dry."},
        {"permeability", "m/s", "Hydraulic conductivity."},
        {"porosity", "-", "Volume of the pores over that of the soil."}};
    return all;
}

std::string PoreWater::doc() const {
    return "Water in the pores of soil: flow by Darcy's law, pressure as one implicit unknown per cell.\n\n"
           "Stress is effective, tension positive; total stress is stress - porePressure I. The time step is "
           "that of the\n"
           "soil without water. Stands behind GridSolver; needs the scheme MUSL. See doc/theory/water.md.";
}

std::vector<Parameter> PoreWater::attributes() {
    return {{"table", "m", "Rows (x, level) of the water table, linear between them.", &table},
            {"rise", "s, m", "Rows (time, height) that the table rises by.", &rise},
            {"heads", "m", "Rows (face, level of the water behind it); others are closed.", &heads},
            {"permeability", "m/s", "Hydraulic conductivity of the soil that it is given to; 0: undrained.",
             &permeability, Range::notNegative()},
            {"porosity", "-", "Volume of the pores over that of this soil.", &porosity, Range::inside(0, 1)},
            {"sealed", "", "No water passes the surface of the soil.", &sealed},
            {"bulkModulus", "kPa", "Bulk modulus of water.", &bulkModulus, Range::positive()},
            {"density", "Mg/m3", "Density of water.", &density, Range::positive()},
            {"tolerance", "kPa", "Error of the pressure that the solution may leave to the next step.",
             &tolerance, Range::positive()},
            {"iterations", "", "Iterations of the last step.", &iterations},
            {"outflow", "m3/s", "Flow out of the soil in the last step (2D: m2/s).", &outflow},
            {"debt", "m3/s", "Rows (cell, what the last solution left over).", &debt}};
}

void PoreWater::finish() {
    checkTable("PoreWater", "table", table, 2);
    checkTable("PoreWater", "rise", rise, 2);
    checkTable("PoreWater", "heads", heads, 2);
}

// Nodes between the corners of a domain that is larger than a cell have no mass, and the pressure of its cells would
// strain nothing.
template <int Dim> void PoreWater::checkSizes(const Scene<Dim>& scene, const Body<Dim>& body) {
    constexpr double most = 1.01; // over the cell
    if (!body.domains->mesh()) return;
    for (int p = 0; p < body.particles.size(); ++p)
        require(
            body.particles.initialVolume.plane()[p] <=
                most * scene.grid.sizeAt(vectorAt<Dim>(body.particles.position, p)).prod(),
            "PoreWater: domains of '", body.name,
            "' are larger than the cells around them; give particles=mpm.APDI(size=...) of at most a cell");
}

template <int Dim> void PoreWater::check(Scene<Dim>& scene) {
    if (dead) return;
    require(scene.scheme->name == "MUSL", "PoreWater: needs the scheme MUSL, not ", scene.scheme->name);
    const Vec<Dim> g = gravityOf(scene);
    require(
        heads.empty() || tableAt(scene, 0).weight > 0,
        "PoreWater: heads are given, and there is no gravity: water of any level has no pressure; give gravity");
    require(g.template head<Dim - 1>().isZero() && !(g[Dim - 1] > 0),
            "PoreWater: gravity does not point down; give "
            "gravity along the last axis alone");
    const Body<Dim>* first = nullptr;
    auto& state = std::get<State<Dim>>(states_);
    state.owed.assign(scene.grid.count, 0.0);
    for (size_t i = 0; i + 1 < debt.size(); i += 2) state.owed[int(debt[i])] = debt[i + 1];
    for (auto& body : scene.bodies) {
        if (PoreState::in(body->particles) < 0) continue;
        if (!first) first = body.get();
        require(first->velocityField == body->velocityField, "PoreWater: '", first->name, "' and '",
                body->name, "' have water and are in different groups; give them one");
        state.field = body->velocityField;
        checkSizes(scene, *body);
        WetBody<Dim> wet(*body);
        lift(scene, wet, tableAt(scene, scene.time));
    }
    for (auto& body : scene.bodies)
        require(!first || !body->isImplicit, "PoreWater: '", body->name,
                "' is implicit; give scene.add(..., implicit=False) in a scene with water");
    require(!first || scene.grid.fields.size() == 1,
            "PoreWater: bodies in contact with soil that has water are "
            "not possible; give all bodies one group, and drive a structure by its particles");
}

template <int Dim> WaterTable PoreWater::tableAt(const Scene<Dim>& scene, double time) const {
    return {table, rise.empty() ? 0 : rowAt(rise, 2, time)[0], -density * gravityOf(scene)[Dim - 1]};
}

template <int Dim> void PoreWater::act(Scene<Dim>& scene) {
    auto& state = std::get<State<Dim>>(states_);
    auto& wet = state.fill.wet;
    wet.clear();
    for (auto& body : scene.bodies)
        if (PoreState::in(body->particles) >= 0 && body->particles.size() > 0) wet.emplace_back(*body);
    if (wet.empty()) return;
    state.fill.find(scene, tableAt(scene, scene.time));
    addCells(scene, state);
    addFlow(scene, state);
    state.system.addNodes(scene.grid);
    setSteps(scene, state);
    state.system.finish();
    auto& system = state.system;
    const auto& motion = scene.grid.fields[state.field].motion;
    state.excess = state.before;
    iterations = 0;
    for (auto* vector : {&state.right, &state.residual, &state.flow}) vector->resize(system.cells.size());
    parallel(scene.threads, [&](ParallelRegion& region) {
        system.flowOut(region, [&](int node, int k) { return motion[node][k]; }, state.flow);
    });
    for (size_t c = 0; c < system.cells.size(); ++c) {
        const auto& cell = system.cells[c];
        state.right[c] =
            cell.storage * state.before[c] - state.flow[c] + cell.source - state.owed[cell.number];
    }
    solve(scene, state, state.excess);
    accelerate(scene, state);
}

// The unknowns.
template <int Dim> void PoreWater::addCells(const Scene<Dim>& scene, State<Dim>& state) {
    auto& system = state.system;
    system.start(scene.grid.count);
    state.before.clear();
    for (int number : state.fill.touched()) {
        const auto& fill = state.fill[number];
        if (!(fill.saturated > 0)) continue;
        system.addCell(scene.grid, number);
        state.before.push_back(fill.excess);
    }
    for (const auto& wet : state.fill.wet) addActing(wet, system);
    for (auto& cell : system.cells)
        cell.storage *= state.fill[cell.number].porosity / (bulkModulus * scene.dt);
}

// The pressure acts with the volume and on the nodes as the mean stress of the soil does (step/CellForces.hpp), so what
// it strains is what the particles get: by the cell inside of the soil, by the particles at a surface.
template <int Dim> void PoreWater::addActing(const WetBody<Dim>& wet, PoreSystem<Dim>& system) {
    const auto& body = *wet.body;
    const bool byCells = body.fbar && body.cellAverage.actByCells();
    for (int p = 0; p < body.particles.size(); ++p) {
        if (!(wet.saturation[p] > 0)) continue;
        const double own = body.particles.volume.plane()[p] / wet.points.per(p);
        for (int point = wet.points.at(p); point < wet.points.at(p) + wet.points.per(p); ++point) {
            const int c = system.cellAt(wet.cell[point]);
            const auto* average = byCells ? body.cellAverage.occupied(wet.cell[point]) : nullptr;
            const double inside = average ? average->inside : 0;
            const double all = average ? average->volume : own; // of the body in the cell
            const double acting =
                inside > 0 ? own / all * (inside * average->share * average->whole + (1 - inside) * all)
                           : own;
            system.cells[c].volume += inside * acting;
            system.cells[c].storage += acting;
            if (inside < 1)
                body.domains->weights(p, [&](int node, double, const Vec<Dim>& slope) {
                    system.parts.push_back({c, node, (1 - inside) * acting * slope});
                });
        }
    }
}

// Whether something presses on a face of a cell: its corners are held across it.
template <int Dim> bool PoreWater::isHeld(const Scene<Dim>& scene, int field, int cell, int axis, int side) {
    bool is = true;
    for (int a = 0; a < corners<Dim>; ++a)
        if ((cornerSign(a, axis) > 0) == bool(side))
            is &= scene.grid.fields[field].holder[cornerOf(scene.grid, cell, a)][axis] >= 0;
    return is;
}

// Part of a face of a cell that soil touches: a prism of the volume in the cell, with its middle as far from the face.
template <class Cell> double coverOf(const Cell& cell, double way, double area) {
    return cell.saturated < 2 * way * area ? cell.saturated / (2 * way * area) : 1;
}

// Between cells, to the surface and to the faces of the grid (two-point flux).
template <int Dim> void PoreWater::addFlow(const Scene<Dim>& scene, State<Dim>& state) {
    const Grid<Dim>& grid = scene.grid;
    const WaterTable water = tableAt(scene, scene.time);
    auto& system = state.system;
    const double overWeight = 1 / (density * standardGravity);
    for (int c = 0; c < int(system.cells.size()); ++c) {
        const int number = system.cells[c].number;
        const auto& own = state.fill[number];
        const Index<Dim> index = grid.indices(number);
        const Vec<Dim> edges = grid.edges(number);
        for (int k = 0; k < Dim; ++k)
            for (int side = 0; side < 2; ++side) {
                const int at = index[k] - grid.ghost;
                if (side ? at == grid.cells[k] - 1 : at == 0) {
                    addWall(scene, state, c, k, side);
                    continue;
                }
                const int beside = number + (side ? 1 : -1) * grid.strides[k], other = system.cellAt(beside);
                const auto& there = state.fill[beside];
                const double area = edges.prod() / edges[k];
                if (other < 0) {
                    const bool isClosed = sealed || state.fill.isClosed(grid, beside) ||
                                          isHeld(scene, state.field, number, k, side);
                    if (isClosed) continue;
                    const double way =
                        0.5 * std::clamp(own.saturated / edges.prod(), leastCover, 1.0) * edges[k];
                    Vec<Dim> surface = own.centre;
                    surface[k] += side ? way : -way;
                    const double conductance = own.permeability * overWeight * area / way;
                    const bool isTable = own.dry > 0 || there.dry > 0; // and no surface of the soil
                    system.cells[c].flow += conductance;
                    system.cells[c].source +=
                        isTable ? 0 : conductance * (water.head<Dim>(surface) - own.head);
                    continue;
                }
                if (!side) continue; // once
                const double face = grid.line(k, index[k] + 1);
                const double to = std::max(face - own.centre[k], 0.0),
                             from = std::max(there.centre[k] - face, 0.0);
                const double way = to + from, least = leastWay * edges[k];
                const double cover =
                    own.isInside || there.isInside
                        ? 1
                        : std::min({1.0, coverOf(own, to, area), coverOf(there, from, area)});
                const double resistance =
                    way > 0 ? to / own.permeability + from / there.permeability : least / own.permeability;
                const double conductance =
                    cover * area * overWeight / (resistance * std::max(1.0, way > 0 ? least / way : 1.0));
                if (conductance > 0)
                    system.faces.push_back({c, other, conductance, conductance * (own.head - there.head)});
            }
    }
}

template <int Dim>
void PoreWater::addWall(const Scene<Dim>& scene, State<Dim>& state, int c, int axis, int side) {
    double level = notGiven;
    for (size_t i = 0; i + 1 < heads.size(); i += 2)
        if (int(heads[i]) == 2 * axis + side) level = heads[i + 1];
    if (std::isnan(level)) return;
    const Grid<Dim>& grid = scene.grid;
    auto& cell = state.system.cells[c];
    const auto& fill = state.fill[cell.number];
    const Vec<Dim> edges = grid.edges(cell.number);
    Vec<Dim> x = fill.centre;
    x[axis] = side ? grid.upper[axis] : grid.lower[axis];
    const double way = std::max(std::abs(x[axis] - fill.centre[axis]), leastCover * edges[axis]);
    const double conductance =
        fill.permeability / (density * standardGravity) * edges.prod() / edges[axis] / way;
    const double gamma = tableAt(scene, scene.time).weight,
                 head = gamma > 0 ? std::max(gamma * level, gamma * x[Dim - 1]) : 0;
    cell.flow += conductance;
    cell.source += conductance * (head - fill.head);
}

template <int Dim> void PoreWater::setSteps(const Scene<Dim>& scene, State<Dim>& state) {
    using NF = NodalField<Dim>;
    const auto& field = scene.grid.fields[state.field];
    const double least = scene.leastMass();
    for (auto& node : state.system.nodes) {
        const double mass = field.sum[node.number][NF::mass];
        for (int k = 0; k < Dim; ++k)
            node.step[k] = mass > least && field.holder[node.number][k] < 0 ? scene.dt / mass : 0;
    }
}

template <int Dim> void PoreWater::solve(Scene<Dim>& scene, State<Dim>& state, std::vector<double>& u) {
    int needed = 0;
    parallel(scene.threads, [&](ParallelRegion& region) {
        const int found =
            state.system.solve(region, state.right, tolerance, mostIterations, u, state.residual);
        region.once([&] { needed = found; });
    });
    if (needed < 0)
        throw RunError(message("step ", scene.step, ": PoreWater: the pressure is not found in ",
                               mostIterations, " iterations; lower dt or raise tolerance, ", tolerance,
                               " kPa"));
    iterations += needed;
}

// What the pressure does to the motion of the nodes, and to what holds them.
template <int Dim> void PoreWater::accelerate(Scene<Dim>& scene, State<Dim>& state) {
    using NF = NodalField<Dim>;
    auto& field = scene.grid.fields[state.field];
    const Vec<Dim> gravity = gravityOf(scene);
    for (const auto& node : state.system.nodes) {
        const auto& sum = field.sum[node.number];
        if (!(sum[NF::mass] > 0)) continue;
        const Vec<Dim> force = state.system.force(node, state.excess);
        auto& motion = field.motion[node.number];
        for (int k = 0; k < Dim; ++k) {
            const double own = NF::velocityAtStart(sum, k);
            if (const int holder = field.holder[node.number][k]; holder >= 0) {
                Constraint& constraint = *scene.constraints[holder];
                const double work = force[k] * scene.heldMean(holder, k, own) * scene.dt;
                addReaction<Dim>(scene.grid.nodePosition(node.number), constraint.centre, k, -force[k],
                                 constraint.reaction, constraint.moment);
                constraint.work -= work;
                scene.energies.loads += work;
                continue;
            }
            const double more = node.step[k] * force[k];
            motion.set(NF::acceleration + k, motion[NF::acceleration + k] + more / scene.dt);
            motion.set(k, motion[k] + more);
            scene.energies.loads += force[k] * 0.5 * (own + motion[k]) * scene.dt;
            scene.energies.gravity += sum[NF::weightMass] * gravity[k] * 0.5 * more * scene.dt;
        }
    }
}

// Once more with the velocity that strains the soil: the balance of water closes for what the particles get.
template <int Dim> void PoreWater::coupleAs(Scene<Dim>& scene) {
    auto& state = std::get<State<Dim>>(states_);
    if (state.fill.wet.empty()) return;
    auto& system = state.system;
    auto& field = scene.grid.fields[state.field];
    const int n = int(system.cells.size());
    parallel(scene.threads, [&](ParallelRegion& region) {
        system.flowOut(region, [&](int node, int k) { return field.velocityOf(node, k); }, state.flow);
    });
    outflow = 0;
    for (int c = 0; c < n; ++c) {
        const auto& cell = system.cells[c];
        state.right[c] = -(cell.storage * (state.excess[c] - state.before[c]) + state.flow[c] +
                           system.flowAway(c, state.excess) - cell.source + state.owed[cell.number]);
    }
    state.change.assign(n, 0.0);
    solve(scene, state, state.change);
    for (const auto& node : system.nodes) {
        const Vec<Dim> more = system.force(node, state.change).cwiseProduct(node.step);
        for (int k = 0; k < Dim; ++k)
            if (node.step[k] > 0)
                field.setVelocity(node.number, k, field.velocityOf(node.number, k) + more[k]);
    }
    std::fill(state.owed.begin(), state.owed.end(), 0.0);
    debt.clear();
    for (int c = 0; c < n; ++c) {
        const auto& cell = system.cells[c];
        state.excess[c] += state.change[c];
        state.owed[cell.number] = -state.residual[c];
        debt.insert(debt.end(), {double(cell.number), -state.residual[c]});
    }
    for (int c = 0; c < n; ++c) // what passes faces between cells adds up to nothing
        outflow += system.flowAway(c, state.excess) - system.cells[c].source;
    giveToParticles(scene, state);
}

// Of the excess in a cell, limited by its neighbours (van Leer 1977), kPa/m.
template <int Dim>
Vec<Dim> PoreWater::slopeOf(const Scene<Dim>& scene, const State<Dim>& state, int c) const {
    const Grid<Dim>& grid = scene.grid;
    const int number = state.system.cells[c].number;
    Vec<Dim> slope = Vec<Dim>::Zero();
    for (int k = 0; k < Dim; ++k) {
        const int low = state.system.cellAt(number - grid.strides[k]),
                  high = state.system.cellAt(number + grid.strides[k]);
        if (low < 0 || high < 0) continue;
        const double x = state.fill[number].centre[k];
        const double before = (state.excess[c] - state.excess[low]) /
                              (x - state.fill[state.system.cells[low].number].centre[k]);
        const double after = (state.excess[high] - state.excess[c]) /
                             (state.fill[state.system.cells[high].number].centre[k] - x);
        if (before * after > 0)
            slope[k] = std::copysign(
                std::min(0.5 * std::abs(before + after), 2 * std::min(std::abs(before), std::abs(after))),
                before);
    }
    return slope;
}

template <int Dim> void PoreWater::giveToParticles(Scene<Dim>& scene, State<Dim>& state) {
    std::vector<Vec<Dim>> slope(state.system.cells.size());
    for (size_t c = 0; c < slope.size(); ++c) slope[c] = slopeOf(scene, state, int(c));
    const WaterTable end = tableAt(scene, scene.time + scene.dt);
    for (auto& wet : state.fill.wet) {
        for (int p = 0; p < wet.body->particles.size(); ++p) {
            if (!(wet.saturation[p] > 0)) continue;
            const Vec<Dim> x = vectorAt<Dim>(wet.body->particles.position, p);
            double excess = 0;
            for (int point = wet.points.at(p); point < wet.points.at(p) + wet.points.per(p); ++point) {
                const int c = state.system.cellAt(wet.cell[point]);
                excess += state.excess[c] + slope[c].dot(x - state.fill[wet.cell[point]].centre);
            }
            wet.pressure[p] = excess / wet.points.per(p) + end.pressure<Dim>(x);
        }
        lift(scene, wet, end);
    }
}

// Buoyancy below the table, and what its slope drives: the body force of the hydrostatic pressure, m/s2.
template <int Dim> void PoreWater::lift(const Scene<Dim>& scene, WetBody<Dim>& wet, const WaterTable& water) {
    auto& particles = wet.body->particles;
    particles.needBodyForce();
    const double h = scene.grid.smallestCell()[0];
    for (int p = 0; p < particles.size(); ++p) {
        const Vec<Dim> x = vectorAt<Dim>(particles.position, p);
        Vec<Dim> force = Vec<Dim>::Zero();
        if (wet.saturation[p] > 0 && water.pressure<Dim>(x) > 0) {
            force[Dim - 1] = water.weight;
            Vec<Dim> before = x, after = x;
            before[0] -= 0.5 * h;
            after[0] += 0.5 * h;
            force[0] -= water.weight * (water.level<Dim>(after) - water.level<Dim>(before)) / h;
        }
        force *= particles.initialVolume.plane()[p] / particles.mass.plane()[p];
        for (int k = 0; k < Dim; ++k) particles.bodyForce.plane(k)[p] = force[k];
    }
}

template void PoreWater::act(Scene<2>&);
template void PoreWater::act(Scene<3>&);

MPM_REGISTER(Engine, PoreWater);

} // namespace mpm
