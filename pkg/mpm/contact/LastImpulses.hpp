// SPDX-License-Identifier: GPL-2.0-or-later
// The impulses that the sites of contact beside implicit bodies took in the last step. The rounds of the next one start
// from them: what presses on a stiff body changes little from step to step, and a wall takes a third of the rounds that
// it takes from nothing. They are no more than a start: of sites that are others now they cost some rounds.
#pragma once

#include "mpm/contact/ContactNode.hpp"

#include <algorithm>
#include <tuple>
#include <vector>

namespace mpm {

struct SiteImpulse {
    int first = 0, second = 0; // velocity fields
    int body = -1, number = 0; // the body of a vertex, and the vertex; -1: a node of the grid
    int face = 0;              // of a vertex, see ContactPoint
    Vec3 impulse = Vec3::Zero();

    template <class Self, class Visit> static void members(Self& row, Visit&& visit) {
        visit("first", "", row.first);
        visit("second", "", row.second);
        visit("body", "", row.body);
        visit("number", "", row.number);
        visit("face", "", row.face);
        visit("impulse", "kN s", row.impulse);
    }
    auto place() const { return std::tie(first, second, body, number, face); }
    bool operator<(const SiteImpulse& other) const { return place() < other.place(); }

    template <int Dim> static SiteImpulse of(const ContactNode<Dim>& node, const int* field) {
        return {field[0], field[1], -1, node.node};
    }
    template <int Dim> static SiteImpulse of(const ContactPoint<Dim>& point, const int* field) {
        return {field[0], field[1], point.body, point.vertex, point.face()};
    }
};

class LastImpulses {
  public:
    std::vector<SiteImpulse> rows; // in order

    template <int Dim> Vec<Dim> at(const SiteImpulse& site) const {
        const auto found = std::lower_bound(rows.begin(), rows.end(), site);
        const bool isKnown = found != rows.end() && found->place() == site.place();
        return isKnown ? Vec<Dim>(found->impulse.template head<Dim>()) : Vec<Dim>::Zero();
    }
    template <int Dim> void add(SiteImpulse site, const Vec<Dim>& impulse) {
        if (impulse.isZero(0)) return;
        site.impulse.head<Dim>() = impulse;
        rows.push_back(site);
    }
    void sort() { std::stable_sort(rows.begin(), rows.end()); }
};

} // namespace mpm
