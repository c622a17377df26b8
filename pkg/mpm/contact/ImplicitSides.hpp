// SPDX-License-Identifier: GPL-2.0-or-later
// The sides of contact nodes that implicit bodies move. An impulse on one of them moves the others, too.
#pragma once

#include "mpm/contact/ContactNode.hpp"
#include "mpm/step/ImplicitBodies.hpp"

namespace mpm {

template <int Dim> class ImplicitSides {
  public:
    bool isEmpty() const { return response_.isEmpty(); }

    // Finds those of a pair of groups, lets `nodes` know their places, and puts their own answers in the place of
    // inverse masses.
    template <class Nodes>
    void find(Scene<Dim>& scene, const std::vector<ContactNode<Dim>>& contacts, const ContactPair& pair,
              Nodes& nodes) {
        response_.clear();
        places_.clear();
        before_.clear();
        auto* bodies = scene.template find<ImplicitBodies>();
        if (!bodies) return;
        for (size_t i = pair.firstNode; i < pair.endNode; ++i)
            for (int side = 0; side < 2; ++side) {
                const int field = contacts[i].field[side], node = contacts[i].node;
                if (!bodies->template moves<Dim>(field, node)) continue;
                nodes[i].responding[side] = int(response_.nodes.size());
                response_.nodes.push_back({field, node});
                places_.push_back({int(i), side});
            }
        if (isEmpty()) return;
        bodies->respond(scene, response_);
        velocity_.assign(response_.size(), 0.0);
        for (size_t r = 0; r < places_.size(); ++r) {
            auto& node = nodes[places_[r].contact];
            node.inverseMass[places_[r].side] = response_.of(int(r), int(r));
            for (int k = 0; k < Dim; ++k) velocity_[response_.rows[r] + k] = node.v[places_[r].side][k];
        }
        for (size_t i = pair.firstNode; i < pair.endNode; ++i)
            before_.push_back(nodes[i].v[0] - nodes[i].v[1]);
    }

    void clear() {
        response_.clear();
        places_.clear();
    }

    // An impulse on one of them. Their velocities are kept here, one behind the other, until told to the nodes.
    void spread(int pushed, const Vec<Dim>& impulse) {
        double* v = velocity_.data();
        for (int k = 0; k < Dim; ++k) {
            const double *column = response_.column(response_.rows[pushed] + k), J = impulse[k];
            for (int i = 0; i < response_.size(); ++i) v[i] += J * column[i];
        }
    }
    Vec<Dim> velocity(int place) const {
        return Eigen::Map<const Vec<Dim>>(velocity_.data() + response_.rows[place]);
    }
    template <class Nodes> void tell(Nodes& nodes) const {
        for (size_t r = 0; r < places_.size(); ++r)
            nodes[places_[r].contact].v[places_[r].side] = velocity(int(r));
    }

    // Change of the relative velocity at contact node number i of the pair.
    Vec<Dim> changeSince(size_t i, const Vec<Dim> (&v)[2]) const { return before_[i] - (v[0] - v[1]); }

    // What the mobility of a site between nodes has beyond that of each of them.
    template <class Nodes>
    Mat<Dim> mutualMobility(const Nodes& nodes, const int* at, const double* S, int count) const {
        Mat<Dim> sum = Mat<Dim>::Zero();
        for (int i = 0; i < count; ++i)
            for (int j = 0; j < count; ++j)
                for (int side = 0; side < 2 && i != j; ++side) {
                    const int a = nodes[at[i]].responding[side], b = nodes[at[j]].responding[side];
                    if (a >= 0 && b >= 0) sum += S[i] * S[j] * response_.of(a, b);
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
            const double sign = place.side == 0 ? -1 : 1;
            impulses.push_back(sign * node.J.all);
            unfelt.push_back(sign * part * node.startInverseMass[place.side] * node.J.agreeing);
        }
        scene.template find<ImplicitBodies>()->take(scene, response_, impulses, unfelt);
    }

  private:
    struct Place {
        int contact, side;
    };
    ImpulseResponse<Dim> response_;
    std::vector<Place> places_;
    std::vector<double> velocity_; // of the rows of the response, m/s
    std::vector<Vec<Dim>> before_; // relative velocities of the contact nodes of the pair
};

} // namespace mpm
