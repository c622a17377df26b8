// SPDX-License-Identifier: GPL-2.0-or-later
// Where two groups of bodies, a and b, have mass on one node, they exchange an impulse (Bardenhagen et al. 2000). With the
// velocities v of the solution, the normal n from a to b, the gap g between the surfaces, and w = (v_a - v_b) . n,
//     J_n = [w - max(g, 0)/dt] / (1/m_a + 1/m_b) where that is positive,   |J_t| <= mu J_n + adhesion A dt:
// surfaces may close a gap but not cross, and do not pull. A node that a constraint holds counts as infinitely heavy.
//
// The velocities at the start of the step, p/m, need not agree either. The nodes are made to; the particles take `impactLoss` of
// that part. Groups that neither slip nor separate take nothing of it, as with one velocity field for all, where the mean of all
// momentum stands for each: they move as one body to the last digits.
// One thread does it all, so that the bits are the same for any number.
#include "mpm/engine/Contact.hpp"

namespace mpm {

namespace {

// Inverse masses per component: what a group answers to an impulse with. Zero where a constraint holds it.
template <int Dim> Vec<Dim> mobility(const NodalField<Dim>& field, int node) {
    Vec<Dim> W;
    for (int k = 0; k < Dim; ++k) W[k] = field.holder[k][node] >= 0 ? 0 : 1 / field.sum[node][NodalField<Dim>::mass];
    return W;
}

} // namespace

std::string Contact::doc() const {
    return "Frictional contact between groups of bodies, each of which moves with a velocity field of its own.\n\n"
           "On nodes that two groups move: no approach beyond the gap, no attraction, Coulomb friction. Without this engine\n"
           "all bodies stick together. Stands between GridSolver and GridToParticle. Sources: Bardenhagen et al. 2000, 2001;\n"
           "doc/contact.md.";
}

std::vector<Parameter> Contact::attributes() {
    return {{"friction", "-", "Coefficient of friction.", &friction, Range::notNegative()},
            {"adhesion", "kPa", "Shear stress that is borne besides friction while in contact.", &adhesion, Range::notNegative()},
            {"separation", "", "Whether groups may come apart; False: what shares a node stays together, gap or not.", &separation},
            {"slip", "", "Whether groups in contact may slip; False: whatever the friction, they do not.", &slip},
            {"impactLoss", "-", "Share of the velocity with which nodes of two groups meet that their particles lose. 0: elastic impacts\n"
                                "keep their energy. 1: they stop a layer of one cell; for soil that flows round a structure, where noise\n"
                                "would push the groups apart otherwise.",
             &impactLoss, Range::between(0, 1)},
            {"normals", "", "'surface': area vectors of the surfaces; 'mass': gradient of the nodal mass.", &normals, {},
             {"surface", "mass"}},
            {"pairs", "", "Friction and adhesion of pairs of groups that differ: numbers of the groups, friction, adhesion.", &pairs},
            {"frictionWork", "kJ", "Work lost to friction since the start.", &frictionWork}};
}

void Contact::finish() {
    require(pairs.size() % 4 == 0, "Contact: pairs has ", pairs.size(), " entries; use pair()");
}

template <int Dim> void Contact::check(Scene<Dim>& scene) {
    require(dead || scene.groups.size() > 1, "Contact: all bodies belong to one group, '", scene.groups.front(),
            "'; give scene.add(..., group=...) for those that may slip");
    std::get<Meeting<Dim>>(meetings_).prepare(scene);
}

Contact::Law Contact::lawOf(int a, int b) const {
    for (size_t i = 0; i < pairs.size(); i += 4)
        if (std::min(pairs[i], pairs[i + 1]) == a && std::max(pairs[i], pairs[i + 1]) == b) return {pairs[i + 2], pairs[i + 3], slip};
    return {friction, adhesion, slip};
}

template <int Dim> std::vector<Meet<Dim>>& Contact::meets(const Scene<Dim>& scene) {
    auto& meeting = std::get<Meeting<Dim>>(meetings_);
    if (!meeting.isFound(scene)) meeting.find(scene, normals == "mass");
    return meeting.meets;
}

// What stops an approach faster than the gap allows in a step, as an impulse on the second group.
template <int Dim> double Contact::stopping(const Meet<Dim>& meet, const Vec<Dim>& answer, const Vec<Dim>& w, double dt) const {
    const double excess = w.dot(meet.normal) - (separation ? std::max(meet.gap, 0.0) / dt : 0);
    const double yielding = meet.normal.dot(answer.cwiseProduct(meet.normal));
    return yielding > 0 && (excess > 0 || !separation) ? excess / yielding : 0;
}

// The impulses on the second group, from the relative velocities at the start and of the solution: all that the nodes take, and
// the part of it that only makes the velocities of the start agree.
template <int Dim>
typename Contact::Impulses<Dim> Contact::exchange(Meet<Dim>& meet, const Law& law, double dt, const Vec<Dim>& answer,
                                                  const Vec<Dim>& start, const Vec<Dim>& w) const {
    Impulses<Dim> J;
    if (!separation && !law.slip) { // one body
        for (int k = 0; k < Dim; ++k)
            if (answer[k] > 0) J.all[k] = w[k] / answer[k], J.agreeing[k] = start[k] / answer[k];
        meet.sticks = true;
        return J;
    }
    const Vec<Dim>& n = meet.normal;
    const double pushed = stopping(meet, answer, w, dt);
    if (pushed == 0) return J;
    const double agreed = separation ? std::min(stopping(meet, answer, start, dt), pushed) : stopping(meet, answer, start, dt);
    J.all = pushed * n, J.agreeing = agreed * n;
    const auto across = [&](const Vec<Dim>& v) { return Vec<Dim>(v - v.dot(n) * n); };
    const Vec<Dim> slip = across(w - answer.cwiseProduct(J.all)), slipped = across(start - answer.cwiseProduct(J.agreeing));
    const Vec<Dim> t = unit(slip, 0.0);
    const double lag = t.dot(answer.cwiseProduct(t)), borne = law.adhesion * meet.area * dt; // lag 0: constraints hold both
    meet.sticks = t.isZero(0);
    if (meet.sticks || !(lag > 0 || law.slip)) return J;
    const double limit = law.friction * std::max(pushed - (1 - impactLoss) * agreed, 0.0) + borne;
    meet.sticks = lag > 0 && (!law.slip || (slip.norm() <= lag * (law.friction * std::max(pushed, 0.0) + borne) &&
                                            (slip - (1 - impactLoss) * slipped).norm() <= lag * limit));
    if (meet.sticks)
        J.all += slip / lag, J.agreeing += slipped / lag;
    else
        J.all += std::min(lag > 0 ? slip.norm() / lag : limit, limit) * t;
    return J;
}

// Motion of one group on a node, with what follows from it: work of gravity, and the reaction of what holds the node.
// answer: its inverse masses, with the sign of the impulse on it.
template <int Dim>
void Contact::change(Scene<Dim>& scene, const Meet<Dim>& meet, int side, const Vec<Dim>& answer, const Impulses<Dim>& J) {
    using NF = NodalField<Dim>;
    NF& field = scene.grid.fields[meet.field[side]];
    auto& motion = field.motion[meet.node];
    const Vec<Dim> x = scene.grid.nodePosition(meet.node), force = (side == 0 ? -1 : 1) / scene.dt * meet.impulse;
    double gained = 0;
    for (int k = 0; k < Dim; ++k) {
        const double change = answer[k] * J.all[k];
        gained += scene.gravity[k] * change;
        motion.set(Dim + k, motion[Dim + k] + answer[k] * meet.impulse[k] / scene.dt);
        motion.set(k, motion[k] + change);
        if (scene.scheme != Scheme::MUSL) NF::setVelocity(field.velocity[meet.node], k, motion[k]);
        const int holder = field.holder[k][meet.node];
        if (holder < 0) continue;
        Constraint& constraint = *scene.constraints[holder];
        double arm[3] = {0, 0, 0};
        for (int m = 0; m < Dim; ++m) arm[m] = x[m] - constraint.centre[m];
        constraint.reaction[k] -= force[k];
        constraint.moment[(k + 1) % 3] -= arm[(k + 2) % 3] * force[k];
        constraint.moment[(k + 2) % 3] += arm[(k + 1) % 3] * force[k];
        constraint.work -= force[k] * motion[k] * scene.dt;
    }
    scene.energies.gravity += field.sum[meet.node][NF::weightMass] * gained * scene.dt;
}

// slip: with the velocity that strains the groups. Nodes that a body hardly feels may have quite another one in the solution.
template <int Dim> void Contact::tell(Scene<Dim>& scene, const Meet<Dim>& meet, const Vec<Dim>& slip) {
    const double rubbed = (meet.impulse - meet.impulse.dot(meet.normal) * meet.normal).dot(slip);
    frictionWork += rubbed, scene.energies.contact += rubbed;
    const auto append = [&](const Vec<Dim>& v) {
        for (int k = 0; k < 3; ++k) table.push_back(k < Dim ? v[k] : 0.0);
    };
    table.insert(table.end(), {double(meet.field[0]), double(meet.field[1])});
    append(scene.grid.nodePosition(meet.node)), append(meet.normal);
    table.insert(table.end(), {meet.gap, meet.area});
    append(meet.impulse / scene.dt), append(slip);
    largestPenetration = std::max(largestPenetration, -meet.gap);
    sliding += !meet.sticks;
}

template <int Dim> void Contact::act(Scene<Dim>& scene) {
    using NF = NodalField<Dim>;
    table.clear(), largestPenetration = 0, sliding = 0;
    const double loss = separation || slip ? impactLoss : 0;
    for (Meet<Dim>& meet : meets(scene)) {
        Vec<Dim> W[2], start[2], v[2];
        for (int side = 0; side < 2; ++side) {
            const NF& field = scene.grid.fields[meet.field[side]];
            W[side] = mobility(field, meet.node);
            for (int k = 0; k < Dim; ++k) {
                v[side][k] = field.motion[meet.node][k];
                start[side][k] = W[side][k] > 0 ? W[side][k] * field.sum[meet.node][NF::momentum + k] : v[side][k];
            }
        }
        const Impulses<Dim> J = exchange<Dim>(meet, lawOf(meet.field[0], meet.field[1]), scene.dt, W[0] + W[1], start[0] - start[1],
                                              v[0] - v[1]);
        if (J.all.isZero(0)) continue;
        meet.impulse = J.all - (1 - loss) * J.agreeing, meet.acts = true;
        for (int side = 0; side < 2; ++side) change<Dim>(scene, meet, side, (side == 0 ? -1 : 1) * W[side], J);
        const Vec<Dim> met = loss * J.agreeing;
        scene.energies.contact += met.dot(start[0] - start[1] - 0.5 * (W[0] + W[1]).cwiseProduct(met));
        if (scene.scheme != Scheme::MUSL) tell<Dim>(scene, meet, v[0] - v[1] - (W[0] + W[1]).cwiseProduct(J.all));
    }
}

// The same for velocities that have been made anew from the momentum of the particles.
template <int Dim> void Contact::tie(Scene<Dim>& scene) {
    using NF = NodalField<Dim>;
    for (Meet<Dim>& meet : meets(scene)) {
        Vec<Dim> W[2], v[2];
        for (int side = 0; side < 2; ++side) {
            NF& field = scene.grid.fields[meet.field[side]];
            W[side] = mobility(field, meet.node);
            for (int k = 0; k < Dim; ++k) v[side][k] = field.velocity[meet.node][NF::lane(k)];
        }
        const Law law{0, 0, slip && !meet.sticks};
        const bool sticks = meet.sticks;
        const Impulses<Dim> J = exchange<Dim>(meet, law, scene.dt, W[0] + W[1], v[0] - v[1], v[0] - v[1]);
        meet.sticks = sticks;
        for (int side = 0; side < 2; ++side) {
            v[side] += (side == 0 ? -1 : 1) * W[side].cwiseProduct(J.all);
            for (int k = 0; k < Dim; ++k) NF::setVelocity(scene.grid.fields[meet.field[side]].velocity[meet.node], k, v[side][k]);
        }
        if (scene.scheme == Scheme::MUSL && meet.acts) tell<Dim>(scene, meet, v[0] - v[1]);
    }
}

MPM_REGISTER(Engine, Contact);

} // namespace mpm
