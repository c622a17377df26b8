// SPDX-License-Identifier: GPL-2.0-or-later
// The sides of contact nodes that implicit bodies move. An impulse on one of them moves the others, too.
#pragma once

#include "mpm/contact/ContactSearch.hpp"
#include "mpm/step/ImpulseResponse.hpp"

namespace mpm {

template <int Dim> class ImplicitSides {
  public:
    bool isEmpty() const { return response_.isEmpty(); }

    // Finds those of a pair of groups, lets `nodes` know their places, and puts their own answers in the place of
    // inverse masses.
    template <class Nodes>
    void find(Scene<Dim>& scene, const ContactSearch<Dim>& search, const ContactPair<Dim>& pair,
              Nodes& nodes) {
        clear();
        start_.clear();
        before_.clear();
        auto* bodies = scene.template role<ImplicitMotion<Dim>>();
        if (!bodies) return;
        for (size_t i = pair.firstNode; i < pair.endNode; ++i)
            for (int side = 0; side < 2; ++side) {
                const int field = search.nodes[i].field[side], node = search.nodes[i].node;
                if (!scene.state.implicitNodes.moves(field, node)) continue;
                if (const int twin = nodes[i].twin[side]; twin >= 0 && twin < int(i)) {
                    nodes[i].responding[side] = nodes[twin].responding[side];
                    continue;
                }
                nodes[i].responding[side] = int(response_.nodes.size());
                response_.nodes.push_back({field, node});
                places_.push_back({int(i), side});
            }
        if (isEmpty()) return;
        bodies->place(response_);
        bodies->start(scene, response_, order(search, pair, nodes));
        for (size_t r = 0; r < places_.size(); ++r) {
            const auto [contact, side] = places_[r];
            start_.push_back(nodes[contact].v[side]);
            for (int row : {contact, nodes[contact].twin[side]})
                if (row >= 0) nodes[row].inverseMass[side] = response_.of(int(r), int(r));
        }
        for (size_t i = pair.firstNode; i < pair.endNode; ++i)
            before_.push_back({nodes[i].v[0], nodes[i].v[1]});
    }

    void clear() {
        response_.clear();
        places_.clear();
    }

    // A site of contact of the pair: a node, or else a point.
    struct Site {
        int node, point;
        int lowest;        // unknown of its nodes
        size_t first, end; // of those that it asks, see asked_
    };
    // All of them, in the order in which one comes by them on the way along a body.
    const std::vector<Site>& sites() const { return sites_; }
    // One is at a site now, by its number: the velocities of its nodes are those of all impulses so far.
    void goTo(size_t site) {
        if (isEmpty()) return;
        for (size_t i = sites_[site].first; i < sites_[site].end; ++i)
            response_.bodies[asked_[i].first].goTo(asked_[i].second);
    }
    void push(int place, const Vec<Dim>& impulse) { response_.push(place, impulse); }
    Vec<Dim> velocity(int place) const { return start_[place] + response_.velocity(place); }
    // Their velocities are kept here until told to the nodes.
    template <class Nodes> void tell(Nodes& nodes) {
        if (isEmpty()) return;
        for (const auto& asked : response_.nodes) response_.bodies[asked.body].restart();
        for (size_t r = 0; r < places_.size(); ++r) {
            const auto [contact, side] = places_[r];
            for (int row : {contact, nodes[contact].twin[side]})
                if (row >= 0) nodes[row].v[side] = velocity(int(r));
        }
    }

    // Change of the velocity of a side at contact node number i of the pair.
    Vec<Dim> changeSince(size_t i, int side, const Vec<Dim>& v) const { return v - before_[i][side]; }

    // What the mobility of a site between nodes has beyond that of each of them.
    template <class Nodes> Mat<Dim> mutualMobility(const Nodes& nodes, const SiteNodes<Dim>& at) const {
        Mat<Dim> sum = Mat<Dim>::Zero();
        for (int i = 0; i < at.count; ++i)
            for (int j = 0; j < at.count; ++j)
                for (int side = 0; side < 2 && i != j; ++side) {
                    const int a = nodes[at.at[i]].responding[side], b = nodes[at.at[j]].responding[side];
                    if (a >= 0 && b >= 0) sum += at.S[side][i] * at.S[side][j] * response_.of(a, b);
                }
        return sum;
    }

    // The bodies take what was exchanged, and their particles all but a part of what made the velocities of the
    // start agree.
    template <class Nodes> void give(Scene<Dim>& scene, const Nodes& nodes, double part) const {
        if (isEmpty()) return;
        std::vector<Vec<Dim>> impulses, unfelt;
        for (const Place& place : places_) {
            const auto& node = nodes[place.contact];
            const Impulses<Dim> J = node.allOn(place.side, nodes);
            const double sign = node.sign(place.side);
            impulses.push_back(sign * J.all);
            unfelt.push_back(sign * part * node.startInverseMass[place.side] * J.agreeing);
        }
        scene.template role<ImplicitMotion<Dim>>()->take(scene, response_, impulses, unfelt);
    }

  private:
    struct Place {
        int contact, side;
    };
    ImpulseResponse<Dim> response_;
    std::vector<Place> places_;
    std::vector<Site> sites_;
    std::vector<std::pair<int, int>> asked_;      // bodies, and the lowest unknown of them at a site
    std::vector<Vec<Dim>> start_;                 // velocities of those that respond before all impulses, m/s
    std::vector<std::array<Vec<Dim>, 2>> before_; // of both sides of the contact nodes of the pair

    // f(body, lowest, highest unknown) for the bodies that move some nodes.
    template <class Nodes, class F>
    void forBodies(const Nodes& nodes, const int* at, int count, F&& f) const {
        for (int i = 0; i < count; ++i)
            for (int side = 0; side < 2; ++side) {
                const int place = nodes[at[i]].responding[side];
                if (place < 0) continue;
                const int body = response_.nodes[place].body;
                int lowest = response_.nodes[place].unknown, highest = lowest;
                for (int j = 0; j < count; ++j)
                    for (int other : nodes[at[j]].responding)
                        if (other >= 0 && response_.nodes[other].body == body) {
                            lowest = std::min(lowest, response_.nodes[other].unknown);
                            highest = std::max(highest, response_.nodes[other].unknown);
                        }
                f(body, lowest, highest);
            }
    }
    // Puts the sites in order; returns a bound on how far apart the unknowns of one are.
    template <class Nodes>
    int order(const ContactSearch<Dim>& search, const ContactPair<Dim>& pair, const Nodes& nodes) {
        sites_.clear();
        asked_.clear();
        int span = Dim;
        const auto add = [&](int node, int point, const int* at, int count) {
            Site site{node, point, -1, asked_.size(), 0};
            forBodies(nodes, at, count, [&](int body, int lowest, int highest) {
                span = std::max(span, highest - lowest + Dim);
                site.lowest = std::max(site.lowest, lowest);
                const std::pair<int, int> asks{body, lowest};
                if (std::find(asked_.begin() + site.first, asked_.end(), asks) == asked_.end())
                    asked_.push_back(asks);
            });
            site.end = asked_.size();
            sites_.push_back(site);
        };
        for (int i = int(pair.firstNode); i < int(pair.endNode); ++i)
            if (!search.nodes[i].isLeftOut) add(i, -1, &i, 1);
        for (int i = int(pair.firstPoint); i < int(pair.endPoint); ++i)
            add(-1, i, search.points[i].contact, search.points[i].size);
        std::stable_sort(sites_.begin(), sites_.end(),
                         [](const Site& a, const Site& b) { return a.lowest > b.lowest; });
        return span;
    }
};

} // namespace mpm
