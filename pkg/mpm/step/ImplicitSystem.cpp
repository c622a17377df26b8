// SPDX-License-Identifier: GPL-2.0-or-later
#include "mpm/step/ImplicitSystem.hpp"

#include "mpm/step/ImplicitIteration.hpp"
#include "mpm/step/narrowestBand.hpp"

#include <algorithm>
#include <functional>

namespace mpm {

template <int Dim> void ImplicitSystem<Dim>::reset(int velocityField) {
    field = velocityField;
    nodes.clear();
    members_.clear();
}

// Operations of a factor that take as long as an iteration does for one sum over the nodes of one particle, by node:
// 35 to 45 were measured on AVX-512.
constexpr double factorPerSum = 40;

template <int Dim> void ImplicitSystem<Dim>::sortNodes(const Grid<Dim>& grid) {
    Index<Dim> first, last, reach;
    first.fill(grid.count);
    last.fill(0);
    reach.fill(0);
    for (const auto* member : members_)
        for (const Strained& particle : member->particles) {
            const auto begin = member->entries.begin() + particle.begin;
            const auto end = member->entries.begin() + particle.end;
            const auto isBefore = [](const Entry& a, const Entry& b) { return a.node < b.node; };
            if (begin == end) continue;
            const auto [lowest, highest] = std::minmax_element(begin, end, isBefore);
            const Index<Dim> low = grid.indices(lowest->node), high = grid.indices(highest->node);
            for (int k = 0; k < Dim; ++k) {
                first[k] = std::min(first[k], low[k]);
                last[k] = std::max(last[k], high[k]);
                reach[k] = std::max(reach[k], high[k] - low[k]);
            }
        }
    const int axis = axisOfNarrowestBand<Dim>(first, last, reach);
    // The highest first: what stands in the ground, and is in contact, comes last, where back-solves are short.
    std::sort(nodes.begin(), nodes.end(), std::greater<int>()); // along the last axis
    if (axis != Dim - 1)
        std::stable_sort(nodes.begin(), nodes.end(),
                         [&](int a, int b) { return grid.indices(a)[axis] > grid.indices(b)[axis]; });
}

template <int Dim> void ImplicitSystem<Dim>::place(const std::vector<int>& number) {
    int span = 0; // of the numbers of the nodes that strain one particle
    for (auto* force : {&atStart_, &weight_}) force->assign(nodes.size(), Vec<Dim>::Zero());
    for (auto* member : members_)
        for (const Strained& particle : member->particles) {
            int least = int(nodes.size()), most = 0;
            for (int e = particle.begin; e < particle.end; ++e) {
                Entry& entry = member->entries[e];
                const int at = number[entry.node];
                least = std::min(least, at);
                most = std::max(most, at);
                entry.unknown = Dim * at;
                atStart_[at] += entry.force;
                weight_[at] += entry.weight;
            }
            span = std::max(span, most - least);
        }
    band_ = Dim * span + Dim - 1;
}

template <int Dim> void ImplicitSystem<Dim>::assemble(double square) {
    factor_.reset(unknowns(), band_);
    for (const auto* member : members_)
        for (const Strained& particle : member->particles) add(square, *member, particle);
}

template <int Dim>
void ImplicitSystem<Dim>::add(double square, const StrainedNodes<Dim>& strained, const Strained& particle) {
    if (!particle.resists()) return;
    order_.clear(); // by number, so that rows are below columns
    for (int e = particle.begin; e < particle.end; ++e) order_.push_back(&strained.entries[e]);
    std::sort(order_.begin(), order_.end(), [](auto* a, auto* b) { return a->unknown < b->unknown; });
    if (particle.rows > 0) return addBeam(square, strained, particle);
    const double lambda = square * particle.lambda, mu = square * particle.mu;
    for (size_t b = 0; b < order_.size(); ++b) {
        const Entry& q = *order_[b];
        const int column = q.unknown;
        double control[StrainedNodes<Dim>::patterns];
        for (int m = 0; m < StrainedNodes<Dim>::patterns; ++m)
            control[m] = square * particle.control[m] * q.gamma[m];
        for (size_t a = b; a < order_.size(); ++a) {
            const Entry& g = *order_[a];
            double product = 0, diagonal = 0;
            for (int k = 0; k < Dim; ++k) product += g.g[k] * q.g[k];
            for (int m = 0; m < StrainedNodes<Dim>::patterns; ++m) diagonal += control[m] * g.gamma[m];
            diagonal += mu * product;
            for (int j = 0; j < Dim; ++j) {
                double* below = &factor_.at(g.unknown, column + j);
                for (int i = a == b ? j : 0; i < Dim; ++i)
                    below[i] +=
                        lambda * g.trace[i] * q.trace[j] + mu * g.g[j] * q.g[i] + (i == j ? diagonal : 0.0);
            }
            factor_.at(g.unknown, column) += 2 * mu * g.hoop * q.hoop;
        }
    }
}

template <int Dim>
void ImplicitSystem<Dim>::multiply(const std::vector<double>& x, std::vector<double>& force) const {
    std::fill(force.begin(), force.end(), 0.0);
    for (const auto* member : members_)
        for (const Strained& particle : member->particles)
            addForce(*member, particle, x.data(), force.data());
}

// The forces on the nodes of a particle that is strained by x.
template <int Dim>
void ImplicitSystem<Dim>::addForce(const StrainedNodes<Dim>& strained, const Strained& particle,
                                   const double* x, double* force) const {
    if (particle.rows > 0) return addBeamForce(strained, particle, x, force);
    if (!particle.resists()) return;
    constexpr int patterns = StrainedNodes<Dim>::patterns;
    double gradient[Dim][Dim] = {}, hourglass[patterns][Dim] = {}, ring = 0, trace = 0;
    for (int e = particle.begin; e < particle.end; ++e) {
        const Entry& entry = strained.entries[e];
        const double* u = x + entry.unknown;
        for (int i = 0; i < Dim; ++i) {
            trace += entry.trace[i] * u[i];
            for (int j = 0; j < Dim; ++j) gradient[i][j] += u[i] * entry.g[j];
            for (int m = 0; m < patterns; ++m) hourglass[m][i] += entry.gamma[m] * u[i];
        }
        ring += entry.hoop * u[0];
    }
    double stress[Dim][Dim]; // beside the pressure, over V
    for (int i = 0; i < Dim; ++i)
        for (int j = 0; j < Dim; ++j) stress[i][j] = particle.mu * (gradient[i][j] + gradient[j][i]);
    for (int m = 0; m < patterns; ++m)
        for (int i = 0; i < Dim; ++i) hourglass[m][i] *= particle.control[m];
    trace *= particle.lambda;
    ring *= 2 * particle.mu;
    for (int e = particle.begin; e < particle.end; ++e) {
        const Entry& entry = strained.entries[e];
        double* f = force + entry.unknown;
        for (int i = 0; i < Dim; ++i) {
            double sum = trace * entry.trace[i];
            for (int j = 0; j < Dim; ++j) sum += stress[i][j] * entry.g[j];
            for (int m = 0; m < patterns; ++m) sum += hourglass[m][i] * entry.gamma[m];
            f[i] += sum;
        }
        f[0] += ring * entry.hoop;
    }
}

template <int Dim> bool ImplicitSystem<Dim>::solve(Scene<Dim>& scene, const Vec<Dim>& gravity) {
    NF& nodal = scene.grid.fields[field];
    const double dt = scene.dt, square = dt * dt;
    const int n = unknowns();
    isFactorised_ = false;
    for (auto* vector : {&velocity_, &force_, &solved_, &straining_})
        vector->assign(BandMatrix::padded(n, band_), 0.0);
    for (int i = 0; i < n; ++i) {
        const double v = nodal.motion[nodes[i / Dim]][i % Dim];
        velocity_[i] = holderOf(nodal, i) >= 0 ? v : 0;
        solved_[i] = holderOf(nodal, i) >= 0 ? 0 : nodal.sum[nodes[i / Dim]][NF::mass] * v;
    }
    multiply(velocity_, force_);
    for (int i = 0; i < n; ++i)
        if (holderOf(nodal, i) < 0) solved_[i] -= square * force_[i];
    if (!findVelocities(scene)) return false;
    for (int i = 0; i < n; ++i)
        if (holderOf(nodal, i) < 0) velocity_[i] = solved_[i];
    multiply(velocity_, force_);
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

template <int Dim> bool ImplicitSystem<Dim>::findVelocities(const Scene<Dim>& scene) {
    if (iterate(scene)) return true;
    if (!factorise(scene)) return false;
    factor_.solve(solved_.data());
    return true;
}

template <int Dim> bool ImplicitSystem<Dim>::iterate(const Scene<Dim>& scene) {
    const NF& nodal = scene.grid.fields[field];
    const double ofFactor = double(unknowns()) * band_ * band_;
    double entries = 0;
    for (const auto* member : members_) entries += double(member->entries.size());
    const auto mostFor = [&](int sums) { return ofFactor / (factorPerSum * sums * entries); };
    if (mostFor(Dim) < ImplicitIteration<Dim>::expected(1) || mayMeetOthers(scene)) return false;
    ImplicitIteration<Dim> iteration(int(nodes.size()), scene.dt * scene.dt);
    for (const auto* member : members_)
        if (!iteration.look(*member)) return false;
    const double most = mostFor(iteration.sums());
    for (const auto* member : members_) iteration.add(*member);
    for (size_t n = 0; n < nodes.size(); ++n) {
        const auto& sum = nodal.sum[nodes[n]];
        bool isHeld[Dim];
        Vec<Dim> right, guess;
        for (int k = 0; k < Dim; ++k) {
            isHeld[k] = nodal.holder[nodes[n]][k] >= 0;
            right[k] = solved_[Dim * n + k];
            guess[k] = NF::velocityAtStart(sum, k);
        }
        iteration.setNode(int(n), sum[NF::mass], isHeld, right, guess);
    }
    if (iteration.expected() > most || !iteration.solve(int(most))) return false;
    for (int i = 0; i < unknowns(); ++i) solved_[i] = iteration.solution(i / Dim, i % Dim);
    return true;
}

// Whether another group has mass on its nodes: Contact then asks for the factor.
template <int Dim> bool ImplicitSystem<Dim>::mayMeetOthers(const Scene<Dim>& scene) const {
    const auto has = [&](const NF& other, int node) {
        return scene.grid.mayHaveMass(other, node) && other.sum[node][NF::mass] > 0;
    };
    for (size_t other = 0; other < scene.grid.fields.size(); ++other)
        for (int node : nodes)
            if (int(other) != field && has(scene.grid.fields[other], node)) return true;
    return false;
}

template <int Dim> void ImplicitSystem<Dim>::requireFactor(const Scene<Dim>& scene) {
    if (!factorise(scene))
        throw RunError(message("step ", scene.step,
                               ": the matrix of the implicit bodies is not positive "
                               "definite; look at the last frames for a body that breaks, or lower dt"));
}

template <int Dim> bool ImplicitSystem<Dim>::factorise(const Scene<Dim>& scene) {
    if (isFactorised_) return true;
    const NF& nodal = scene.grid.fields[field];
    assemble(scene.dt * scene.dt);
    for (int i = 0; i < unknowns(); ++i) {
        factor_.at(i, i) += nodal.sum[nodes[i / Dim]][NF::mass];
        if (holderOf(nodal, i) >= 0) factor_.decouple(i);
    }
    return isFactorised_ = factor_.factorise();
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
void ImplicitSystem<Dim>::start(const Scene<Dim>& scene, ImpulseSweep& sweep, int first, int span) {
    const NF& nodal = scene.grid.fields[field];
    requireFactor(scene);
    sweep.start(factor_, first, span, [&](int unknown) { return holderOf(nodal, unknown) >= 0; });
}

template <int Dim>
void ImplicitSystem<Dim>::solveFor(const Scene<Dim>& scene, const ImpulseResponse<Dim>& response, int body,
                                   const std::vector<Vec<Dim>>& impulses) {
    const NF& nodal = scene.grid.fields[field];
    requireFactor(scene);
    std::fill(solved_.begin(), solved_.end(), 0.0);
    forUnknowns(nodal, response, body, [&](size_t n, int k, int i) { solved_[i] += impulses[n][k]; });
    factor_.solve(solved_.data());
}

template <int Dim>
void ImplicitSystem<Dim>::answer(const Scene<Dim>& scene, const ImpulseResponse<Dim>& response, int body,
                                 const std::vector<Vec<Dim>>& impulses, std::vector<Vec<Dim>>& changes) {
    const NF& nodal = scene.grid.fields[field];
    solveFor(scene, response, body, impulses);
    forUnknowns(nodal, response, body, [&](size_t n, int k, int i) { changes[n][k] = solved_[i]; });
}

template <int Dim>
void ImplicitSystem<Dim>::strain(Scene<Dim>& scene, const ImpulseResponse<Dim>& response, int body,
                                 const std::vector<Vec<Dim>>& impulses) {
    NF& nodal = scene.grid.fields[field];
    solveFor(scene, response, body, impulses);
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
    requireFactor(scene);
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
    multiply(solved_, force);
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
    multiply(straining_, solved_);
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
