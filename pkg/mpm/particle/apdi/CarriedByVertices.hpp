// SPDX-License-Identifier: GPL-2.0-or-later
// What the vertices hold during a transfer, plane by plane: from the domains momentum and inertial mass,
// force, and force of hourglass control; towards the domains the motion in the place of the first, and in
// that of the last the momentum that comes back.
#pragma once

#include "mpm/particle/NodeLanes.hpp"
#include "mpm/particle/apdi/HourglassControl.hpp"

namespace mpm {

template <int Dim> class CarriedByVertices {
  public:
    using NF = NodalField<Dim>;
    using Vertices = MeshVertices<Dim>;
    static constexpr int momentum = 0, force = Dim + 1, control = 2 * Dim + 1, motion = 0, all = 3 * Dim + 1;

    void resize(int vertices) { carried_.resize(vertices); }
    size_t bytes() const { return carried_.bytes(); }

    template <int n> std::array<double*, n> planes(int first) {
        std::array<double*, n> some;
        for (int k = 0; k < n; ++k) some[k] = carried_.plane(first + k);
        return some;
    }

    // Of vertices [begin, end).
    void clear(int begin, int end) {
        for (double* x : planes<all>(0)) std::fill(x + begin, x + end, 0.0);
    }
    void clear(ParallelRegion& region) {
        region.chunks(carried_.size(), [&](int begin, int end) { clear(begin, end); });
    }

    // Forces of hourglass control as an impulse: the first part of the momentum that comes back. Hanging
    // vertices have handed theirs to their masters in toNodes().
    void startMomentum(ParallelRegion& region, const Vertices& vertices, double dt) {
        const auto momentum = planes<Dim>(control);
        region.chunksNoWait(carried_.size(), [&](int begin, int end) {
            for (double* x : momentum)
                for (int v = begin; v < end; ++v) x[v] = dt == 0 ? 0 : dt * x[v];
            vertices.hanging.within(begin, end, [&](int, int slave) {
                for (double* x : momentum) x[slave] = 0;
            });
        });
    }

    // To the nodes; the forces of hourglass control stay on the vertices, too. overScale: weight mass over
    // inertial mass.
    void toNodes(ParallelRegion& region, const Vertices& vertices, typename NF::Sum* nodes, bool withControl,
                 double overScale) {
        const auto given = planes<all>(0);
        vertices.scatter(region, nodes, given, [&](int first, int count, typename NF::Sum* out) {
            double weightMass[chunkSize];
            for (int i = 0; i < count; ++i) weightMass[i] = overScale * given[Dim][first + i];
            std::array<const double*, Dim> f, c;
            for (int k = 0; k < Dim; ++k) {
                f[k] = given[force + k] + first;
                c[k] = withControl ? given[control + k] + first : NodeLanes<Dim>::none;
            }
            if constexpr (Dim == 2) {
                interleave({given[0] + first, given[1] + first, given[2] + first, weightMass}, count,
                           out->part, 2);
                interleave({f[0], c[0], f[1], c[1]}, count, out->part + 1, 2);
            } else {
                double total[Dim][chunkSize];
                for (int k = 0; k < Dim; ++k)
                    for (int i = 0; i < count; ++i) total[k][i] = f[k][i] + c[k][i];
                interleave({given[0] + first, given[1] + first, given[2] + first, given[3] + first}, count,
                           out->part, 2);
                interleave({total[0], total[1], total[2], weightMass}, count, out->part + 1, 2);
            }
        });
    }

    void momentumToNodes(ParallelRegion& region, const Vertices& vertices, typename NF::Velocity* nodes) {
        const auto given = planes<Dim>(control);
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
template <int Dim> struct alignas(64) GivenByDomains {
    using Shapes = BatchShapes<Dim>;
    using Carried = CarriedByVertices<Dim>;
    static constexpr int most = Batch<Dim>::most;
    double momentum[Dim + 1][most];                 // and inertial mass, times w
    double tension[Dim][Dim][most];                 // -V sigma, times g
    double bodyForce[Dim][most];                    // times w
    typename HourglassControl<Dim>::Forces control; // times gamma

    // To plane k of corner a.
    MPM_INLINE double toCorner(const Shapes& d, int a, int k, int p) const {
        double sum = 0;
        if (k < Carried::force)
            sum = d.w[a][p] * momentum[k][p];
        else if (k < Carried::control)
            MPM_UNROLL
        for (int j = 0; j < Dim; ++j) sum += d.g[a][j][p] * tension[k - Carried::force][j][p];
        else MPM_UNROLL for (int m = 0; m < Shapes::modes; ++m) sum +=
            HourglassControl<Dim>::gamma(d, m, a, p) * control[m][k - Carried::control][p];
        return sum;
    }
};

} // namespace mpm
