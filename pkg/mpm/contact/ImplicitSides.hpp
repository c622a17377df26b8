// SPDX-License-Identifier: GPL-2.0-or-later
// The groups on contact nodes that implicit bodies move. An impulse on one of them moves the others, too.
#pragma once

#include "mpm/contact/ContactSearch.hpp"
#include "mpm/step/ImplicitBodies.hpp"

namespace mpm {

// A group on a node of the grid: what it answers to impulses, its velocities, and what it takes.
template <int Dim> struct GroupMotion {
    int field, node;
    // 1/Mg along each axis, zero where a constraint holds it. Of an implicit body: what it answers if all sites pushed
    // alike; at the start that of the node alone.
    Vec<Dim> inverseMass, startInverseMass;
    Vec<Dim> first, free, start, v; // m/s: of the start and of the solution, before and after the impulses
    Vec<Dim> taken, agreeing;       // kN s, see Impulses
    double share = 0;               // sum of the weights with which sites push it
    int responding = -1;            // place in the response of implicit bodies, -1: none

    // Energy, kJ, that particles lose when they take a part of what makes the starts agree.
    double lostByStart(double part) const {
        const Vec<Dim> met = -part * agreeing;
        return met.dot(first - 0.5 * startInverseMass.cwiseProduct(met));
    }
};

template <int Dim> class ImplicitSides {
  public:
    using Groups = std::vector<GroupMotion<Dim>>;

    bool isEmpty() const { return response_.nodes.empty(); }
    void clear() { response_.nodes.clear(); }

    // Finds them and tells them their places.
    void find(Scene<Dim>& scene, Groups& groups) {
        clear();
        auto* bodies = scene.template find<ImplicitBodies>();
        if (!bodies) return;
        for (auto& group : groups) {
            if (!bodies->template moves<Dim>(group.field, group.node)) continue;
            group.responding = int(response_.nodes.size());
            response_.nodes.push_back({group.field, group.node});
        }
        if (!isEmpty()) bodies->place(response_);
    }

    // Their inverse masses by the shares of the sites.
    void weigh(Groups& groups) {
        if (isEmpty()) return;
        places_.resize(response_.nodes.size());
        for (auto& group : groups)
            if (group.responding >= 0) places_[group.responding] = &group;
        response_.bound(
            [&](size_t i, int k) { return places_[i]->startInverseMass[k] > 0 ? places_[i]->share : 0.0; },
            bounds_);
        for (size_t i = 0; i < places_.size(); ++i)
            if (places_[i]->share > 0) places_[i]->inverseMass = bounds_[i] / places_[i]->share;
    }
    // Their velocities, by what they take.
    void move(Groups& groups) {
        if (isEmpty()) return;
        solve(groups);
        for (auto& group : groups)
            if (group.responding >= 0) group.v = group.free + response_.velocity(group.responding);
    }

    // The bodies take what was exchanged, and their particles all but a part of what made the velocities of the
    // start agree.
    void give(Scene<Dim>& scene, const Groups& groups, double part) const {
        if (isEmpty()) return;
        std::vector<Vec<Dim>> impulses, unfelt;
        for (const auto& group : groups) {
            if (group.responding < 0) continue;
            impulses.push_back(group.taken);
            unfelt.push_back(part * group.startInverseMass.cwiseProduct(group.agreeing));
        }
        scene.template find<ImplicitBodies>()->take(scene, response_, impulses, unfelt);
    }

  private:
    ImpulseResponse<Dim> response_;
    std::vector<GroupMotion<Dim>*> places_; // of those that respond
    std::vector<Vec<Dim>> bounds_;

    void solve(const Groups& groups) {
        response_.clearImpulses();
        for (const auto& group : groups)
            if (group.responding >= 0)
                for (int k = 0; k < Dim; ++k)
                    if (group.startInverseMass[k] > 0) response_.push(group.responding, k, group.taken[k]);
        response_.solve();
    }
};

} // namespace mpm
