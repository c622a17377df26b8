// SPDX-License-Identifier: GPL-2.0-or-later
// Rows of nodes, along the last axis, that are held and move alike: what touches no others is not strained.
#pragma once

#include "mpm/scene/Body.hpp"

namespace mpm {

template <int Dim> class RigidRows {
  public:
    using NF = NodalField<Dim>;

    // Of the nodes of a field with more than so little mass.
    void find(const Grid<Dim>& grid, const NF& field, double least) {
        rows_.assign(grid.slabs(), Row());
        for (int slab = 0; slab < grid.slabs(); ++slab)
            grid.forNodes(field, slab, [&](int node) {
                Row& row = rows_[slab];
                if (!row.isRigid || !(field.sum[node][NF::mass] > least)) return;
                const auto& motion = field.motion[node];
                if (!row.motion) row.motion = &motion;
                for (int k = 0; k < Dim; ++k) row.isRigid &= field.holder[node][k] >= 0;
                row.isRigid &= areAlike(motion, *row.motion);
            });
    }

    // Whether all nodes that a particle may touch are held and move alike.
    bool moveRigidly(const Grid<Dim>& grid, const Body<Dim>& body, int p) const {
        constexpr int axis = Dim - 1;
        const double edge = body.domains->mesh() ? body.domains->mesh()->longestEdge(p) : 0.0;
        const int own = int(grid.inCells(body.particles.position.plane(axis)[p], axis));
        const int reach = 1 + int(std::ceil(edge / grid.smallestCell()[axis]));
        const typename NF::Motion* motion = nullptr;
        for (int i = std::max(0, own - reach); i <= std::min(int(rows_.size()) - 1, own + reach + 1); ++i) {
            const Row& row = rows_[i];
            if (!row.isRigid || (motion && row.motion && !areAlike(*motion, *row.motion))) return false;
            if (!motion) motion = row.motion;
        }
        return motion != nullptr;
    }

  private:
    struct Row {
        bool isRigid = true;
        const typename NF::Motion* motion = nullptr; // of its first node; none: no node
    };

    static bool areAlike(const typename NF::Motion& a, const typename NF::Motion& b) {
        bool alike = true;
        for (int k = 0; k < Dim; ++k) alike &= a[NF::velocity + k] == b[NF::velocity + k];
        return alike;
    }

    std::vector<Row> rows_;
};

} // namespace mpm
