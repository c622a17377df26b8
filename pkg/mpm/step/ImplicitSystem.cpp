// SPDX-License-Identifier: GPL-2.0-or-later
#include "mpm/step/ImplicitSystem.hpp"

#include <algorithm>
#include <functional>

namespace mpm {

template <int Dim> void ImplicitSystem<Dim>::sortNodes(const Grid<Dim>& grid) {
    Index<Dim> first, last;
    first.fill(grid.count);
    last.fill(0);
    for (int node : nodes) {
        const Index<Dim> at = grid.indices(node);
        for (int k = 0; k < Dim; ++k) {
            first[k] = std::min(first[k], at[k]);
            last[k] = std::max(last[k], at[k]);
        }
    }
    int longest = Dim - 1;
    for (int k = 0; k < Dim - 1; ++k)
        if (last[k] - first[k] > last[longest] - first[longest]) longest = k;
    // The highest first: what stands in the ground, and is in contact, comes last, where back-solves are short.
    std::sort(nodes.begin(), nodes.end(), std::greater<int>()); // along the last axis
    if (longest != Dim - 1)
        std::stable_sort(nodes.begin(), nodes.end(),
                         [&](int a, int b) { return grid.indices(a)[longest] > grid.indices(b)[longest]; });
}

template <int Dim>
void ImplicitSystem<Dim>::assemble(const std::vector<const StrainedNodes<Dim>*>& bodies,
                                   const std::vector<int>& number) {
    int span = 0; // of the numbers of the nodes that strain one particle
    for (const auto* body : bodies)
        for (const auto& particle : body->particles) {
            int least = int(nodes.size()), most = 0;
            for (int e = particle.begin; e < particle.end; ++e) {
                least = std::min(least, number[body->entries[e].node]);
                most = std::max(most, number[body->entries[e].node]);
            }
            span = std::max(span, most - least);
        }
    stiffness_.reset(Dim * int(nodes.size()), Dim * span + Dim - 1);
    for (const auto* body : bodies)
        for (const auto& particle : body->particles) add(*body, particle, number);
    for (auto* force : {&atStart_, &weight_}) force->assign(nodes.size(), Vec<Dim>::Zero());
    for (const auto* body : bodies)
        for (const auto& entry : body->entries) {
            atStart_[number[entry.node]] += entry.force;
            weight_[number[entry.node]] += entry.weight;
        }
    for (auto* vector : {&velocity_, &force_, &solved_, &straining_})
        vector->assign(stiffness_.padded(), 0.0);
}

template <int Dim>
void ImplicitSystem<Dim>::add(const StrainedNodes<Dim>& strained,
                              const typename StrainedNodes<Dim>::Strained& particle,
                              const std::vector<int>& number) {
    using Entry = typename StrainedNodes<Dim>::Entry;
    order_.clear(); // by number, so that rows are below columns
    for (int e = particle.begin; e < particle.end; ++e)
        order_.emplace_back(Dim * number[strained.entries[e].node], &strained.entries[e]);
    std::sort(order_.begin(), order_.end(), [](auto& a, auto& b) { return a.first < b.first; });
    const double lambda = particle.lambda, mu = particle.mu;
    for (size_t b = 0; b < order_.size(); ++b) {
        const int column = order_[b].first;
        const Entry& q = *order_[b].second;
        for (size_t a = b; a < order_.size(); ++a) {
            const int row = order_[a].first;
            const Entry& g = *order_[a].second;
            double product = 0, diagonal = 0;
            for (int k = 0; k < Dim; ++k) product += g.g[k] * q.g[k];
            for (int m = 0; m < StrainedNodes<Dim>::patterns; ++m)
                diagonal += particle.control[m] * g.gamma[m] * q.gamma[m];
            diagonal += mu * product;
            for (int j = 0; j < Dim; ++j) {
                double* below = &stiffness_.at(row, column + j);
                for (int i = a == b ? j : 0; i < Dim; ++i)
                    below[i] +=
                        lambda * g.trace[i] * q.trace[j] + mu * g.g[j] * q.g[i] + (i == j ? diagonal : 0.0);
            }
            stiffness_.at(row, column) += 2 * mu * g.hoop * q.hoop;
            if (particle.rows) addBeam(strained, particle, order_[a], order_[b]);
        }
    }
}

template <int Dim>
void ImplicitSystem<Dim>::addBeam(const StrainedNodes<Dim>& strained,
                                  const typename StrainedNodes<Dim>::Strained& particle,
                                  const Numbered& below, const Numbered& above) {
    const auto rowsOf = [&](const Numbered& at) {
        return strained.beamRows[at.second - strained.entries.data()];
    };
    const auto a = rowsOf(below), b = rowsOf(above);
    for (int r = 0; r < particle.rows; ++r)
        for (int j = 0; j < Dim; ++j)
            for (int i = &below == &above ? j : 0; i < Dim; ++i)
                stiffness_.at(below.first + i, above.first + j) +=
                    particle.rowStiffness[r] * a.row[r][i] * b.row[r][j];
}

template <int Dim> bool ImplicitSystem<Dim>::solve(Scene<Dim>& scene, const Vec<Dim>& gravity) {
    NF& nodal = scene.grid.fields[field];
    const double dt = scene.dt, square = dt * dt;
    const int n = unknowns();
    factor_.setScaled(stiffness_, square);
    for (int i = 0; i < n; ++i) {
        const double v = nodal.motion[nodes[i / Dim]][i % Dim];
        velocity_[i] = holderOf(nodal, i) >= 0 ? v : 0;
        solved_[i] = holderOf(nodal, i) >= 0 ? 0 : nodal.sum[nodes[i / Dim]][NF::mass] * v;
    }
    stiffness_.multiply(velocity_.data(), force_.data());
    for (int i = 0; i < n; ++i) {
        factor_.at(i, i) += nodal.sum[nodes[i / Dim]][NF::mass];
        if (holderOf(nodal, i) >= 0)
            factor_.decouple(i);
        else
            solved_[i] -= square * force_[i];
    }
    if (!factor_.factorise()) return false;
    factor_.solve(solved_.data());
    for (int i = 0; i < n; ++i)
        if (holderOf(nodal, i) < 0) velocity_[i] = solved_[i];
    stiffness_.multiply(velocity_.data(), force_.data());
    double gained = 0; // by gravity, beyond the explicit motion
    for (int i = 0; i < n; ++i) {
        if (holderOf(nodal, i) >= 0) {
            react(scene, i, dt * force_[i]);
            continue;
        }
        const double more = velocity_[i] - nodal.motion[nodes[i / Dim]][i % Dim];
        gained += change(scene, gravity, i, more, more / dt);
    }
    scene.energies.gravity += gained * dt;
    return true;
}

template <int Dim>
double ImplicitSystem<Dim>::change(Scene<Dim>& scene, const Vec<Dim>& gravity, int unknown, double v,
                                   double a) const {
    NF& nodal = scene.grid.fields[field];
    const int node = nodes[unknown / Dim], k = unknown % Dim;
    auto& motion = nodal.motion[node];
    motion.set(NF::acceleration + k, motion[NF::acceleration + k] + a);
    motion.set(k, motion[k] + v);
    if (!scene.scheme->remapsSolution()) nodal.setVelocity(node, k, motion[k]);
    return nodal.sum[node][NF::weightMass] * gravity[k] * (v - 0.5 * scene.dt * a);
}

template <int Dim>
void ImplicitSystem<Dim>::place(ImpulseResponse<Dim>& response, int body,
                                const std::vector<int>& number) const {
    for (auto& asked : response.nodes)
        if (asked.field == field && number[asked.node] >= 0) {
            asked.body = body;
            asked.unknown = Dim * number[asked.node];
        }
}

template <int Dim>
void ImplicitSystem<Dim>::start(const Scene<Dim>& scene, ImpulseSweep& sweep, int first, int span) const {
    const NF& nodal = scene.grid.fields[field];
    sweep.start(factor_, first, span, [&](int unknown) { return holderOf(nodal, unknown) >= 0; });
}

template <int Dim>
void ImplicitSystem<Dim>::solveFor(const NF& nodal, const ImpulseResponse<Dim>& response, int body,
                                   const std::vector<Vec<Dim>>& impulses) {
    std::fill(solved_.begin(), solved_.end(), 0.0);
    forUnknowns(nodal, response, body, [&](size_t n, int k, int i) { solved_[i] += impulses[n][k]; });
    factor_.solve(solved_.data());
}

template <int Dim>
void ImplicitSystem<Dim>::answer(const Scene<Dim>& scene, const ImpulseResponse<Dim>& response, int body,
                                 const std::vector<Vec<Dim>>& impulses, std::vector<Vec<Dim>>& changes) {
    const NF& nodal = scene.grid.fields[field];
    solveFor(nodal, response, body, impulses);
    forUnknowns(nodal, response, body, [&](size_t n, int k, int i) { changes[n][k] = solved_[i]; });
}

template <int Dim>
void ImplicitSystem<Dim>::strain(Scene<Dim>& scene, const ImpulseResponse<Dim>& response, int body,
                                 const std::vector<Vec<Dim>>& impulses) {
    NF& nodal = scene.grid.fields[field];
    solveFor(nodal, response, body, impulses);
    for (int i = 0; i < unknowns(); ++i) {
        if (holderOf(nodal, i) >= 0) continue;
        straining_[i] += solved_[i];
        auto& motion = nodal.motion[nodes[i / Dim]];
        motion.set(i % Dim, motion[i % Dim] + solved_[i]);
    }
}

template <int Dim>
void ImplicitSystem<Dim>::take(Scene<Dim>& scene, const Vec<Dim>& gravity,
                               const std::vector<Impulse>& impulses, const std::vector<int>& number) {
    const NF& nodal = scene.grid.fields[field];
    std::fill(solved_.begin(), solved_.end(), 0.0);
    unfelt_.assign(solved_.size(), 0.0);
    for (const Impulse& impulse : impulses)
        for (int k = 0; k < Dim; ++k)
            if (const int i = Dim * number[impulse.node] + k; holderOf(nodal, i) < 0) {
                solved_[i] += impulse.given[k];
                unfelt_[i] += impulse.unfelt[k];
            }
    factor_.solve(solved_.data());
    std::vector<double> force(solved_.size());
    stiffness_.multiply(solved_.data(), force.data());
    double gained = 0;
    for (int i = 0; i < unknowns(); ++i) {
        velocity_[i] += solved_[i];
        force_[i] += force[i];
        if (holderOf(nodal, i) >= 0)
            react(scene, i, scene.dt * force[i]);
        else
            gained += change(scene, gravity, i, solved_[i], (solved_[i] - unfelt_[i]) / scene.dt);
    }
    scene.energies.gravity += gained * scene.dt;
}

// What holds a node feels the elastic forces at the end of the step; GridSolver has told it those at its start.
template <int Dim> void ImplicitSystem<Dim>::react(Scene<Dim>& scene, int unknown, double force) const {
    const NF& nodal = scene.grid.fields[field];
    const int node = nodes[unknown / Dim], k = unknown % Dim, holder = holderOf(nodal, unknown);
    Constraint& constraint = *scene.constraints[holder];
    addReaction<Dim>(scene.grid.nodePosition(node), constraint.centre, k, force, constraint.reaction,
                     constraint.moment);
    constraint.work += force * scene.heldMean(holder, k, NF::velocityAtStart(nodal.sum[node], k)) * scene.dt;
}

// Like backward Euler: the forces at the end of the step do more with velocities at the end, which strain, than with
// the mean ones of the step, and more than their own mean. So they do with what only strains. An implicit body has its
// velocities at the end, so its weight works with these, too.
template <int Dim> void ImplicitSystem<Dim>::addEnergies(Scene<Dim>& scene) {
    const NF& nodal = scene.grid.fields[field];
    const double half = 0.5 * scene.dt * scene.dt;
    double taken = 0, fallen = 0;
    stiffness_.multiply(straining_.data(), solved_.data());
    for (int i = 0; i < unknowns(); ++i) {
        const double a = nodal.motion[nodes[i / Dim]][NF::acceleration + i % Dim];
        const double atEnd = atStart_[i / Dim][i % Dim] - scene.dt * force_[i];
        const double beyond = a + 2 * straining_[i] / scene.dt; // of the mean velocity
        taken += velocity_[i] * force_[i] + beyond * atEnd - straining_[i] * solved_[i];
        fallen += beyond * weight_[i / Dim][i % Dim];
    }
    scene.energies.implicit += half * (taken + fallen);
    scene.energies.gravity += half * fallen;
}

template class ImplicitSystem<2>;
template class ImplicitSystem<3>;

} // namespace mpm
