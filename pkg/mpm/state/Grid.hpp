// SPDX-License-Identifier: GPL-2.0-or-later
// The background grid: a box of equal cells with ghost nodes around it. Nodes are numbered with the first
// axis fastest; a slab is the set of nodes with the same number along the last axis. A block is four rows of nodes wide along each axis but the
// first, along which it is as long as the grid.
#pragma once

#include "mpm/base/largePages.hpp"
#include "mpm/base/require.hpp"
#include "mpm/base/threads.hpp"
#include "mpm/base/types.hpp"

#include <limits>
#include <vector>

namespace mpm {

// Nodal data of one velocity field. Bodies that share a velocity field stick together; where there is a Contact,
// each group of bodies has its own.
template <int Dim> struct NodalField {
    // What particles give: momentum, mass, weight mass (mass without inertial scaling), and force: in 2D component k is the sum of two lanes,
    // see particle/Lanes.hpp.
    using Sum = Pack<8>;
    static constexpr int momentum = 0, mass = Dim, weightMass = Dim == 2 ? 3 : 7;
    static constexpr int lane(int k) { return Dim == 2 ? 2 * k : k; }
    static constexpr int force(int k) { return 4 + lane(k); }
    static double forceOf(const Sum& sum, int k) {
        return Dim == 2 ? sum[force(k)] + sum[force(k) + 1] : sum[force(k)];
    }

    // Velocity, acceleration: what particles take.
    using Motion = Pack<Dim == 2 ? 4 : 8>;

    // The velocity that enters the velocity gradient. Where it is summed up from particles (MUSL, USF): their momentum, and behind it 1/mass.
    using Velocity = Pack<4>;
    MPM_INLINE static Velocity noMomentum(double overMass) {
        Velocity v;
        v.part[0] = Dim == 2 ? Quad{0, 0, overMass, 0} : Quad{0, 0, 0, overMass};
        return v;
    }

    // Vectors with component k in lane(k), in 2D also in the next.
    MPM_INLINE static Quad momentumIn(const Sum& sum) {
        const Quad p = sum.part[0];
        return Dim == 2 ? Quad{p[0], p[0], p[1], p[1]} : Quad{p[0], p[1], p[2], 0};
    }
    MPM_INLINE static Quad forceIn(const Sum& sum) {
        const Quad f = sum.part[1];
        return Dim == 2 ? f + Quad{f[1], f[0], f[3], f[2]} : Quad{f[0], f[1], f[2], 0};
    }
    MPM_INLINE static void
    setComponent(Quad& vector, int k,
                 double value) { // not lane by lane: the vector would be read before it is in memory
        const auto in = [&](int l) { return (Dim == 2 ? l / 2 : l) == k ? value : vector[l]; };
        vector = Quad{in(0), in(1), in(2), in(3)};
    }
    MPM_INLINE static void setMotion(Motion& motion, const Quad& v, const Quad& a) {
        if constexpr (Dim == 2)
            motion.part[0] = evenLanes(v, a);
        else
            motion.part[0] = Quad{v[0], v[1], v[2], a[0]}, motion.part[1] = Quad{a[1], a[2], 0, 0};
    }
    MPM_INLINE static Velocity velocityOf(const Quad& v) {
        Velocity velocity;
        velocity.part[0] = Dim == 2 ? evenLanes(v, Quad{}) : v;
        return velocity;
    }

    std::vector<Sum, OnLargePages<Sum>> sum;
    std::vector<Motion, OnLargePages<Motion>> motion;
    std::vector<Velocity, OnLargePages<Velocity>> velocity;

    // Which constraint holds each component of a node, -1: none. Fixed sets of nodes are entered by
    // Scene::prepare(), driven ones anew in every step by ParticleToGrid (see engine/Driving.hpp).
    using Holders = std::array<short, Dim>;
    std::vector<Holders> holder;
    static Holders free() {
        Holders none;
        none.fill(-1);
        return none;
    }
    bool isHeld(int node) const {
        bool held = false;
        for (short h : holder[node]) held |= h >= 0;
        return held;
    }

    // The part of each slab that particles touched in this step: a box in the other axes.
    struct Extent {
        Index<Dim> first, last; // inclusive; first > last: none
    };
    std::vector<Extent> extents;
    Shares shares; // of the slabs, by the number of their touched nodes

    void setSize(int nodes, int slabs) {
        sum.assign(nodes, Sum::zero()), motion.assign(nodes, Motion::zero()),
            velocity.assign(nodes, Velocity::zero());
        holder.assign(nodes, free());
        extents.resize(slabs);
        forgetExtents();
    }
    void forgetExtents() {
        Extent none;
        none.first.fill(1 << 30), none.last.fill(-(1 << 30));
        std::fill(extents.begin(), extents.end(), none);
    }
    void shareOut() {
        shares.set(int(extents.size()), [&](int slab) {
            double n = 1;
            for (int k = 0; k < Dim - 1; ++k)
                n *= std::max(0, extents[slab].last[k] - extents[slab].first[k] + 1);
            return n;
        });
    }
};

template <int Dim> class Grid {
  public:
    static constexpr int ghost = 2; // layers of nodes outside the box
    static constexpr int blockWidth =
        4; // in nodes; blocks are the pieces of deterministic scatter, see BlockOrder
    static constexpr int wander = 1; // nodes that a particle may leave its block by before it is re-sorted

    Grid(const Vec<Dim>& lower, const Vec<Dim>& upper, const Vec<Dim>& cell)
        : lower(lower), upper(upper), cell(cell) {
        int stride = 1;
        double total = 1;
        for (int k = 0; k < Dim; ++k) {
            require(std::isfinite(lower[k]) && std::isfinite(upper[k]) && lower[k] < upper[k],
                    "Scene: lower = ", place(lower), ", upper = ", place(upper),
                    "; lower must be below upper");
            require(cell[k] > 0, "Scene: cell = ", cell[k], " m; give a positive cell size");
            total *= (upper[k] - lower[k]) / cell[k] + 1 + 2 * ghost;
            require(total <= std::numeric_limits<int>::max(), "Scene: cell = ", cell[k],
                    " m makes a grid of ", total, " nodes or more, and ", std::numeric_limits<int>::max(),
                    " are possible; give a larger cell or a smaller grid");
            cells[k] = int(std::lround((upper[k] - lower[k]) / cell[k]));
            require(cells[k] >= 1 && std::abs(cells[k] * cell[k] - (upper[k] - lower[k])) < 1e-6 * cell[k],
                    "Scene: upper - lower = ", upper[k] - lower[k], " m along axis ", k,
                    " is not a multiple of cell = ", cell[k], " m; move lower or upper, or change cell");
            nodes[k] = cells[k] + 1 + 2 * ghost;
            strides[k] = stride, overStride_[k] = 1.0 / stride;
            stride *= nodes[k];
        }
        count = stride;
        setFields(1);
    }

    const Vec<Dim> lower, upper, cell;
    Index<Dim> cells, nodes, strides;
    int count = 0;
    std::vector<NodalField<Dim>> fields;

    void setFields(int n) {
        fields.resize(n);
        for (auto& field : fields)
            if (int(field.sum.size()) != count) field.setSize(count, slabs());
    }

    int slabs() const { return nodes[Dim - 1]; }
    // Blocks are numbered tile by tile. A tile is two of them wide along each axis but the first and has one of each colour, so that threads with a few
    // tiles each begin with the first colour, go on with the next, and hardly wait for each other.
    int blocks() const {
        int product = 1;
        for (int k = 1; k < Dim; ++k) product *= 2 * tilesAlong(k);
        return product;
    }
    int blockAt(const Index<Dim>& node) const {
        int tile = 0, within = 0;
        for (int k = Dim - 1; k > 0; --k) {
            const int place = node[k] / blockWidth;
            tile = tile * tilesAlong(k) + place / 2, within = 2 * within + place % 2;
        }
        return (tile << (Dim - 1)) + within;
    }
    // The first node of a block along each axis.
    Index<Dim> blockBegin(int block) const {
        Index<Dim> begin;
        begin[0] = 0;
        for (int k = 1, within = block, tile = block >> (Dim - 1); k < Dim;
             within /= 2, tile /= tilesAlong(k++))
            begin[k] = (2 * (tile % tilesAlong(k)) + within % 2) * blockWidth;
        return begin;
    }
    // f(block) for the blocks beside a block, those across an edge too.
    template <class F> void blocksBeside(int block, F&& f) const {
        for (int n = 0; n < (Dim == 2 ? 3 : 9); ++n) {
            Index<Dim> there = blockBegin(block);
            bool isInside = true;
            for (int k = 1, rest = n; k < Dim; rest /= 3, ++k) {
                there[k] += (rest % 3 - 1) * blockWidth;
                isInside &= there[k] >= 0 && there[k] < nodes[k];
            }
            if (isInside && blockAt(there) != block) f(blockAt(there));
        }
    }

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

    // Calls f(node) for the nodes of a slab that the particles of a field touched.
    template <class F> void forNodes(const NodalField<Dim>& field, int slab, F&& f) const {
        forNodes(field.extents[slab], slab, f);
    }
    template <class F> void forNodes(const typename NodalField<Dim>::Extent& e, int slab, F&& f) const {
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

    int tilesAlong(int axis) const { return (nodes[axis] + 2 * blockWidth - 1) / (2 * blockWidth); }
};

} // namespace mpm
