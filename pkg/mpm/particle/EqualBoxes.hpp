// SPDX-License-Identifier: GPL-2.0-or-later
// Optional interface of Domains: particles on a lattice, each of which stands for a box; all boxes have one
// size.
#pragma once

#include "mpm/particle/Outline.hpp"

#include <functional>

namespace mpm {

template <int Dim> class EqualBoxes {
  public:
    virtual Vec<Dim> halfSize() const = 0; // half edges, m
    virtual void setHalfSize(const Vec<Dim>& half) = 0;
    virtual void grown() = 0; // after particles were appended
    // Cuts particles that are too long in two; returns whether there were any.
    virtual bool splitStretched() { return false; }
    // The surface of the region that the boxes were cut from; nullptr where boxes are whole.
    virtual const Outline<Dim>* outline() const { return nullptr; }

    // Where a wall parts soil, the particles on its second side move with the second half of the nodes' memory, see
    // NodalField::beSecondHalfOf(). wallAt[node]: number + 1 of the wall that parts nodes which a particle with this
    // lowest node reaches. Such a particle has a side, found by sideOf(p, wall), and keeps it (mayDecide) as long as it is
    // there. After locate(), one thread.
    virtual void divide(const std::vector<short>& wallAt, const std::function<int(int, int)>& sideOf,
                        bool mayDecide) = 0;
    virtual void unite() = 0; // all of them move with the first half
    // Whether each particle does; empty: none.
    virtual const std::vector<char>& seconds() const = 0;

  protected:
    ~EqualBoxes() = default;
};

} // namespace mpm
