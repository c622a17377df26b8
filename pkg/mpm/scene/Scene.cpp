// SPDX-License-Identifier: GPL-2.0-or-later
// The loop over engines.
#include "mpm/scene/Scene.hpp"

#include "mpm/base/parallel/relaxed.hpp"
#include "mpm/scene/SharedCells.hpp"

#include <algorithm>
#include <chrono>
#include <numeric>

namespace mpm {

template <int Dim>
Scene<Dim>::Scene(const Vec<Dim>& lower, const Vec<Dim>& upper, const Vec<Dim>& cell)
    : grid(lower, upper, cell) {}

template <int Dim> Scene<Dim>::Scene(const typename Grid<Dim>::Lines& lines) : grid(lines) {}

template <int Dim> Scene<Dim>::~Scene() = default;

template <int Dim> StepState<Dim>::StepState() : sharedCells(std::make_unique<SharedCells<Dim>>()) {}
template <int Dim> StepState<Dim>::~StepState() = default;

template <int Dim> void Scene<Dim>::prepare() {
    require(!bodies.empty(), "Scene: there is no body; add one with scene.add(name, region, material, type)");
    for (const auto& body : bodies)
        require(
            !body->domains->distortion() || !body->type->converts() || body->convertsTo, "body '", body->name,
            "': onDistortion = 'convert', and no body takes over its domains; give it one with convertTo");
    state.driven.clear();
    separateGroups();
    for (auto& field : grid.fields) field.holder.assign(grid.count, NodalField<Dim>::free());
    for (size_t c = 0; c < constraints.size(); ++c) {
        const Constraint& constraint = *constraints[c];
        if (constraint.drivesBody()) body(constraint.body);
        if (!constraint.active) continue;
        for (auto& field : grid.fields)
            for (int node : constraint.nodes)
                for (int k = 0; k < Dim; ++k)
                    if (!std::isnan(constraint.velocity[k])) field.holder[node][k] = short(c);
    }
    state.mirrors.findRollers(grid, constraints);
    state.sharedCells->isWanted = false;
    for (auto& engine : engines) {
        engine->finish();
        engine->prepare(*this);
    }
    require(!engines.empty(), "Scene: there are no engines; leave scene.engines alone for the default chain");
}

// Without an engine for contact all bodies move with one velocity field.
template <int Dim> void Scene<Dim>::separateGroups() {
    const auto separates = [](auto& engine) { return !engine->dead && engine->separatesGroups(); };
    const bool isSeparate = std::any_of(engines.begin(), engines.end(), separates);
    groups.clear();
    for (auto& body : bodies) {
        const std::string group = isSeparate ? body->group : "";
        auto found = std::find(groups.begin(), groups.end(), group);
        if (found == groups.end()) found = groups.insert(groups.end(), group);
        body->velocityField = int(found - groups.begin());
    }
    groupOf.resize(groups.size());
    std::iota(groupOf.begin(), groupOf.end(), 0);
    state.parted.find(*this);
    grid.setFields(groupOf);
}

template <int Dim> void Scene<Dim>::actAlone(Engine& engine) {
    if (engine.dead) return;
    if (engine.isStage() && !state.located) {
        const auto first = std::find_if(engines.begin(), engines.end(), [](auto& e) { return e->isStage(); });
        require(
            first != engines.end() && first->get() == &engine, "Scene: ", engine.className(),
            " cannot act before ParticleToGrid has found the particles in the grid, once in every step; do "
            "not leave that out (dead), and act in the order of scene.engines");
    }
    using Clock = std::chrono::steady_clock;
    const auto begin = Clock::now();
    for (auto& body : bodies) body->domains->step = step;
    engine.action(*this);
    storeRelaxed(engine.seconds,
                 engine.seconds + std::chrono::duration<double>(Clock::now() - begin).count());
    storeRelaxed(engine.calls, engine.calls + 1);
}

template <int Dim> void Scene<Dim>::endStep(double newTime) {
    for (auto& constraint : constraints) constraint->stepped(dt, newTime);
    for (auto& engine : engines)
        if (!engine->dead) engine->stepped(dt);
    state.located = false;
    storeRelaxed(time, newTime);
    storeRelaxed(step, step + 1);
}

template <int Dim> long Scene<Dim>::advance(long steps, double seconds) {
    using Clock = std::chrono::steady_clock;
    const auto since = [](Clock::time_point t) {
        return std::chrono::duration<double>(Clock::now() - t).count();
    };
    const auto start = Clock::now();
    size_t lastStage = 0; // the clock moves on after it, so that callbacks at the end see the new time
    for (size_t e = 0; e < engines.size(); ++e)
        if (engines[e]->isStage() && !engines[e]->dead) lastStage = e;
    long taken = 0;
    std::vector<ThreadUse*> uses;
    for (auto& engine : engines) uses.push_back(&engine->use);
    ThreadPool::during(threads, uses, [&] {
        for (; taken < steps; ++taken) {
            if (taken > 0 && since(start) >= seconds) break;
            for (size_t e = 0; e < engines.size(); ++e) {
                Engine& engine = *engines[e];
                ThreadPool::countFor(int(e));
                const auto tick = [&] {
                    if (e == lastStage) endStep(time + dt);
                };
                try {
                    actAlone(engine);
                } catch (...) { // what ends a step at its last stage (a distorted domain) has made all of it
                    tick();
                    throw;
                }
                tick();
            }
        }
        ThreadPool::countFor(int(engines.size())); // none: threads that end are no work of the last one
    });
    return taken;
}

template struct StepState<2>;
template struct StepState<3>;
template class Scene<2>;
template class Scene<3>;

} // namespace mpm
