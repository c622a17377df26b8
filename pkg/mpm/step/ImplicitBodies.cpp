// SPDX-License-Identifier: GPL-2.0-or-later
// Threads share what is one by one, the particles; all sums are made by one, so that the bits are the same for any
// number.
#include "mpm/step/ImplicitBodies.hpp"

#include "mpm/step/GridSolver.hpp"

#include <atomic>

namespace mpm {

std::string ImplicitBodies::doc() const {
    return "Lets the elastic forces of implicit bodies at the end of the step enter the solution on the nodes: "
           "their\n"
           "stiffness does not limit the time step.\n\n"
           "(M + dt^2 K) v = p + dt f on the nodes of the bodies with scene.add(..., implicit=True), K their "
           "elastic\n"
           "stiffness. The scene puts it behind GridSolver. See doc/explanation/implicit-bodies.md.";
}

template <int Dim> void ImplicitBodies::check(Scene<Dim>& scene) {
    if (dead) return;
    for (const auto& body : scene.bodies) {
        if (!body->isImplicit) continue;
        require(!scene.scheme->stressFirst, "body '", body->name, "': implicit=True has no meaning under ",
                scene.scheme->name, ", which updates the stress before the solution; give scheme='MUSL'");
        require(
            !body->fbar, "body '", body->name,
            "': implicit=True with fbar=True is not possible, for the stiffness of cell-wise strains is not "
            "known to the solution; give fbar=False (True is the default of a material that yields), or leave "
            "implicit out");
    }
}

// Room for all nodes, without what the step before left in it.
template <int Dim> void ImplicitBodies::clear(const Scene<Dim>& scene, State<Dim>& state) {
    state.scratch.resize(scene.grid.count, -1);
    state.velocity.resize(scene.grid.fields.size());
    for (auto& velocity : state.velocity)
        velocity.resize(scene.grid.count, NodalField<Dim>::Velocity::zero());
    state.owner.resize(scene.grid.fields.size());
    for (auto& owner : state.owner) owner.resize(scene.grid.count, -1);
    for (auto& system : state.systems)
        for (int node : system.nodes) state.owner[system.field][node] = -1;
    state.spare.swap(state.systems); // for their memory
    state.systems.clear();
}

// Of each piece of a body, the first one that it shares nodes with, over others.
template <int Dim> std::vector<int> ImplicitBodies::groups(int fields, State<Dim>& state) {
    const auto& pieces = state.pieces;
    std::vector<int> group(pieces.size());
    for (size_t i = 0; i < pieces.size(); ++i) group[i] = int(i);
    for (int field = 0; field < fields; ++field) {
        const auto forEntries = [&](auto&& f) {
            for (size_t i = 0; i < pieces.size(); ++i)
                if (pieces[i].body->velocityField == field)
                    for (const auto& entry : pieces[i].strained.entries) f(int(i), entry.node);
        };
        forEntries([&](int i, int node) {
            int& owner = state.scratch[node];
            if (owner < 0) owner = i;
            if (group[owner] == group[i]) return;
            const int from = std::max(group[owner], group[i]), to = std::min(group[owner], group[i]);
            for (int& g : group)
                if (g == from) g = to;
        });
        forEntries([&](int, int node) { state.scratch[node] = -1; });
    }
    return group;
}

// The system of some pieces of bodies, which move with one velocity field.
template <int Dim>
void ImplicitBodies::addSystem(const Grid<Dim>& grid, int field,
                               const std::vector<StrainedNodes<Dim>*>& members, State<Dim>& state) {
    const size_t number = state.systems.size();
    ImplicitSystem<Dim>& system = state.systems.emplace_back();
    if (number < state.spare.size()) system = std::move(state.spare[number]);
    system.reset(field);
    for (auto* member : members) {
        system.addMember(*member);
        for (const auto& entry : member->entries)
            if (state.scratch[entry.node] < 0) {
                state.scratch[entry.node] = 0;
                system.nodes.push_back(entry.node);
            }
    }
    system.sortNodes(grid);
    withNumbers(state, system, [&] { system.place(state.scratch); });
    for (int node : system.nodes) state.owner[field][node] = int(number);
}

// f() while scratch has the numbers of the nodes of a system.
template <int Dim, class F>
void ImplicitBodies::withNumbers(State<Dim>& state, const ImplicitSystem<Dim>& system, F&& f) {
    for (size_t i = 0; i < system.nodes.size(); ++i) state.scratch[system.nodes[i]] = int(i);
    f();
    for (int node : system.nodes) state.scratch[node] = -1;
}

// Whether an implicit body moves with a velocity field.
template <int Dim> bool hasBodies(const Scene<Dim>& scene, int field) {
    return std::any_of(scene.bodies.begin(), scene.bodies.end(),
                       [&](auto& body) { return body->isImplicit && body->velocityField == field; });
}

// Cuts the bodies into pieces, each of which one thread looks at.
template <int Dim> void ImplicitBodies::cut(Scene<Dim>& scene, State<Dim>& state) {
    constexpr int most = 32; // particles; few enough that small bodies keep two threads busy
    size_t count = 0;
    for (auto& body : scene.bodies)
        for (int begin = 0; body->isImplicit && begin < body->particles.size(); begin += most) {
            if (state.pieces.size() == count) state.pieces.emplace_back();
            auto& piece = state.pieces[count++];
            piece.body = body.get();
            piece.begin = begin;
            piece.end = std::min(begin + most, body->particles.size());
        }
    state.pieces.resize(count);
}

// Finds what strains a piece.
template <int Dim>
void ImplicitBodies::look(const Scene<Dim>& scene, const RigidRows<Dim>& rows, double least,
                          Piece<Dim>& piece) {
    const auto& nodal = scene.grid.fields[piece.body->velocityField];
    piece.strained.find(
        *piece.body, piece.begin, piece.end, gravityOf(scene),
        [&](int p) { return !rows.moveRigidly(scene.grid, *piece.body, p); },
        [&](int node) { return nodal.sum[node][NodalField<Dim>::mass] > least; });
}

// What shares a node belongs to one system.
template <int Dim> void ImplicitBodies::findSystems(Scene<Dim>& scene, State<Dim>& state) {
    const std::vector<int> group = groups(int(scene.grid.fields.size()), state);
    std::vector<std::vector<StrainedNodes<Dim>*>> members(group.size());
    for (size_t i = 0; i < group.size(); ++i)
        if (!state.pieces[i].strained.entries.empty()) members[group[i]].push_back(&state.pieces[i].strained);
    for (size_t first = 0; first < group.size(); ++first)
        if (!members[first].empty())
            addSystem(scene.grid, state.pieces[first].body->velocityField, members[first], state);
}

// Threads take the pieces as they come, and the one that does the last piece goes on with the solution. Another one
// does meanwhile what it can of the next engine.
template <int Dim> void ImplicitBodies::act(Scene<Dim>& scene) {
    State<Dim>& state = std::get<State<Dim>>(states_);
    cut(scene, state);
    clear(scene, state);
    const int count = int(state.pieces.size());
    if (count == 0) return;
    const double least = scene.leastMass();
    state.rigidRows.resize(scene.grid.fields.size());
    for (size_t f = 0; f < scene.grid.fields.size(); ++f)
        if (hasBodies(scene, int(f))) state.rigidRows[f].find(scene.grid, scene.grid.fields[f], least);
    auto* const next = scene.threads > 1 ? scene.template next<LookingAhead>(*this) : nullptr;
    WorkPartition each;
    each.set(scene.threads, [](int) { return 1.0; });
    std::atomic<int> begun{0}, done{0};
    parallel(scene.threads, [&](ParallelRegion& region) {
        region.forPieces(each, [&](int thread) {
            if (next && thread == scene.threads - 1) next->lookAhead(scene);
            for (int i = begun++; i < count; i = begun++) {
                auto& piece = state.pieces[i];
                look(scene, state.rigidRows[piece.body->velocityField], least, piece);
                if (++done == count) solve(scene, state);
            }
        });
    });
}

template <int Dim> void ImplicitBodies::solve(Scene<Dim>& scene, State<Dim>& state) {
    findSystems(scene, state);
    const Vec<Dim> gravity = gravityOf(scene);
    for (auto& system : state.systems)
        if (!system.solve(scene, gravity))
            throw RunError(
                message("step ", scene.step,
                        ": the equations of the implicit bodies cannot be solved, their stiffness is "
                        "not finite or negative; look at the last frames for a body that breaks, or "
                        "lower dt"));
}

template <int Dim> bool ImplicitBodies::moves(int field, int node) const {
    const auto& owner = std::get<State<Dim>>(states_).owner;
    return owner[field][node] >= 0;
}

template <int Dim> void ImplicitBodies::place(ImpulseResponse<Dim>& response) {
    State<Dim>& state = std::get<State<Dim>>(states_);
    response.bodies.resize(state.systems.size());
    for (size_t s = 0; s < state.systems.size(); ++s)
        withNumbers(state, state.systems[s],
                    [&] { state.systems[s].place(response, int(s), state.scratch); });
}

template <int Dim>
void ImplicitBodies::start(const Scene<Dim>& scene, ImpulseResponse<Dim>& response, int span) {
    auto& systems = std::get<State<Dim>>(states_).systems;
    for (size_t s = 0; s < systems.size(); ++s) {
        int first = systems[s].unknowns();
        for (const auto& asked : response.nodes)
            if (asked.body == int(s)) first = std::min(first, asked.unknown);
        if (first < systems[s].unknowns()) systems[s].start(scene, response.bodies[s], first, span);
    }
}

template <int Dim>
void ImplicitBodies::answer(const Scene<Dim>& scene, const ImpulseResponse<Dim>& response,
                            const std::vector<Vec<Dim>>& impulses, std::vector<Vec<Dim>>& changes) {
    auto& systems = std::get<State<Dim>>(states_).systems;
    for (size_t s = 0; s < systems.size(); ++s) systems[s].answer(scene, response, int(s), impulses, changes);
}

template <int Dim>
void ImplicitBodies::strain(Scene<Dim>& scene, const ImpulseResponse<Dim>& response,
                            const std::vector<Vec<Dim>>& impulses) {
    auto& systems = std::get<State<Dim>>(states_).systems;
    for (size_t s = 0; s < systems.size(); ++s) systems[s].strain(scene, response, int(s), impulses);
}

template <int Dim>
void ImplicitBodies::take(Scene<Dim>& scene, const ImpulseResponse<Dim>& response,
                          const std::vector<Vec<Dim>>& given, const std::vector<Vec<Dim>>& unfelt) {
    State<Dim>& state = std::get<State<Dim>>(states_);
    const Vec<Dim> gravity = gravityOf(scene);
    for (auto& system : state.systems) {
        std::vector<typename ImplicitSystem<Dim>::Impulse> impulses;
        for (size_t i = 0; i < response.nodes.size(); ++i) {
            const auto& asked = response.nodes[i];
            if (&system == &state.systems[asked.body]) impulses.push_back({asked.node, given[i], unfelt[i]});
        }
        if (impulses.empty()) continue;
        withNumbers(state, system, [&] { system.take(scene, gravity, impulses, state.scratch); });
    }
}

template <int Dim> void ImplicitBodies::strainNeighbours(Scene<Dim>& scene) const {
    for (const auto& system : std::get<State<Dim>>(states_).systems) {
        if (!mixesImplicit(scene, system.field)) continue;
        auto& field = scene.grid.fields[system.field];
        for (int node : system.nodes)
            for (int k = 0; k < Dim; ++k) field.setVelocity(node, k, field.motion[node][k]);
    }
}

template <int Dim> void ImplicitBodies::finishMotion(Scene<Dim>& scene) {
    State<Dim>& state = std::get<State<Dim>>(states_);
    for (auto& system : state.systems) system.addEnergies(scene);
    for (size_t f = 0; f < scene.grid.fields.size(); ++f) {
        if (!hasBodies(scene, int(f))) continue;
        const auto& field = scene.grid.fields[f];
        for (int slab = 0; slab < scene.grid.slabs(); ++slab)
            scene.grid.forNodes(field, slab, [&](int node) {
                for (int k = 0; k < Dim; ++k) state.velocity[f][node].set(k, field.motion[node][k]);
            });
    }
}

template void ImplicitBodies::strainNeighbours(Scene<2>&) const;
template void ImplicitBodies::strainNeighbours(Scene<3>&) const;
template void ImplicitBodies::finishMotion(Scene<2>&);
template void ImplicitBodies::finishMotion(Scene<3>&);
template bool ImplicitBodies::moves<2>(int, int) const;
template bool ImplicitBodies::moves<3>(int, int) const;
template void ImplicitBodies::place(ImpulseResponse<2>&);
template void ImplicitBodies::place(ImpulseResponse<3>&);
template void ImplicitBodies::start(const Scene<2>&, ImpulseResponse<2>&, int);
template void ImplicitBodies::start(const Scene<3>&, ImpulseResponse<3>&, int);
template void ImplicitBodies::answer(const Scene<2>&, const ImpulseResponse<2>&, const std::vector<Vec<2>>&,
                                     std::vector<Vec<2>>&);
template void ImplicitBodies::answer(const Scene<3>&, const ImpulseResponse<3>&, const std::vector<Vec<3>>&,
                                     std::vector<Vec<3>>&);
template void ImplicitBodies::strain(Scene<2>&, const ImpulseResponse<2>&, const std::vector<Vec<2>>&);
template void ImplicitBodies::strain(Scene<3>&, const ImpulseResponse<3>&, const std::vector<Vec<3>>&);
template void ImplicitBodies::take(Scene<2>&, const ImpulseResponse<2>&, const std::vector<Vec<2>>&,
                                   const std::vector<Vec<2>>&);
template void ImplicitBodies::take(Scene<3>&, const ImpulseResponse<3>&, const std::vector<Vec<3>>&,
                                   const std::vector<Vec<3>>&);

MPM_REGISTER(Engine, ImplicitBodies);

} // namespace mpm
