// SPDX-License-Identifier: GPL-2.0-or-later
// When a domain is too distorted to go on with, and how far the others are from that.
#pragma once

#include "mpm/particle/Distortion.hpp"
#include "mpm/particle/apdi/DomainMesh.hpp"
#include "mpm/state/Particles.hpp"

#include <mutex>

namespace mpm {

// Smallest corner area over area below which a domain is given up: at zero it would be inverted within a few
// steps.
constexpr double worstQuality = 0.05;
// Corner weight below which a domain counts as concave: soon it would make a nodal mass negative.
constexpr double leastWeight = 0.02;
// Longest edge over that at the start beyond which a domain is converted, where that is asked for: it knows
// the motion at its corners alone.
constexpr double worstGrowth = 1.15;

// Smallest corner area over the area, but not above 0 if a corner weight is too small. In 2D a corner is flat
// before its weight is.
template <int Dim, class S> MPM_INLINE double qualityOf(const S& shape, double corner) {
    const double quality = corner * shape.overVolume, capped = quality < 0 ? quality : 0;
    if (Dim == 2) return shape.volume > 0 ? quality : -1.0;
    double least = shape.w[0];
    MPM_UNROLL
    for (int a = 1; a < corners<Dim>; ++a) least = shape.w[a] < least ? shape.w[a] : least;
    return shape.volume > 0 ? (least < leastWeight ? capped : quality) : -1.0;
}

template <int Dim> bool isStretched(const DomainMesh<Dim>& mesh, int p) {
    return mesh.longestSquare(p, mesh.vertices.position) >
           worstGrowth * worstGrowth * mesh.longestSquare(p, mesh.vertices.reference);
}

// Domains whose quality is at most `limit`, and the worst of all.
template <int Dim> QualityReport reportQuality(const DomainMesh<Dim>& mesh, double limit) {
    QualityReport found;
    for (int p = 0; p < mesh.domains(); ++p) {
        const auto X = mesh.cornerNumbersOf(p);
        const ClosedShape<Dim> shape(X);
        const double quality = qualityOf<Dim>(shape, smallestCorner(shape, X));
        found.count += quality <= limit;
        if (quality < found.worst.quality) found.worst = {p, quality};
    }
    return found;
}

// Smallest corner over initial volume.
template <bool isRound, int Dim>
double smallestJacobian(const DomainMesh<Dim>& mesh, const Field& initialVolume) {
    double least = 1e300;
    for (int p = 0; p < mesh.domains(); ++p) {
        const auto X = mesh.cornerNumbersOf(p);
        least = std::min(least, smallestCorner(DomainShape<Dim, isRound>(X), X) / initialVolume.plane()[p]);
    }
    return least;
}

// Distorted domains in the order of their numbers, whichever threads find them.
class DistortedList {
  public:
    void clear() { all_.clear(); }
    const std::vector<Distorted>& all() const { return all_; }
    void note(const Distorted& d) {
        std::lock_guard<std::mutex> lock(mutex_);
        const auto byNumber = [](const Distorted& a, const Distorted& b) { return a.particle < b.particle; };
        all_.insert(std::upper_bound(all_.begin(), all_.end(), d, byNumber), d);
    }

  private:
    std::vector<Distorted> all_;
    std::mutex mutex_;
};

} // namespace mpm
