// SPDX-License-Identifier: GPL-2.0-or-later
// The surface of a body of boxes, where it is known: facets, each carried by a particle. A facet with the
// offset xi from its particle and the area vector A0 at first is at x_p + F xi, with the area vector J F^-T
// A0 (Nanson).
#pragma once

#include "mpm/state/Particles.hpp"

#include <Eigen/LU>

#include <unordered_map>

namespace mpm {

template <int Dim> class Outline {
  public:
    Field carrier{"outlineCarrier", "-", "Id of the particle that carries a facet of the outline.", {}, 'i'};
    Field offset{
        "outlineOffset", "m", "From the particle to the middle of the facet, in the undeformed body.", {Dim}};
    Field area{"outlineArea",
               "m2",
               "Outward area vector of the facet in the undeformed body (2D: length, m).",
               {Dim}};

    int size() const { return carrier.size(); }
    std::vector<Field*> fields() { return {&carrier, &offset, &area}; }

    void set(const std::vector<int>& carriers, const std::vector<Vec<Dim>>& offsets,
             const std::vector<Vec<Dim>>& areas) {
        for (Field* field : fields()) field->resize(int(carriers.size()));
        for (int i = 0; i < size(); ++i) {
            carrier.integers()[i] = carriers[i];
            for (int k = 0; k < Dim; ++k) {
                offset.plane(k)[i] = offsets[i][k];
                area.plane(k)[i] = areas[i][k];
            }
        }
    }

    // After particles have been made, sorted, restored or removed: a facet goes with its particle.
    void find(const Particles<Dim>& particles) {
        if (size() == 0) return;
        std::unordered_map<int64_t, int> place;
        for (int p = 0; p < particles.size(); ++p) place.emplace(particles.id.integers()[p], p);
        std::vector<int> kept;
        particle_.clear();
        for (int i = 0; i < size(); ++i) {
            const auto found = place.find(carrier.integers()[i]);
            if (found == place.end()) continue;
            kept.push_back(i);
            particle_.push_back(found->second);
        }
        if (int(kept.size()) < size())
            for (Field* field : fields()) field->select(kept);
    }

    // Particle p was cut in two: it has moved by F d, the other by -F d.
    void split(int p, int64_t other, const Vec<Dim>& d) {
        for (int i = 0; i < size(); ++i) {
            if (particle_[i] != p) continue;
            const Vec<Dim> xi = vectorAt<Dim>(offset, i);
            const bool stays = xi.dot(d) >= 0;
            if (!stays) carrier.integers()[i] = other;
            for (int k = 0; k < Dim; ++k) offset.plane(k)[i] = stays ? xi[k] - d[k] : xi[k] + d[k];
        }
    }

    int particle(int i) const { return particle_[i]; }

    // Facet i as it is now: its middle, and its area vector.
    std::pair<Vec<Dim>, Vec<Dim>> at(const Particles<Dim>& particles, int i) const {
        const int p = particle_[i];
        Mat<Dim> F;
        for (int k = 0; k < Dim; ++k)
            for (int m = 0; m < Dim; ++m) F(k, m) = particles.deformationGradient.plane(3 * k + m)[p];
        return {vectorAt<Dim>(particles.position, p) + F * vectorAt<Dim>(offset, i),
                cofactor(F) * vectorAt<Dim>(area, i)};
    }

  private:
    std::vector<int> particle_; // of each facet

    static Mat<2> cofactor(const Mat<2>& F) {
        return (Mat<2>() << F(1, 1), -F(1, 0), -F(0, 1), F(0, 0)).finished();
    }
    static Mat<3> cofactor(const Mat<3>& F) {
        Mat<3> C;
        for (int k = 0; k < 3; ++k) C.row(k) = F.row((k + 1) % 3).cross(F.row((k + 2) % 3));
        return C;
    }
};

} // namespace mpm
