// SPDX-License-Identifier: GPL-2.0-or-later
// What implicit bodies answer to impulses on some of their nodes: an impulse on one moves them all, for the
// bodies are stiff.
#pragma once

#include "mpm/base/types.hpp"
#include "mpm/step/ImpulseSweep.hpp"

namespace mpm {

template <int Dim> class ImpulseResponse {
  public:
    struct Node {
        int field, node;
        int body = -1,
            unknown = 0; // which of those that are solved for together, and the first of its unknowns
    };
    std::vector<Node> nodes;          // those that respond
    std::vector<ImpulseSweep> bodies; // along each

    bool isEmpty() const { return nodes.empty(); }
    void clear() { nodes.clear(); }

    // Velocity of a node per impulse on another one, or on itself, 1/Mg; zero between bodies that share no node.
    // The nodes are of one site.
    Mat<Dim> of(int node, int pushed) const {
        Mat<Dim> answer = Mat<Dim>::Zero();
        const Node &a = nodes[node], &b = nodes[pushed];
        for (int i = 0; i < Dim && a.body == b.body; ++i)
            for (int k = 0; k < Dim; ++k) answer(i, k) = bodies[a.body].answer(a.unknown + i, b.unknown + k);
        return answer;
    }
    void push(int node, const Vec<Dim>& impulse) {
        for (int k = 0; k < Dim; ++k) bodies[nodes[node].body].push(nodes[node].unknown + k, impulse[k]);
    }
    Vec<Dim> velocity(int node) const { // what impulses made it
        Vec<Dim> v;
        for (int k = 0; k < Dim; ++k) v[k] = bodies[nodes[node].body].velocity(nodes[node].unknown + k);
        return v;
    }
};

} // namespace mpm
