// SPDX-License-Identifier: GPL-2.0-or-later
// Optional interface of Domains: they take the shape of the deformed body, and may become too distorted to go
// on with.
#pragma once

#include "mpm/base/types.hpp"

#include <vector>

namespace mpm {

// A domain that is too distorted to go on with.
struct Distorted {
    int particle;
    double quality; // smallest corner area over domain area: 1 for a parallelogram, <= 0 concave
};

// Domains of poor quality: their number, and the worst of all.
struct QualityReport {
    int count = 0;
    Distorted worst{-1, 1};
};

// A small uGIMP-like piece of a domain: what conversion hands over.
template <int Dim> struct Piece {
    int parent;
    Vec<Dim> position;
    double fraction; // of the parent's volume and mass
};

template <int Dim> class Distortion {
  public:
    // Found in the last takeGradient(), by number.
    virtual std::vector<Distorted> distorted() const = 0;
    // Parts of a domain with edges about as long as those of a box, and domains taken out of the mesh
    // (numbers in order).
    virtual std::vector<Piece<Dim>> split(int particle, const Vec<Dim>& halfSize) const = 0;
    virtual void remove(const std::vector<int>& particles) = 0;

    // --- diagnosis ----------------------------------------------------------------------------------
    // Domains whose quality is at most `limit`, and the worst of all.
    virtual QualityReport qualityReport(double limit) const = 0;
    virtual double minJacobian() const = 0; // smallest corner Jacobian over initial volume
    virtual double hourglass() const = 0;   // largest hourglass amplitude over edge
    virtual double hourglassEnergy() = 0;   // stored in the patterns, kJ

  protected:
    ~Distortion() = default;
};

} // namespace mpm
