// SPDX-License-Identifier: GPL-2.0-or-later
// Pore pressure as one unknown u per cell of saturated soil: the excess over a reference. B takes nodal velocities to
// the flow out of the cells, its transpose u to nodal forces (doc/theory/water.md):
//     (B v)_c = V_c v_i . grad phi_ic      f_i = sum_c V_c u_c grad phi_ic
// with the volume V_c that the pressure of a cell acts with and the mean of the gradient over the cell. The matrix
//     A = C + H + dt B M^-1 B^T,   C = n V_c/(K_w dt)
// with the flow H u between cells and to where the water is free, is symmetric and positive; it is never formed.
#pragma once

#include "mpm/base/parallel/OrderedSum.hpp"
#include "mpm/base/parallel/ParallelRegion.hpp"
#include "mpm/particle/apdi/APDIShape.hpp"
#include "mpm/state/cover.hpp"

#include <array>
#include <vector>

namespace mpm {

template <int Dim> class PoreSystem {
  public:
    static constexpr int NC = corners<Dim>;

    struct Cell {
        int number;                 // of the grid
        double volume;              // that its pressure acts with, m3
        Vec<Dim> slope;             // of a hat function over the cell, 1/m: with the sign of the corner
        double storage = 0;         // C, m3/(kPa s)
        double flow = 0;            // diagonal of H, m3/(kPa s)
        double source = 0;          // what flows in at u = 0, m3/s
        std::array<int, NC> corner; // number among the nodes
    };
    struct Node {
        int number;                // of the grid
        Vec<Dim> step;             // dt over the mass where it may move, else 0, s/Mg
        std::array<int, NC> cells; // around it, -1: none; in the order of its corner in them
    };
    struct Face {
        int before, beyond; // cells
        double conductance; // m3/(kPa s)
        double drive;       // flow from `before` to `beyond` at equal u, m3/s
    };

    std::vector<Cell> cells;
    std::vector<Node> nodes;
    std::vector<Face> faces;

    // One by one, after a new start: the cells first.
    void start(int gridCount) {
        for (const Cell& cell : cells) cellAt_[cell.number] = -1;
        for (const Node& node : nodes) nodeAt_[node.number] = -1;
        cellAt_.resize(gridCount, -1);
        nodeAt_.resize(gridCount, -1);
        cells.clear();
        nodes.clear();
        faces.clear();
    }
    Cell& addCell(const Grid<Dim>& grid, int number) {
        cellAt_[number] = int(cells.size());
        Cell& cell = cells.emplace_back();
        cell.number = number;
        const Vec<Dim> edges = grid.edges(number);
        cell.slope = (2.0 / NC) * edges.cwiseInverse();
        return cell;
    }
    int cellAt(int number) const { return cellAt_[number]; }
    // Those of all cells.
    void addNodes(const Grid<Dim>& grid) {
        for (int c = 0; c < int(cells.size()); ++c)
            for (int a = 0; a < NC; ++a) {
                const int number = cornerOf(grid, cells[c].number, a);
                int& at = nodeAt_[number];
                if (at < 0) {
                    at = int(nodes.size());
                    Node& node = nodes.emplace_back();
                    node.number = number;
                    node.cells.fill(-1);
                }
                nodes[at].cells[a] = c;
                cells[c].corner[a] = at;
            }
    }
    // Once all is known: who is beside whom.
    void finish() {
        beside_.assign(cells.size(), {});
        for (auto& list : beside_) list.fill({-1, 0});
        std::vector<int> count(cells.size(), 0);
        for (const Face& face : faces) {
            cells[face.before].flow += face.conductance;
            cells[face.beyond].flow += face.conductance;
            cells[face.before].source -= face.drive;
            cells[face.beyond].source += face.drive;
            beside_[face.before][count[face.before]++] = {face.beyond, face.conductance};
            beside_[face.beyond][count[face.beyond]++] = {face.before, face.conductance};
        }
        for (auto* vector : {&direction_, &product_}) vector->resize(cells.size());
        impulse_.resize(nodes.size());
        findDiagonal();
    }

    // B v of velocities velocity(node of the grid, axis), m3/s.
    template <class Velocity>
    void flowOut(ParallelRegion& region, Velocity&& velocity, std::vector<double>& out) const {
        region.chunks(int(cells.size()), [&](int begin, int end) {
            for (int c = begin; c < end; ++c) {
                double sum = 0;
                for (int a = 0; a < NC; ++a)
                    for (int k = 0; k < Dim; ++k)
                        sum += cornerSign(a, k) * cells[c].slope[k] *
                               velocity(nodes[cells[c].corner[a]].number, k);
                out[c] = cells[c].volume * sum;
            }
        });
    }
    // B^T u on a node, kN.
    Vec<Dim> force(const Node& node, const std::vector<double>& u) const {
        Vec<Dim> f = Vec<Dim>::Zero();
        for (int a = 0; a < NC; ++a) {
            const int c = node.cells[a];
            if (c < 0) continue;
            for (int k = 0; k < Dim; ++k)
                f[k] += cornerSign(a, k) * cells[c].slope[k] * (cells[c].volume * u[c]);
        }
        return f;
    }
    // y = H u, m3/s
    double flowAway(int c, const std::vector<double>& u) const {
        double sum = cells[c].flow * u[c];
        for (const auto& [other, conductance] : beside_[c])
            if (other >= 0) sum -= conductance * u[other];
        return sum;
    }

    // Solves A u = right from the u that is there, until no cell is off by more than `tolerance` kPa of storage.
    // Returns the iterations, -1: not within `most`. residual: right - A u, m3/s. By all threads.
    int solve(ParallelRegion& region, const std::vector<double>& right, double tolerance, int most,
              std::vector<double>& u, std::vector<double>& residual) {
        const int n = int(cells.size());
        multiply(region, u, product_);
        region.chunks(n, [&](int begin, int end) {
            for (int c = begin; c < end; ++c) residual[c] = right[c] - product_[c];
        });
        double before = 0;
        for (int iteration = 0;; ++iteration) {
            if (isDone(region, residual, tolerance)) return iteration;
            if (iteration == most) return -1;
            const double now =
                sumOf(region, [&](int c) { return residual[c] * residual[c] * overDiagonal_[c]; });
            const double part = iteration > 0 ? now / before : 0;
            before = now;
            region.chunks(n, [&](int begin, int end) {
                for (int c = begin; c < end; ++c)
                    direction_[c] = overDiagonal_[c] * residual[c] + (part > 0 ? part * direction_[c] : 0);
            });
            multiply(region, direction_, product_);
            const double length = now / sumOf(region, [&](int c) { return direction_[c] * product_[c]; });
            region.chunks(n, [&](int begin, int end) {
                for (int c = begin; c < end; ++c) {
                    u[c] += length * direction_[c];
                    residual[c] -= length * product_[c];
                }
            });
        }
    }

    // y = A x, by all threads.
    void multiply(ParallelRegion& region, const std::vector<double>& x, std::vector<double>& y) {
        region.chunks(int(nodes.size()), [&](int begin, int end) {
            for (int i = begin; i < end; ++i) impulse_[i] = force(nodes[i], x).cwiseProduct(nodes[i].step);
        });
        region.chunks(int(cells.size()), [&](int begin, int end) {
            for (int c = begin; c < end; ++c) {
                double sum = 0;
                for (int a = 0; a < NC; ++a)
                    for (int k = 0; k < Dim; ++k)
                        sum += cornerSign(a, k) * cells[c].slope[k] * impulse_[cells[c].corner[a]][k];
                y[c] = cells[c].storage * x[c] + flowAway(c, x) + cells[c].volume * sum;
            }
        });
    }

  private:
    std::vector<int> cellAt_, nodeAt_; // of the grid; -1: none
    std::vector<std::array<std::pair<int, double>, 2 * Dim>> beside_;
    std::vector<double> overDiagonal_, direction_, product_;
    std::vector<Vec<Dim>> impulse_;
    OrderedSum sum_;
    double total_ = 0;
    char isDone_ = 0;

    void findDiagonal() {
        overDiagonal_.resize(cells.size());
        for (size_t c = 0; c < cells.size(); ++c) {
            const Cell& cell = cells[c];
            double sum = 0;
            for (int a = 0; a < NC; ++a) sum += cell.slope.cwiseAbs2().dot(nodes[cell.corner[a]].step);
            overDiagonal_[c] = 1 / (cell.storage + cell.flow + cell.volume * cell.volume * sum);
        }
    }
    template <class F> double sumOf(ParallelRegion& region, F&& f) {
        const int n = int(cells.size());
        region.once([&] { sum_.clear(n); });
        region.chunks(n, [&](int begin, int end) {
            double sum = 0;
            for (int c = begin; c < end; ++c) sum += f(c);
            sum_.of(begin) = sum;
        });
        region.once([&] { total_ = sum_.total(); });
        return total_;
    }
    bool isDone(ParallelRegion& region, const std::vector<double>& residual, double tolerance) {
        return sumOf(region, [&](int c) {
                   return std::abs(residual[c]) > tolerance * cells[c].storage ? 1.0 : 0.0;
               }) == 0;
    }
};

} // namespace mpm
