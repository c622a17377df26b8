// SPDX-License-Identifier: GPL-2.0-or-later
// The matrix of the pore pressure, A = C + H + dt B M^-1 B^T (step/PoreSystem.hpp), stored by its stencil, and
// conjugate gradients with it. A node couples the cells around it, so a row has 3 x 3 cells (3D: 27), and half of
// them are stored, since A is symmetric. Rows have the places of their cells in the grid: the neighbours of a run
// of cells are then runs, too, and loops over them vectorise. Nodes at a surface and beside structures, which
// couple more cells, are applied one by one ("others").
#pragma once

#include "mpm/base/parallel/OrderedSum.hpp"
#include "mpm/step/PoreCoarse.hpp"
#include "mpm/step/PoreSystem.hpp"

#include <cmath>

namespace mpm {

template <int Dim> class PoreMatrix {
  public:
    // Once the steps of the nodes are known. strides: of the grid.
    void assemble(ParallelRegion& region, PoreSystem<Dim>& system, const Index<Dim>& strides) {
        region.once([&] {
            system.findOthers();
            makeRoom(system, strides);
            findOthers(system);
        });
        spreadSteps(region, system);
        const auto& places = system.runs.places;
        places.forBlocks(region, [&](int begin, int) {
            places.forRuns(begin, [&](int first, int last) { fillRows(system, first, last); });
        });
        region.once([&] {
            addFaces(system);
            addBlocks(system);
        });
        findDiagonal(region, system);
    }

    // y = A x, by all threads.
    void multiply(ParallelRegion& region, const PoreSystem<Dim>& system, const std::vector<double>& x,
                  std::vector<double>& y) {
        region.once([&] { system.runs.places.spread(x, direction_); });
        findProduct(region, system);
        region.once([&] { system.runs.places.collect(product_, y); });
    }

    // Solves A u = right from the u that is there, until the pressure of no cell is off by more than `tolerance`
    // kPa. Returns the iterations, -1: not within `most`. residual: right - A u, m3/s. By all threads. A residual r
    // is an error of A^-1 r. That is r over the storage at most; and where it has the width of a block, beyond which
    // the blocks carry it, it is r over the diagonal times the square of that width in cells.
    int solve(ParallelRegion& region, const PoreSystem<Dim>& system, const std::vector<double>& right,
              double tolerance, int most, std::vector<double>& u, std::vector<double>& residual) {
        region.once([&] {
            const double part = coarse_.leastPart();
            for (int c = 0; c < unknowns_; ++c) {
                const int p = place_[c];
                limit_[p] = tolerance * std::max(system.cells[c].storage, part / overDiagonal_[p]);
            }
            system.runs.places.spread(u, direction_);
            system.runs.places.spread(u, solution_);
            system.runs.places.spread(right, residual_);
        });
        findProduct(region, system);
        double before = 0;
        int iteration = 0;
        for (advance(region, system.runs.places, 0, 1); off_ > 0; ++iteration) {
            if (iteration == most) return -1;
            region.once([&] { now_ += coarse_.solve(residual_); });
            const double part = iteration > 0 ? now_ / before : 0;
            before = now_;
            system.runs.places.forBlocks(region, [&](int begin, int) { turn(begin, part); });
            findProduct(region, system);
            advance(region, system.runs.places, now_ / power_, now_ / power_);
        }
        region.once([&] {
            system.runs.places.collect(solution_, u);
            system.runs.places.collect(residual_, residual);
        });
        return iteration;
    }

  private:
    static constexpr int around = Dim == 2 ? 9 : 27, ahead = around / 2;
    struct Entry { // of B: a velocity of another node, m2
        int at;    // cell, or place among the others
        Vec<Dim> flow;
    };

    int unknowns_ = 0;
    int shape_ = -1;                                 // of the system that there is room for
    std::vector<int> place_;                         // of each unknown
    std::array<int, ahead> steps_;                   // to the neighbours beyond
    std::array<std::vector<double>, Dim> nodeSteps_; // of nodes that are not others, s/Mg
    std::array<std::vector<double>, ahead> beyond_;  // of the matrix, m3/(kPa s)
    std::vector<double> diagonal_, overDiagonal_, limit_, solution_, residual_, direction_, product_;
    std::vector<int> others_;                // numbers of nodes
    std::vector<int> ofOther_, ofCell_;      // first entry of each, and the end
    std::vector<Entry> byOther_, byCell_;    // with the cell, and with the place among the others
    std::vector<Vec<Dim>> impulse_, answer_; // of the others; of all nodes
    std::vector<double> unknown_, acting_;   // for implicit bodies
    PoreCoarse<Dim> coarse_;
    OrderedSum sum_, count_;
    double now_ = 0, off_ = 0, power_ = 0; // r D^-1 r; cells beyond the tolerance; d A d

    void makeRoom(const PoreSystem<Dim>& system, const Index<Dim>& strides) {
        if (shape_ == system.shape) return;
        shape_ = system.shape;
        unknowns_ = system.unknowns;
        for (int s = 0; s < ahead; ++s) {
            steps_[s] = 0;
            for (int k = 0, rest = s + ahead + 1; k < Dim; ++k, rest /= 3)
                steps_[s] += (rest % 3 - 1) * strides[k];
        }
        place_.resize(unknowns_);
        for (int c = 0; c < unknowns_; ++c) place_[c] = system.placeOf(c);
        const int size = system.runs.places.size;
        for (auto& one : nodeSteps_) one.assign(size, 0.0);
        coarse_.start(place_, size, -system.runs.places.offset, strides);
        for (auto& one : beyond_) one.assign(size, 0.0);
        for (auto* one :
             {&diagonal_, &overDiagonal_, &limit_, &solution_, &residual_, &direction_, &product_})
            one->assign(size, 0.0);
    }
    // Nodes that couple more than the cells around them, and what they do to each unknown.
    void findOthers(const PoreSystem<Dim>& system) {
        others_.clear();
        byOther_.clear();
        ofOther_.assign(1, 0);
        for (int n = 0; n < int(system.nodes.size()); ++n) {
            if (!system.nodes[n].isOther) continue;
            others_.push_back(n);
            const auto first = byOther_.insert(byOther_.end(), {}) - byOther_.begin();
            system.forFlows(n, [&](int c, const Vec<Dim>& flow) { byOther_.push_back({c, flow}); });
            mergeFrom(first);
            ofOther_.push_back(int(byOther_.size()));
        }
        ofCell_.assign(unknowns_ + 1, 0);
        for (const Entry& entry : byOther_) ++ofCell_[entry.at + 1];
        for (int c = 0; c < unknowns_; ++c) ofCell_[c + 1] += ofCell_[c];
        byCell_.resize(byOther_.size());
        std::vector<int> next(ofCell_.begin(), ofCell_.end() - 1);
        for (int i = 0; i < int(others_.size()); ++i)
            for (int j = ofOther_[i]; j < ofOther_[i + 1]; ++j)
                byCell_[next[byOther_[j].at]++] = {i, byOther_[j].flow};
        impulse_.resize(others_.size());
    }
    // One entry for each cell.
    void mergeFrom(size_t first) {
        std::stable_sort(byOther_.begin() + first, byOther_.end(),
                         [](const Entry& a, const Entry& b) { return a.at < b.at; });
        size_t n = first;
        for (size_t i = first; i < byOther_.size(); ++i)
            if (n > first && byOther_[n - 1].at == byOther_[i].at)
                byOther_[n - 1].flow += byOther_[i].flow;
            else
                byOther_[n++] = byOther_[i];
        byOther_.resize(n);
    }

    // Number in the stencil of the step from a cell whose corner a is a node to the one of which it is corner b.
    static int stepTo(int a, int b) {
        int step = 0;
        for (int k = Dim - 1; k >= 0; --k) step = 3 * step + 1 + int(cornerSign(a, k) - cornerSign(b, k)) / 2;
        return step;
    }
    // Copies what rows are made of to the places of the cells and nodes.
    void spreadSteps(ParallelRegion& region, const PoreSystem<Dim>& system) {
        region.chunksNoWait(unknowns_, [&](int begin, int end) {
            for (int c = begin; c < end; ++c)
                diagonal_[place_[c]] = system.cells[c].storage + system.cells[c].flow;
        });
        const int size = int(diagonal_.size());
        region.chunks(int(system.nodes.size()), [&](int begin, int end) {
            for (int n = begin; n < end; ++n) {
                const auto& node = system.nodes[n];
                const int p = node.number + system.runs.places.offset;
                if (p < 0 || p >= size) continue; // an other, away from the cells
                for (int k = 0; k < Dim; ++k) nodeSteps_[k][p] = node.isOther ? 0 : node.step[k];
            }
        });
    }
    // Of rows what is on the diagonal and beyond, without the others and without flow to the neighbours.
    void fillRows(const PoreSystem<Dim>& system, int first, int last) {
        for (auto& one : beyond_) std::fill(one.begin() + first, one.begin() + last, 0.0);
        for (int a = 0; a < corners<Dim>; ++a)
            for (int b = 0; b < corners<Dim>; ++b) {
                const int s = stepTo(a, b) - ahead;
                if (s < 0) continue;
                double* const row = s > 0 ? beyond_[s - 1].data() : diagonal_.data();
                for (int k = 0; k < Dim; ++k)
                    addRow(row, system.runs.flows[cornerSign(a, 0) > 0][k].data(),
                           nodeSteps_[k].data() + system.runs.places.toCorner[a],
                           system.runs.flows[cornerSign(b, 0) > 0][k].data() + (s > 0 ? steps_[s - 1] : 0),
                           cornerSign(a, k) * cornerSign(b, k), first, last);
            }
    }
    static void addRow(double* row, const double* own, const double* step, const double* other, double sign,
                       int first, int last) {
#pragma GCC ivdep
        for (int p = first; p < last; ++p) row[p] += sign * own[p] * step[p] * other[p];
    }
    // What scales the residual.
    void findDiagonal(ParallelRegion& region, const PoreSystem<Dim>& system) {
        region.chunks(unknowns_, [&](int begin, int end) {
            for (int c = begin; c < end; ++c) {
                double sum = diagonal_[place_[c]];
                for (int i = ofCell_[c]; i < ofCell_[c + 1]; ++i) {
                    sum += byCell_[i].flow.cwiseAbs2().dot(system.wholeStep(others_[byCell_[i].at]));
                }
                overDiagonal_[place_[c]] = 1 / sum;
            }
        });
    }
    void addFaces(const PoreSystem<Dim>& system) {
        for (const auto& face : system.faces) {
            int s = 0; // of the step by one along the axis
            for (int k = 0, three = 1; k <= face.axis; ++k, three *= 3) s = three - 1;
            beyond_[s][place_[face.before]] -= face.conductance;
        }
    }

    // The sums of the matrix over blocks of cells. Of implicit bodies as if each node were alone.
    void addBlocks(const PoreSystem<Dim>& system) {
        coarse_.clear();
        for (size_t i = 0; i < others_.size(); ++i) {
            const Vec<Dim> step = system.wholeStep(others_[i]);
            for (int j = ofOther_[i]; j < ofOther_[i + 1]; ++j)
                for (int k = ofOther_[i]; k <= j; ++k)
                    coarse_.add(place_[byOther_[j].at], place_[byOther_[k].at],
                                byOther_[j].flow.cwiseProduct(step).dot(byOther_[k].flow));
        }
        coarse_.reset();
        coarse_.addAll(diagonal_.data(), 0);
        for (int s = 0; s < ahead; ++s) coarse_.addAll(beyond_[s].data(), steps_[s]);
        coarse_.factorise();
    }

    // product = A direction, and power.
    void findProduct(ParallelRegion& region, const PoreSystem<Dim>& system) {
        if (!others_.empty()) findImpulses(region, system);
        region.once([&] { sum_.clear(unknowns_); });
        system.runs.places.forBlocks(region, [&](int begin, int end) {
            double sum = 0;
            system.runs.places.forRuns(begin, [&](int first, int last) { sum += multiplyRun(first, last); });
            for (int i = ofCell_[begin], c = begin; i < ofCell_[end]; ++i) {
                while (ofCell_[c + 1] <= i) ++c;
                const double more = byCell_[i].flow.dot(impulse_[byCell_[i].at]);
                product_[place_[c]] += more;
                sum += direction_[place_[c]] * more;
            }
            sum_.of(begin) = sum;
        });
        region.once([&] { power_ = sum_.total(); });
    }
    // Without the others; returns x A x.
    double multiplyRun(int first, int last) {
        const double *const x = direction_.data(), *const d = diagonal_.data();
        double* const y = product_.data();
        std::array<const double*, ahead> a;
        for (int s = 0; s < ahead; ++s) a[s] = beyond_[s].data();
        const std::array<int, ahead> steps = steps_;
        double power = 0;
#pragma omp simd reduction(+ : power)
        for (int p = first; p < last; ++p) {
            double sum = d[p] * x[p];
#pragma GCC unroll 13
            for (int s = 0; s < ahead; ++s)
                sum += a[s][p] * x[p + steps[s]] + a[s][p - steps[s]] * x[p - steps[s]];
            y[p] = sum;
            power += x[p] * sum;
        }
        return power;
    }
    void findImpulses(ParallelRegion& region, const PoreSystem<Dim>& system) {
        region.chunks(int(others_.size()), [&](int begin, int end) {
            for (int i = begin; i < end; ++i) {
                Vec<Dim> force = Vec<Dim>::Zero();
                for (int j = ofOther_[i]; j < ofOther_[i + 1]; ++j)
                    force += direction_[place_[byOther_[j].at]] * byOther_[j].flow;
                impulse_[i] = force.cwiseProduct(system.nodes[others_[i]].step);
            }
        });
        if (!system.respond) return;
        region.once([&] {
            system.runs.places.collect(direction_, unknown_);
            system.findActing(unknown_, acting_);
            answer_.assign(system.nodes.size(), Vec<Dim>::Zero());
            system.respond(acting_, answer_);
            for (size_t i = 0; i < others_.size(); ++i) impulse_[i] += answer_[others_[i]];
        });
    }

    // d = what the preconditioner makes of r, and a part of d. Loops vectorise with pointers of their own.
    void turn(int begin, double part) {
        double* const d = direction_.data();
        const double *const r = residual_.data(), *const over = overDiagonal_.data();
        coarse_.forSegments(begin, [&](int first, int last, double pressure) {
            turnRun(d, r, over, first, last, pressure, part);
        });
    }
    static void turnRun(double* d, const double* r, const double* over, int first, int last, double pressure,
                        double part) {
#pragma GCC ivdep
        for (int p = first; p < last; ++p) d[p] = over[p] * r[p] + pressure + part * d[p];
    }
    void step(const PorePlaces<Dim>& places, int begin, double length, double loss) {
        double sum = 0, off = 0;
        places.forRuns(begin, [&](int first, int last) {
            stepRun(solution_.data(), residual_.data(), direction_.data(), product_.data(),
                    overDiagonal_.data(), limit_.data(), first, last, length, loss, sum, off);
        });
        sum_.of(begin) = sum;
        count_.of(begin) = off;
    }
    static void stepRun(double* u, double* r, const double* d, const double* product, const double* over,
                        const double* limit, int first, int last, double length, double loss, double& sum,
                        double& off) {
        double s = 0, o = 0;
#pragma omp simd reduction(+ : s, o)
        for (int p = first; p < last; ++p) {
            u[p] += length * d[p];
            r[p] -= loss * product[p];
            s += r[p] * r[p] * over[p];
            o += std::abs(r[p]) > limit[p] ? 1.0 : 0.0;
        }
        sum += s;
        off += o;
    }

    // u += length d and r -= loss A d, and what is left.
    void advance(ParallelRegion& region, const PorePlaces<Dim>& places, double length, double loss) {
        region.once([&] {
            sum_.clear(unknowns_);
            count_.clear(unknowns_);
        });
        places.forBlocks(region, [&](int begin, int) { step(places, begin, length, loss); });
        region.once([&] {
            now_ = sum_.total();
            off_ = count_.total();
        });
    }
};

} // namespace mpm
