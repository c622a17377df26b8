// SPDX-License-Identifier: GPL-2.0-or-later
// What particles get from the balance of water: pressure, flow, and the body force of the reference pressure.
#include "mpm/step/PoreWater.hpp"

#include <algorithm>
#include <cmath>

namespace mpm {

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

template <int Dim>
PoreWater::InCell<Dim> PoreWater::inCell(const Scene<Dim>& scene, const State<Dim>& state, int c) const {
    const int number = state.system.cells[c].number;
    const auto& speeds = state.system.speeds[c];
    const Vec<Dim> edges = scene.grid.edges(number), slope = slopeOf(scene, state, c),
                   lower = scene.grid.centre(scene.grid.indices(number)) - 0.5 * edges,
                   gain = (speeds[1] - speeds[0]).cwiseQuotient(edges);
    return {state.excess[c] - slope.dot(state.fill[number].centre), slope,
            speeds[0] - gain.cwiseProduct(lower), gain};
}

template <int Dim> void PoreWater::giveToParticles(Scene<Dim>& scene, State<Dim>& state) {
    const WaterTable end = tableAt(scene, scene.time + scene.dt);
    state.system.findSpeeds(state.excess);
    state.inCells.resize(state.system.unknowns);
    const auto give = [&](WetBody<Dim>& wet, int p) {
        const Vec<Dim> x = vectorAt<Dim>(wet.body->particles.position, p);
        double excess = 0;
        const int first = wet.points.at(p), count = wet.points.per(p);
        for (int point = first; point < first + count; ++point) {
            const auto& in = state.inCells[state.system.cellAt(wet.cell[point])];
            excess += in.excess + in.slope.dot(x);
        }
        wet.pressure[p] = excess / count + end.pressure<Dim>(x);
        auto& particles = wet.body->particles;
        const Vec<Dim> lift =
            particles.initialVolume.plane()[p] / particles.mass.plane()[p] * buoyancy(scene, end, x);
        for (int k = 0; k < Dim; ++k) particles.bodyForce.plane(k)[p] = lift[k];
        const auto& in = state.inCells[state.system.cellAt(wet.cell[first])];
        const Vec<Dim> flow = in.flow + in.gain.cwiseProduct(x);
        for (int k = 0; k < Dim; ++k) wet.flow[k][p] = flow[k];
    };
    parallel(scene.threads, [&](ParallelRegion& region) {
        region.chunks(state.system.unknowns, [&](int begin, int end) {
            for (int c = begin; c < end; ++c) state.inCells[c] = inCell(scene, state, c);
        });
        for (auto& wet : state.fill.wet)
            region.chunksNoWait(wet.body->particles.size(), [&](int begin, int last) {
                if (end.isLevel() && !wet.points.isInParts())
                    return giveBelowLevel(state, wet, end, begin, last);
                for (int p = begin; p < last; ++p)
                    if (wet.saturation[p] > 0) give(wet, p);
            });
    });
}

// The same below a level table, for particles that lie in one cell each.
template <int Dim>
void PoreWater::giveBelowLevel(const State<Dim>& state, WetBody<Dim>& wet, const WaterTable& water, int begin,
                               int end) {
    auto& particles = wet.body->particles;
    const double *const volume = particles.initialVolume.plane(), *const mass = particles.mass.plane();
    std::array<const double*, Dim> x;
    std::array<double*, Dim> force, flow = wet.flow;
    for (int k = 0; k < Dim; ++k) {
        x[k] = particles.position.plane(k);
        force[k] = particles.bodyForce.plane(k);
    }
    const double level = water.level<Dim>(Vec<Dim>::Zero()), weight = water.weight;
    const int* const cell = wet.cell.data();
    for (int p = begin; p < end; ++p) {
        if (!(wet.saturation[p] > 0)) continue;
        const auto& in = state.inCells[state.system.cellAt(cell[p])];
        double pressure = in.excess;
        for (int k = 0; k < Dim; ++k) {
            pressure += in.slope[k] * x[k][p];
            flow[k][p] = in.flow[k] + in.gain[k] * x[k][p];
            force[k][p] = 0;
        }
        const double below = weight > 0 ? weight * std::max(0.0, level - x[Dim - 1][p]) : 0;
        wet.pressure[p] = pressure + below;
        force[Dim - 1][p] = below > 0 ? volume[p] / mass[p] * weight : 0;
    }
}

// Water has the reference pressure around all that is below the table: soil that is full of it, and what has
// no water. areWet: of the former, too, which otherwise has it from giveToParticles().
template <int Dim> void PoreWater::liftAll(Scene<Dim>& scene, double time, bool areWet) {
    const WaterTable water = tableAt(scene, time);
    for (auto& body : scene.bodies) {
        const bool isWet = PoreState::in(body->particles) >= 0;
        if (isWet ? areWet : !table.empty()) lift(scene, *body, water);
    }
}

// On soil that is full of water, kN/m3: the reference pressure, and what the slope of the table drives.
template <int Dim>
Vec<Dim> PoreWater::buoyancy(const Scene<Dim>& scene, const WaterTable& water, const Vec<Dim>& x) {
    Vec<Dim> force = Vec<Dim>::Zero();
    if (!(water.pressure<Dim>(x) > 0)) return force;
    force[Dim - 1] = water.weight;
    if (water.isLevel()) return force;
    const double h = scene.grid.smallestCell()[0];
    Vec<Dim> before = x, beyond = x;
    before[0] -= 0.5 * h;
    beyond[0] = before[0] + h;
    force[0] -= water.weight * ((water.level<Dim>(beyond) - water.level<Dim>(before)) / h);
    return force;
}

// Buoyancy, and what the slope of the table drives: the body force of the reference pressure, m/s2. In a body
// without water it is that of the faces of each domain, taken as a square: in a row of them the pressures at
// its ends are left.
template <int Dim> void PoreWater::lift(const Scene<Dim>& scene, Body<Dim>& body, const WaterTable& water) {
    auto& particles = body.particles;
    particles.needBodyForce();
    const double* const saturation =
        PoreState::in(particles) >= 0 ? WetBody<Dim>(body).saturation : nullptr; // else all is below
    const auto across = [&](Vec<Dim> x, int k, double width) {
        x[k] -= 0.5 * width;
        const double before = water.pressure<Dim>(x);
        x[k] += width;
        return (water.pressure<Dim>(x) - before) / width;
    };
    const auto liftOne = [&](int p) {
        const Vec<Dim> x = vectorAt<Dim>(particles.position, p);
        const double volume = particles.initialVolume.plane()[p];
        Vec<Dim> force = Vec<Dim>::Zero();
        if (!saturation) {
            const double width = std::pow(volume / scene.grid.thicknessAt(x[0]), 1.0 / Dim);
            for (int k : {0, Dim - 1}) force[k] = -across(x, k, width);
        } else if (saturation[p] > 0)
            force = buoyancy(scene, water, x);
        force *= volume / particles.mass.plane()[p];
        for (int k = 0; k < Dim; ++k) particles.bodyForce.plane(k)[p] = force[k];
    };
    parallel(scene.threads, [&](ParallelRegion& region) {
        region.chunks(particles.size(), [&](int begin, int end) {
            for (int p = begin; p < end; ++p) liftOne(p);
        });
    });
}

template void PoreWater::giveToParticles(Scene<2>& scene, State<2>& state);
template void PoreWater::liftAll(Scene<2>& scene, double time, bool areWet);
template void PoreWater::giveToParticles(Scene<3>& scene, State<3>& state);
template void PoreWater::liftAll(Scene<3>& scene, double time, bool areWet);

} // namespace mpm
