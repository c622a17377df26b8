// SPDX-License-Identifier: GPL-2.0-or-later
// Where two groups of bodies, a and b, have mass on one node, they exchange an impulse (Bardenhagen et al. 2000). With the
// velocities v of the solution, the normal n from a to b, the gap g between the surfaces, and w = (v_a - v_b) . n,
//     J_n = [w - max(g, 0)/dt] / (1/m_a + 1/m_b) where that is positive,   |J_t| <= mu J_n + adhesion A dt:
// surfaces may close a gap but not cross, and do not pull. A node that a constraint holds counts as infinitely heavy. Vertices of meshes
// between the nodes (touches) exchange impulses by the same rule, with velocities and masses that follow from their hat functions.
//
// The velocities at the start of the step, p/m, need not agree either. The nodes are made to; the particles take `impactLoss` of
// that part. Groups that neither slip nor separate take nothing of it, as with one velocity field for all, where the mean of all
// momentum stands for each: they move as one body to the last digits.
// One thread does it all, so that the bits are the same for any number.
#include "mpm/contact/Contact.hpp"

namespace mpm {

namespace {

// Inverse masses per component: what a group answers to an impulse with. Zero where a constraint holds it.
template <int Dim> Vec<Dim> mobility(const NodalField<Dim>& field, int node) {
    Vec<Dim> W;
    for (int k = 0; k < Dim; ++k)
        W[k] = field.holder[node][k] >= 0 ? 0 : 1 / field.sum[node][NodalField<Dim>::mass];
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
    return {
        {"friction", "-", "Coefficient of friction.", &friction, Range::notNegative()},
        {"adhesion", "kPa", "Shear stress that is borne besides friction while in contact.", &adhesion,
         Range::notNegative()},
        {"separation", "",
         "Whether groups may come apart; False: what shares a node stays together, gap or not.", &separation},
        {"slip", "", "Whether groups in contact may slip; False: whatever the friction, they do not.", &slip},
        {"impactLoss", "-",
         "Share of the velocity with which nodes of two groups meet that their particles lose. 0: elastic impacts\n"
         "keep their energy. 1: they stop a layer of one cell; for soil that flows round a structure, where noise\n"
         "would push the groups apart otherwise.",
         &impactLoss, Range::between(0, 1)},
        {"normals",
         "",
         "'surface': area vectors of the surfaces; 'mass': gradient of the nodal mass.",
         &normals,
         {},
         {"surface", "mass"}},
        {"pairs", "",
         "Friction and adhesion of pairs of groups that differ: numbers of the groups, friction, adhesion.",
         &pairs},
        {"frictionWork", "kJ", "Work lost to friction since the start.", &frictionWork},
        {"impulses", "kN s",
         "Time integrals of the forces between groups since the start; see forceImpulses().", &impulses}};
}

void Contact::finish() {
    require(pairs.size() % 4 == 0, "Contact: pairs has ", pairs.size(), " entries; use pair()");
}

void Contact::stepped(double dt) {
    impulses.resize(forces.size());
    for (size_t i = 0; i < forces.size(); ++i) impulses[i] += dt * forces[i];
}

template <int Dim> void Contact::check(Scene<Dim>& scene) {
    require(dead || scene.groups.size() > 1, "Contact: all bodies belong to one group, '",
            scene.groups.front(), "'; give scene.add(..., group=...) for those that may slip");
    std::get<Meeting<Dim>>(meetings_).prepare(scene);
}

Contact::Law Contact::lawOf(int a, int b) const {
    for (size_t i = 0; i < pairs.size(); i += 4)
        if (std::min(pairs[i], pairs[i + 1]) == a && std::max(pairs[i], pairs[i + 1]) == b)
            return {pairs[i + 2], pairs[i + 3], slip};
    return {friction, adhesion, slip};
}

template <int Dim> Meeting<Dim>& Contact::meeting(const Scene<Dim>& scene) {
    auto& meeting = std::get<Meeting<Dim>>(meetings_);
    if (!meeting.isFound(scene)) meeting.find(scene, normals == "mass");
    return meeting;
}

// What stops an approach faster than the gap allows in a step, as an impulse on the second group. Where impacts are lost, surfaces that
// pressed on each other in this step do not part either in the velocities that are made anew: the pressure would give energy.
template <int Dim>
double Contact::stopping(const Site<Dim>& site, const Vec<Dim>& answer, const Vec<Dim>& w, double dt) const {
    const double excess =
        w.dot(site.normal) - (separation ? std::max(site.gap + site.tolerated, 0.0) / dt : 0);
    const double yielding = site.normal.dot(answer.cwiseProduct(site.normal));
    if (!(yielding > 0)) return 0;
    return (excess > 0 || !separation ? 1 : site.presses ? impactLoss : 0) * excess / yielding;
}

// The impulses on the second group, from the relative velocities at the start and of the solution: all that the nodes take, and
// the part of it that only makes the velocities of the start agree.
template <int Dim>
Impulses<Dim> Contact::exchange(const Site<Dim>& site, const Law& law, double dt, const Vec<Dim>& answer,
                                const Vec<Dim>& start, const Vec<Dim>& w) const {
    Impulses<Dim> J;
    if (!separation && !law.slip) { // one body
        for (int k = 0; k < Dim; ++k)
            if (answer[k] > 0) J.all[k] = w[k] / answer[k], J.agreeing[k] = start[k] / answer[k];
        J.sticks = true;
        return J;
    }
    const Vec<Dim>& n = site.normal;
    const double pushed = stopping(site, answer, w, dt);
    if (pushed == 0) return J;
    const double agreed =
        separation ? std::min(stopping(site, answer, start, dt), pushed) : stopping(site, answer, start, dt);
    J.all = pushed * n, J.agreeing = agreed * n;
    const auto across = [&](const Vec<Dim>& v) { return Vec<Dim>(v - v.dot(n) * n); };
    const Vec<Dim> slip = across(w - answer.cwiseProduct(J.all)),
                   slipped = across(start - answer.cwiseProduct(J.agreeing));
    const Vec<Dim> t = unit(slip, 0.0);
    const double lag = t.dot(answer.cwiseProduct(t)),
                 borne = law.adhesion * site.area * dt; // lag 0: constraints hold both
    J.sticks = t.isZero(0);
    if (J.sticks || !(lag > 0 || law.slip)) return J;
    const double limit = law.friction * std::max(pushed - (1 - impactLoss) * agreed, 0.0) + borne;
    J.sticks =
        lag > 0 && (!law.slip || (slip.norm() <= lag * (law.friction * std::max(pushed, 0.0) + borne) &&
                                  (slip - (1 - impactLoss) * slipped).norm() <= lag * limit));
    if (J.sticks)
        J.all += slip / lag, J.agreeing += slipped / lag;
    else
        J.all += std::min(lag > 0 ? slip.norm() / lag : limit, limit) * t;
    return J;
}

// Motion of one group on a node, with what follows from it: work of gravity, and the reaction of what holds the node.
// answer: its inverse masses, with the sign of the impulse on it.
template <int Dim>
void Contact::change(Scene<Dim>& scene, const Meet<Dim>& meet, int side, const Vec<Dim>& answer,
                     const Impulses<Dim>& J) {
    using NF = NodalField<Dim>;
    NF& field = scene.grid.fields[meet.field[side]];
    auto& motion = field.motion[meet.node];
    const Vec<Dim>&x = meet.position, force = (side == 0 ? -1 : 1) / scene.dt * meet.impulse;
    double gained = 0;
    for (int k = 0; k < Dim; ++k) {
        const double change = answer[k] * J.all[k];
        gained += scene.gravity[k] * change;
        motion.set(Dim + k, motion[Dim + k] + answer[k] * meet.impulse[k] / scene.dt);
        motion.set(k, motion[k] + change);
        if (scene.scheme != Scheme::MUSL) field.velocity[meet.node].set(k, motion[k]);
        const int holder = field.holder[meet.node][k];
        if (holder < 0) continue;
        Constraint& constraint = *scene.constraints[holder];
        addReaction<Dim>(x, constraint.centre, k, -force[k], constraint.reaction, constraint.moment);
        constraint.work -= force[k] * motion[k] * scene.dt;
    }
    scene.energies.gravity += field.sum[meet.node][NF::weightMass] * gained * scene.dt;
}

// slip: with the velocity that strains the groups. Nodes that a body hardly feels may have quite another one in the solution.
template <int Dim> void Contact::tell(Scene<Dim>& scene, const Meet<Dim>& meet, const Vec<Dim>& slip) {
    const double rubbed = meet.friction.dot(slip);
    frictionWork += rubbed, scene.energies.contact += rubbed;
    const auto append = [&](const Vec<Dim>& v) {
        for (int k = 0; k < 3; ++k) table.push_back(k < Dim ? v[k] : 0.0);
    };
    table.insert(table.end(), {double(meet.field[0]), double(meet.field[1])});
    append(meet.position), append(meet.normal);
    table.insert(table.end(), {meet.gap, meet.area});
    append(meet.impulse / scene.dt), append(slip);
    double* force = &forces[3 * pairOf(meet.field[0], meet.field[1])];
    for (int k = 0; k < Dim; ++k) force[k] += meet.impulse[k] / scene.dt;
    if (!meet.hasTouches) largestPenetration = std::max(largestPenetration, -meet.gap);
    sliding += meet.slides;
}

// The impulse at a site between nodes with weights S, anew, in view of what the others exchange. Returns whether it has changed much.
template <int Dim>
bool Contact::renew(Site<Dim>& site, const Law& law, double dt, const int* at, const double* S, int count) {
    auto& nodes = std::get<std::vector<Pair<Dim>>>(nodes_);
    Vec<Dim> answer = Vec<Dim>::Zero(), start = answer, w = answer;
    for (int i = 0; i < count; ++i) {
        const Pair<Dim>& node = nodes[at[i]];
        answer += S[i] * S[i] * (node.W[0] + node.W[1]);
        start += S[i] * (node.start[0] - node.start[1]), w += S[i] * (node.v[0] - node.v[1]);
    }
    start += answer.cwiseProduct(site.J.agreeing), w += answer.cwiseProduct(site.J.all);
    const Impulses<Dim> J = exchange<Dim>(site, law, dt, answer, start, w);
    const Impulses<Dim> more{J.all - site.J.all, J.agreeing - site.J.agreeing};
    site.J = J;
    if (!more.all.isZero(0) || !more.agreeing.isZero(0))
        for (int i = 0; i < count; ++i) nodes[at[i]].take(more, S[i]);
    return more.all.norm() > 1e-3 * J.all.norm();
}

// What a pair of groups exchanges at nodes, and at touches between them that still approach: one after the other, some rounds.
template <int Dim, class LawOf>
void Contact::settle(Meeting<Dim>& meeting, const Stretch& pair, double dt, LawOf&& lawOf) {
    const double one = 1;
    for (int round = 0; round < 10; ++round) {
        for (int i = int(pair.meet); i < int(pair.lastMeet); ++i)
            renew<Dim>(meeting.meets[i], lawOf(meeting.meets[i]), dt, &i, &one, 1);
        bool isDone = true;
        for (size_t i = pair.touch; separation && i < pair.lastTouch; ++i) {
            Touch<Dim>& touch = meeting.touches[i];
            isDone &= !renew<Dim>(touch, lawOf(touch), dt, touch.meet, touch.S, Touch<Dim>::size);
        }
        if (isDone) return;
    }
}

// Energy that a pair of groups takes from the motion of the nodes: J . w - J . answer J / 2, w from before the exchange. Frictionless rounds
// never give any, settled ones neither. Adhesion and friction that come and go between rounds might: then the share of all impulses that
// takes most is left.
template <int Dim> double Contact::bound(Meeting<Dim>& meeting, const Stretch& pair) {
    auto& nodes = std::get<std::vector<Pair<Dim>>>(nodes_);
    double stopped = 0, answered = 0;
    for (size_t i = pair.meet; i < pair.lastMeet; ++i) {
        const Pair<Dim>& node = nodes[i];
        const Vec<Dim> change = (node.W[0] + node.W[1]).cwiseProduct(node.J.all);
        stopped += node.J.all.dot(node.v[0] - node.v[1] + change), answered += node.J.all.dot(change);
    }
    if (stopped >= 0.5 * answered) return stopped - 0.5 * answered;
    const double share = stopped > 0 ? stopped / answered : 0;
    ++reduced;
    const auto scale = [&](Impulses<Dim>& J) { J.all *= share, J.agreeing *= share; };
    for (size_t i = pair.meet; i < pair.lastMeet; ++i) {
        nodes[i].take(Impulses<Dim>(nodes[i].J), share - 1);
        scale(meeting.meets[i].J);
    }
    for (size_t i = pair.touch; i < pair.lastTouch; ++i) scale(meeting.touches[i].J);
    return 0.5 * share * stopped;
}

// Where there is friction, and how far meshes overlap.
template <int Dim> void Contact::addFriction(Meeting<Dim>& meeting, const Stretch& pair, double loss) {
    const auto add = [&](Site<Dim>& site, const int* at, const double* S, int count) {
        site.sticks = site.J.sticks;
        if (site.J.all.isZero(0)) return;
        site.presses = true;
        const Vec<Dim> taken = site.J.all - (1 - loss) * site.J.agreeing,
                       along = taken - taken.dot(site.normal) * site.normal;
        for (int i = 0; i < count; ++i) {
            Meet<Dim>& meet = meeting.meets[at[i]];
            meet.friction += S[i] * along, meet.slides |= !site.sticks;
        }
    };
    const double one = 1;
    for (int i = int(pair.meet); i < int(pair.lastMeet); ++i) add(meeting.meets[i], &i, &one, 1);
    for (size_t i = pair.touch; i < pair.lastTouch; ++i) {
        Touch<Dim>& touch = meeting.touches[i];
        largestPenetration = std::max(largestPenetration, -touch.gap);
        add(touch, touch.meet, touch.S, Touch<Dim>::size);
    }
}

template <int Dim> void Contact::act(Scene<Dim>& scene) {
    using NF = NodalField<Dim>;
    table.clear(), largestPenetration = gridLoss = 0, sliding = reduced = 0;
    forces.assign(3 * pairOf(0, int(scene.groups.size())), 0.0);
    const double loss = separation || slip ? impactLoss : 0;
    Meeting<Dim>& meeting = this->meeting(scene);
    auto& nodes = std::get<std::vector<Pair<Dim>>>(nodes_);
    nodes.assign(meeting.meets.size(), {});
    for (const Stretch& pair : meeting.pairs) {
        for (size_t i = pair.meet; i < pair.lastMeet; ++i)
            for (int side = 0; side < 2; ++side) {
                const int node = meeting.meets[i].node;
                const NF& field = scene.grid.fields[meeting.meets[i].field[side]];
                const Vec<Dim> W = nodes[i].W[side] = mobility(field, node);
                for (int k = 0; k < Dim; ++k) {
                    const double v = nodes[i].v[side][k] = field.motion[node][k];
                    nodes[i].start[side][k] = W[k] > 0 ? W[k] * field.sum[node][NF::momentum + k] : v;
                }
            }
        const Law law = lawOf(meeting.meets[pair.meet].field[0], meeting.meets[pair.meet].field[1]);
        settle<Dim>(meeting, pair, scene.dt, [&](const Site<Dim>&) { return law; });
        gridLoss += bound<Dim>(meeting, pair);
        addFriction<Dim>(meeting, pair, loss);
        for (size_t i = pair.meet; i < pair.lastMeet; ++i) {
            Meet<Dim>& meet = meeting.meets[i];
            const Pair<Dim>& node = nodes[i];
            if (node.J.all.isZero(0)) continue;
            meet.impulse = node.J.all - (1 - loss) * node.J.agreeing, meet.acts = true;
            for (int side = 0; side < 2; ++side)
                change<Dim>(scene, meet, side, (side == 0 ? -1 : 1) * node.W[side], node.J);
            const Vec<Dim> met = loss * node.J.agreeing, answer = node.W[0] + node.W[1];
            const Vec<Dim> start =
                node.start[0] - node.start[1] + answer.cwiseProduct(node.J.agreeing); // before the exchange
            scene.energies.contact += met.dot(start - 0.5 * answer.cwiseProduct(met));
            if (scene.scheme != Scheme::MUSL) tell<Dim>(scene, meet, node.v[0] - node.v[1]);
        }
    }
}

// The same for velocities that have been made anew from the momentum of the particles.
template <int Dim> void Contact::tie(Scene<Dim>& scene) {
    using NF = NodalField<Dim>;
    Meeting<Dim>& meeting = this->meeting(scene);
    auto& nodes = std::get<std::vector<Pair<Dim>>>(nodes_);
    nodes.assign(meeting.meets.size(), {});
    for (const Stretch& pair : meeting.pairs) {
        for (size_t i = pair.touch; i < pair.lastTouch; ++i) meeting.touches[i].J = {};
        for (size_t i = pair.meet; i < pair.lastMeet; ++i) {
            meeting.meets[i].J = {};
            for (int side = 0; side < 2; ++side) {
                const NF& field = scene.grid.fields[meeting.meets[i].field[side]];
                nodes[i].W[side] = mobility(field, meeting.meets[i].node);
                for (int k = 0; k < Dim; ++k) nodes[i].v[side][k] = field.velocity[meeting.meets[i].node][k];
                nodes[i].start[side] = nodes[i].v[side];
            }
        }
        settle<Dim>(meeting, pair, scene.dt,
                    [&](const Site<Dim>& site) { return Law{0, 0, slip && !site.sticks}; });
        for (size_t i = pair.meet; i < pair.lastMeet; ++i) {
            Meet<Dim>& meet = meeting.meets[i];
            for (int side = 0; side < 2; ++side)
                for (int k = 0; k < Dim; ++k)
                    scene.grid.fields[meet.field[side]].velocity[meet.node].set(k, nodes[i].v[side][k]);
            if (scene.scheme == Scheme::MUSL && meet.acts)
                tell<Dim>(scene, meet, nodes[i].v[0] - nodes[i].v[1]);
        }
    }
}

MPM_REGISTER(Engine, Contact);

} // namespace mpm
