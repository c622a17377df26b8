// SPDX-License-Identifier: GPL-2.0-or-later
// Threads share what is one by one, the particles; all sums are made by one, so that the bits are the same for any
// number.
#include "mpm/step/ImplicitBodies.hpp"

#include <atomic>
#include <numeric>

namespace mpm {

std::string ImplicitBodies::doc() const {
    return "Lets the elastic forces of implicit bodies at the end of the step enter the solution on the nodes: "
           "their\n"
           "stiffness does not limit the time step.\n\n"
           "(M + dt^2 K) v = p + dt f on the nodes of the bodies with scene.add(..., implicit=True), K their "
           "elastic\n"
           "stiffness. The scene puts it behind GridSolver. See doc/explanation/implicit-bodies.md.";
}

template <int Dim> void ImplicitSolution<Dim>::check(const Scene<Dim>& scene) {
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
template <int Dim> void ImplicitSolution<Dim>::clear(Scene<Dim>& scene) {
    scratch_.resize(scene.grid.count, -1);
    scene.state.implicitNodes.reset(scene.grid.fields.size(), scene.grid.count);
    spare_.swap(systems_); // for their memory
    systems_.clear();
}

// Of each piece of a body, the first one that it shares nodes with, over others.
template <int Dim> std::vector<int> ImplicitSolution<Dim>::groups(int fields) {
    std::vector<int> group(pieces_.size());
    std::iota(group.begin(), group.end(), 0);
    for (int field = 0; field < fields; ++field) {
        const auto forEntries = [&](auto&& f) {
            for (size_t i = 0; i < pieces_.size(); ++i)
                if (pieces_[i].body->velocityField == field)
                    for (const auto& entry : pieces_[i].strained.entries) f(int(i), entry.node);
        };
        forEntries([&](int i, int node) {
            int& owner = scratch_[node];
            if (owner < 0) owner = i;
            if (group[owner] == group[i]) return;
            const int from = std::max(group[owner], group[i]), to = std::min(group[owner], group[i]);
            for (int& g : group)
                if (g == from) g = to;
        });
        forEntries([&](int, int node) { scratch_[node] = -1; });
    }
    return group;
}

// The system of some pieces of bodies, which move with one velocity field.
template <int Dim>
void ImplicitSolution<Dim>::addSystem(Scene<Dim>& scene, int field,
                                      const std::vector<StrainedNodes<Dim>*>& members) {
    const size_t number = systems_.size();
    ImplicitSystem<Dim>& system = systems_.emplace_back();
    if (number < spare_.size()) system = std::move(spare_[number]);
    system.reset(field);
    for (auto* member : members) {
        system.addMember(*member);
        for (const auto& entry : member->entries)
            if (scratch_[entry.node] < 0) {
                scratch_[entry.node] = 0;
                system.nodes.push_back(entry.node);
            }
    }
    system.sortNodes(scene.grid);
    withNumbers(system, [&] { system.place(scratch_); });
    for (int node : system.nodes) scene.state.implicitNodes.setMoved(field, node);
}

// f() while scratch has the numbers of the nodes of a system.
template <int Dim>
template <class F>
void ImplicitSolution<Dim>::withNumbers(const ImplicitSystem<Dim>& system, F&& f) {
    for (size_t i = 0; i < system.nodes.size(); ++i) scratch_[system.nodes[i]] = int(i);
    f();
    for (int node : system.nodes) scratch_[node] = -1;
}

// Whether an implicit body moves with a velocity field.
template <int Dim> bool hasBodies(const Scene<Dim>& scene, int field) {
    return std::any_of(scene.bodies.begin(), scene.bodies.end(),
                       [&](auto& body) { return body->isImplicit && body->velocityField == field; });
}

// Cuts the bodies into pieces, each of which one thread looks at.
template <int Dim> void ImplicitSolution<Dim>::cut(Scene<Dim>& scene) {
    constexpr int most = 32; // particles; few enough that small bodies keep two threads busy
    size_t count = 0;
    for (auto& body : scene.bodies)
        for (int begin = 0; body->isImplicit && begin < body->particles.size(); begin += most) {
            if (pieces_.size() == count) pieces_.emplace_back();
            Piece& piece = pieces_[count++];
            piece.body = body.get();
            piece.begin = begin;
            piece.end = std::min(begin + most, body->particles.size());
        }
    pieces_.resize(count);
}

// Finds what strains a piece.
template <int Dim>
void ImplicitSolution<Dim>::look(const Scene<Dim>& scene, const RigidRows<Dim>& rows, double least,
                                 Piece& piece) {
    const auto& nodal = scene.grid.fields[piece.body->velocityField];
    piece.strained.find(
        *piece.body, piece.begin, piece.end, gravityOf(scene),
        [&](int p) { return !rows.moveRigidly(scene.grid, *piece.body, p); },
        [&](int node) { return nodal.sum[node][NodalField<Dim>::mass] > least; });
}

// What shares a node belongs to one system.
template <int Dim> void ImplicitSolution<Dim>::findSystems(Scene<Dim>& scene) {
    const std::vector<int> group = groups(int(scene.grid.fields.size()));
    std::vector<std::vector<StrainedNodes<Dim>*>> members(group.size());
    for (size_t i = 0; i < group.size(); ++i)
        if (!pieces_[i].strained.entries.empty()) members[group[i]].push_back(&pieces_[i].strained);
    for (size_t first = 0; first < group.size(); ++first)
        if (!members[first].empty()) addSystem(scene, pieces_[first].body->velocityField, members[first]);
}

// Threads take the pieces as they come, and the one that does the last piece goes on with the solution. Another one
// does meanwhile what it can of the next engine.
template <int Dim> void ImplicitSolution<Dim>::find(Scene<Dim>& scene, LookingAhead* next) {
    cut(scene);
    clear(scene);
    const int count = int(pieces_.size());
    if (count == 0) return;
    const double least = scene.leastMass();
    rigidRows_.resize(scene.grid.fields.size());
    for (size_t f = 0; f < scene.grid.fields.size(); ++f)
        if (hasBodies(scene, int(f))) rigidRows_[f].find(scene.grid, scene.grid.fields[f], least);
    WorkPartition each;
    each.set(scene.threads, [](int) { return 1.0; });
    std::atomic<int> begun{0}, done{0};
    parallel(scene.threads, [&](ParallelRegion& region) {
        region.forPieces(each, [&](int thread) {
            if (next && thread == scene.threads - 1) next->lookAhead(scene);
            for (int i = begun++; i < count; i = begun++) {
                Piece& piece = pieces_[i];
                look(scene, rigidRows_[piece.body->velocityField], least, piece);
                if (++done == count) solve(scene);
            }
        });
    });
}

template <int Dim> void ImplicitSolution<Dim>::solve(Scene<Dim>& scene) {
    findSystems(scene);
    const Vec<Dim> gravity = gravityOf(scene);
    for (auto& system : systems_)
        if (!system.solve(scene, gravity))
            throw RunError(
                message("step ", scene.step,
                        ": the equations of the implicit bodies cannot be solved, their stiffness is "
                        "not finite or negative; look at the last frames for a body that breaks, or "
                        "lower dt"));
}

template <int Dim> void ImplicitSolution<Dim>::place(ImpulseResponse<Dim>& response) {
    response.bodies.resize(systems_.size());
    for (size_t s = 0; s < systems_.size(); ++s)
        withNumbers(systems_[s], [&] { systems_[s].place(response, int(s), scratch_); });
}

template <int Dim>
void ImplicitSolution<Dim>::start(const Scene<Dim>& scene, ImpulseResponse<Dim>& response, int span) {
    for (size_t s = 0; s < systems_.size(); ++s) {
        int first = systems_[s].unknowns();
        for (const auto& asked : response.nodes)
            if (asked.body == int(s)) first = std::min(first, asked.unknown);
        if (first < systems_[s].unknowns()) systems_[s].start(scene, response.bodies[s], first, span);
    }
}

template <int Dim>
void ImplicitSolution<Dim>::answer(const Scene<Dim>& scene, const ImpulseResponse<Dim>& response,
                                   const Vectors& impulses, Vectors& changes) {
    for (size_t s = 0; s < systems_.size(); ++s)
        systems_[s].answer(scene, response, int(s), impulses, changes);
}

template <int Dim>
void ImplicitSolution<Dim>::strain(Scene<Dim>& scene, const ImpulseResponse<Dim>& response,
                                   const Vectors& impulses) {
    for (size_t s = 0; s < systems_.size(); ++s) systems_[s].strain(scene, response, int(s), impulses);
}

template <int Dim>
void ImplicitSolution<Dim>::take(Scene<Dim>& scene, const ImpulseResponse<Dim>& response,
                                 const Vectors& given, const Vectors& unfelt) {
    const Vec<Dim> gravity = gravityOf(scene);
    for (auto& system : systems_) {
        std::vector<typename ImplicitSystem<Dim>::Impulse> impulses;
        for (size_t i = 0; i < response.nodes.size(); ++i) {
            const auto& asked = response.nodes[i];
            if (&system == &systems_[asked.body]) impulses.push_back({asked.node, given[i], unfelt[i]});
        }
        if (impulses.empty()) continue;
        withNumbers(system, [&] { system.take(scene, gravity, impulses, scratch_); });
    }
}

template <int Dim> void ImplicitSolution<Dim>::strainNeighbours(Scene<Dim>& scene) const {
    for (const auto& system : systems_) {
        if (!mixesImplicit(scene, system.field)) continue;
        auto& field = scene.grid.fields[system.field];
        for (int node : system.nodes)
            for (int k = 0; k < Dim; ++k) field.setVelocity(node, k, field.motion[node][k]);
    }
}

template <int Dim> void ImplicitSolution<Dim>::finishMotion(Scene<Dim>& scene) {
    for (auto& system : systems_) system.addEnergies(scene);
    for (size_t f = 0; f < scene.grid.fields.size(); ++f) {
        if (!hasBodies(scene, int(f))) continue;
        const auto& field = scene.grid.fields[f];
        for (int slab = 0; slab < scene.grid.slabs(); ++slab)
            scene.grid.forNodes(field, slab, [&](int node) {
                for (int k = 0; k < Dim; ++k)
                    scene.state.implicitNodes.setVelocity(int(f), node, k, field.motion[node][k]);
            });
    }
}

template class ImplicitSolution<2>;
template class ImplicitSolution<3>;

MPM_REGISTER(Engine, ImplicitBodies);

} // namespace mpm
