// SPDX-License-Identifier: GPL-2.0-or-later
// Pore pressure as one unknown u per cell of saturated soil: the excess over a reference. B takes nodal
// velocities to the flow out of the cells, its transpose u to nodal forces (doc/theory/water.md):
//     (B v)_c = V_c v_i . grad phi_ic      f_i = sum_c V_c u_c grad phi_ic
// with the volume V_c that the pressure of a cell acts with and the gradient of its rate of volume change:
// the mean of the gradient over the cell inside of the soil, and that of its particles at a surface (parts).
// The matrix
//     A = C + H + dt B M^-1 B^T,   C = n V_c/(K_w dt)
// with the flow H u between cells and to where the water is free, is symmetric and positive; step/PoreMatrix.hpp
// solves with it.
//
// Cells that a structure cuts hand a share of their flow to neighbours with more soil, and have the same
// share of their pressure (step/PoreSolids.hpp). Of a node that several groups move, v is the mean by their
// volumes; implicit bodies answer by all of their nodes.
#pragma once

#include "mpm/base/parallel/OrderedSum.hpp"
#include "mpm/base/parallel/ParallelRegion.hpp"
#include "mpm/particle/apdi/APDIShape.hpp"
#include "mpm/state/cover.hpp"
#include "mpm/step/PoreRuns.hpp"

#include <algorithm>
#include <array>
#include <functional>
#include <utility>
#include <vector>

namespace mpm {

template <int Dim> class PoreSystem {
  public:
    static constexpr int NC = corners<Dim>;

    struct Cell {
        int number;                 // of the grid
        double volume = 0;          // that its pressure acts with by its corners, m3
        double ofParts = 0;         // and by the particles in it
        double storage = 0;         // C, m3/(kPa s)
        double flow = 0;            // diagonal of H, m3/(kPa s)
        double source = 0;          // what flows in at u = 0, m3/s
        double own = 1;             // part of its flow that is its unknown's
        std::array<int, NC> corner; // number among the nodes, -1: not yet known
    };
    struct Node {
        Vec<Dim> step;             // dt over the mass where it may move, else 0, s/Mg
        std::array<int, NC> cells; // around it, -1: none; in the order of its corner in them
        int number;                // of the grid
        bool isPlain = true;       // pressure acts on it from the cells around it alone, by their corners
        bool isOther = false;      // couples more than the cells around it
    };
    struct Face {
        int before, beyond; // cells
        double conductance; // m3/(kPa s)
        double drive;       // flow from `before` to `beyond` at equal u, m3/s
        int axis;
        double area; // that water passes, m2
    };

    struct Outlet { // to water outside
        int cell;
        double conductance; // m3/(kPa s)
        double source;      // what flows in at u = 0, m3/s
        int axis, side;     // of the cell that it leaves by; axis -1: in the middle
        double area;        // that water passes, m2
    };
    struct Part { // of B: what particles at a surface have of a cell
        int cell, node;
        Vec<Dim> flow;   // of a velocity of 1 m/s, m2
        double hoop = 0; // of flow[0], what the circumference has
    };
    struct Share { // of the flow of a cell that is another one's
        int from, to;
        double part;
    };

    std::vector<Cell> cells; // the first `unknowns` have one, the others only hand on
    int unknowns = 0;
    int shape = 0;   // another number with other unknowns
    double half = 0; // of the boxes in the cells along r, m: see Grid::ringMoment()
    std::vector<Node> nodes;
    std::vector<Vec<Dim>> stiffSteps; // of implicit bodies, as if each node were alone; empty: there are none
    std::vector<Face> faces;
    std::vector<Outlet> outlets;
    std::vector<Part> parts; // with nodes of the grid until addNodes()
    std::vector<Share> shares;
    PoreRuns<Dim> runs;                          // of the unknowns
    std::vector<std::array<Vec<Dim>, 2>> speeds; // flow through the faces of each unknown's cell, m/s
    // Adds what implicit bodies change in the velocities of the nodes, by the pressure that acts in the
    // cells.
    std::function<void(const std::vector<double>&, std::vector<Vec<Dim>>&)> respond;

    // First of all: the cells with an unknown, by their numbers. Who is beside whom is kept where they are those of
    // the step before.
    void start(const Grid<Dim>& grid, const std::vector<int>& numbers) {
        leave(unknowns, ownNodes_);
        faces.clear();
        outlets.clear();
        parts.clear();
        shares.clear();
        respond = nullptr;
        if (isOf(grid, numbers)) {
            for (Cell& cell : cells) {
                cell.volume = cell.ofParts = cell.storage = cell.flow = cell.source = 0;
                cell.own = 1;
            }
            return;
        }
        leave(0, 0);
        cellAt_.resize(grid.count, -1);
        nodeAt_.resize(grid.count, -1);
        for (int number : numbers) {
            cellAt_[number] = int(cells.size());
            addHandingCell(grid, number);
        }
        unknowns = int(cells.size());
        addCorners(grid, 0);
        ownNodes_ = int(nodes.size());
        keptHalf_ = half;
        ++shape;
        runs.start(numbers, grid.strides);
    }
    // Behind all others.
    Cell& addHandingCell(const Grid<Dim>& grid, int number) {
        Cell& cell = cells.emplace_back();
        cell.number = number;
        cell.corner.fill(-1);
        const Vec<Dim> overEdges = (2.0 / NC) * grid.edges(number).cwiseInverse();
        if (grid.isAxisymmetric)
            rings_.push_back({grid.edges(number).cwiseInverse(), grid.ringMoment(number, half),
                              grid.centre(grid.indices(number))[0] / grid.edges(number)[0]});
        auto& slopes = slopes_.emplace_back();
        for (int side = 0; side < 2; ++side)
            slopes[side] =
                overEdges.cwiseProduct(grid.volumeSlopes(number, number + side * grid.strides[0], half));
        return cell;
    }
    int cellAt(int number) const { return cellAt_[number]; }
    // Those of handing cells and of parts.
    void addNodes(const Grid<Dim>& grid) {
        addCorners(grid, unknowns);
        for (Part& part : parts) part.node = addNode(part.node);
        sortParts();
    }
    // Once all is known.
    void finish() {
        for (const Face& face : faces) {
            cells[face.before].flow += face.conductance;
            cells[face.beyond].flow += face.conductance;
            cells[face.before].source -= face.drive;
            cells[face.beyond].source += face.drive;
        }
        for (const Outlet& outlet : outlets) {
            cells[outlet.cell].flow += outlet.conductance;
            cells[outlet.cell].source += outlet.source;
        }
        for (int c = 0; c < unknowns; ++c) runs.set(placeOf(c), cells[c].volume, slopes_[c]);
        flow_.resize(cells.size());
        ofShare_.assign(cells.size() + 1, 0);
        for (const Share& share : shares) ++ofShare_[share.from + 1];
        for (size_t c = 0; c < cells.size(); ++c) ofShare_[c + 1] += ofShare_[c];
        for (size_t n = 0; n < nodes.size(); ++n) {
            Node& node = nodes[n];
            node.isPlain = ofNode_[n + 1] == ofNode_[n];
            for (int c : node.cells)
                node.isPlain &=
                    c < 0 || (c < unknowns && cells[c].own == 1 && ofShare_[c + 1] == ofShare_[c]);
        }
    }
    int placeOf(int cell) const { return cells[cell].number + runs.places.offset; }
    // Of B what a corner has of a cell, m2.
    Vec<Dim> cornerFlow(int cell, int corner) const {
        const Vec<Dim>& size = slopes_[cell][cornerSign(corner, 0) > 0];
        Vec<Dim> flow;
        for (int k = 0; k < Dim; ++k) flow[k] = cornerSign(corner, k) * cells[cell].volume * size[k];
        return flow;
    }
    // The step of a node with what implicit bodies answer there.
    Vec<Dim> wholeStep(int node) const {
        return stiffSteps.empty() ? nodes[node].step : Vec<Dim>(nodes[node].step + stiffSteps[node]);
    }
    // f(unknown, flow): all of B that a node has; an unknown may come several times.
    template <class F> void forFlows(int node, F&& f) const {
        const auto hand = [&](int c, const Vec<Dim>& flow) {
            if (c < unknowns) f(c, cells[c].own * flow);
            for (int i = ofShare_[c]; i < ofShare_[c + 1]; ++i) f(shares[i].to, shares[i].part * flow);
        };
        for (int a = 0; a < NC; ++a)
            if (const int c = nodes[node].cells[a]; c >= 0) hand(c, cornerFlow(c, a));
        for (int i = ofNode_[node]; i < ofNode_[node + 1]; ++i)
            hand(parts[byNode_[i]].cell, parts[byNode_[i]].flow);
    }
    // Once the steps of the nodes are known: which couple more than the cells around them.
    void findOthers() {
        for (size_t n = 0; n < nodes.size(); ++n)
            nodes[n].isOther = !nodes[n].isPlain || (!stiffSteps.empty() && !stiffSteps[n].isZero());
    }

    // What flows out as the nodes move for dt, m3/s: B v, and what the volumes of the cells have of higher order.
    // Without that, soil that flows is compressed by its squared rate of shear, step after step.
    void flowOut(ParallelRegion& region, const std::vector<Vec<Dim>>& velocity, double dt,
                 std::vector<double>& out) {
        region.chunks(int(nodes.size()), [&](int begin, int end) {
            for (int n = begin; n < end; ++n) runs.setVelocity(nodes[n].number, velocity[n]);
        });
        if (rings_.empty()) runs.flowOut(region, dt, flow_);
        region.chunks(int(cells.size()), [&](int begin, int end) {
            for (int c = begin; c < end; ++c)
                if (c >= unknowns || !rings_.empty() || ofCell_[c] < ofCell_[c + 1])
                    flow_[c] = flowOf(c, velocity, dt);
        });
        region.once([&] {
            handFlow();
            std::copy(flow_.begin(), flow_.begin() + unknowns, out.begin());
        });
    }
    // What acts in all cells at u.
    void findActing(const std::vector<double>& u, std::vector<double>& acting) const {
        acting.resize(cells.size());
        for (size_t c = 0; c < cells.size(); ++c) acting[c] = int(c) < unknowns ? cells[c].own * u[c] : 0;
        for (const Share& share : shares) acting[share.from] += share.part * u[share.to];
    }
    // B^T u on all plain nodes, by what acts in the cells; for foundForce().
    void findForces(ParallelRegion& region, const std::vector<double>& acting) {
        runs.findForces(region, acting);
    }
    // On a node, kN, by what acted there.
    Vec<Dim> foundForce(const Node& node, const std::vector<double>& acting) const {
        return node.isPlain ? runs.force(node.number) : force(node, acting);
    }
    // On a node, kN.
    Vec<Dim> force(const Node& node, const std::vector<double>& acting) const {
        Vec<Dim> f = Vec<Dim>::Zero();
        const size_t number = &node - nodes.data();
        for (int i = ofNode_[number]; i < ofNode_[number + 1]; ++i) {
            const Part& part = parts[byNode_[i]];
            f += acting[part.cell] * part.flow;
        }
#pragma GCC unroll 8
        for (int a = 0; a < NC; ++a)
            if (const int c = node.cells[a]; c >= 0) f += acting[c] * cornerFlow(c, a);
        return f;
    }
    // y = H u, m3/s
    void flowAway(const std::vector<double>& u, std::vector<double>& y) const {
        y.resize(unknowns);
        for (int c = 0; c < unknowns; ++c) y[c] = cells[c].flow * u[c];
        for (const Face& face : faces) {
            y[face.before] -= face.conductance * u[face.beyond];
            y[face.beyond] -= face.conductance * u[face.before];
        }
    }
    // The flow along the axes through both faces of each cell, at u.
    void findSpeeds(const std::vector<double>& u) {
        speeds.assign(unknowns, {Vec<Dim>::Zero(), Vec<Dim>::Zero()});
        for (const Face& face : faces) {
            const double speed =
                (face.conductance * (u[face.before] - u[face.beyond]) + face.drive) / face.area;
            speeds[face.before][1][face.axis] = speeds[face.beyond][0][face.axis] = speed;
        }
        for (const Outlet& outlet : outlets) {
            if (outlet.axis < 0) continue;
            const double out = (outlet.conductance * u[outlet.cell] - outlet.source) / outlet.area;
            speeds[outlet.cell][outlet.side][outlet.axis] += outlet.side ? out : -out;
        }
    }

  private:
    // Leaves the first cells and nodes.
    void leave(int someCells, int someNodes) {
        for (int c = someCells; c < int(cells.size()); ++c) {
            if (c < unknowns) cellAt_[cells[c].number] = -1;
            for (int a = 0; a < NC; ++a)
                if (cells[c].corner[a] >= 0) nodes[cells[c].corner[a]].cells[a] = -1;
        }
        for (int n = someNodes; n < int(nodes.size()); ++n) nodeAt_[nodes[n].number] = -1;
        cells.resize(someCells);
        slopes_.resize(someCells);
        if (!rings_.empty()) rings_.resize(someCells);
        nodes.resize(someNodes);
    }
    bool isOf(const Grid<Dim>& grid, const std::vector<int>& numbers) const {
        return int(cellAt_.size()) == grid.count && half == keptHalf_ && numbers.size() == cells.size() &&
               std::equal(cells.begin(), cells.end(), numbers.begin(),
                          [](const Cell& cell, int number) { return cell.number == number; });
    }
    void addCorners(const Grid<Dim>& grid, int first) {
        for (int c = first; c < int(cells.size()); ++c)
            for (int a = 0; a < NC; ++a) {
                const int at = addNode(cornerOf(grid, cells[c].number, a));
                nodes[at].cells[a] = c;
                cells[c].corner[a] = at;
            }
    }
    int addNode(int number) {
        int& at = nodeAt_[number];
        if (at < 0) {
            at = int(nodes.size());
            nodes.emplace_back().number = number;
            nodes.back().cells.fill(-1);
        }
        return at;
    }
    // One part for each cell and node.
    void sortParts() {
        const auto key = [](const Part& part) { return std::pair(part.cell, part.node); };
        std::stable_sort(parts.begin(), parts.end(),
                         [&](const Part& a, const Part& b) { return key(a) < key(b); });
        int n = 0;
        for (const Part& part : parts)
            if (n > 0 && key(parts[n - 1]) == key(part))
                parts[n - 1].flow += part.flow, parts[n - 1].hoop += part.hoop;
            else
                parts[n++] = part;
        parts.resize(n);
        const auto starts = [&](std::vector<int>& first, size_t size, auto&& ownerOf) {
            first.assign(size + 1, 0);
            for (const Part& part : parts) ++first[ownerOf(part) + 1];
            for (size_t i = 0; i < size; ++i) first[i + 1] += first[i];
        };
        starts(ofCell_, cells.size(), [](const Part& part) { return part.cell; });
        starts(ofNode_, nodes.size(), [](const Part& part) { return part.node; });
        byNode_.resize(n);
        std::vector<int> next(ofNode_.begin(), ofNode_.end() - 1);
        for (int i = 0; i < n; ++i) byNode_[next[parts[i].node]++] = i;
    }
    std::vector<int> cellAt_, nodeAt_; // of the grid; -1: none
    std::vector<int> ofCell_, ofNode_; // first part of each, and the end
    std::vector<int> byNode_;          // parts, by their node
    int ownNodes_ = 0;                 // of the cells with an unknown
    double keptHalf_ = 0;              // `half` when they were found, m
    // Of the hat functions of corners in each cell, 1/m, with the sign of the corner: of those before and beyond the
    // middle along the first axis, which differ with axial symmetry.
    std::vector<std::array<Vec<Dim>, 2>> slopes_;
    struct Ring {           // that a cell is with axial symmetry
        Vec<Dim> overEdges; // 1/m
        double part;        // of the second moments, see Grid::ringMoment()
        double middle;      // radius over the edge
    };
    std::vector<Ring> rings_;  // of the cells; empty: there is no axial symmetry
    std::vector<int> ofShare_; // first share from each cell, and the end
    std::vector<double> flow_; // of all cells

    // Of the mean velocity gradients L of the cell and of the particles in it, V (det(1 + L dt) - 1)/dt.
    double flowOf(int c, const std::vector<Vec<Dim>>& velocity, double dt) const {
        Mat<Dim> ofCell = Mat<Dim>::Zero(), ofParts = Mat<Dim>::Zero(); // V L
#pragma GCC unroll 8
        for (int a = 0; a < NC; ++a) ofCell += velocity[cells[c].corner[a]] * cornerFlow(c, a).transpose();
        const double own = rings_.empty() ? grown(ofCell, cells[c].volume, dt)
                                          : ofCell.trace() + cells[c].volume * beyondRate(c, velocity, dt);
        if (ofCell_[c] == ofCell_[c + 1]) return own;
        double hoop = 0;
        for (int i = ofCell_[c]; i < ofCell_[c + 1]; ++i) {
            ofParts += velocity[parts[i].node] * parts[i].flow.transpose();
            hoop += velocity[parts[i].node][0] * parts[i].hoop;
        }
        return own + grown(ofParts, cells[c].ofParts, dt, hoop);
    }
    // Of a ring, 1/s: what its volume grows by in a step (RingShape::moment), less the part that is linear in the
    // velocities; each term is small, so none loses digits.
    double beyondRate(int c, const std::vector<Vec<Dim>>& velocity, double dt) const {
        const Ring& ring = rings_[c];
        double r[4] = {}, z[4] = {}; // rates of the coefficients of 1, xi, eta and xi eta, 1/s
        for (int a = 0; a < 4; ++a) {
            const Vec<Dim> rate = 0.25 * velocity[cells[c].corner[a]].cwiseProduct(ring.overEdges);
            const double xi = cornerSign(a, 0), eta = cornerSign(a, 1), factors[4] = {1, xi, eta, xi * eta};
            for (int i = 0; i < 4; ++i) {
                r[i] += factors[i] * rate[0];
                z[i] += factors[i] * rate[1];
            }
        }
        const double area = dt * (r[1] * z[2] - r[2] * z[1]), ofXi = dt * (r[1] * z[3] - r[3] * z[1]),
                     ofEta = dt * (r[3] * z[2] - r[2] * z[3]);
        const double ofMiddle = r[0] * (0.5 * (r[1] + z[2]) + area),
                     ofSides = r[1] * (0.5 * z[3] + ofXi) + r[2] * (0.5 * r[3] + ofEta);
        const double rate = ring.middle * area + dt * ofMiddle + ring.part / 3 * (0.5 * ofXi + dt * ofSides);
        return 4 / ring.middle * rate;
    }
    // By the invariants of L, which lose no digits where it is small. hoop: of the trace, what the circumference has.
    static double grown(Mat<Dim> rate, double volume, double dt, double hoop = 0) {
        const double trace = rate.trace();
        if (!(volume > 0)) return trace;
        const double pairs = 0.5 * (trace * trace - (rate * rate).trace()), step = dt / volume;
        if constexpr (Dim == 3) return trace + step * (pairs + step * rate.determinant());
        rate(0, 0) -= hoop;
        const double area = rate.trace() + step * rate.determinant();
        return area + hoop + step * hoop * area;
    }
    // The flow of cells to the unknowns that have it.
    void handFlow() {
        if (shares.empty()) return;
        std::vector<double> handed(shares.size());
        for (size_t i = 0; i < shares.size(); ++i) handed[i] = shares[i].part * flow_[shares[i].from];
        for (int c = 0; c < unknowns; ++c) flow_[c] *= cells[c].own;
        for (size_t i = 0; i < shares.size(); ++i) flow_[shares[i].to] += handed[i];
    }
};

} // namespace mpm
