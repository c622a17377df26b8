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
    // Where component k of force and velocity is in its four lanes: in 2D each fills two, see particle/Lanes.hpp.
    static constexpr int lane(int k) { return Dim == 2 ? 2 * k : k; }

    // What particles give: momentum, mass, weight mass (mass without inertial scaling), and force.
    static constexpr int momentum = 0, mass = Dim, weightMass = Dim == 2 ? 3 : 7;
    static constexpr int force(int k) { return 4 + lane(k); }
    using Sum = Pack<8>;
    using Motion = Pack<Dim == 2 ? 4 : 8>; // velocity, acceleration: what particles take
    using Velocity = Pack<4>;              // the velocity that enters the velocity gradient

    static void setVelocity(Velocity& v, int k, double value) {
        for (int l = lane(k); l < (Dim == 2 ? lane(k + 1) : lane(k) + 1); ++l) v.set(l, value);
    }

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
            strides[k] = stride, overStride_[k] = 1.0 / stride;
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
        for (int k = Dim - 1; k > 0; --k) {
            index[k] = int((node + 0.5) * overStride_[k]); // exact, and faster than dividing whole numbers
            node -= index[k] * strides[k];
        }
        index[0] = node;
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

    void forgetExtents() {
        Extent none;
        none.first.fill(1 << 30), none.last.fill(-(1 << 30));
        extents.assign(slabs(), none);
    }

    Shares shares; // of the slabs, by the number of their touched nodes
    void shareOut() {
        shares.set(slabs(), [&](int slab) {
            double n = 1;
            for (int k = 0; k < Dim - 1; ++k) n *= std::max(0, extents[slab].last[k] - extents[slab].first[k] + 1);
            return n;
        });
    }

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

  private:
    std::array<double, Dim> overStride_;
};

} // namespace mpm
