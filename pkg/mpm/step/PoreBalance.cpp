// SPDX-License-Identifier: GPL-2.0-or-later
// The balance of pore water: cells with an unknown, what flows between them and through faces, and what an impulse on a
// node changes.
#include "mpm/step/PoreWater.hpp"
#include "mpm/step/timeTable.hpp"

#include <algorithm>
#include <cmath>
#include <map>

namespace mpm {

namespace {
constexpr double standardGravity = 9.81; // m/s2, of the permeability in m/s
constexpr double leastCover = 0.05;      // of a cell, for the way to a surface
constexpr double leastWay = 0.25;        // in cells, between the middles of the soil in two cells
constexpr double drainOverCell = 1e3;    // flow into a drain over that between two cells, at equal heads

// The value of rows (face, value), nullptr: the face has none.
const double* atFace(const std::vector<double>& rows, double face) {
    for (size_t i = 0; i + 1 < rows.size(); i += 2)
        if (rows[i] == face) return &rows[i + 1];
    return nullptr;
}

// The level of rows (face, time, level), empty: the face has none.
std::vector<double> headAt(const std::vector<double>& rows, double face, double time) {
    std::vector<double> own; // rows (time, level)
    for (size_t i = 0; i + 2 < rows.size(); i += 3)
        if (rows[i] == face) own.insert(own.end(), {rows[i + 1], rows[i + 2]});
    return own.empty() ? own : rowAt(own, 2, time);
}

} // namespace

// The unknowns.
template <int Dim> void PoreWater::addCells(Scene<Dim>& scene, State<Dim>& state) {
    auto& system = state.system;
    auto* const boxes = state.fill.wet.front().body->domains->boxes();
    system.half = boxes ? boxes->halfSize()[0] : 0;
    state.before.clear();
    state.numbers.clear();
    for (int number : state.fill.touched()) {
        const auto& fill = state.fill[number];
        if (!(fill.saturated > 0)) continue;
        state.numbers.push_back(number);
        state.before.push_back(fill.excess);
    }
    system.start(scene.grid, state.numbers);
    for (const auto& wet : state.fill.wet) addActing(state, wet);
    mirrorParts(scene, state);
    addHandingCells(scene, state);
    for (int c = 0; c < system.unknowns; ++c)
        system.cells[c].storage *= state.fill[system.cells[c].number].porosity / (bulkModulus * scene.dt);
}

// f(node, what its velocity adds to the rate of volume of a particle, 1/m, what the circumference has of that).
template <int Dim, class F> void forVolumeSlopes(const Body<Dim>& body, int p, F&& f) {
    double stiffness[Mesh<Dim>::patterns];
    if (const auto* mesh = body.domains->mesh())
        return mesh->strains(
            p,
            [&](int node, double, const Vec<Dim>& slope, double hoop, const double*) {
                f(node, slope + hoop * Vec<Dim>::Unit(0), hoop);
            },
            stiffness);
    const double overRadius = body.domains->overRadius(p);
    body.domains->weights(p, [&](int node, double phi, const Vec<Dim>& slope) {
        f(node, slope + phi * overRadius * Vec<Dim>::Unit(0), phi * overRadius);
    });
}

// The pressure acts with the volume and on the nodes as the mean stress of the soil does (step/CellForces.hpp),
// so what it strains is what the particles get: by the cell inside of the soil, by the particles at a surface.
// Cells beside structures come later. Storage is a volume until all is known.
template <int Dim> void PoreWater::addActing(State<Dim>& state, const WetBody<Dim>& wet) {
    auto& system = state.system;
    const auto& body = *wet.body;
    const bool byCells = body.fbar && body.cellAverage.actByCells();
    state.isDone.resize(state.owed.size());
    for (int c = 0; c < system.unknowns; ++c) {
        const int number = system.cells[c].number;
        if (state.isDone[number] = state.solids.isNear(number); state.isDone[number] || !byCells) continue;
        const auto* average = body.cellAverage.occupied(number);
        if (!average || average->inside < 1 || state.fill[number].dry > 0) continue;
        state.isDone[number] = 1; // all of the body is in the soil, and full of water
        system.cells[c].volume += average->share * average->whole;
        system.cells[c].storage += average->share * average->whole;
    }
    for (int p = 0; p < body.particles.size(); ++p)
        for (int point = wet.points.at(p); point < wet.points.at(p) + wet.points.per(p); ++point) {
            if (state.isDone[wet.cell[point]] || !(wet.saturation[p] > 0)) continue;
            const int c = system.cellAt(wet.cell[point]);
            const double own = body.particles.volume.plane()[p] / wet.points.per(p);
            const auto* average = byCells ? body.cellAverage.occupied(wet.cell[point]) : nullptr;
            const double inside = average ? average->inside : 0;
            const double all = average ? average->volume : own; // of the body in the cell
            const double acting =
                inside > 0 ? own / all * (inside * average->share * average->whole + (1 - inside) * all)
                           : own;
            system.cells[c].volume += inside * acting;
            system.cells[c].storage += acting;
            system.cells[c].ofParts += (1 - inside) * acting;
            if (inside < 1)
                forVolumeSlopes(body, p, [&](int node, const Vec<Dim>& slope, double hoop) {
                    system.parts.push_back(
                        {c, node, (1 - inside) * acting * slope, (1 - inside) * acting * hoop});
                });
        }
}

// Ghost nodes behind rollers move as their images before them.
template <int Dim> void PoreWater::mirrorParts(Scene<Dim>& scene, State<Dim>& state) {
    std::map<int, const typename MirrorNodes<Dim>::Image*> images;
    for (const auto& image : scene.state.mirrors.find(scene.grid))
        if (image.field == state.field) images[image.ghost] = &image;
    if (images.empty()) return;
    for (auto& part : state.system.parts)
        if (const auto found = images.find(part.node); found != images.end()) {
            part.node = found->second->node;
            part.flow = part.flow.cwiseProduct(found->second->sign);
            part.hoop *= found->second->sign[0];
        }
}

// That the pressure of a cell beside a structure acts with: the whole one away from the surface of the soil.
template <int Dim>
double PoreWater::actingVolume(const Scene<Dim>& scene, const State<Dim>& state, int number) {
    const Grid<Dim>& grid = scene.grid;
    const double whole = grid.volume(number);
    if (scene.state.sharedCells->isClosed(number))
        for (const auto& wet : state.fill.wet)
            if (const auto* average = wet.body->cellAverage.occupied(number); average && average->inside == 1)
                return whole;
    const auto isFull = [&](int other) {
        return state.fill[other].saturated >
               (PoreFill<Dim>::fullFrom - state.solids.solidPart(other)) * grid.volume(other);
    };
    bool isInside = true;
    forAround(grid, number, [&](int other, int axes) {
        if (axes <= 1) isInside = isInside && isFull(other);
    });
    return isInside ? whole : std::min(whole, state.fill[number].saturated / state.solids.openPart(number));
}

// Who hands on what of the flow, and the volume of the soil that stores water.
template <int Dim> void PoreWater::addHandingCells(const Scene<Dim>& scene, State<Dim>& state) {
    const Grid<Dim>& grid = scene.grid;
    auto& system = state.system;
    if (state.solids.isEmpty()) return;
    std::vector<double> filled(system.unknowns); // part of its room for soil that a cell acts with
    for (int c = 0; c < system.unknowns; ++c) {
        const int number = system.cells[c].number;
        const bool isNear = state.solids.isNear(number);
        if (isNear) system.cells[c].volume = actingVolume(scene, state, number);
        filled[c] = (isNear ? system.cells[c].volume : system.cells[c].storage) / grid.volume(number);
    }
    // Hands on what is not its own, with the room for soil.
    const auto hand = [&](int c) {
        auto& cell = system.cells[c];
        const int number = cell.number;
        const double room = state.solids.openPart(number) * grid.volume(number);
        const double own = state.solids.forTakers(grid, state.fill, number, [&](int other, double part) {
            const int to = system.cellAt(other);
            system.shares.push_back({c, to, part});
            if (c >= system.unknowns) cell.volume += part * filled[to] * grid.volume(number);
            system.cells[to].storage += part * room * filled[c < system.unknowns ? c : to];
        });
        cell.own = own;
        if (c < system.unknowns) cell.storage += cell.own * room * filled[c];
    };
    for (int c = 0; c < system.unknowns; ++c)
        if (state.solids.isNear(system.cells[c].number)) hand(c);
    state.solids.forHanding(grid, state.fill, [&](int number) {
        bool hasTaker = false;
        state.solids.forTakers(grid, state.fill, number, [&](int, double) { hasTaker = true; });
        if (!hasTaker) return;
        system.addHandingCell(grid, number);
        hand(int(system.cells.size()) - 1);
    });
}

// Whether something presses on a face of a cell: its corners are held across it.
template <int Dim> bool PoreWater::isHeld(const Scene<Dim>& scene, int field, int cell, int axis, int side) {
    bool is = true;
    for (int a = 0; a < corners<Dim>; ++a)
        if ((cornerSign(a, axis) > 0) == bool(side))
            is &= scene.grid.fields[field].holder[cornerOf(scene.grid, cell, a)][axis] >= 0;
    return is;
}

// Part of a face of a cell that soil touches: a prism of the volume in the cell, with its middle as far from
// the face.
template <class Cell> double coverOf(const Cell& cell, double way, double area) {
    return cell.saturated < 2 * way * area ? cell.saturated / (2 * way * area) : 1;
}

// Between cells, to the surface and to the faces of the grid (two-point flux).
template <int Dim> void PoreWater::addFlow(const Scene<Dim>& scene, State<Dim>& state) {
    const Grid<Dim>& grid = scene.grid;
    const WaterTable water = tableAt(scene, scene.time);
    auto& system = state.system;
    const double overWeight = 1 / (density * standardGravity);
    for (int c = 0; c < system.unknowns; ++c) {
        const int number = system.cells[c].number;
        const auto& own = state.fill[number];
        const Index<Dim> index = grid.indices(number);
        const Vec<Dim> edges = grid.edges(number);
        for (int k = 0; k < Dim; ++k)
            for (int side = 0; side < 2; ++side) {
                const int at = index[k] - grid.ghost;
                if (side ? at == grid.cells[k] - 1 : at == 0) {
                    addWall(scene, state, water, c, k, side);
                    continue;
                }
                const int beside = number + (side ? 1 : -1) * grid.strides[k], other = system.cellAt(beside);
                if (other >= 0 && !side) continue; // once
                const auto& there = state.fill[beside];
                const double face = grid.line(k, index[k] + side);
                const double area = edges.prod() / edges[k] * grid.thicknessAt(k == 0 ? face : own.centre[0]);
                if (other < 0) {
                    const bool isClosed = sealed || state.fill.isClosed(grid, beside) ||
                                          state.solids.solidPart(beside) > PoreFill<Dim>::fullFrom ||
                                          isHeld(scene, state.field, number, k, side);
                    if (isClosed) continue;
                    const double way =
                        0.5 * std::clamp(own.saturated / grid.volume(number), leastCover, 1.0) * edges[k];
                    Vec<Dim> surface = own.centre;
                    surface[k] += side ? way : -way;
                    const double thickness = grid.thicknessAt(0.5 * (surface[0] + own.centre[0]));
                    const double conductance =
                        own.permeability * overWeight * thickness * edges.prod() / edges[k] / way;
                    const bool isTable = own.dry > 0 || there.dry > 0; // and no surface of the soil
                    const double head = isTable ? own.head : water.head<Dim>(surface);
                    system.outlets.push_back({c, conductance, conductance * (head - own.head), k, side,
                                              thickness * edges.prod() / edges[k]});
                    continue;
                }
                if (state.solids.isBetween(grid, state.fill, number, k)) continue;
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
                    system.faces.push_back(
                        {c, other, conductance, conductance * (own.head - there.head), k, cover * area});
            }
    }
}

// A face of the grid: closed, with a flow, or with water of a level or of the table behind it.
template <int Dim>
void PoreWater::addWall(const Scene<Dim>& scene, State<Dim>& state, const WaterTable& water, int c, int axis,
                        int side) {
    const double face = 2 * axis + side;
    const Grid<Dim>& grid = scene.grid;
    auto& system = state.system;
    const auto& fill = state.fill[system.cells[c].number];
    const Vec<Dim> edges = grid.edges(system.cells[c].number);
    Vec<Dim> x = fill.centre;
    x[axis] = side ? grid.upper[axis] : grid.lower[axis];
    const double across = std::abs(x[axis] - fill.centre[axis]);
    const double whole = edges.prod() / edges[axis]; // of the cell
    const double thickness = std::min(grid.thicknessAt(x[0]), grid.thicknessAt(fill.centre[0]));
    const double length = fill.isInside ? whole : whole * coverOf(fill, across, whole * thickness);
    const double wall = length * grid.thicknessAt(x[0]);
    if (const double* given = atFace(inflows, face); given && wall > 0)
        system.outlets.push_back({c, 0, *given * wall, axis, side, wall});
    const std::vector<double> level = headAt(heads, face, tableTime(scene.time));
    const bool isDrained = std::find(drained.begin(), drained.end(), face) != drained.end();
    if (level.empty() && !isDrained) return;
    const double way = std::max(across, leastCover * edges[axis]);
    const double area = length * grid.thicknessAt(0.5 * (x[0] + fill.centre[0]));
    const double conductance = fill.permeability / (density * standardGravity) * area / way;
    const double head = level.empty() ? water.head<Dim>(x) : water.weight * std::max(level[0], x[Dim - 1]);
    system.outlets.push_back({c, conductance, conductance * (head - fill.head), axis, side, area});
}

// The soil in all cells of a well shares what it takes, by its volume.
template <int Dim> void PoreWater::addWells(State<Dim>& state) {
    std::map<double, double> volumes; // of each well
    const auto forRows = [&](auto&& f) {
        for (size_t i = 0; i + 2 < wells.size(); i += 3)
            if (const int number = int(wells[i + 1]); state.system.cellAt(number) >= 0)
                f(wells[i], state.fill[number].saturated, number, wells[i + 2]);
    };
    forRows([&](double well, double volume, int, double) { volumes[well] += volume; });
    forRows([&](double well, double volume, int number, double flow) {
        state.system.outlets.push_back(
            {state.system.cellAt(number), 0, -flow * volume / volumes[well], -1, 0, 0});
    });
}

// Where the head is above that of a drain.
template <int Dim> void PoreWater::addDrains(const Scene<Dim>& scene, State<Dim>& state) {
    const double weight = tableAt(scene, scene.time).weight;
    for (size_t i = 0; i + 1 < drains.size(); i += 2) {
        const int number = int(drains[i]), c = state.system.cellAt(number);
        if (c < 0) continue;
        const auto& fill = state.fill[number];
        const double head = weight * drains[i + 1] - fill.head;
        if (!(fill.excess > head)) continue;
        const double least = scene.grid.edges(number).minCoeff();
        const double conductance = drainOverCell * fill.permeability / (density * standardGravity) *
                                   fill.saturated / (least * least);
        state.system.outlets.push_back({c, conductance, conductance * head, -1, 0, 0});
    }
}

// Of structures only the nodes that have mass.
template <int Dim> void PoreWater::findMovers(const Scene<Dim>& scene, State<Dim>& state) {
    const double least = scene.leastMass();
    state.movers.clear();
    for (int i = 0; i < int(state.system.nodes.size()); ++i) {
        const int number = state.system.nodes[i].number;
        const auto add = [&](int group, double part) {
            if (part > 0 && scene.grid.fields[group].sum[number][NodalField<Dim>::mass] > least)
                state.movers.push_back({i, group, part});
        };
        if (!state.solids.isShared(number))
            add(state.field, 1);
        else
            for (int group = 0; group < state.solids.groups(); ++group)
                add(group, state.solids.partOf(group, number));
    }
}

// What an impulse changes in the mean velocity of a node. Implicit bodies answer by all of their nodes.
template <int Dim> void PoreWater::setSteps(Scene<Dim>& scene, State<Dim>& state) {
    using NF = NodalField<Dim>;
    auto* const implicit = scene.template role<ImplicitMotion<Dim>>();
    state.response.nodes.clear();
    auto& system = state.system;
    for (auto& node : system.nodes) node.step = Vec<Dim>::Zero();
    system.stiffSteps.clear();
    for (Mover<Dim>& mover : state.movers) {
        auto& node = system.nodes[mover.node];
        const auto& field = scene.grid.fields[mover.group];
        if (implicit && scene.state.implicitNodes.moves(mover.group, node.number)) {
            mover.stiff = int(state.response.nodes.size());
            state.response.nodes.push_back({mover.group, node.number});
        }
        for (int k = 0; k < Dim; ++k)
            if (field.holder[node.number][k] < 0) mover.step[k] = scene.dt / field.sum[node.number][NF::mass];
        if (mover.stiff >= 0) system.stiffSteps.resize(system.nodes.size(), Vec<Dim>::Zero());
        (mover.stiff < 0 ? node.step : system.stiffSteps[mover.node]) += mover.part * mover.part * mover.step;
    }
    if (!state.response.nodes.empty()) {
        implicit->place(state.response);
        state.changes.assign(state.response.nodes.size(), Vec<Dim>::Zero());
        state.impulses = state.changes;
        state.system.respond = [&scene, &state, implicit](const std::vector<double>& acting,
                                                          std::vector<Vec<Dim>>& velocity) {
            findImpulses(scene, state, acting);
            implicit->answer(scene, state.response, state.impulses, state.changes);
            for (const Mover<Dim>& mover : state.movers)
                if (mover.stiff >= 0) velocity[mover.node] += mover.part * state.changes[mover.stiff];
        };
    }
    parallel(scene.threads, [&](ParallelRegion& region) {
        state.matrix.assemble(region, state.system, scene.grid.strides);
    });
}

template void PoreWater::addCells(Scene<2>& scene, State<2>& state);
template void PoreWater::addCells(Scene<3>& scene, State<3>& state);
template void PoreWater::addActing(State<2>& state, const WetBody<2>& wet);
template void PoreWater::addActing(State<3>& state, const WetBody<3>& wet);
template void PoreWater::mirrorParts(Scene<2>& scene, State<2>& state);
template void PoreWater::mirrorParts(Scene<3>& scene, State<3>& state);
template double PoreWater::actingVolume(const Scene<2>& scene, const State<2>& state, int number);
template double PoreWater::actingVolume(const Scene<3>& scene, const State<3>& state, int number);
template void PoreWater::addHandingCells(const Scene<2>& scene, State<2>& state);
template void PoreWater::addHandingCells(const Scene<3>& scene, State<3>& state);
template bool PoreWater::isHeld(const Scene<2>& scene, int field, int cell, int axis, int side);
template bool PoreWater::isHeld(const Scene<3>& scene, int field, int cell, int axis, int side);
template void PoreWater::addFlow(const Scene<2>& scene, State<2>& state);
template void PoreWater::addFlow(const Scene<3>& scene, State<3>& state);
template void PoreWater::addWall(const Scene<2>& scene, State<2>& state, const WaterTable& water, int c,
                                 int axis, int side);
template void PoreWater::addWall(const Scene<3>& scene, State<3>& state, const WaterTable& water, int c,
                                 int axis, int side);
template void PoreWater::addWells(State<2>& state);
template void PoreWater::addWells(State<3>& state);
template void PoreWater::addDrains(const Scene<2>& scene, State<2>& state);
template void PoreWater::addDrains(const Scene<3>& scene, State<3>& state);
template void PoreWater::findMovers(const Scene<2>& scene, State<2>& state);
template void PoreWater::findMovers(const Scene<3>& scene, State<3>& state);
template void PoreWater::setSteps(Scene<2>& scene, State<2>& state);
template void PoreWater::setSteps(Scene<3>& scene, State<3>& state);

} // namespace mpm
