// SPDX-License-Identifier: GPL-2.0-or-later
// What domains whose velocity is linear give to the nodes besides the momentum of their centres X_p:
//     node_i += sum_v S_i(X_v) [q_v + P_v (x_i - X_v)],
//     q_v = sum_p w_pv m L_p (X_v - X_p),   P_v = sum_p w_pv m L_p
// so that the two stages domain -> vertex -> node hand on the linear velocity and not its values at the
// vertices alone. A hanging vertex v gives S_i(X_m) w_vm P_v (x_i - X_v) to the nodes of its masters m.
#pragma once

#include "mpm/particle/NodeLanes.hpp"
#include "mpm/particle/apdi/DomainMesh.hpp"

namespace mpm {

template <int Dim> class SlopesAtVertices {
  public:
    static constexpr int NC = corners<Dim>, slopes = Dim * Dim;

    void resize(int vertices) { slope_.resize(vertices); }
    size_t bytes() const { return slope_.bytes(); }

    void clear(ParallelRegion& region) {
        region.chunks(slope_.size(), [&](int begin, int end) {
            for (int c = 0; c < slopes; ++c) std::fill(slope_.plane(c) + begin, slope_.plane(c) + end, 0.0);
        });
    }

    // From a batch of domains with the corner weights w: q to the planes of momentum, P to those of this.
    template <class Weights>
    void take(const Batch<Dim>& batch, const Weights& w, const ParticlePlanes<Dim>& q, const Field& positions,
              double inertiaScale, const std::array<double*, Dim>& momentum) {
        const AtCorners<Dim, Dim> X(batch, vectorPlanes<Dim>(positions));
        double mL[slopes][Batch<Dim>::most], centre[Dim][Batch<Dim>::most];
        q.slopes(batch.first, batch.count, inertiaScale, mL);
        for (int k = 0; k < Dim; ++k)
            for (int p = 0; p < batch.count; ++p) {
                centre[k][p] = 0;
                for (int a = 0; a < NC; ++a) centre[k][p] += w[a][p] * X.x[a][k][p];
            }
        batch.addToCorners(momentum, [&](int a, int k, int p) MPM_INLINE_LAMBDA {
            double sum = 0;
            MPM_UNROLL
            for (int j = 0; j < Dim; ++j) sum += mL[Dim * k + j][p] * (X.x[a][j][p] - centre[j][p]);
            return w[a][p] * sum;
        });
        std::array<double*, slopes> own;
        for (int c = 0; c < slopes; ++c) own[c] = slope_.plane(c);
        batch.addToCorners(own, [&](int a, int c, int p) MPM_INLINE_LAMBDA { return w[a][p] * mL[c][p]; });
    }

    // First Quad of node += S P (x_i - X).
    template <class Node>
    void toNodes(ParallelRegion& region, const MeshVertices<Dim>& vertices, Node* nodes) const {
        vertices.forBlocks(region, [&](int first, int end) {
            const typename MeshVertices<Dim>::Arms arms(vertices);
            for (int v = first; v < end; ++v) {
                if (vertices.hanging.isSlave(v)) continue;
                add(nodes, arms, v, v, 1);
            }
            vertices.hanging.shares(first, end, [&](int master, int slave, double weight) {
                add(nodes, arms, master, slave, weight);
            });
        });
    }

  private:
    // To the nodes around vertex `at`, a share of the slope of vertex `of`.
    template <class Node>
    void add(Node* nodes, const typename MeshVertices<Dim>::Arms& arms, int at, int of, double share) const {
        arms(at, of, [&](int node, double S, const Vec<Dim>& arm) {
            Quad given{};
            for (int k = 0; k < Dim; ++k)
                for (int j = 0; j < Dim; ++j) given[k] += share * S * slope_.plane(Dim * k + j)[of] * arm[j];
            nodes[node].part[0] += given;
        });
    }

    Field slope_{"slope", "", "Inertia times velocity gradient at the vertices.", {Dim, Dim}};
};

} // namespace mpm
