// SPDX-License-Identifier: GPL-2.0-or-later
// What the vertices hold during a transfer, plane by plane: from the domains momentum, inertial mass and
// force; towards the domains the motion in their place, and behind it the momentum that comes back.
#pragma once

#include "mpm/particle/NodeLanes.hpp"
#include "mpm/particle/apdi/HourglassControl.hpp"

namespace mpm {

template <int Dim> class CarriedByVertices {
  public:
    using NF = NodalField<Dim>;
    using Vertices = MeshVertices<Dim>;
    static constexpr int momentum = 0, force = Dim + 1, sums = 2 * Dim + 1, motion = 0, back = 2 * Dim,
                         all = 3 * Dim;

    void resize(int vertices) { carried_.resize(vertices); }
    size_t bytes() const { return carried_.bytes(); }

    template <int n> std::array<double*, n> planes(int first) {
        std::array<double*, n> some;
        for (int k = 0; k < n; ++k) some[k] = carried_.plane(first + k);
        return some;
    }

    // The sums of vertices [begin, end).
    void clear(int begin, int end) {
        for (double* x : planes<sums>(0)) std::fill(x + begin, x + end, 0.0);
    }
    void clear(ParallelRegion& region) {
        region.chunks(carried_.size(), [&](int begin, int end) { clear(begin, end); });
    }
    // The threads do not wait for each other at the end.
    void clearBack(ParallelRegion& region) {
        region.chunksNoWait(carried_.size(), [&](int begin, int end) {
            for (double* x : planes<Dim>(back)) std::fill(x + begin, x + end, 0.0);
        });
    }

    // To the nodes. overScale: weight mass over inertial mass.
    void toNodes(ParallelRegion& region, const Vertices& vertices, typename NF::Sum* nodes,
                 double overScale) {
        const auto given = planes<sums>(0);
        vertices.scatter(region, nodes, given, [&](int first, int count, typename NF::Sum* out) {
            double weightMass[chunkSize];
            for (int i = 0; i < count; ++i) weightMass[i] = overScale * given[Dim][first + i];
            std::array<const double*, sums> g;
            for (int k = 0; k < sums; ++k) g[k] = given[k] + first;
            const double* none = NodeLanes<Dim>::none;
            if constexpr (Dim == 2) {
                interleave({g[0], g[1], g[2], weightMass}, count, out->part, 2);
                interleave({g[3], none, g[4], none}, count, out->part + 1, 2);
            } else {
                interleave({g[0], g[1], g[2], g[3]}, count, out->part, 2);
                interleave({g[4], g[5], g[6], weightMass}, count, out->part + 1, 2);
            }
        });
    }

    void momentumToNodes(ParallelRegion& region, const Vertices& vertices, typename NF::Velocity* nodes) {
        const auto given = planes<Dim>(back);
        vertices.scatter(region, nodes, given, [&](int first, int count, typename NF::Velocity* out) {
            std::array<const double*, Dim> from;
            for (int k = 0; k < Dim; ++k) from[k] = given[k] + first;
            NodeLanes<Dim>::packMomenta(from, count, out->part);
        });
    }

    void takeMotion(ParallelRegion& region, const Vertices& vertices, const typename NF::Motion* nodes) {
        vertices.gather(
            region, nodes, planes<2 * Dim>(motion),
            [](const typename NF::Motion* in, int count, const std::array<double*, 2 * Dim>& out) {
                NodeLanes<Dim>::unpackMotion(in, count, out);
            });
    }

  private:
    Field carried_{"carried", "", "What the vertices hold during a transfer.", {all}};
};

// What a batch of domains gives to its vertices.
template <int Dim, bool isRound> struct alignas(64) GivenByDomains {
    using Shapes = BatchShapes<Dim, isRound>;
    using Carried = CarriedByVertices<Dim>;
    static constexpr int most = Batch<Dim>::most;
    double momentum[Dim + 1][most];                  // and inertial mass, times w
    double tension[Dim][Dim][most];                  // -V sigma, times g
    double ring[isRound ? most : 1];                 // -V sigma_theta, times hoop: radial force
    double bodyForce[Dim][most];                     // times w
    typename HourglassControl<Dim>::OfBatch control; // times gamma

    void takeRing(const double* volume, const ActingStress& stress, int first, int count) {
        for (int p = 0; isRound && p < count; ++p)
            ring[p] = -volume[first + p] * stress.diagonal(2, first + p);
    }
    // To plane k of corner a.
    template <bool isPatterned> MPM_INLINE double toCorner(const Shapes& d, int a, int k, int p) const {
        double sum = 0;
        if (k < Carried::force) return d.w[a][p] * momentum[k][p];
        MPM_UNROLL
        for (int j = 0; j < Dim; ++j) sum += d.g[a][j][p] * tension[k - Carried::force][j][p];
        if constexpr (isRound)
            if (k == Carried::force) sum += d.hoop[a][p] * ring[p];
        MPM_UNROLL
        for (int m = 0; m < Shapes::modes; ++m)
            sum += control.template gamma<isPatterned>(d, m, a, p) * control.force[m][k - Carried::force][p];
        return sum;
    }
};

} // namespace mpm
