// SPDX-License-Identifier: GPL-2.0-or-later
// The nodes on which a pair of groups is in contact, and those next to them.
#pragma once

#include "mpm/contact/NodalSurface.hpp"
#include "mpm/state/nearestNode.hpp"

#include <algorithm>

namespace mpm {

// The nodes of the cell round a point: their numbers among the contact nodes, -1 where it is none, and their
// hat functions.
template <int Dim> struct SurroundingNodes {
    static constexpr int size = 1 << Dim;
    int contact[size];
    double S[size];

    // The hat functions of a place in the cell that has the part of its edges below it.
    void weigh(const double* part, double* weights) const {
        for (int corner = 0; corner < size; ++corner) {
            weights[corner] = 1;
            for (int k = 0; k < Dim; ++k) weights[corner] *= corner >> k & 1 ? part[k] : 1 - part[k];
        }
    }
};

// The cell of a place along an axis, and the part of it that lies below the place. A place that is nearer to a line than
// `onLine` lies on it: sites of contact must not depend on the side of the line where a face lies that is even but for
// its elastic strain. A soil has next to no mass just beyond the line: points of one face that reach there by different
// hairs ask as many velocities of it as there are points, and their impulses do not settle. With half and with twice the
// value walls at rest and the thrust on a wall are the same within 1 %; with ten times it the foot of a wall loses 7 %.
struct PlaceInCell {
    static constexpr double onLine = 1e-4, roundOff = 1e-6; // cells
    double below;                                           // the line below, in cells

    explicit PlaceInCell(double cells) : below(std::floor(cells + onLine)) {}
    double partOf(double cells) const {
        const double part = cells - below;
        return part < onLine ? 0 : part > 1 - onLine ? 1 : part;
    }
};

template <int Dim> class NearbyNodes {
  public:
    Vec<Dim> lower, upper; // of a box that holds all that is near

    void prepare(const Grid<Dim>& grid) {
        contact_.assign(grid.count, -1);
        near_.assign(grid.count, -1);
        nodes_.clear();
    }

    void clear() {
        for (int node : nodes_) contact_[node] = near_[node] = -1;
        nodes_.clear();
        lower.setConstant(farAway);
        upper = -lower;
    }

    // Before finish(): the groups are in contact on this node, `number` among the contact nodes.
    void add(const Grid<Dim>& grid, int node, int number) {
        contact_[node] = number;
        const Vec<Dim> x = grid.nodePosition(node), reach = grid.twoCells(node);
        lower = lower.cwiseMin(x - reach);
        upper = upper.cwiseMax(x + reach);
        forNeighbours(grid, node, [&](int other, const Index<Dim>&) {
            if (near_[other] >= 0) return;
            near_[other] = 0;
            nodes_.push_back(other);
        });
    }
    void finish() {
        std::sort(nodes_.begin(), nodes_.end());
        for (size_t i = 0; i < nodes_.size(); ++i) near_[nodes_[i]] = int(i);
    }

    int size() const { return int(nodes_.size()); }
    int contact(int node) const { return contact_[node]; } // -1: no contact node
    // Of a node that is near, growing with the node: rows of nodes have numbers in a row. -1: it is not near.
    int number(int node) const { return near_[node]; }

    bool holds(const Grid<Dim>& grid, const Vec<Dim>& x) const {
        return (x.array() >= lower.array()).all() && (x.array() <= upper.array()).all() &&
               near_[nearestNode(grid, x)] >= 0;
    }

    // f(corner, node) for the nodes of the cell round a point; part: of its edges that is below the point.
    template <class F> static void forCorners(const Grid<Dim>& grid, const Vec<Dim>& x, double* part, F&& f) {
        int first = 0;
        for (int k = 0; k < Dim; ++k) {
            const double c = grid.inCells(x[k], k);
            const PlaceInCell place(c);
            first += int(place.below) * grid.strides[k];
            part[k] = place.partOf(c);
        }
        for (int corner = 0; corner < SurroundingNodes<Dim>::size; ++corner) {
            int node = first;
            for (int k = 0; k < Dim; ++k) node += corner >> k & 1 ? grid.strides[k] : 0;
            f(corner, node);
        }
    }

    SurroundingNodes<Dim> around(const Grid<Dim>& grid, const Vec<Dim>& x) const {
        double part[Dim];
        SurroundingNodes<Dim> around;
        forCorners(grid, x, part, [&](int corner, int node) { around.contact[corner] = contact_[node]; });
        around.weigh(part, around.S);
        return around;
    }

  private:
    std::vector<int> contact_, near_; // of all nodes of the grid
    std::vector<int> nodes_;          // that are near, contact nodes among them; in order
};

} // namespace mpm
