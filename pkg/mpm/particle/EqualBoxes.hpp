// SPDX-License-Identifier: GPL-2.0-or-later
// Optional interface of Domains: particles on a lattice, each of which stands for a box; all boxes have one
// size.
#pragma once

#include "mpm/particle/Outline.hpp"

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

  protected:
    ~EqualBoxes() = default;
};

} // namespace mpm
