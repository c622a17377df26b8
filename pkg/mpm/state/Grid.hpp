// SPDX-License-Identifier: GPL-2.0-or-later
// The background grid: a box of equal cells with ghost nodes around it. Nodes are numbered with the first
// axis fastest; a slab is the set of nodes with the same number along the last axis. A block is four rows of
// nodes wide along each axis but the first, along which it is as long as the grid.
#pragma once

#include "mpm/base/require.hpp"
#include "mpm/state/NodalField.hpp"

#include <limits>
#include <vector>

namespace mpm {

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
            strides[k] = stride;
            overStride_[k] = 1.0 / stride;
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
    // Blocks are numbered tile by tile. A tile is two of them wide along each axis but the first and has one
    // of each colour, so that threads with a few tiles each begin with the first colour, go on with the next,
    // and hardly wait for each other.
    int blocks() const {
        int product = 1;
        for (int k = 1; k < Dim; ++k) product *= 2 * tilesAlong(k);
        return product;
    }
    int blockAt(const Index<Dim>& node) const {
        int tile = 0, within = 0;
        for (int k = Dim - 1; k > 0; --k) {
            const int place = node[k] / blockWidth;
            tile = tile * tilesAlong(k) + place / 2;
            within = 2 * within + place % 2;
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
