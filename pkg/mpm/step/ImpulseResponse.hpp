// SPDX-License-Identifier: GPL-2.0-or-later
// The velocities that impulses J on some of their nodes give to implicit bodies, A^-1 J with A = M + dt^2 K: an impulse
// on one node moves them all, for the bodies are stiff.
#pragma once

#include "mpm/base/types.hpp"
#include "mpm/step/BandMatrix.hpp"

#include <algorithm>

namespace mpm {

template <int Dim> class ImpulseResponse {
  public:
    struct Node {
        int field, node;
        int body = -1,
            unknown = 0; // which of those that are solved for together, and the first of its unknowns
    };
    struct Body {
        const BandMatrix* factor = nullptr; // of A
        int first = 0;                      // of the unknowns that are asked for
        std::vector<double> values;         // impulses, kN s, then velocities, m/s
        std::vector<double> near, shares;   // A^-1 near its diagonal; weights of the unknowns
    };
    std::vector<Node> nodes; // those that respond
    std::vector<Body> bodies;

    void clearImpulses() {
        for (Body& body : bodies) body.values.assign(body.factor ? body.factor->padded() : 0, 0.0);
    }
    // On a component that no constraint holds.
    void push(int node, int axis, double impulse) {
        bodies[nodes[node].body].values[nodes[node].unknown + axis] += impulse;
    }
    void solve() {
        for (Body& body : bodies)
            if (body.factor) body.factor->solve(body.values.data(), body.first);
    }
    Vec<Dim> velocity(int node) const {
        return Eigen::Map<const Vec<Dim>>(&bodies[nodes[node].body].values[nodes[node].unknown]);
    }

    // Bounds on the sums of the rows of |A^-1| with weights, shareOf(node, axis), zero where a constraint holds: for each
    // node and axis boundOf(node)[axis]. The sums of A^-1 itself, with what entries near the diagonal have below zero or
    // across the axes: those further away are the motion of a body that is stiff.
    template <class ShareOf> void bound(ShareOf&& shareOf, std::vector<Vec<Dim>>& bounds) {
        bounds.assign(nodes.size(), Vec<Dim>::Zero());
        for (int axis = 0; axis < Dim; ++axis) {
            clearImpulses();
            for (size_t i = 0; i < nodes.size(); ++i) push(int(i), axis, shareOf(i, axis));
            solve();
            for (size_t i = 0; i < nodes.size(); ++i) bounds[i][axis] = std::abs(velocity(int(i))[axis]);
        }
        for (Body& body : bodies) {
            if (!body.factor) continue;
            body.factor->invertNearDiagonal(body.first, reachOf(body), body.near);
            body.shares.assign(body.factor->size() - body.first, 0.0);
        }
        for (size_t i = 0; i < nodes.size(); ++i)
            for (int axis = 0; axis < Dim; ++axis)
                bodies[nodes[i].body].shares[nodes[i].unknown + axis - bodies[nodes[i].body].first] =
                    shareOf(i, axis);
        for (size_t i = 0; i < nodes.size(); ++i)
            for (int axis = 0; axis < Dim; ++axis)
                if (shareOf(i, axis) > 0)
                    bounds[i][axis] += hidden(bodies[nodes[i].body], nodes[i].unknown + axis);
    }

  private:
    static int reachOf(const Body& body) { return body.factor->band() + 1; }
    // What the sum of a row near the diagonal hides.
    static double hidden(const Body& body, int unknown) {
        const int reach = reachOf(body), row = unknown - body.first, count = int(body.shares.size());
        double sum = 0;
        for (int other = std::max(0, row - reach + 1); other < std::min(count, row + reach); ++other) {
            if (body.shares[other] == 0) continue;
            const auto [lower, upper] = std::minmax(row, other);
            const double entry = body.near[std::size_t(lower) * reach + upper - lower];
            const bool isAlong = (row - other) % Dim == 0;
            sum += body.shares[other] * (std::abs(entry) - (isAlong ? entry : 0));
        }
        return sum;
    }
};

} // namespace mpm
