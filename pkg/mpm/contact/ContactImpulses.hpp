// SPDX-License-Identifier: GPL-2.0-or-later
// The impulses of a pair of groups on all its contact nodes and points, which follow each other: projected
// Gauss-Seidel.
#pragma once

#include "mpm/contact/ContactSearch.hpp"
#include "mpm/contact/FrictionLaw.hpp"
#include "mpm/contact/ImplicitSides.hpp"

namespace mpm {

// Two groups on a node: inverse masses, velocities at the start and of the solution, what they have exchanged. A
// group answers an impulse by its inverse mass; zero where a constraint holds it.
template <int Dim> struct NodeMotion {
    Mat<Dim> inverseMass[2];           // of an implicit body: its answer to impulses
    Mat<Dim> startInverseMass[2];      // of the node alone
    Vec<Dim> first[2], start[2], v[2]; // first: at the start, before the pairs that came earlier
    Impulses<Dim> J;
    // Place in the response of implicit bodies, -1: none. ImplicitSides has v then, until it tells the nodes.
    int responding[2] = {-1, -1};

    void take(const Impulses<Dim>& more, double weight) {
        J.all += weight * more.all;
        J.agreeing += weight * more.agreeing;
        for (int side = 0; side < 2; ++side) {
            const double sign = side == 0 ? -weight : weight;
            if (responding[side] < 0) v[side] += sign * inverseMass[side] * more.all;
            start[side] += sign * startInverseMass[side] * more.agreeing;
        }
    }
    // Energy, kJ, that particles lose when they take a part of what makes the starts agree; of earlier pairs they have
    // taken the same part.
    double lostByStart(double part) const {
        const Mat<Dim> mobility = startMobility();
        const Vec<Dim> before = start[0] - start[1] + mobility * J.agreeing;
        const Vec<Dim> met = part * J.agreeing,
                       ofParticles = (1 - part) * (first[0] - first[1]) + part * before;
        return met.dot(ofParticles - 0.5 * mobility * met);
    }
    Mat<Dim> startMobility() const { return startInverseMass[0] + startInverseMass[1]; }
    Mat<Dim> mobility() const { return inverseMass[0] + inverseMass[1]; }
};

template <int Dim> class ContactImpulses {
  public:
    std::vector<NodeMotion<Dim>> nodes; // a row for each contact node of the search
    ImplicitSides<Dim> implicit;        // of the pair in work

    // lawOf(site): the friction law there. Returns whether the rounds have come to an end of their own.
    template <class LawOf>
    bool solve(ContactSearch<Dim>& search, const ContactPair<Dim>& pair, double dt, LawOf&& lawOf) {
        const double one = 1;
        const bool isCoupled = !implicit.isEmpty();
        if (pair.ownsFacets && !isCoupled) share(search, pair, dt, lawOf);
        const bool hasPoints = pair.firstPoint < pair.endPoint; // else no node sees another one
        const int most = isCoupled ? mostCoupledRounds : hasPoints ? mostRounds : 1;
        before_.assign(pair.endNode - pair.firstNode, Vec<Dim>::Zero());
        const auto updateNode = [&](int i) {
            if (!search.nodes[i].isLeftOut) update(search.nodes[i], lawOf(search.nodes[i]), dt, &i, &one, 1);
        };
        const auto updatePoint = [&](int i) {
            ContactPoint<Dim>& point = search.points[i];
            const FrictionLaw law = lawOf(point);
            // Else what shares a node stays together, and nothing crosses between nodes.
            if (law.separation) update(point, law, dt, point.contact, point.S, point.size);
        };
        bool isSettled = most == 1;
        for (int round = 0; round < most && (round == 0 || !isSettled); ++round) {
            if (isCoupled)
                for (const auto& site : implicit.sites())
                    site.node >= 0 ? updateNode(site.node) : updatePoint(site.point);
            else {
                for (int i = int(pair.firstNode); i < int(pair.endNode); ++i) updateNode(i);
                for (int i = int(pair.firstPoint); i < int(pair.endPoint); ++i) updatePoint(i);
            }
            if (most > 1) isSettled = isDone(pair);
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
            const Vec<Dim> change = implicit.isEmpty() ? Vec<Dim>(node.mobility() * node.J.all)
                                                       : implicit.changeSince(i - pair.firstNode, node.v);
            stopped += node.J.all.dot(node.v[0] - node.v[1] + change);
            answered += node.J.all.dot(change);
        }
        isReduced = !(stopped >= 0.5 * answered);
        if (!isReduced) return stopped - 0.5 * answered;
        const double part = stopped > 0 ? stopped / answered : 0;
        for (size_t i = pair.firstNode; i < pair.endNode; ++i) {
            give(int(i), Impulses<Dim>(nodes[i].J), part - 1);
            search.nodes[i].J.scale(part);
        }
        implicit.tell(nodes);
        for (size_t i = pair.firstPoint; i < pair.endPoint; ++i) search.points[i].J.scale(part);
        return 0.5 * part * stopped;
    }

  private:
    // With 30 rounds contact between meshes costs twice as much, and gives back 0.01 instead of 0.1 % of the
    // energy.
    static constexpr int mostRounds = 10;
    // Beside an implicit body, whose nodes answer each other; about 6 are taken.
    static constexpr int mostCoupledRounds = 50;
    // Change of the impulses in a round over their size, by the energy of the motion that they make, below which they
    // are done.
    static constexpr double convergence = 1e-4;

    // Looks at nodes: sites that take from each other what one node gets may do so for ever, and move nothing.
    bool isDone(const ContactPair<Dim>& pair) {
        double changed = 0, size = 0;
        for (size_t i = pair.firstNode; i < pair.endNode; ++i) {
            const Vec<Dim>&J = nodes[i].J.all, more = J - before_[i - pair.firstNode];
            const Mat<Dim> mobility = nodes[i].mobility();
            changed += more.dot(mobility * more);
            size += J.dot(mobility * J);
            before_[i - pair.firstNode] = J;
        }
        return changed <= convergence * convergence * size;
    }
    std::vector<Vec<Dim>> before_; // impulses on the nodes of the pair after the last round

    void give(int i, const Impulses<Dim>& more, double weight) {
        nodes[i].take(more, weight);
        for (int side = 0; side < 2; ++side)
            if (const int pushed = nodes[i].responding[side]; pushed >= 0)
                implicit.push(pushed, (side == 0 ? -weight : weight) * more.all);
    }

    // Relative velocities at a site between nodes with weights S, and its mobilities.
    struct Relative {
        Mat<Dim> mobility = Mat<Dim>::Zero(), startMobility = mobility;
        Vec<Dim> start = Vec<Dim>::Zero(), w = start;
    };
    // shares: for each node the sum of the weights with which sites push it; nullptr: a site is alone.
    Relative relativeAt(const int* at, const double* S, int count, const double* shares) const {
        Relative found;
        for (int i = 0; i < count; ++i) {
            const NodeMotion<Dim>& node = nodes[at[i]];
            const double weight = S[i] * (shares ? shares[at[i]] : S[i]);
            found.mobility += weight * node.mobility();
            found.startMobility += weight * node.startMobility();
            found.start += S[i] * (node.start[0] - node.start[1]);
            found.w += S[i] * velocityAt(node);
        }
        return found;
    }
    // Of the first group against the second.
    Vec<Dim> velocityAt(const NodeMotion<Dim>& node) const {
        const auto of = [&](int side) {
            const int place = node.responding[side];
            return place < 0 ? node.v[side] : implicit.velocity(place);
        };
        return of(0) - of(1);
    }

    // Sites near each other stop the same approach. The first that is asked would take it all, and the others, which
    // then do not press, would bear no adhesion and friction. So each first takes its share at once: what it took if
    // all of them pushed alike (Jacobi's rule with the sums of the rows).
    template <class LawOf>
    void share(ContactSearch<Dim>& search, const ContactPair<Dim>& pair, double dt, LawOf&& lawOf) {
        const double one = 1;
        shares_.assign(nodes.size(), 0.0);
        const auto forSites = [&](auto&& visit) {
            for (int i = int(pair.firstNode); i < int(pair.endNode); ++i)
                if (!search.nodes[i].isLeftOut) visit(search.nodes[i], &i, &one, 1);
            for (size_t i = pair.firstPoint; i < pair.endPoint; ++i)
                visit(search.points[i], search.points[i].contact, search.points[i].S, search.points[i].size);
        };
        forSites([&](const ContactSite<Dim>&, const int* at, const double* S, int count) {
            for (int i = 0; i < count; ++i) shares_[at[i]] += S[i];
        });
        forSites([&](ContactSite<Dim>& site, const int* at, const double* S, int count) {
            const Relative r = relativeAt(at, S, count, shares_.data());
            site.J = lawOf(site).template impulses<Dim>(site, dt, r.mobility, r.startMobility, r.start, r.w);
        });
        forSites([&](const ContactSite<Dim>& site, const int* at, const double* S, int count) {
            for (int i = 0; i < count; ++i) give(at[i], site.J, S[i]);
        });
    }
    std::vector<double> shares_;

    // The impulse at a site between nodes with weights S, anew, in view of what the others exchange.
    void update(ContactSite<Dim>& site, const FrictionLaw& law, double dt, const int* at, const double* S,
                int count) {
        if (!implicit.isEmpty()) implicit.goTo(nodes, at, count);
        if (site.J.all.isZero(0)) { // and so nothing makes it agree
            Vec<Dim> w = Vec<Dim>::Zero();
            for (int i = 0; i < count; ++i) w += S[i] * velocityAt(nodes[at[i]]);
            if (law.isApart(site, dt, w)) return;
        }
        auto [mobility, startMobility, start, w] = relativeAt(at, S, count, nullptr);
        if (count > 1 && !implicit.isEmpty()) mobility += implicit.mutualMobility(nodes, at, S, count);
        start += startMobility * site.J.agreeing;
        w += mobility * site.J.all;
        const Impulses<Dim> J = law.impulses<Dim>(site, dt, mobility, startMobility, start, w);
        const Impulses<Dim> more{J.all - site.J.all, J.agreeing - site.J.agreeing};
        site.J = J;
        if (!more.all.isZero(0) || !more.agreeing.isZero(0))
            for (int i = 0; i < count; ++i) give(at[i], more, S[i]);
    }
};

} // namespace mpm
