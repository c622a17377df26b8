// SPDX-License-Identifier: GPL-2.0-or-later
// The background grid: a box of cells with ghost nodes around it. The cells are equal, or along each axis lines
// of nodes are where they were given (a graded grid); who needs a place in the grid or the size of a cell asks
// for it here, and does not know which of the two it is. Nodes are numbered with the first
// axis fastest; a slab is the set of nodes with the same number along the last axis. A block is four rows of
// nodes wide along each axis but the first, along which it is as long as the grid.
#pragma once

#include "mpm/base/freeMemory.hpp"
#include "mpm/base/require.hpp"
#include "mpm/state/GridLines.hpp"
#include "mpm/state/NodalField.hpp"

#include <algorithm>
#include <limits>
#include <vector>

namespace mpm {

template <int Dim> class Grid {
  public:
    static constexpr int ghost = 2; // layers of nodes outside the box
    static constexpr int blockWidth =
        4; // in nodes; blocks are the pieces of deterministic scatter, see BlockOrder
    static constexpr int wander = 1; // nodes that a particle may leave its block by before it is re-sorted

    using Lines = std::array<std::vector<double>, Dim>;

    Grid(const Vec<Dim>& lower, const Vec<Dim>& upper, const Vec<Dim>& cell)
        : lower(lower), upper(upper), cell_(cell), largest_(cell) {
        double total = 1;
        for (int k = 0; k < Dim; ++k) {
            require(std::isfinite(lower[k]) && std::isfinite(upper[k]) && lower[k] < upper[k],
                    "Scene: lower = ", place(lower), ", upper = ", place(upper),
                    "; lower must be below upper");
            require(cell[k] > 0, "Scene: cell = ", cell[k], " m; give a positive cell size");
            total *= (upper[k] - lower[k]) / cell[k] + 1 + 2 * ghost;
            checkCount(total, cell[k]);
            cells[k] = int(std::lround((upper[k] - lower[k]) / cell[k]));
            require(cells[k] >= 1 && std::abs(cells[k] * cell[k] - (upper[k] - lower[k])) < 1e-6 * cell[k],
                    "Scene: upper - lower = ", upper[k] - lower[k], " m along axis ", k,
                    " is not a multiple of cell = ", cell[k], " m; move lower or upper, or change cell");
        }
        setSize();
    }

    // Positions of the lines of nodes across each axis, m, the first and the last at the faces of the grid.
    explicit Grid(const Lines& lines) : lower(endsOf(lines, false)), upper(endsOf(lines, true)) {
        double total = 1;
        for (int k = 0; k < Dim; ++k) {
            lines_[k] = GridLines(lines[k], ghost, k);
            cell_[k] = lines_[k].smallest();
            largest_[k] = lines_[k].largest();
            cells[k] = int(lines[k].size()) - 1;
            total *= cells[k] + 1.0 + 2 * ghost;
            checkCount(total, cell_[k]);
        }
        isGraded_ = true;
        setSize();
    }

    const Vec<Dim> lower, upper;
    // With axial symmetry the first axis is the distance from the axis, r, and all that is by volume is of the whole
    // ring: it has the thickness 2 pi r where plane strain has 1 m. Set before there are bodies.
    bool isAxisymmetric = false;
    Index<Dim> cells, nodes, strides;
    int count = 0;
    std::vector<NodalField<Dim>> fields;

    // firstOf: of each field, the one that it has the second half of the memory of; itself: it has its own. Raises
    // MemoryError, and changes nothing, where they do not fit into memory.
    void setFields(const std::vector<int>& firstOf) {
        const int n = int(firstOf.size());
        const int more = n - int(fields.size());
        if (more > 0)
            requireMemory(double(more) * count * NodalField<Dim>::bytesOfNode,
                          message("Scene: the ", count, " nodes of the grid",
                                  fields.empty() ? "" : " for the groups that Contact has besides the first"),
                          "give a larger cell or a smaller grid, or end other programs");
        fields.resize(n);
        for (int f = 0; f < n; ++f) {
            const int halves = int(std::count(firstOf.begin(), firstOf.end(), f));
            if (halves > 0 && (fields[f].sum.size() != count || fields[f].halves != halves))
                fields[f].setSize(count, slabs(), halves);
            if (halves == 0) fields[f].beSecondHalfOf(fields[firstOf[f]]);
        }
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

    // --- cells: a cell has the number, along each axis, of the line below it --------------------------
    bool isGraded() const { return isGraded_; }
    const Vec<Dim>& smallestCell() const { return cell_; } // edges, m: along each axis that of all cells
    const Vec<Dim>& largestCell() const { return largest_; }
    double cellSize(int axis, int line) const { return isGraded_ ? lines_[axis].size(line) : cell_[axis]; }
    Vec<Dim> edges(int cell) const {
        if (!isGraded_) return cell_;
        const Index<Dim> index = indices(cell);
        Vec<Dim> size;
        for (int k = 0; k < Dim; ++k) size[k] = lines_[k].size(std::clamp(index[k], 0, nodes[k] - 2));
        return size;
    }
    double thicknessAt(double r) const { return isAxisymmetric ? 2 * M_PI * std::abs(r) : 1; }
    double volume(int cell) const {
        const double area = edges(cell).prod();
        return isAxisymmetric ? area * thicknessAt(centre(indices(cell))[0]) : area;
    }
    // Boxes weigh r by its value in their middles, half: of their edge along r, m. A cell that acts for them takes its
    // second moment over r from these middles: this part of the whole one. 1: exact, of domains of meshes (half = 0).
    double ringMoment(int cell, double half) const {
        const double part = 2 * half / edges(cell)[0];
        return 1 - part * part;
    }
    // What a cell's volume gains as its node moves along each axis, over the same where the thickness is that in the
    // middle of the cell. half: see ringMoment().
    Vec<Dim> volumeSlopes(int cell, int node, double half) const {
        Vec<Dim> slopes = Vec<Dim>::Ones();
        if constexpr (Dim == 2)
            if (isAxisymmetric) {
                const double over = nodePosition(node)[0] / centre(indices(cell))[0];
                slopes = {over, 1 + ringMoment(cell, half) * (over - 1) / 3};
            }
        return slopes;
    }
    // f(std::true_type()) with axial symmetry, else f(std::false_type()): loops are compiled for each of the two.
    template <class F> decltype(auto) inGeometry(F&& f) const {
        if constexpr (Dim == 2)
            if (isAxisymmetric) return f(std::true_type());
        return f(std::false_type());
    }
    // Edges of the cell at a place.
    Vec<Dim> sizeAt(const Vec<Dim>& x) const {
        if (!isGraded_) return cell_;
        Vec<Dim> size;
        for (int k = 0; k < Dim; ++k)
            size[k] = lines_[k].size(std::clamp(int(inCells(x[k], k)), 0, nodes[k] - 2));
        return size;
    }
    // Along each axis, the mean edge of the two cells beside a node, and how far the nodes two away are at most.
    Vec<Dim> meanSize(int node) const {
        return isGraded_ ? alongAxes(node, [](double, double before, double after,
                                              double) { return 0.5 * (after - before); })
                         : cell_;
    }
    Vec<Dim> twoCells(int node) const {
        return isGraded_ ? alongAxes(node, [](double first, double, double,
                                              double last) { return std::max(-first, last); })
                         : Vec<Dim>(2 * cell_);
    }
    // Whether all cells beside a node have the smallest size.
    bool isEven(const Index<Dim>& node) const {
        bool areAll = true;
        for (int k = 0; k < Dim && isGraded_; ++k) areAll &= lines_[k].isEven(node[k]);
        return areAll;
    }

    // --- places ---------------------------------------------------------------------------------------
    // Position in cells from the lower face, and from the lowest ghost node.
    double fromLower(double x, int axis) const {
        return isGraded_ ? lines_[axis].inCells(x) - ghost : (x - lower[axis]) / cell_[axis];
    }
    double inCells(double x, int axis) const {
        return isGraded_ ? lines_[axis].inCells(x) : (x - lower[axis]) / cell_[axis] + ghost;
    }
    // loop(inCells) for a loop over many places along an axis, with what inCells(x) is on this grid.
    template <class Loop> void alongAxis(int axis, Loop&& loop) const {
        const double origin = lower[axis], cell = cell_[axis];
        const GridLines& lines = lines_[axis];
        if (isGraded_)
            loop([&](double x) MPM_INLINE_LAMBDA { return lines.inCells(x); });
        else
            loop([=](double x) MPM_INLINE_LAMBDA { return (x - origin) / cell + ghost; });
    }
    const GridLines& lines(int axis) const { return lines_[axis]; } // of a graded grid

    // Adds to each of some places' numbers what the line below it along an axis counts: cell numbers, once this was
    // done for all axes. Places outside of the grid (or not a number: found out later) go to the outermost cells.
    void addCells(int axis, const double* x, int count, int* number) const {
        addCells(axis, x, count, number, strides[axis]);
    }
    void addCells(int axis, const double* x, int count, int* number, int stride) const {
        const int last = nodes[axis] - 2;
        if (isGraded_) {
            const GridLines& lines = lines_[axis];
            for (int i = 0; i < count; ++i)
                number[i] += std::min(std::max(1, lines.below(x[i])), last) * stride;
        } else {
            const double origin = lower[axis], cell = cell_[axis];
            for (int i = 0; i < count; ++i) {
                const double inCells = std::max(1.0, (x[i] - origin) / cell + ghost);
                number[i] += int(std::min(inCells, double(last))) * stride;
            }
        }
    }

    double line(int axis, int number) const {
        return isGraded_ ? lines_[axis].position(number) : lower[axis] + (number - ghost) * cell_[axis];
    }
    Vec<Dim> centre(const Index<Dim>& cell) const {
        Vec<Dim> x;
        for (int k = 0; k < Dim; ++k)
            x[k] = isGraded_ ? lines_[k].position(cell[k]) + 0.5 * lines_[k].size(cell[k])
                             : lower[k] + (cell[k] - ghost + 0.5) * cell_[k];
        return x;
    }

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
        for (int k = 0; k < Dim; ++k) x[k] = line(k, index[k]);
        return x;
    }

    // Whether the particles of a field may have given mass to a node in this step.
    bool mayHaveMass(const NodalField<Dim>& field, int node) const {
        const Index<Dim> index = indices(node);
        const auto& extent = field.extents[index[Dim - 1]];
        bool isIn = extent.first[0] <= extent.last[0];
        for (int k = 0; k < Dim - 1; ++k) isIn &= index[k] >= extent.first[k] && index[k] <= extent.last[k];
        return isIn;
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
    Vec<Dim> cell_, largest_; // m, of the cells: smallest and largest
    bool isGraded_ = false;
    std::array<GridLines, Dim> lines_; // empty where the cells are equal
    std::array<double, Dim> overStride_;

    static Vec<Dim> endsOf(const Lines& lines, bool isUpper) {
        Vec<Dim> end;
        for (int k = 0; k < Dim; ++k) {
            require(lines[k].size() > 1, "Scene: axis ", k,
                    " has no two grid lines; give the ends of the grid");
            end[k] = isUpper ? lines[k].back() : lines[k].front();
        }
        return end;
    }

    static void checkCount(double total, double cell) {
        require(total <= std::numeric_limits<int>::max(), "Scene: cell = ", cell, " m makes a grid of ",
                total, " nodes or more, and ", std::numeric_limits<int>::max(),
                " are possible; give a larger cell or a smaller grid");
    }

    void setSize() {
        int stride = 1;
        for (int k = 0; k < Dim; ++k) {
            nodes[k] = cells[k] + 1 + 2 * ghost;
            strides[k] = stride;
            overStride_[k] = 1.0 / stride;
            stride *= nodes[k];
        }
        count = stride;
        setFields({0});
    }

    // f(distances from a node to the two lines before it and the two after it) along each axis.
    template <class F> Vec<Dim> alongAxes(int node, F&& f) const {
        const Index<Dim> index = indices(node);
        Vec<Dim> all;
        for (int k = 0; k < Dim; ++k) {
            const auto to = [&](int step) {
                return line(k, std::clamp(index[k] + step, 0, nodes[k] - 1)) - line(k, index[k]);
            };
            all[k] = f(to(-2), to(-1), to(1), to(2));
        }
        return all;
    }

    int tilesAlong(int axis) const { return (nodes[axis] + 2 * blockWidth - 1) / (2 * blockWidth); }
};

} // namespace mpm
