// SPDX-License-Identifier: GPL-2.0-or-later
// The background grid: a box of equal cells with ghost nodes around it. Nodes are numbered with the first
// axis fastest; a slab is the set of nodes with the same number along the last axis.
#pragma once

#include "mpm/base/require.hpp"
#include "mpm/base/threads.hpp"
#include "mpm/base/types.hpp"

#include <vector>

namespace mpm {

// Nodal data of one velocity field. Bodies that share a velocity field stick together; contact between
// bodies will give each contact group its own.
template <int Dim> struct NodalField {
    // What particles give: mass, momentum, force, and weight mass (mass without inertial scaling). The
    // force has the last four lanes to itself (and the weight mass in 3D): only it has a gradient part.
    static constexpr int mass = 0, momentum = 1, force = 4, weightMass = Dim == 2 ? 3 : 7;
    static constexpr int sumLanes = 8, motionLanes = Dim == 2 ? 4 : 8;
    using Sum = Pack<sumLanes>;
    using Motion = Pack<motionLanes>; // velocity, acceleration: what particles take
    using Velocity = Pack<4>;         // the velocity that enters the velocity gradient

    std::vector<Sum> sum;
    std::vector<Motion> motion;
    std::vector<Velocity> velocity;
};

template <int Dim> class Grid {
  public:
    static constexpr int ghost = 2;         // layers of nodes outside the box
    static constexpr int slabsPerBlock = 4; // pieces of deterministic scatter, see Body::order
    static constexpr int wander = 1;        // slabs a particle may leave its block by before it is re-sorted

    Grid(const Vec<Dim>& lower, const Vec<Dim>& upper, const Vec<Dim>& cell) : lower(lower), upper(upper), cell(cell) {
        int stride = 1;
        for (int k = 0; k < Dim; ++k) {
            require(std::isfinite(lower[k]) && std::isfinite(upper[k]) && lower[k] < upper[k],
                    "Scene: lower = ", place(lower), ", upper = ", place(upper), "; lower must be below upper");
            require(cell[k] > 0, "Scene: cell = ", cell[k], " m; give a positive cell size");
            cells[k] = int(std::lround((upper[k] - lower[k]) / cell[k]));
            require(cells[k] >= 1 && std::abs(cells[k] * cell[k] - (upper[k] - lower[k])) < 1e-6 * cell[k],
                    "Scene: upper - lower = ", upper[k] - lower[k], " m along axis ", k, " is not a multiple of cell = ",
                    cell[k], " m; move lower or upper, or change cell");
            nodes[k] = cells[k] + 1 + 2 * ghost;
            strides[k] = stride;
            stride *= nodes[k];
        }
        count = stride;
        extents.resize(nodes[Dim - 1]);
        fields.resize(1);
        for (NodalField<Dim>& field : fields) {
            field.sum.assign(count, NodalField<Dim>::Sum::zero());
            field.motion.assign(count, NodalField<Dim>::Motion::zero());
            field.velocity.assign(count, NodalField<Dim>::Velocity::zero());
        }
    }

    const Vec<Dim> lower, upper, cell;
    Index<Dim> cells, nodes, strides;
    int count = 0;
    std::vector<NodalField<Dim>> fields;

    int slabs() const { return nodes[Dim - 1]; }
    int blocks() const { return (slabs() + slabsPerBlock - 1) / slabsPerBlock; }
    int slabOf(int node) const { return node / strides[Dim - 1]; }

    // Position in cells from the lowest ghost node.
    double inCells(double x, int axis) const { return (x - lower[axis]) / cell[axis] + ghost; }

    Index<Dim> indices(int node) const {
        Index<Dim> index;
        for (int k = Dim - 1; k >= 0; --k) index[k] = node / strides[k], node %= strides[k];
        return index;
    }
    Vec<Dim> nodePosition(int node) const {
        const Index<Dim> index = indices(node);
        Vec<Dim> x;
        for (int k = 0; k < Dim; ++k) x[k] = lower[k] + (index[k] - ghost) * cell[k];
        return x;
    }

    // The part of each slab that particles touched in this step: a box in the other axes.
    struct Extent {
        Index<Dim> first, last; // inclusive; first > last: none
    };
    std::vector<Extent> extents;

    // Calls f(node) for the touched nodes of a slab.
    template <class F> void forNodes(int slab, F&& f) const {
        const Extent& e = extents[slab];
        const int start = slab * strides[Dim - 1];
        if (Dim == 2) {
            for (int i = e.first[0]; i <= e.last[0]; ++i) f(start + i);
        } else {
            for (int j = e.first[1]; j <= e.last[1]; ++j)
                for (int i = e.first[0]; i <= e.last[0]; ++i) f(start + j * strides[1] + i);
        }
    }
};

} // namespace mpm
