// SPDX-License-Identifier: GPL-2.0-or-later
// Where two groups of bodies, a and b, have mass on one node, they exchange an impulse (Bardenhagen et al.
// 2000), by the rule in FrictionLaw.hpp, with the normal from a to b. A node that a constraint holds counts
// as infinitely heavy. Vertices of meshes between the nodes (contact points) exchange impulses by the same
// rule, with velocities and masses that follow from their hat functions.
//
// The velocities at the start of the step, p/m, need not agree either. The nodes are made to; the particles
// take `impactLoss` of that part. Groups that neither slip nor separate take nothing of it, as with one
// velocity field for all, where the mean of all momentum stands for each: they move as one body to the last
// digits. One thread does it all, so that the bits are the same for any number.
#include "mpm/contact/Contact.hpp"

#include "mpm/scene/SharedCells.hpp"

namespace mpm {

namespace {

// Zero where a constraint holds it.
template <int Dim> Mat<Dim> inverseMass(const NodalField<Dim>& field, int node) {
    Mat<Dim> W = Mat<Dim>::Zero();
    for (int k = 0; k < Dim; ++k)
        if (field.holder[node][k] < 0) W(k, k) = 1 / field.sum[node][NodalField<Dim>::mass];
    return W;
}

// Takes the axes that constraints hold on both sides out of the normals. A site between nodes is held where all of
// them are.
template <int Dim> void straighten(const Scene<Dim>& scene, ContactSearch<Dim>& search) {
    const auto isFree = [&](int i, int k) {
        const ContactNode<Dim>& contact = search.nodes[i];
        return scene.grid.fields[contact.field[0]].holder[contact.node][k] < 0 ||
               scene.grid.fields[contact.field[1]].holder[contact.node][k] < 0;
    };
    const auto look = [&](ContactSite<Dim>& site, const int* at, const double* S, int count) {
        site.normal = freePart<Dim>(site.normal, [&](int k) {
            bool isHeld = true;
            for (int i = 0; i < count; ++i) isHeld &= S[i] == 0 || !isFree(at[i], k);
            return isHeld;
        });
    };
    const double one = 1;
    for (int i = 0; i < int(search.nodes.size()); ++i) look(search.nodes[i], &i, &one, 1);
    for (auto& point : search.points) look(point, point.contact, point.S, point.size);
}

// For velocities made anew. Surfaces that part though all that is carried holds them do so there, too. Held once more
// they would strain nothing, at whatever speed their particles part, and no stress would answer the pressure.
template <int Dim> void startAnew(ContactSite<Dim>& site) {
    site.J = {};
    if (site.parts) site.carried = 0;
}

} // namespace

std::string Contact::doc() const {
    return "Frictional contact between groups of bodies, each of which moves with a velocity "
           "field of its own.\n\n"
           "On nodes that two groups move: no approach beyond the gap, no attraction, Coulomb "
           "friction. Without this engine\n"
           "all bodies stick together. Stands between GridSolver and GridToParticle. Sources: "
           "Bardenhagen et al. 2000, 2001;\n"
           "doc/explanation/contact.md.";
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
         "Share of the velocity with which nodes of two groups meet that their particles lose. "
         "1: an impact stops a\n"
         "layer of one cell. 0: elastic bodies that collide keep their energy; not for soil that flows round a "
         "structure,\n"
         "where noise would push the groups apart.",
         &impactLoss, Range::between(0, 1)},
        {"constraints",
         "",
         "What may not cross. 'nodes': nodes of both groups, and vertices of meshes between them. 'facets': "
         "each facet\n"
         "of a mesh belongs to a vertex or to nodes, never to both; else curved and inclined bodies are "
         "too large.\n"
         "'auto': facets where one of two groups is of meshes and none has boxes with an outline; else nodes, which\n"
         "make boxes on boxes 10 to 30 % too stiff or too soft.",
         &constraints,
         {},
         {"auto", "nodes", "facets"}},
        {"pairs", "", "Friction and adhesion of pairs of groups that differ; made by pair().",
         recordsOf(pairs)},
        {"sharedCells", "",
         "Whether soil (boxes with F-bar, and meshes bonded to them) and a mesh in one cell of the grid fill it "
         "together:\n"
         "what the mesh pushes into the cell presses on the soil. False: the soil feels what its own particles do, and loses pressure "
         "beside a\n"
         "body that moves far. Where facets belong to points (see constraints).",
         &sharedCells},
        {"cells", "", "Numbers of the cells of the grid that soil and a mesh share now (sharedCells).",
         &cells},
        {"gaps", "-",
         "Of each of these, how far it has opened, over the volume of its soil. 0: closed, soil and mesh "
         "press on each\n"
         "other as one volume; negative: not known, they have not met there.",
         &gaps},
        {"frictionWork", "kJ", "Work lost to friction since the start.", &frictionWork},
        {"edgeMotions", "",
         "How edges of one group last moved against another one: direction (three numbers) and speed, m/s, for each "
         "group of\neach pair. At rest their normals stay so.",
         &edgeMotions.numbers},
        {"pressing", "",
         "Sites that pressed on each other in the last step, for USF: pair of groups, body of a mesh (-1: a node), "
         "vertex or\nnode, face of a vertex at an edge, and 1 where they stuck.",
         &pressed.numbers},
        {"impulses", "kN s",
         "Time integrals of the forces between groups since the start; see forceImpulses().", &impulses},
        {"facetImpulses", "kN s",
         "Time integrals of the forces on the facets of meshes since the start; see facePressure().",
         &facetImpulses}};
}

void Contact::finish() {
    require(edgeMotions.numbers.size() % EdgeMotions::perPair == 0, "Contact: edgeMotions has ",
            edgeMotions.numbers.size(), " numbers; give ", EdgeMotions::perPair,
            " for each pair of groups, or none");
    require(pressed.numbers.size() % PressedSites::perSite == 0, "Contact: pressing has ",
            pressed.numbers.size(), " numbers; give ", PressedSites::perSite, " for each site, or none");
    for (const PairLaw& law : pairs)
        require(law.friction >= 0 && law.adhesion >= 0, "Contact: friction = ", law.friction,
                ", adhesion = ", law.adhesion, " of a pair; give zero or positive numbers by pair()");
}

void Contact::stepped(double dt) {
    std::apply([&](auto&... state) { (state.facets.store(facetImpulses), ...); }, states_);
    std::apply([&](auto*... shared) { ((shared ? shared->store(cells, gaps) : void()), ...); }, shared_);
    impulses.resize(forces.size());
    for (size_t i = 0; i < forces.size(); ++i) impulses[i] += dt * forces[i];
}

template <int Dim> void Contact::check(Scene<Dim>& scene) {
    require(dead || scene.groups.size() > 1, "Contact: all bodies belong to one group, '",
            scene.groups.front(), "'; give scene.add(..., group=...) for those that may slip");
    State<Dim>& state = std::get<State<Dim>>(states_);
    state.search.prepare(scene);
    state.solved = -1;
    state.facets.clear(); // facetImpulses may be those of a checkpoint
    const bool sharesCells = !dead && sharedCells && ownedFacets() != OwnedFacets::none;
    if (!sharesCells) {
        cells.clear();
        gaps.clear();
    }
    if (dead) return;
    scene.state.sharedCells->isWanted = sharesCells;
    scene.state.sharedCells->restore(cells, gaps);
    std::get<SharedCells<Dim>*>(shared_) = scene.state.sharedCells.get();
}

FrictionLaw Contact::lawOf(int a, int b) const {
    for (const PairLaw& law : pairs)
        if (std::min(law.first, law.second) == a && std::max(law.first, law.second) == b)
            return {law.friction, law.adhesion, slip, separation, impactLoss};
    return {friction, adhesion, slip, separation, impactLoss};
}

OwnedFacets Contact::ownedFacets() const {
    if (!separation || constraints == "nodes") return OwnedFacets::none;
    return constraints == "facets" ? OwnedFacets::all : OwnedFacets::ofMeshes;
}

template <int Dim> Contact::State<Dim>& Contact::found(const Scene<Dim>& scene) {
    auto& state = std::get<State<Dim>>(states_);
    if (!state.search.isFound(scene)) state.search.find(scene, rule());
    const bool isReady = state.solved == scene.step; // act() has asked for the same
    if (!isReady) straighten(scene, state.search);
    state.impulses.nodes.assign(state.search.nodes.size(), {});
    for (size_t i = 0; i < state.search.nodes.size(); ++i)
        std::copy(state.search.nodes[i].twin, state.search.nodes[i].twin + 2, state.impulses.nodes[i].twin);
    if (!isReady && scene.state.sharedCells->isWanted)
        state.carried.find(*scene.state.sharedCells, state.search);
    return state;
}

// Motion of one group on a node, with what follows from it: work of gravity, and the reaction of what holds
// the node. answer: its inverse masses, with the sign of the impulse on it.
template <int Dim>
void Contact::change(Scene<Dim>& scene, const Vec<Dim>& gravity, const ContactNode<Dim>& contact, int side,
                     const Mat<Dim>& answer, const Impulses<Dim>& J) {
    using NF = NodalField<Dim>;
    NF& field = scene.grid.fields[contact.field[side]];
    auto& motion = field.motion[contact.node];
    const Vec<Dim>& x = contact.position;
    // What the particles of the other side get, who keep the share flip of their velocity: the holder gives it.
    const double sign = side == 0 ? -1 : 1;
    const Vec<Dim> force = sign / scene.dt * (flip_ * contact.impulse[side] + (1 - flip_) * J.all);
    double gained = 0;
    for (int k = 0; k < Dim; ++k) {
        const double change = answer.row(k) * J.all, taken = answer.row(k).dot(contact.impulse[side]);
        gained += gravity[k] * (change - 0.5 * taken);
        motion.set(Dim + k, motion[Dim + k] + taken / scene.dt);
        motion.set(k, motion[k] + change);
        if (!scene.scheme->remapsSolution()) field.setVelocity(contact.node, k, motion[k]);
        const int holder = field.holder[contact.node][k];
        if (holder < 0) continue;
        Constraint& constraint = *scene.constraints[holder];
        addReaction<Dim>(x, constraint.centre, k, -force[k], constraint.reaction, constraint.moment);
        const double own = NF::velocityAtStart(field.sum[contact.node], k);
        constraint.work -= force[k] * scene.heldMean(holder, k, own) * scene.dt;
    }
    scene.energies.gravity += field.sum[contact.node][NF::weightMass] * gained * scene.dt;
}

// Where there is friction, and how far meshes overlap.
template <int Dim>
void Contact::addFriction(ContactSearch<Dim>& search, const ContactPair<Dim>& pair, double loss) {
    const auto add = [&](ContactSite<Dim>& site, const SiteNodes<Dim>& at) {
        site.sticks = site.J.sticks;
        site.parts = site.J.parts;
        if (site.J.all.isZero(0)) return;
        // Not by the round-off of what acts along the surface.
        site.presses = site.J.all.dot(site.normal) > 1e-9 * site.J.all.norm() || !separation;
        const Vec<Dim> taken = site.J.all - (1 - loss) * site.J.agreeing;
        const Vec<Dim> along = taken - taken.dot(site.normal) * site.normal;
        for (int i = 0; i < at.count; ++i) {
            ContactNode<Dim>& contact = search.nodes[at.at[i]];
            for (int side = 0; side < 2; ++side) contact.friction[side] += at.S[side][i] * along;
            if (at.S[0][i] == 0 && at.S[1][i] == 0) continue; // beside a site on a line of the grid
            contact.touches |= site.presses;
            contact.slides |= !site.sticks;
        }
    };
    const double one = 1;
    for (int i = int(pair.firstNode); i < int(pair.endNode); ++i) add(search.nodes[i], {1, &i, {&one, &one}});
    for (size_t i = pair.firstPoint; i < pair.endPoint; ++i) {
        ContactPoint<Dim>& point = search.points[i];
        largestPenetration = std::max(largestPenetration, -point.gap);
        add(point, point.sites());
    }
}

template <int Dim> void Contact::act(Scene<Dim>& scene) {
    using NF = NodalField<Dim>;
    table.clear();
    largestPenetration = gridLoss = 0;
    sliding = reduced = unsettled = 0;
    forces.assign(3 * pairOf(0, int(scene.groups.size())), 0.0);
    const Vec<Dim> gravity = gravityOf(scene);
    flip_ = flipOf(scene);
    State<Dim>& state = found(scene);
    state.solved = scene.step;
    ContactSearch<Dim>& search = state.search;
    auto& nodes = state.impulses.nodes;
    state.own.assign(search.nodes.size(), {});
    state.starts.clear();
    const bool mayBeThree = search.pairs.size() > 1; // groups on a node
    for (ContactPair<Dim>& pair : search.pairs) {
        for (size_t i = pair.firstNode; i < pair.endNode; ++i)
            for (int side = 0; side < 2; ++side) {
                const int node = search.nodes[i].node;
                const NF& field = scene.grid.fields[search.nodes[i].field[side]];
                const Mat<Dim> W = inverseMass(field, node);
                nodes[i].inverseMass[side] = nodes[i].startInverseMass[side] = W;
                for (int k = 0; k < Dim; ++k) {
                    const double v = nodes[i].v[side][k] = field.motion[node][k];
                    nodes[i].start[side][k] = W(k, k) > 0 ? W(k, k) * field.sum[node][NF::momentum + k] : v;
                }
                nodes[i].first[side] = nodes[i].start[side];
                if (!mayBeThree) continue;
                const auto started = state.starts.find({search.nodes[i].field[side], node});
                if (started != state.starts.end()) nodes[i].start[side] = started->second;
            }
        state.impulses.implicit.find(scene, search, pair, nodes);
        for (size_t i = pair.firstNode; i < pair.endNode; ++i)
            for (int side = 0; side < 2; ++side)
                if ((state.own[i].is[side] = nodes[i].responding[side] >= 0))
                    state.own[i].answer[side] = nodes[i].inverseMass[side];
        PressedSites::forget(search, pair);
        FrictionLaw law = lawOf(pair.group[0], pair.group[1]);
        law.mayBeThree = mayBeThree;
        unsettled +=
            !state.impulses.solve(search, pair, scene.dt, [&](const ContactSite<Dim>&) { return law; });
        if (!state.impulses.implicit.isEmpty()) pair.negligible = state.impulses.negligible();
        bool isReduced;
        gridLoss += state.impulses.limitEnergy(search, pair, isReduced);
        reduced += isReduced;
        addFriction<Dim>(search, pair, loss());
        for (size_t i = pair.firstNode; i < pair.endNode; ++i)
            exchange(scene, gravity, search.nodes[i], nodes[i]);
        for (size_t i = pair.firstNode; i < pair.endNode && mayBeThree; ++i)
            for (int side = 0; side < 2; ++side)
                state.starts[{search.nodes[i].field[side], search.nodes[i].node}] = nodes[i].start[side];
        state.impulses.implicit.give(scene, nodes, 1 - loss());
    }
    for (const ContactPair<Dim>& pair : search.pairs)
        for (int side = 0; side < 2; ++side)
            if (pair.hasEdges[side])
                edgeMotions.add<Dim>(pairOf(pair.group[0], pair.group[1]), side, pair.motionOfEdges[side],
                                     scene.dt, scene.grid.smallestCell().minCoeff());
    if (scene.scheme->stressFirst) pressed.note(search);
    touch(scene, search);
    addToFacets(scene, state);
    if (!scene.scheme->remapsSolution()) recordShared(scene);
}

// Tells the shared cells where groups press on each other.
template <int Dim> void Contact::touch(Scene<Dim>& scene, const ContactSearch<Dim>& search) {
    if (!scene.state.sharedCells->isWanted) return;
    for (const auto& node : search.nodes)
        if (node.touches) scene.state.sharedCells->touch(node.field, node.node);
    scene.state.sharedCells->closeTouched(scene.grid);
}

// Gives the groups on a node what they have exchanged.
template <int Dim>
void Contact::exchange(Scene<Dim>& scene, const Vec<Dim>& gravity, ContactNode<Dim>& contact,
                       const NodeMotion<Dim>& node) {
    if (node.J[0].all.isZero(0) && node.J[1].all.isZero(0)) return;
    const double loss = this->loss();
    contact.acts = true;
    for (int side = 0; side < 2; ++side) {
        contact.impulse[side] = node.J[side].all - (1 - loss) * node.J[side].agreeing;
        const bool isMovedLater = node.responding[side] >= 0; // with all impulses on the body
        const double sign = isMovedLater ? 0 : side == 0 ? -1 : 1;
        change<Dim>(scene, gravity, contact, side, sign * node.inverseMass[side], node.J[side]);
    }
    const double rubbed =
        contact.friction[0].dot(node.v[0]) - contact.friction[1].dot(node.v[1]); // booked later
    const auto& rows = std::get<State<Dim>>(states_).impulses.nodes;
    scene.energies.contact +=
        loss == 1 && node.responds() ? node.lostByAll() - rubbed : node.lostByStart(loss, rows);
    if (!scene.scheme->remapsSolution()) record<Dim>(scene, contact, node);
}

// The same for velocities that have been made anew from the momentum of the particles. An implicit body is strained
// by the velocity of the solution: here the others only come to it.
template <int Dim> void Contact::tie(Scene<Dim>& scene) {
    using NF = NodalField<Dim>;
    State<Dim>& state = found(scene);
    ContactSearch<Dim>& search = state.search;
    auto& nodes = state.impulses.nodes;
    state.impulses.implicit.clear();
    state.own.resize(search.nodes.size()); // USF comes here first, and has no implicit bodies
    if (state.solved != scene.step) pressed.recall(search, separation);
    for (const ContactPair<Dim>& pair : search.pairs) {
        for (size_t i = pair.firstPoint; i < pair.endPoint; ++i) startAnew(search.points[i]);
        for (size_t i = pair.firstNode; i < pair.endNode; ++i) {
            startAnew(search.nodes[i]);
            const int node = search.nodes[i].node;
            for (int side = 0; side < 2; ++side) {
                const NF& field = scene.grid.fields[search.nodes[i].field[side]];
                const auto& own = state.own[i];
                nodes[i].startInverseMass[side] = inverseMass(field, node);
                nodes[i].inverseMass[side] =
                    own.is[side] ? own.answer[side] : nodes[i].startInverseMass[side];
                for (int k = 0; k < Dim; ++k)
                    nodes[i].v[side][k] = own.is[side] ? field.motion[node][k] : field.velocityOf(node, k);
                nodes[i].start[side] = nodes[i].v[side];
            }
        }
        // Only what has stuck strains as one, or is one body: a stop along a surface that bears nothing would do no work,
        // and the force behind it would.
        state.impulses.solve(search, pair, scene.dt, [&](const ContactSite<Dim>& site) {
            return FrictionLaw{0, 0, !site.sticks && (slip || separation), separation, impactLoss};
        });
        for (size_t i = pair.firstNode; i < pair.endNode; ++i) {
            const ContactNode<Dim>& contact = search.nodes[i];
            for (int side = 0; side < 2; ++side)
                for (int k = 0; k < Dim; ++k)
                    scene.grid.fields[contact.field[side]].setVelocity(contact.node, k, nodes[i].v[side][k]);
            if (scene.scheme->remapsSolution() && contact.acts) record<Dim>(scene, contact, nodes[i]);
        }
    }
    if (scene.scheme->remapsSolution()) recordShared(scene);
}

MPM_REGISTER(Engine, Contact);

} // namespace mpm
