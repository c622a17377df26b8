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
#include <cstdint>
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
    // Marks the cells up to two beyond the marked ones along each axis; and one more, the outermost.
    void widen(const Grid<Dim>& grid) {
        widenBy(grid, 2);
        outermost_ = cells_.size();
        widenBy(grid, 1);
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
    size_t outermost_ = 0; // the first of them in cells_

    void widenBy(const Grid<Dim>& grid, int by) {
        for (int k = 0; k < Dim; ++k)
            for (size_t i = 0, n = cells_.size(); i < n; ++i) {
                const int cell = cells_[i], at = grid.indices(cell)[k];
                const int last = std::min(at + by, grid.ghost + grid.cells[k] - 1);
                for (int j = std::max(at - by, grid.ghost); j <= last; ++j)
                    add(cell + (j - at) * grid.strides[k]);
            }
    }

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
        int steps[block]; // from the cell to its nodes and those round it
        for (int n = 0; n < block; ++n) {
            steps[n] = 0;
            for (int k = 0, rest = n; k < Dim; ++k, rest /= 4) steps[n] += (rest % 4 - 1) * grid.strides[k];
        }
        boxes_.clear();
        edge_.clear();
        body.cellAverage.forCells(marked.edges().front(), marked.edges().back(), [&](int p, int own) {
            if (!marked.isEdge(own)) return;
            boxes_.push_back(p);
            edge_.push_back(marked.numberOf(own));
        });
        inEdge_.fill(int(marked.edges().size()), edge_);
        Sums sums;
        for (int e = 0; e < int(marked.edges().size()); ++e) {
            const int edge = marked.edges()[e];
            Own cell{edge, int(nodes_.size())};
            const Around around(grid, edge, marked);
            for (int i = inEdge_.begin(e); i < inEdge_.end(e); ++i)
                cell.volume += cut(body, boxes_[inEdge_.point(i)], around, sums);
            for (; sums.touched; sums.touched &= sums.touched - 1) {
                const int n = __builtin_ctzll(sums.touched);
                const Quad sum = std::exchange(sums.of[n], Quad{});
                Vec<Dim> slope;
                for (int k = 0; k < Dim; ++k) slope[k] = sum[k];
                if (!slope.isZero(0)) nodes_.push_back({edge + steps[n], slope});
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
            for (int n = own.first; n < own.end; ++n) {
                const Vec<Dim> force = -cell.stress * nodes_[n].slope;
                Quad& sum = nodes[nodes_[n].node].part[1];
                if constexpr (Dim == 2)
                    sum += Quad{force[0], 0, force[1], 0};
                else
                    sum += Quad{force[0], force[1], force[2], 0};
            }
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
    // The sums of a cell, of those nodes that parts have touched.
    struct Sums {
        uint64_t touched = 0;
        Quad of[block] = {};
    };
    // A cell, and along each axis the ones before and after it: s of the cell less theirs, where it starts.
    struct Around {
        struct Row {
            double start, end, size, slope;
            bool isThere;
        };
        Row rows[Dim][3];
        double less[Dim == 2 ? 9 : 27];

        Around(const Grid<Dim>& grid, int number, const MarkedCells<Dim>& marked) {
            const Index<Dim> index = grid.indices(number);
            for (int k = 0; k < Dim; ++k)
                for (int j = 0; j < 3; ++j) {
                    const int at = index[k] + j - 1;
                    Row& row = rows[k][j];
                    row.isThere = at >= grid.ghost && at < grid.ghost + grid.cells[k];
                    if (!row.isThere) continue;
                    row.start = grid.line(k, at);
                    row.end = grid.line(k, at + 1);
                    row.size = grid.cellSize(k, at);
                    row.slope = 1 / row.size;
                }
            const double inside = marked.inside(number);
            for (int n = 0; n < (Dim == 2 ? 9 : 27); ++n) {
                int cell = number;
                bool isThere = true;
                for (int k = 0, rest = n; k < Dim; ++k, rest /= 3) {
                    isThere &= rows[k][rest % 3].isThere;
                    cell += (rest % 3 - 1) * grid.strides[k];
                }
                less[n] = isThere ? inside - marked.inside(cell) : 0;
            }
        }
    };
    // A part of a box along one axis k: its share of the box; hat functions of the two nodes at its centre, in lane k
    // their slopes, 1/m; the lower node, counted from the one before the cell of the box.
    struct Along {
        double share;
        Quad hat[2];
        int node;

        void set(const typename Around::Row& row, int k, double from, double to, double half) {
            const double after = (0.5 * (from + to) - row.start) / row.size, before = 1 - after;
            share = (to - from) / (2 * half);
            const auto lanes = [k](double all, double own) {
                return Quad{k == 0 ? own : all, k == 1 ? own : all, k == 2 ? own : all, 0};
            };
            hat[0] = lanes(before, -row.slope);
            hat[1] = lanes(after, row.slope);
        }
    };
    std::vector<Own> cells_; // their numbers rise
    std::vector<Node> nodes_;
    std::vector<int> boxes_, edge_; // boxes in the edges, and in which: memory of find()
    Bins inEdge_;

    // Adds the parts of a box to the sums of its cell; returns their volume. Along each axis it reaches into one of the
    // cells beside that of its centre at most.
    static double cut(const Body<Dim>& body, int p, const Around& around, Sums& sums) {
        const Vec<Dim> half = body.domains->boxes()->halfSize();
        double from[Dim], to[Dim];
        int side[Dim]; // 0: it does not reach there
        for (int k = 0; k < Dim; ++k) {
            const double x = body.particles.position.plane(k)[p];
            from[k] = x - half[k];
            to[k] = x + half[k];
            side[k] = from[k] < around.rows[k][1].start ? -1 : to[k] > around.rows[k][1].end ? 1 : 0;
            if (!around.rows[k][1 + side[k]].isThere) side[k] = 0;
        }
        double share[corners<Dim>]; // of the part that is beside along the axes of n
        bool isAny = false;
        for (int n = 1; n < corners<Dim>; ++n) {
            int cell = 0;
            bool isThere = true;
            for (int k = Dim - 1; k >= 0; --k) {
                isThere &= side[k] != 0 || (n >> k & 1) == 0;
                cell = 3 * cell + 1 + (n >> k & 1) * side[k];
            }
            share[n] = isThere ? around.less[cell] : 0;
            isAny |= share[n] != 0;
        }
        if (!isAny) return 0;
        Along along[Dim][2]; // in the cell of the centre, and beside it
        for (int k = 0; k < Dim; ++k) {
            const auto& own = around.rows[k][1];
            along[k][0].set(own, k, std::max(own.start, from[k]), std::min(own.end, to[k]), half[k]);
            along[k][0].node = 1;
            if (side[k] == 0) continue;
            const auto& beside = around.rows[k][1 + side[k]];
            along[k][1].set(beside, k, side[k] > 0 ? own.end : std::max(beside.start, from[k]),
                            side[k] < 0 ? own.start : std::min(beside.end, to[k]), half[k]);
            along[k][1].node = 1 + side[k];
        }
        double all = 0;
        for (int n = 1; n < corners<Dim>; ++n) {
            if (share[n] == 0) continue;
            const Along* part[Dim];
            double volume = share[n] * body.particles.volume.plane()[p];
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
    static void addSlopes(const Along* const part[Dim], double volume, Sums& sums) {
        int first = 0;
        for (int k = Dim - 1; k >= 0; --k) first = 4 * first + part[k]->node;
        sums.touched |= uint64_t(Dim == 2 ? 0x33 : 0x330033) << first; // the corners of a cell
        for (int z = 0; z < (Dim == 2 ? 1 : 2); ++z) {
            const Quad plane = Dim == 2 ? Quad{volume, volume, 0, 0} : volume * part[Dim - 1]->hat[z];
            for (int y = 0; y < 2; ++y) {
                const Quad row = plane * part[1]->hat[y];
                for (int x = 0; x < 2; ++x) sums.of[first + 16 * z + 4 * y + x] += row * part[0]->hat[x];
            }
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
