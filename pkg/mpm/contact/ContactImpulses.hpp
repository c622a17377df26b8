// SPDX-License-Identifier: GPL-2.0-or-later
// The impulses of a pair of groups on all its contact nodes and points, which follow each other: projected
// Gauss-Seidel, with the steps of conjugate gradients between its rounds (Silcowitz-Hansen, Niebe & Erleben 2010), beside
// implicit bodies, whose nodes answer each other, along the line through the last two rounds (Anderson 1965). Where it ends
// early, the impulses depend on which site comes first, and those of a mirror image differ.
#pragma once

#include "mpm/contact/ContactSearch.hpp"
#include "mpm/contact/FrictionLaw.hpp"
#include "mpm/contact/ImplicitSides.hpp"

#include <algorithm>

namespace mpm {

// Two groups on a node: inverse masses, velocities at the start and of the solution, what they have exchanged. A
// group answers an impulse by its inverse mass; zero where a constraint holds it.
template <int Dim> struct NodeMotion {
    Mat<Dim> inverseMass[2];           // of an implicit body: its answer to impulses
    Mat<Dim> startInverseMass[2];      // of the node alone
    Vec<Dim> first[2], start[2], v[2]; // first: at the start, before the pairs that came earlier
    Impulses<Dim> J[2];                // what the first group loses, and what the second gets
    // Place in the response of implicit bodies, -1: none. ImplicitSides has v then, until it tells the nodes.
    int responding[2] = {-1, -1};
    int twin[2] = {-1, -1}; // the row that has the same velocity of a side, see ContactNode

    static double sign(int side) { return side == 0 ? -1 : 1; }
    // With those of the twin.
    Impulses<Dim> allOn(int side, const std::vector<NodeMotion>& rows) const {
        Impulses<Dim> all = J[side];
        if (twin[side] < 0) return all;
        all.all += rows[twin[side]].J[side].all;
        all.agreeing += rows[twin[side]].J[side].agreeing;
        return all;
    }
    void take(int side, const Impulses<Dim>& more, double weight) {
        J[side].all += weight * more.all;
        J[side].agreeing += weight * more.agreeing;
        weight *= sign(side);
        if (responding[side] < 0) v[side] += weight * inverseMass[side] * more.all;
        start[side] += weight * startInverseMass[side] * more.agreeing;
    }
    // Energy, kJ, that particles lose when they take a part of what makes the starts agree; of earlier pairs they have
    // taken the same part.
    double lostByStart(double part, const std::vector<NodeMotion>& rows = {}) const {
        double lost = 0;
        for (int side = 0; side < 2; ++side) {
            const Mat<Dim>& W = startInverseMass[side];
            const Vec<Dim> made = sign(side) * W * allOn(side, rows).agreeing, before = start[side] - made;
            const Vec<Dim> met = -sign(side) * part * J[side].agreeing;
            lost += met.dot((1 - part) * first[side] + part * before + 0.5 * part * made);
        }
        return lost;
    }
    // Where an implicit body answers, the rest of an impulse stops the body as a whole: then by all of it, with the mean
    // velocities of the step. Of particles that take all.
    double lostByAll() const {
        double lost = 0;
        for (int side = 0; side < 2; ++side)
            lost -= 0.5 * sign(side) * J[side].all.dot(first[side] + v[side]);
        return lost;
    }
    bool responds() const { return responding[0] >= 0 || responding[1] >= 0; }
};

template <int Dim> class ContactImpulses {
  public:
    std::vector<NodeMotion<Dim>> nodes; // a row for each contact node of the search
    ImplicitSides<Dim> implicit;        // of the pair in work

    // What a round of the last solution may change, by the energy of the motion, kJ.
    double negligible() const { return negligible_; }

    // lawOf(site): the friction law there. Returns whether the rounds have come to an end of their own.
    template <class LawOf>
    bool solve(ContactSearch<Dim>& search, const ContactPair<Dim>& pair, double dt, LawOf&& lawOf) {
        const bool isCoupled = !implicit.isEmpty();
        if (pair.ownsFacets && !isCoupled) share(search, pair, dt, lawOf);
        const bool hasPoints = pair.firstPoint < pair.endPoint; // else no node sees another one
        const int most = isCoupled ? mostCoupledRounds : hasPoints ? mostRounds : 1;
        if (most > 1) start(search, pair);
        mobilities_.clear();
        bool isSettled = most == 1;
        for (int round = 0; round < most && (round == 0 || !isSettled); ++round) {
            size_t number = 0;
            forSites(search, pair, [&](auto& site, const SiteNodes<Dim>& at) {
                const FrictionLaw law = lawOf(site);
                if (round == 0) mobilities_.emplace_back();
                implicit.goTo(number);
                // Else what shares a node stays together, and nothing crosses between nodes.
                if (at.count == 1 || law.separation) update(site, law, dt, at, mobilities_[number]);
                ++number;
            });
            if (most == 1) continue;
            const double last = changed_;
            isSettled = isDone(pair, isCoupled ? coupledConvergence : convergence);
            if (isSettled || round + 1 == most) continue;
            if (isCoupled)
                mix(search, pair, last > 0);
            else
                goOn(search, pair, changed_ < last ? changed_ / last : 0);
            note(pair);
        }
        implicit.tell(nodes);
        return isSettled;
    }

    // Energy, kJ, that a pair takes from the motion of the nodes: J . w - J . mobility J / 2, w from before
    // the exchange. Frictionless rounds never give any, finished ones neither. Adhesion and friction that
    // come and go between rounds might: then `isReduced`, and the part of all impulses is left that takes
    // most.
    double limitEnergy(ContactSearch<Dim>& search, const ContactPair<Dim>& pair, bool& isReduced) {
        double stopped = 0, answered = 0;
        for (size_t i = pair.firstNode; i < pair.endNode; ++i) {
            const NodeMotion<Dim>& node = nodes[i];
            for (int side = 0; side < 2; ++side) {
                const Vec<Dim> taken = node.sign(side) * node.J[side].all,
                               change = implicit.isEmpty()
                                            ? Vec<Dim>(node.inverseMass[side] * node.sign(side) *
                                                       node.allOn(side, nodes).all)
                                            : implicit.changeSince(i - pair.firstNode, side, node.v[side]);
                stopped -= taken.dot(node.v[side] - change);
                answered += taken.dot(change);
            }
        }
        isReduced = !(stopped >= 0.5 * answered);
        if (!isReduced) return stopped - 0.5 * answered;
        const double part = stopped > 0 ? stopped / answered : 0;
        for (size_t i = pair.firstNode; i < pair.endNode; ++i) {
            for (int side = 0; side < 2; ++side)
                give(int(i), side, Impulses<Dim>(nodes[i].J[side]), part - 1);
            search.nodes[i].J.scale(part);
        }
        implicit.tell(nodes);
        for (size_t i = pair.firstPoint; i < pair.endPoint; ++i) search.points[i].J.scale(part);
        return 0.5 * part * stopped;
    }

  private:
    // Where vertices are dense on the grid all are taken; what they leave of a T-bar's force is 3e-6. With 50 a step of
    // it costs a fifth more.
    static constexpr int mostRounds = 20;
    // Change of the impulses in a round over their size, by the energy of the motion that they make, below which they
    // are done.
    static constexpr double convergence = 1e-6;
    // Beside an implicit body.
    static constexpr int mostCoupledRounds = 50;
    static constexpr double coupledConvergence = 1e-4;
    // By how many times their last change the impulses go on between two rounds, where these go on alike. With 3 and with
    // 30 a wall of one cell in soil takes as many rounds.
    static constexpr double mostAhead = 10;

    // Looks at nodes: sites that take from each other what one node gets may do so for ever, and move nothing.
    bool isDone(const ContactPair<Dim>& pair, double least) {
        double size = changed_ = 0;
        for (size_t i = pair.firstNode; i < pair.endNode; ++i)
            for (int side = 0; side < 2; ++side) {
                const Vec<Dim>&J = nodes[i].J[side].all, more = J - before_[i - pair.firstNode][side];
                const Mat<Dim>& W = nodes[i].inverseMass[side];
                changed_ += more.dot(W * more);
                size += J.dot(W * J);
            }
        negligible_ = std::max(least * least * size, pair.negligible);
        return changed_ <= negligible_;
    }
    // What the impulses are before a round.
    void note(const ContactPair<Dim>& pair) {
        for (size_t i = pair.firstNode; i < pair.endNode; ++i)
            before_[i - pair.firstNode] = {nodes[i].J[0].all, nodes[i].J[1].all};
    }
    void start(ContactSearch<Dim>& search, const ContactPair<Dim>& pair) {
        before_.resize(pair.endNode - pair.firstNode);
        note(pair);
        courses_.clear();
        forSites(search, pair, [&](const ContactSite<Dim>& site, const SiteNodes<Dim>&) {
            courses_.push_back({site.J.all, Vec<Dim>::Zero()});
        });
        changed_ = 0;
    }
    // The impulses go on as they went before the last round, by the part of the way. 0: anew, for its end is passed.
    void goOn(ContactSearch<Dim>& search, const ContactPair<Dim>& pair, double part) {
        auto course = courses_.begin();
        forSites(search, pair, [&](ContactSite<Dim>& site, const SiteNodes<Dim>& at) {
            auto& [before, way] = *course++;
            const Vec<Dim> step = site.J.all - before, more = part * way;
            if (!more.isZero(0)) give(at, {more, Vec<Dim>::Zero()});
            before = site.J.all += more;
            way = part > 0 ? Vec<Dim>(more + step) : more;
        });
    }
    // Beside implicit bodies: the part of the way from the last round to this one after which what a round changes is
    // least, by the energy of the motion.
    void mix(ContactSearch<Dim>& search, const ContactPair<Dim>& pair, bool isAny) {
        double along = 0, square = 0;
        rest_.resize(pair.endNode - pair.firstNode);
        for (size_t i = pair.firstNode; i < pair.endNode; ++i)
            for (int side = 0; side < 2; ++side) {
                Vec<Dim>& last = rest_[i - pair.firstNode][side];
                const Vec<Dim> rest = nodes[i].J[side].all - before_[i - pair.firstNode][side],
                               change = rest - last, moved = nodes[i].inverseMass[side] * change;
                along += rest.dot(moved);
                square += change.dot(moved);
                last = rest;
            }
        const double part = isAny && square > 0 ? std::clamp(-along / square, -0.5, mostAhead) : 0;
        auto course = courses_.begin();
        forSites(search, pair, [&](ContactSite<Dim>& site, const SiteNodes<Dim>& at) {
            Vec<Dim>& last = (course++)->before;
            const Vec<Dim> more = part * (site.J.all - last);
            last = site.J.all;
            if (more.isZero(0)) return;
            give(at, {more, Vec<Dim>::Zero()});
            site.J.all += more;
        });
    }
    // visit(site, the nodes that it acts on) for all of a pair, along implicit bodies.
    template <class Visit>
    void forSites(ContactSearch<Dim>& search, const ContactPair<Dim>& pair, Visit&& visit) const {
        const auto visitNode = [&](int i) {
            if (!search.nodes[i].isLeftOut) visit(search.nodes[i], alone(i));
        };
        const auto visitPoint = [&](int i) { visit(search.points[i], search.points[i].sites()); };
        if (!implicit.isEmpty()) {
            for (const auto& site : implicit.sites())
                site.node >= 0 ? visitNode(site.node) : visitPoint(site.point);
            return;
        }
        for (int i = int(pair.firstNode); i < int(pair.endNode); ++i) visitNode(i);
        for (int i = int(pair.firstPoint); i < int(pair.endPoint); ++i) visitPoint(i);
    }
    std::vector<std::array<Vec<Dim>, 2>>
        before_;                                // impulses on the nodes of the pair before the round in work
    std::vector<std::array<Vec<Dim>, 2>> rest_; // what the last one has changed
    // The same at its sites, and how they went from there, kN s.
    struct Course {
        Vec<Dim> before, way;
    };
    std::vector<Course> courses_;
    double changed_ = 0;    // energy of the motion by what the last round has changed, kJ,
    double negligible_ = 0; // and what ends the rounds

    void give(int i, int side, const Impulses<Dim>& more, double weight) {
        nodes[i].take(side, more, weight);
        if (const int twin = nodes[i].twin[side]; twin >= 0) {
            nodes[twin].v[side] = nodes[i].v[side];
            nodes[twin].start[side] = nodes[i].start[side];
        }
        if (const int pushed = nodes[i].responding[side]; pushed >= 0)
            implicit.push(pushed, nodes[i].sign(side) * weight * more.all);
    }
    void give(const SiteNodes<Dim>& at, const Impulses<Dim>& more) {
        for (int i = 0; i < at.count; ++i)
            for (int side = 0; side < 2; ++side)
                if (at.S[side][i] != 0) give(at.at[i], side, more, at.S[side][i]);
    }
    static SiteNodes<Dim> alone(const int& node) {
        static constexpr double one = 1;
        return {1, &node, {&one, &one}};
    }

    // Of a site, by all that moves its nodes, and by the masses of these alone.
    struct Mobility {
        Mat<Dim> all = Mat<Dim>::Zero(), start = all;
        bool isKnown = false;
    };
    std::vector<Mobility> mobilities_; // of the sites, in the order of a round
    // shares: for each node the sums of the weights with which sites push its groups; nullptr: a site is alone.
    Mobility mobilityAt(const SiteNodes<Dim>& at, const std::array<double, 2>* shares) const {
        Mobility found;
        found.isKnown = true;
        for (int i = 0; i < at.count; ++i)
            for (int side = 0; side < 2; ++side) {
                const NodeMotion<Dim>& node = nodes[at.at[i]];
                const double S = at.S[side][i], weight = S * (shares ? shares[at.at[i]][side] : S);
                if (weight == 0) continue;
                found.all += weight * node.inverseMass[side];
                found.start += weight * node.startInverseMass[side];
            }
        if (at.count > 1 && !implicit.isEmpty()) found.all += implicit.mutualMobility(nodes, at);
        return found;
    }
    // Relative velocity at the start.
    Vec<Dim> startAt(const SiteNodes<Dim>& at) const {
        Vec<Dim> start = Vec<Dim>::Zero();
        for (int i = 0; i < at.count; ++i)
            for (int side = 0; side < 2; ++side) {
                const NodeMotion<Dim>& node = nodes[at.at[i]];
                if (at.S[side][i] != 0) start -= node.sign(side) * at.S[side][i] * node.start[side];
            }
        return start;
    }
    // Of the first group against the second.
    Vec<Dim> velocityAt(const SiteNodes<Dim>& at) const {
        Vec<Dim> w = Vec<Dim>::Zero();
        for (int i = 0; i < at.count; ++i)
            for (int side = 0; side < 2; ++side) {
                if (at.S[side][i] == 0) continue;
                const NodeMotion<Dim>& node = nodes[at.at[i]];
                const int place = node.responding[side];
                w -= node.sign(side) * at.S[side][i] * (place < 0 ? node.v[side] : implicit.velocity(place));
            }
        return w;
    }

    // Sites near each other stop the same approach. The first that is asked would take it all, and the others, which
    // then do not press, would bear no adhesion and friction. So each first takes its share at once: what it took if
    // all of them pushed alike (Jacobi's rule with the sums of the rows).
    template <class LawOf>
    void share(ContactSearch<Dim>& search, const ContactPair<Dim>& pair, double dt, LawOf&& lawOf) {
        shares_.assign(nodes.size(), {0.0, 0.0});
        forSites(search, pair, [&](const ContactSite<Dim>&, const SiteNodes<Dim>& at) {
            for (int i = 0; i < at.count; ++i)
                for (int side = 0; side < 2; ++side) shares_[at.at[i]][side] += at.S[side][i];
        });
        addTwins(pair);
        forSites(search, pair, [&](ContactSite<Dim>& site, const SiteNodes<Dim>& at) {
            const Mobility mobility = mobilityAt(at, shares_.data());
            site.J = lawOf(site).template impulses<Dim>(site, dt, mobility.all, mobility.start, startAt(at),
                                                        velocityAt(at));
        });
        forSites(search, pair,
                 [&](const ContactSite<Dim>& site, const SiteNodes<Dim>& at) { give(at, site.J); });
    }
    // What pushes a wall from both sides pushes the same node.
    void addTwins(const ContactPair<Dim>& pair) {
        for (int i = int(pair.firstNode); i < int(pair.endNode); ++i)
            for (int side = 0; side < 2; ++side)
                if (const int twin = nodes[i].twin[side]; twin > i)
                    shares_[i][side] = shares_[twin][side] = shares_[i][side] + shares_[twin][side];
    }
    std::vector<std::array<double, 2>> shares_;

    // The impulse at a site between nodes anew, in view of what the others exchange.
    void update(ContactSite<Dim>& site, const FrictionLaw& law, double dt, const SiteNodes<Dim>& at,
                Mobility& mobility) {
        if (site.J.all.isZero(0) && law.isApart(site, dt, velocityAt(at)))
            return; // and nothing makes it agree
        if (!mobility.isKnown) mobility = mobilityAt(at, nullptr);
        const Vec<Dim> start = startAt(at) + mobility.start * site.J.agreeing,
                       w = velocityAt(at) + mobility.all * site.J.all;
        const Impulses<Dim> J = law.impulses<Dim>(site, dt, mobility.all, mobility.start, start, w);
        const Impulses<Dim> more{J.all - site.J.all, J.agreeing - site.J.agreeing};
        site.J = J;
        if (!more.all.isZero(0) || !more.agreeing.isZero(0)) give(at, more);
    }
};

} // namespace mpm
