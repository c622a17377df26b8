// SPDX-License-Identifier: GPL-2.0-or-later
// The mean stress of boxes beside rigid bodies, where it reaches up to the surface: there some cells act
// whole, others by their particles (share s, see CellAverage). A box counts in the cell c of its centre. Its
// part in a cell j that acts whole would act twice, and one beyond such a cell not at all. With the
// volume V_j of these parts and their centres x_j, where hat functions have their means over the part,
//     f_i -= p_c sum_j (s_c - s_j) V_j grad S_i(x_j),
//     r_c = (V_a r_c + eta sum_j (s_c - s_j) V_j sum_i v_i . grad S_i(x_j))/(V_a + sum_j (s_c - s_j) V_j),
// each the transpose of the other. So a pressure that is the same everywhere is in equilibrium with bodies
// that press on the faces of boxes. At a free surface there is no mean stress that could count twice.
#pragma once

#include "mpm/scene/Body.hpp"
#include "mpm/state/Bins.hpp"
#include "mpm/state/cover.hpp"

#include <algorithm>
#include <map>
#include <utility>

namespace mpm {

// Cells of the grid round some, each with its share s. What was marked in a step is forgotten cell by cell: a grid may
// be large, and one thread does this.
template <int Dim> class MarkedCells {
  public:
    void reset(const Grid<Dim>& grid) {
        for (int cell : cells_) mark_[cell] = Mark::none;
        cells_.clear();
        edges_.clear();
        mark_.resize(grid.count);
        inside_.resize(grid.count);
        number_.resize(grid.count);
        outermost_ = 0;
    }
    void add(int cell) {
        if (mark_[cell] == Mark::none) cells_.push_back(cell);
        mark_[cell] = Mark::marked;
    }
    // Marks the cells round the outermost ones, too.
    void widen(const Grid<Dim>& grid) {
        const size_t first = std::exchange(outermost_, cells_.size());
        for (size_t i = first; i < outermost_; ++i)
            anyAround(grid, cells_[i], [&](int other) {
                add(other);
                return false;
            });
    }
    template <class F> void setInside(F&& of) {
        for (int cell : cells_) inside_[cell] = of(cell);
    }
    // An edge is a cell that may be one, has a cell beside it with another share, and none that is not marked.
    template <class MayBe> void findEdges(const Grid<Dim>& grid, MayBe&& mayBe) {
        for (size_t i = 0; i < cells_.size(); ++i) {
            const int cell = cells_[i];
            if (!mayBe(cell)) continue;
            const double inside = inside_[cell];
            if (!anyAround(grid, cell, [&](int other) { return inside_[other] != inside; })) continue;
            if (i < outermost_ ||
                !anyAround(grid, cell, [&](int other) { return mark_[other] == Mark::none; }))
                edges_.push_back(cell);
        }
        std::sort(edges_.begin(), edges_.end());
        for (size_t e = 0; e < edges_.size(); ++e) {
            mark_[edges_[e]] = Mark::edge;
            number_[edges_[e]] = int(e);
        }
    }
    const std::vector<int>& edges() const { return edges_; } // their numbers rise
    bool isEdge(int cell) const { return mark_[cell] == Mark::edge; }
    int numberOf(int edge) const { return number_[edge]; }
    double inside(int cell) const { return inside_[cell]; }
    bool empty() const { return cells_.empty(); }

  private:
    enum class Mark : char { none, marked, edge };
    std::vector<Mark> mark_;     // an edge is marked, too
    std::vector<double> inside_; // s, of marked ones
    std::vector<int> number_;    // of edges, among them
    std::vector<int> cells_, edges_;
    size_t outermost_ = 0; // the first of the ring that was added last

    // Whether f(cell) is true of one round a cell, asked in the order of their numbers.
    template <class F> static bool anyAround(const Grid<Dim>& grid, int cell, F&& f) {
        const Index<Dim> index = grid.indices(cell);
        int first[Dim], last[Dim];
        for (int k = 0; k < Dim; ++k) {
            first[k] = index[k] > grid.ghost ? -1 : 0;
            last[k] = index[k] < grid.ghost + grid.cells[k] - 1 ? 1 : 0;
        }
        for (int z = Dim > 2 ? first[Dim - 1] : 0; z <= (Dim > 2 ? last[Dim - 1] : 0); ++z)
            for (int y = first[1]; y <= last[1]; ++y) {
                const int row = cell + y * grid.strides[1] + (Dim > 2 ? z * grid.strides[Dim - 1] : 0);
                for (int x = first[0]; x <= last[0]; ++x)
                    if (f(row + x)) return true;
            }
        return false;
    }
};

// Of one body of the scene.
template <int Dim> class BoxParts {
  public:
    void clear() {
        cells_.clear();
        nodes_.clear();
    }
    bool empty() const { return cells_.empty(); }

    // Of the boxes in the edges of the marked cells.
    void find(const Body<Dim>& body, const Grid<Dim>& grid, const MarkedCells<Dim>& marked) {
        boxes_.clear();
        edge_.clear();
        body.cellAverage.forCells(marked.edges().front(), marked.edges().back(), [&](int p, int own) {
            if (!marked.isEdge(own)) return;
            boxes_.push_back(p);
            edge_.push_back(marked.numberOf(own));
        });
        inEdge_.fill(int(marked.edges().size()), edge_);
        for (int e = 0; e < int(marked.edges().size()); ++e) {
            Own cell{marked.edges()[e], int(nodes_.size())};
            Vec<Dim> sums[block];
            for (auto& sum : sums) sum.setZero();
            for (int i = inEdge_.begin(e); i < inEdge_.end(e); ++i)
                cell.volume += cut(body, grid, boxes_[inEdge_.point(i)], cell.number, marked, sums);
            for (int n = 0; n < block; ++n) {
                if (sums[n].isZero(0)) continue;
                int node = cell.number;
                for (int k = 0, rest = n; k < Dim; ++k, rest /= 4) node += (rest % 4 - 1) * grid.strides[k];
                nodes_.push_back({node, sums[n]});
            }
            cell.end = int(nodes_.size());
            if (cell.end > cell.first) cells_.push_back(cell);
        }
    }
    // Adds the forces of the mean stress of the cells to the nodes.
    void addForces(const Body<Dim>& body, typename NodalField<Dim>::Sum* nodes) const {
        for (const Own& own : cells_) {
            const auto& cell = *body.cellAverage.occupied(own.number);
            if (cell.shared > 0) continue;
            for (int n = own.first; n < own.end; ++n)
                for (int k = 0; k < Dim; ++k)
                    NodalField<Dim>::addForce(nodes[nodes_[n].node], k, -cell.stress * nodes_[n].slope[k]);
        }
    }
    // Before rate(): what flows into the parts of each cell.
    template <class Velocity> void takeFluxes(const Velocity* nodes) {
        for (Own& cell : cells_) {
            cell.flux = 0;
            for (int n = cell.first; n < cell.end; ++n)
                for (int k = 0; k < Dim; ++k) cell.flux += nodes_[n].slope[k] * nodes[nodes_[n].node][k];
        }
    }
    // Rate of volume change of a cell with its parts, 1/s, from that without; acting: volume of this one, m3.
    double rate(int number, double without, double acting, double uneven) const {
        const auto at = std::lower_bound(cells_.begin(), cells_.end(), number,
                                         [](const Own& cell, int n) { return cell.number < n; });
        if (at == cells_.end() || at->number != number) return without;
        return (without * acting + uneven * at->flux) / (acting + at->volume);
    }

  private:
    static constexpr int block = Dim == 2 ? 16 : 64; // nodes of a cell and of those round it

    // A cell that counts boxes: its nodes_, the volume of all parts times s_c - s_j, and what flows into them.
    struct Own {
        int number, first, end = 0;
        double volume = 0, flux = 0; // m3, m3/s
    };
    struct Node {
        int node;
        Vec<Dim> slope; // m2, the sum of (s_c - s_j) V_j grad S
    };
    // A part of a box along one axis: its share of the box; hat functions of the two nodes at its centre, their slope,
    // 1/m; the lower node, counted from the one before the cell of the box.
    struct Along {
        double share = 1, hat[2] = {0, 0}, slope = 0;
        int node = 1;

        Along() = default;
        Along(const Grid<Dim>& grid, int k, int index, double from, double to, double half)
            : share((to - from) / (2 * half)), slope(1 / grid.cellSize(k, index)) {
            hat[1] = (0.5 * (from + to) - grid.line(k, index)) / grid.cellSize(k, index);
            hat[0] = 1 - hat[1];
        }
    };
    std::vector<Own> cells_; // their numbers rise
    std::vector<Node> nodes_;
    std::vector<int> boxes_, edge_; // boxes in the edges, and in which: memory of find()
    Bins inEdge_;

    // Adds the parts of a box to the sums of its cell; returns their volume. Along each axis it reaches into one of the
    // cells beside that of its centre at most.
    double cut(const Body<Dim>& body, const Grid<Dim>& grid, int p, int own, const MarkedCells<Dim>& marked,
               Vec<Dim>* sums) const {
        const Vec<Dim> half = body.domains->boxes()->halfSize();
        const Index<Dim> index = grid.indices(own);
        Along along[Dim][2]; // in the cell of the centre, and beside it
        int side[Dim];       // 0: it does not reach there
        for (int k = 0; k < Dim; ++k) {
            const double x = body.particles.position.plane(k)[p], from = x - half[k], to = x + half[k];
            const double low = grid.line(k, index[k]), high = grid.line(k, index[k] + 1);
            side[k] = from < low ? -1 : to > high ? 1 : 0;
            along[k][0] = Along(grid, k, index[k], std::max(low, from), std::min(high, to), half[k]);
            const int at = index[k] + side[k];
            if (at < grid.ghost || at >= grid.ghost + grid.cells[k]) side[k] = 0;
            if (side[k] == 0) continue;
            const double start = grid.line(k, at), end = grid.line(k, at + 1);
            along[k][1] = Along(grid, k, at, side[k] > 0 ? high : std::max(start, from),
                                side[k] < 0 ? low : std::min(end, to), half[k]);
            along[k][1].node += side[k];
        }
        double all = 0;
        for (int n = 1; n < corners<Dim>; ++n) { // along which axes it is beside
            int cell = own;
            bool isThere = true;
            for (int k = 0; k < Dim; ++k) {
                isThere &= side[k] != 0 || (n >> k & 1) == 0;
                cell += (n >> k & 1) * side[k] * grid.strides[k];
            }
            const double share = isThere ? marked.inside(own) - marked.inside(cell) : 0;
            if (share == 0) continue;
            const Along* part[Dim];
            double volume = share * body.particles.volume.plane()[p];
            for (int k = 0; k < Dim; ++k) {
                part[k] = &along[k][n >> k & 1];
                volume *= part[k]->share;
            }
            all += volume;
            addSlopes(part, volume, sums);
        }
        return all;
    }
    // Adds the slopes of the hat functions at the centre of a part, times its volume.
    static void addSlopes(const Along* const part[Dim], double volume, Vec<Dim>* sums) {
        for (int a = 0; a < corners<Dim>; ++a) {
            int node = 0;
            Vec<Dim> slope = Vec<Dim>::Constant(volume);
            for (int k = Dim - 1; k >= 0; --k) {
                const int corner = cornerSign(a, k) > 0;
                node = 4 * node + part[k]->node + corner;
                for (int i = 0; i < Dim; ++i)
                    slope[i] *= i == k ? cornerSign(a, k) * part[k]->slope : part[k]->hat[corner];
            }
            sums[node] += slope;
        }
    }
};

// What rigid bodies press on.
template <int Dim> class PressedBoxes {
  public:
    // Of each body of the scene: those of bodies that nothing presses on are empty, and there are none without rigid
    // bodies.
    std::vector<BoxParts<Dim>> parts;
    // Of the bodies of boxes that were pressed, by their numbers.
    std::map<int, MarkedCells<Dim>> cells;

    // Those of a body that has the number b; nullptr: nothing presses on it.
    BoxParts<Dim>* of(size_t b) { return b < parts.size() && !parts[b].empty() ? &parts[b] : nullptr; }
};

} // namespace mpm
