// SPDX-License-Identifier: GPL-2.0-or-later
// The transfers of uGIMP, fast: StencilDomains says what they are. Particles are treated in batches, for
// which the weights are found by vectors; neighbours in memory with the same support, a run, are summed
// before the grid is touched.
#pragma once

#include "mpm/particle/ugimp/AveragedHat.hpp"
#include "mpm/particle/ugimp/BoxWeights.hpp"

namespace mpm {

template <int Dim> class BoxTransfers : public StencilDomains<Dim, AveragedHat> {
  public:
    using Base = StencilDomains<Dim, AveragedHat>;
    using Base::particles, Base::grid, Base::order, Base::moved_, Base::Base;
    using typename Base::L, typename Base::NF, typename Base::Planes;

    void restored() override {
        makeRoom();
        Base::restored();
    }

    void addSum(ParallelRegion& region, typename NF::Sum* nodes, double inertiaScale,
                const ActingStress* stress) override {
        const Planes q(particles);
        const ActingStress own(particles.stress); // for lanes that are cleared then
        const bool hasBodyForce = particles.hasBodyForce;
        forBatches(region, [&](int first, int count, const Weights& w) {
            Quad value[batch];
            typename L::Set B[batch];
            q.values(first, count, inertiaScale, value);
            q.forces(first, count, stress ? *stress : own, B);
            if (!stress)
                for (auto& b : B)
                    for (int k = 0; k < (Dim == 2 ? 1 : 3); ++k) b[k] = Quad{};
            scatter(nodes, first, count, w, value, B, stress);
            if (hasBodyForce) {
                double given[Dim][batch];
                q.bodyForces(first, count, given);
                NodeLanes<Dim>::packForces(given, count, value);
                scatter<1>(nodes, first, count, w, value);
            }
        });
    }

    void addForce(ParallelRegion& region, typename NF::Sum* nodes, const double* const tensor[9]) override {
        const Planes q(particles);
        const ActingStress stress(tensor);
        forBatches(region, [&](int first, int count, const Weights& w) {
            Quad value[batch];
            typename L::Set B[batch];
            std::fill(value, value + count, Quad{});
            q.forces(first, count, stress, B);
            scatter(nodes, first, count, w, value, B, &stress);
        });
    }

    void move(ParallelRegion& region, const typename NF::Motion* nodes, typename NF::Velocity* momentum,
              const Move& how) override {
        const Planes q(particles);
        forBatches<false>(region, [&](int first, int count, const Weights& w, int block) {
            if (nodes) {
                double taken[2 * Dim][padded];
                gather(nodes, first, count, w, taken);
                moved_[block] +=
                    q.move(first, count, how, [&](int k, int i) MPM_INLINE_LAMBDA { return taken[k][i]; });
            }
            if (momentum) {
                double given[Dim + 1][batch];
                Quad value[batch];
                q.momenta(first, count, how.inertiaScale, given);
                NodeLanes<Dim>::packMomenta(given, count, value);
                scatter<0>(momentum, first, count, w, value);
            }
        });
    }

    void takeGradient(int begin, int end, const typename NF::Velocity* nodes, double) override {
        const Planes q(particles);
        for (int first = begin; first < end; first += batch) {
            const int count = std::min(batch, end - first);
            const Weights w = weightsOf(first, count);
            grid.inGeometry([&](auto isRound) { gatherGradient<isRound>(nodes, first, count, w, q); });
        }
    }

    // Where the driven part of a body is: at every step, so not one by one through weights().
    void addQuantity(const double* quantity, const std::vector<int>& which, double* nodal,
                     std::vector<int>& touched) const override {
        for (size_t i = 0; i < which.size();) {
            const int first = which[i];
            int count = 1;
            while (i + count < which.size() && count < batch && which[i + count] == first + count) ++count;
            i += count;
            const Weights w = weightsOf(first, count);
            for (int p = 0; p < count; ++p)
                for (int row = 0; row < rows; ++row)
                    for (int i = 0; i < 3; ++i)
                        Base::addTo(cell_[first + p] + rowOffset(row) + i,
                                    w.across(row, p).S * w.axis[0].S[i][p] * quantity[first + p], nodal,
                                    touched);
        }
    }

    // By the weights of the loops, to the last bit: what a rigid body gives to a particle's nodes is taken
    // back by move().
    void weights(int p, const std::function<void(int, double, const Vec<Dim>&)>& each) const override {
        const Weights w = weightsOf(p, 1);
        for (int n = 0; n < 3 * rows; ++n) {
            int node = Base::firstNodes()[p];
            double phi = 1;
            Vec<Dim> gradient = Vec<Dim>::Ones();
            for (int k = 0, rest = n; k < Dim; ++k, rest /= 3) {
                const double S = w.axis[k].S[rest % 3][0], G = w.axis[k].G[rest % 3][0];
                node += rest % 3 * grid.strides[k];
                phi *= S;
                for (int m = 0; m < Dim; ++m) gradient[m] *= m == k ? G : S;
            }
            each(node, phi, gradient);
        }
    }

    size_t bytes() const override { return sizeof(int) * runEnd_.size() + Base::bytes(); }

  protected:
    using Base::cell_, Base::local_, Base::half_, Base::overRadius_;

    void cellsChanged(int begin, int end) override {
        const int* nodes = Base::firstNodes();
        for (int p = end - 1, last = end; p >= begin; --p) {
            if (p + 1 < end && nodes[p] != nodes[p + 1]) last = p + 1;
            runEnd_[p] = last;
        }
        if (grid.isGraded()) findUnequal(begin, end);
    }

    void group() override {
        makeRoom();
        Base::group();
    }

  private:
    using Weights = BoxWeights<Dim>;
    using Several = typename Weights::Several;
    static constexpr int lanes = Weights::lanes, batch = Weights::batch, padded = Weights::padded;
    static constexpr int rows = Dim == 2 ? 3 : 9; // of three nodes along the first axis
#ifdef __AVX512VL__
    static constexpr int rowsAtOnce = 3; // 18 sums, in 32 registers
#else
    static constexpr int rowsAtOnce = 1;
#endif

    // Before the threads look at blocks of their own.
    void makeRoom() {
        runEnd_.resize(particles.size());
        if (grid.isGraded()) isUnequal_.resize(particles.size());
    }

    // withSlopes: whether the derivatives are asked for.
    template <bool withSlopes = true> Weights weightsOf(int first, int count) const {
        Weights w(local_, half_, grid.smallestCell(), first, count);
        if (grid.isGraded()) takeUnequalCells(w, first, count);
        if (withSlopes && grid.isAxisymmetric) weighByRadius(w, first, count);
        return w;
    }

    // The derivative along r as the mean over the box weighted with r: what is beyond the middle node counts
    // A B/(4 l r) more, A and B the parts of the box before and beyond it, m. Weights stay the plain means: then
    // sum phi r_i = r_p, and phi/r_p is the mean of N/r weighted with r.
    void weighByRadius(Weights& w, int first, int count) const {
        const double half = half_.plane()[0];
        auto& x = w.axis[0];
        if (!grid.isGraded()) return weighByRadius(w, first, count, grid.smallestCell()[0]);
        for (int p = 0; p < count; ++p) {
            const int line = grid.indices(cell_[first + p])[0];
            const double a = grid.cellSize(0, line), b = grid.cellSize(0, line + 1);
            const double more = -x.G[0][p] * a * x.G[2][p] * b * half * overRadius_[first + p];
            x.G[0][p] += more / a;
            x.G[2][p] += more / b;
            x.G[1][p] = -x.G[0][p] - x.G[2][p];
        }
    }
    void weighByRadius(Weights& w, int first, int count, double h) const {
        const double factor = -h * half_.plane()[0], *overRadius = overRadius_.data() + first;
        auto& x = w.axis[0];
#pragma omp simd
        for (int p = 0; p < count; ++p) {
            const double more = factor * x.G[0][p] * x.G[2][p] * overRadius[p];
            x.G[0][p] += more;
            x.G[2][p] += more;
            x.G[1][p] -= 2 * more;
        }
    }

    bool takesUnequalCells() const override { return true; }

    // Which particles have, beside the middle of their nodes, a cell that is not of the smallest size.
    void findUnequal(int begin, int end) {
        for (int p = begin; p < end; ++p) {
            Index<Dim> middle = grid.indices(cell_[p]);
            for (int k = 0; k < Dim; ++k) ++middle[k];
            isUnequal_[p] = !grid.isEven(middle);
        }
    }

    // Boxes are at most as wide as the smallest cell: they reach into the two cells beside the middle of
    // their nodes, and no further.
    void takeUnequalCells(Weights& w, int first, int count) const {
        for (int p = 0; p < count; ++p) {
            if (!isUnequal_[first + p]) continue;
            const Index<Dim> lowest = grid.indices(cell_[first + p]);
            for (int k = 0; k < Dim; ++k)
                w.axis[k].set(p, local_.plane(k)[first + p] - 1, half_.plane()[k],
                              grid.cellSize(k, lowest[k]), grid.cellSize(k, lowest[k] + 1));
        }
    }

    MPM_INLINE int rowOffset(int row) const {
        return row % 3 * grid.strides[1] + (Dim == 3 ? row / 3 * grid.strides[Dim - 1] : 0);
    }

    // f(first, count, weights[, block]) for batches of particles; blocks that share nodes take turns.
    template <bool withSlopes = true, class F> void forBatches(ParallelRegion& region, F&& f) {
        region.forColoured(order.coloured, [&](int b) {
            for (int first = order.start[b], end = order.start[b + 1], count; first < end; first += count) {
                count =
                    std::min(batch - first % 8, end - first); // whole cache lines from the second batch on
                const Weights w = weightsOf<withSlopes>(first, count);
                if constexpr (std::is_invocable_v<F, int, int, const Weights&, int>)
                    f(first, count, w, b);
                else
                    f(first, count, w);
            }
        });
    }

    // f(begin, end, its first node) for the runs of a batch.
    template <class F> MPM_INLINE void forRuns(int first, int count, F&& f) const {
        const int *cells = Base::firstNodes() + first, *ends = runEnd_.data() + first;
        for (int begin = 0, end; begin < count; begin = end) {
            end = std::min(ends[begin] - first, count);
            f(begin, end, cells[begin]);
        }
    }

    // Quad `part` of node += phi * value.
    template <int part, class Node>
    MPM_INLINE void scatter(Node* nodes, int first, int count, const Weights& w, const Quad* value) const {
        forRuns(first, count, [&](int begin, int end, int cell) {
            for (int layer = 0; layer < rows; layer += 3) {
                Quad sum[3][3] = {};
                for (int p = begin; p < end; ++p) MPM_UNROLL
                for (int row = 0; row < 3; ++row) {
                    const Quad v = w.across(layer + row, p).S * value[p];
                    MPM_UNROLL
                    for (int i = 0; i < 3; ++i) sum[row][i] += w.axis[0].S[i][p] * v;
                }
                MPM_UNROLL
                for (int row = 0; row < 3; ++row) {
                    Node* node = inRegister(nodes + cell + rowOffset(layer + row));
                    MPM_UNROLL
                    for (int i = 0; i < 3; ++i) node[i].part[part] += sum[row][i];
                }
            }
        });
    }

    // First Quad of node += phi * value, second one += B grad phi; with axial symmetry its radial force also
    // -= phi V sigma_theta/r. stress: nullptr for no force.
    MPM_INLINE void scatter(typename NF::Sum* nodes, int first, int count, const Weights& w,
                            const Quad* value, const typename L::Set* B, const ActingStress* stress) const {
        grid.inGeometry([&](auto isRound) {
            double hoop[isRound ? batch : 1] = {};
            for (int p = 0; isRound && stress && p < count; ++p)
                hoop[p] = -particles.volume.plane()[first + p] * stress->diagonal(2, first + p) *
                          overRadius_[first + p];
            this->template scatter<isRound>(nodes, first, count, w, value, B, hoop);
        });
    }

    // As many rows of nodes at a time as registers can hold the sums of.
    template <bool isRound>
    MPM_INLINE void scatter(typename NF::Sum* nodes, int first, int count, const Weights& w,
                            const Quad* value, const typename L::Set* B, const double* hoop) const {
        const auto rowOf = [&](int p, int row) MPM_INLINE_LAMBDA {
            if constexpr (isRound)
                return typename L::Row(value[p], B[p], w.across(row, p), hoop[p]);
            else
                return typename L::Row(value[p], B[p], w.across(row, p));
        };
        const auto& x = w.axis[0];
        forRuns(first, count, [&](int begin, int end, int cell) {
            for (int top = 0; top < rows; top += rowsAtOnce) {
                typename NF::Sum sum[rowsAtOnce][3] = {};
                for (int p = begin; p < end; ++p) MPM_UNROLL
                for (int row = 0; row < rowsAtOnce; ++row) {
                    const typename L::Row given = rowOf(p, top + row);
                    MPM_UNROLL
                    for (int i = 0; i < 3; ++i) given.add(sum[row][i], x.S[i][p], x.G[i][p]);
                }
                MPM_UNROLL
                for (int row = 0; row < rowsAtOnce; ++row) {
                    auto* node = inRegister(nodes + cell + rowOffset(top + row));
                    MPM_UNROLL
                    for (int i = 0; i < 3; ++i) L::finish(sum[row][i], node[i]);
                }
            }
        });
    }

    // As many particles of a run as there are lanes: f(first of them, its first node). Lanes without a
    // particle belong to the next ones, which come later.
    template <class F> MPM_INLINE void forLanes(int first, int count, F&& f) const {
        const int *cells = Base::firstNodes() + first, *ends = runEnd_.data() + first;
        for (int p = 0; p < count; p = std::min(ends[p] - first, p + lanes)) f(p, cells[p]);
    }

    // taken[k] = sum phi N_k over the nodes.
    template <size_t n, class Node>
    MPM_INLINE void gather(const Node* nodes, int first, int count, const Weights& w,
                           double (&taken)[n][padded]) const {
        forLanes(first, count, [&](int p, int cell) MPM_INLINE_LAMBDA {
            const auto S = w.alongS(p);
            Several sum[n] = {};
            MPM_UNROLL
            for (int row = 0; row < rows; ++row) {
                const Node* node = inRegister(nodes + cell + rowOffset(row));
                const Several across = w.acrossSeveral(row, p).S;
                MPM_UNROLL
                for (size_t k = 0; k < n; ++k)
                    sum[k] += across * (node[0][k] * S[0] + node[1][k] * S[1] + node[2][k] * S[2]);
            }
            MPM_UNROLL
            for (size_t k = 0; k < n; ++k) store(taken[k] + p, sum[k]);
        });
    }

    // velocityGradient[Dim i + j] = sum v_i d_j phi, and with axial symmetry hoopRate = sum v_r phi/r, of the
    // particles of the batch alone: the next ones may be another thread's.
    template <bool isRound, class Node>
    MPM_INLINE void gatherGradient(const Node* nodes, int first, int count, const Weights& w,
                                   const Planes& q) const {
        const auto keep = [&](double* plane, int p, const Several& sum) MPM_INLINE_LAMBDA {
            if (p + lanes <= count)
                store(plane + first + p, sum);
            else
                std::memcpy(plane + first + p, &sum, (count - p) * sizeof(double));
        };
        forLanes(first, count, [&](int p, int cell) MPM_INLINE_LAMBDA {
            const auto S = w.alongS(p), G = w.alongG(p);
            Several sum[Dim * Dim] = {}, radial = {};
            MPM_UNROLL
            for (int row = 0; row < rows; ++row) {
                const auto* node = inRegister(nodes + cell + rowOffset(row));
                const auto across = w.acrossSeveral(row, p);
                MPM_UNROLL
                for (int i = 0; i < Dim; ++i) {
                    const double a = node[0][i], b = node[1][i], c = node[2][i];
                    const Several along = a * S[0] + b * S[1] + c * S[2];
                    if (isRound && i == 0) radial += across.S * along;
                    sum[Dim * i] += across.S * (a * G[0] + b * G[1] + c * G[2]);
                    MPM_UNROLL
                    for (int j = 1; j < Dim; ++j) sum[Dim * i + j] += across.G[j - 1] * along;
                }
            }
            MPM_UNROLL
            for (int c = 0; c < Dim * Dim; ++c) keep(q.velocityGradient[c], p, sum[c]);
            if constexpr (isRound) keep(q.hoopRate, p, radial);
        });
        for (int p = first; isRound && p < first + count; ++p) q.hoopRate[p] *= overRadius_[p];
    }

    std::vector<int> runEnd_;     // of the run, in its block, that each particle is in
    std::vector<char> isUnequal_; // see findUnequal; empty where all cells are equal
};

} // namespace mpm
