// SPDX-License-Identifier: GPL-2.0-or-later
// Uniform GIMP: particles with fixed box domains (Bardenhagen & Kober 2004, CMES 5(6), contiguous
// particles of constant size). Good for separation and very large deformation. The box neither stretches
// nor turns: in tension gaps open between boxes, and from a stretch of 2 (h + l)/(2 l) on neighbours
// no longer share a node (numerical fracture), unless long particles are cut in two (Splitting.hpp).
#include "mpm/particle/LatticeType.hpp"
#include "mpm/particle/Transfers.hpp"
#include "mpm/particle/ugimp/Splitting.hpp"

namespace mpm {

// One direction of a box: half size l in cells, in (0, 1/2], and what follows from it and the cell size h.
struct BoxAxis {
    double l, quarter, slope; // l, 1/(4 l), 1/(2 l h)

    BoxAxis() = default;
    BoxAxis(double half, double h) : l(half / h), quarter(h / (4 * half)), slope(0.5 / half) {}
};

// Weights of the three nodes that each particle of a batch reaches in one direction, and their gradients. c: position
// in cells from the middle one, in [-1/2, 1/2). S is the hat function averaged over the box, S = 1/(2l) int hat,
// written without branches: `below` and `above` are the lengths of the box on either side of the middle node, `left` and
// `right` how far the box is from it. `lanes` beyond the batch are zero, see together().
template <int size, int lanes> struct alignas(64) BoxWeights {
    double S[3][size], G[3][size];

    void set(const double* position, int count, const BoxAxis& axis) {
        const double l = axis.l, quarter = axis.quarter, slope = axis.slope;
#pragma omp simd
        for (int p = 0; p < count; ++p) {
            const double c = position[p] - 1, cut = c < l ? c : l, middle = cut > -l ? cut : -l,
                         beyond = c - middle;
            const double below = l - middle, above = l + middle, right = beyond > 0 ? beyond : 0,
                         left = right - beyond;
            const double first = below * below * quarter + left, last = above * above * quarter + right;
            S[0][p] = first, S[1][p] = 1 - first - last, S[2][p] = last;
            G[0][p] = -slope * below, G[1][p] = -2 * slope * middle, G[2][p] = slope * above;
        }
        for (int i = 0; i < 3; ++i)
            std::fill_n(S[i] + count, lanes, 0.0), std::fill_n(G[i] + count, lanes, 0.0);
    }
};

template <int Dim> class BoxDomains : public Transfers<Dim>, public EqualBoxes<Dim> {
  public:
    using Base = Transfers<Dim>;
    using Base::particles, Base::grid, Base::order, Base::damped_;
    using typename Base::L, typename Base::NF, typename Base::Planes;

    BoxDomains(Particles<Dim>& particles, const Grid<Dim>& grid, double splitAt, bool hasOutline)
        : Base(particles, grid), splitting_(splitAt), hasOutline_(hasOutline) {}

    void build(const Geometry<Dim>& geometry) override {
        const Vec<Dim> half = geometry.halfSize;
        half_.resize(Dim);
        double volume = 1;
        for (int k = 0; k < Dim; ++k) {
            half_.plane()[k] = half[k];
            require(half[k] > 0 && half[k] <= 0.5 * grid.cell[k] * (1 + 1e-12), "UGIMP in '", Base::bodyName,
                    "': half size ", half[k], " m must be positive and at most half a cell (",
                    0.5 * grid.cell[k], " m); use more particles per cell");
            volume *= 2 * half[k];
        }
        Base::create(geometry.positions, std::vector<double>(geometry.positions.size(), volume));
        if (splitting_.isOn()) splitting_.start(particles.size());
        outline_.set(geometry.carriers, geometry.offsets, geometry.areas);
        regroup();
    }

    std::vector<Field*> fields() override {
        std::vector<Field*> all{&half_};
        if (splitting_.isOn()) all.push_back(&splitting_.share);
        if (hasOutline_)
            for (Field* field : outline_.fields()) all.push_back(field);
        return all;
    }
    std::vector<std::pair<std::string, std::vector<int>*>> tables() override {
        auto all = Base::tables();
        all.emplace_back("runsWhenSorted", &runsWhenSorted_);
        return all;
    }

    void restored() override {
        cell_.assign(particles.size(), -1), local_.resize(particles.size()),
            stretchEnd_.resize(particles.size());
        outline_.find(particles);
        order.isOf(grid) ? order.prepare(grid, 3) : regroup();
    }

    // --- the step -----------------------------------------------------------------------------------
    void locate(ParallelRegion& region) override {
        region.forPiecesNoWait(order.coloured.partition, [&](int b) {
            const int begin = order.start[b], end = order.start[b + 1];
            if (find(begin, end) || !order.isKnown(b))
                order.inspect(b, grid, cell_), endStretches(begin, end);
        });
    }

    // Sorts when a particle has left the neighbourhood of its block, or when too few neighbours in memory share a cell.
    bool resort() override {
        if (isSorted_) runsWhenSorted_[0] = order.runs();
        isSorted_ = !isSorted_ && (order.broken(grid) || order.runs() > 2 * runsWhenSorted_[0] + 64);
        if (isSorted_) regroup();
        damped_.assign(order.blocks(), 0.0);
        if (splitting_.isOn()) splitting_.expect(particles.size());
        return isSorted_;
    }

    void addSum(ParallelRegion& region, typename NF::Sum* nodes, double inertiaScale,
                bool withForce) override {
        const Planes q(particles);
        const auto stress = Base::stressPlanes();
        const bool hasBodyForce = particles.hasBodyForce;
        batches(region, [&](int first, int count, const Weights& w) {
            Quad value[batch];
            typename L::Set B[batch];
            q.values(first, count, inertiaScale, value);
            q.forces(first, count, stress.data(), B);
            if (!withForce)
                for (auto& b : B)
                    for (int k = 0; k < (Dim == 2 ? 1 : 3); ++k) b[k] = Quad{};
            scatter(nodes, first, count, w, value, B);
            if (hasBodyForce) {
                double given[Dim][batch];
                q.bodyForces(first, count, given);
                Base::packForces(given, count, value);
                scatter<1>(nodes, first, count, w, value);
            }
        });
    }

    void move(ParallelRegion& region, const typename NF::Motion* nodes, typename NF::Velocity* momentum,
              const Move& how) override {
        const Planes q(particles);
        batches(region, [&](int first, int count, const Weights& w, int block) {
            if (nodes) {
                double taken[2 * Dim][padded];
                gather(nodes, first, count, w, taken);
                damped_[block] += q.move(first, count, how, [&](int k, int i) __attribute__((always_inline)) {
                    return taken[k][i];
                });
            }
            if (momentum) {
                double given[Dim + 1][batch];
                Quad value[batch];
                q.momenta(first, count, how.inertiaScale, given);
                Base::packMomenta(given, count, value);
                scatter<0>(momentum, first, count, w, value);
            }
        });
    }

    void takeGradient(int begin, int end, const typename NF::Velocity* nodes, double) override {
        const Planes q(particles);
        for (int first = begin; first < end; first += batch) {
            const int count = std::min(batch, end - first);
            const Weights w(*this, first, count);
            gatherGradient(nodes, first, count, w, q.velocityGradient);
        }
    }

    void volumes(int begin, int end) override {
        Base::volumesFromGradient(begin, end);
        if (splitting_.isOn()) splitting_.look(particles, begin, end);
    }

    // --- besides the step ---------------------------------------------------------------------------
    void addForce(ParallelRegion& region, typename NF::Sum* nodes, const double* const tensor[9]) override {
        const Planes q(particles);
        batches(region, [&](int first, int count, const Weights& w) {
            Quad value[batch];
            typename L::Set B[batch];
            std::fill(value, value + count, Quad{});
            q.forces(first, count, tensor, B);
            scatter(nodes, first, count, w, value, B);
        });
    }

    // Where the driven part of a body is: at every step, so not one by one through weights().
    void addMass(const std::vector<int>& which, double* nodal, std::vector<int>& touched) const override {
        const double* mass = particles.mass.plane();
        for (size_t i = 0; i < which.size();) {
            const int first = which[i];
            int count = 1;
            while (i + count < which.size() && count < batch && which[i + count] == first + count) ++count;
            i += count;
            const Weights w(*this, first, count);
            for (int p = 0; p < count; ++p)
                for (int row = 0; row < rows; ++row)
                    for (int i = 0; i < 3; ++i)
                        Base::addMassTo(cell_[first + p] + rowOffset(row) + i,
                                        w.across(row, p).S * w.axis[0].S[i][p] * mass[first + p], nodal,
                                        touched);
        }
    }

    void grown() override { regroup(); }

    bool splitStretched() override {
        if (!splitting_.isOn() || !splitting_.cut(particles, halfSize(), outline_)) return false;
        grown();
        return true;
    }
    size_t bytes() const override {
        return sizeof(int) * (cell_.size() + stretchEnd_.size()) + local_.bytes();
    }

    EqualBoxes<Dim>* boxes() override { return this; }
    const Outline<Dim>* outline() const override { return outline_.size() > 0 ? &outline_ : nullptr; }
    Vec<Dim> halfSize() const override { return Eigen::Map<const Vec<Dim>>(half_.plane()); }

    void weights(int p, const std::function<void(int, double, const Vec<Dim>&)>& each) const override {
        const Weights w(*this, p, 1);
        for (int n = 0; n < power(3, Dim); ++n) {
            int node = cell_[p];
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

  private:
    static constexpr int power(int base, int exponent) {
        return exponent == 0 ? 1 : base * power(base, exponent - 1);
    }
    static constexpr int rows = power(3, Dim - 1); // of three nodes along the first axis
#ifdef __AVX512VL__
    static constexpr int rowsAtOnce = 3; // 18 sums, in 32 registers
#else
    static constexpr int rowsAtOnce = 1;
#endif
    // A lane for each particle of a support, where there are two along each axis.
    using Several = typename Widest<corners<Dim>>::Vector;
    static constexpr int lanes = sizeof(Several) / sizeof(double);
    static constexpr int batch = Base::largestBatch,
                         padded = batch + 8; // room for all lanes from each one on; whole cache lines

    // Weights of a batch of particles, short enough to stay in the first cache while it is used.
    struct Weights {
        BoxWeights<padded, lanes> axis[Dim];

        Weights(const BoxDomains& d, int first, int count) {
            for (int k = 0; k < Dim; ++k)
                axis[k].set(d.local_.plane(k) + first, count, BoxAxis(d.half_.plane()[k], d.grid.cell[k]));
        }
        MPM_INLINE Across<Dim> across(int row, int p) const {
            const auto &y = axis[1], &z = axis[Dim - 1];
            const int j = row % 3, k = row / 3;
            if constexpr (Dim == 2)
                return {y.S[j][p], {y.G[j][p]}};
            else
                return {y.S[j][p] * z.S[k][p], {y.G[j][p] * z.S[k][p], y.S[j][p] * z.G[k][p]}};
        }
        MPM_INLINE Across<Dim, Several> acrossSeveral(int row, int p) const {
            const auto &y = axis[1], &z = axis[Dim - 1];
            const int j = row % 3, k = row / 3;
            const Several S = load<Several>(y.S[j] + p), G = load<Several>(y.G[j] + p);
            if constexpr (Dim == 2)
                return {S, {G}};
            else {
                const Several Sz = load<Several>(z.S[k] + p);
                return {S * Sz, {G * Sz, S * load<Several>(z.G[k] + p)}};
            }
        }
    };

    MPM_INLINE int rowOffset(int row) const {
        return row % 3 * grid.strides[1] + (Dim == 3 ? row / 3 * grid.strides[Dim - 1] : 0);
    }

    MPM_INLINE static std::array<Several, 3> severalOf(const double (&weight)[3][padded], int p) {
        return {load<Several>(weight[0] + p), load<Several>(weight[1] + p), load<Several>(weight[2] + p)};
    }

    // f(first, count, weights, block) for batches of particles, by blocks in turns.
    template <class F> void batches(ParallelRegion& region, F&& f) {
        region.forColoured(order.coloured, [&](int b) {
            for (int first = order.start[b], end = order.start[b + 1], count; first < end; first += count) {
                count = std::min(batch - first % 8, end - first);
                const Weights w(*this, first, count);
                if constexpr (std::is_invocable_v<F, int, int, const Weights&, int>)
                    f(first, count, w, b);
                else
                    f(first, count, w);
            }
        });
    }

    // Stretches of a batch that have the same support are summed before the grid is touched: f(begin, end, its first node).
    template <class F> MPM_INLINE void stretches(int first, int count, F&& f) const {
        const int *cells = cell_.data() + first, *ends = stretchEnd_.data() + first;
        for (int begin = 0, end; begin < count; begin = end) {
            end = std::min(ends[begin] - first, count);
            f(begin, end, cells[begin]);
        }
    }

    // Quad `part` of node += phi * value.
    template <int part, class Node>
    MPM_INLINE void scatter(Node* nodes, int first, int count, const Weights& w, const Quad* value) const {
        stretches(first, count, [&](int begin, int end, int cell) {
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

    // First Quad of node += phi * value, second one += B grad phi; as many rows of nodes at a time as registers can hold the sums of.
    MPM_INLINE void scatter(typename NF::Sum* nodes, int first, int count, const Weights& w,
                            const Quad* value, const typename L::Set* B) const {
        const auto& x = w.axis[0];
        stretches(first, count, [&](int begin, int end, int cell) {
            for (int top = 0; top < rows; top += rowsAtOnce) {
                typename NF::Sum sum[rowsAtOnce][3] = {};
                for (int p = begin; p < end; ++p) MPM_UNROLL
                for (int row = 0; row < rowsAtOnce; ++row) {
                    const typename L::Row given(value[p], B[p], w.across(top + row, p));
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

    // Particles of a batch with the same support, as many as there are lanes: f(first of them, its first node). Lanes without
    // a particle belong to the next ones, which come later.
    template <class F> MPM_INLINE void together(int first, int count, F&& f) const {
        const int *cells = cell_.data() + first, *ends = stretchEnd_.data() + first;
        for (int p = 0; p < count; p = std::min(ends[p] - first, p + lanes)) f(p, cells[p]);
    }

    // taken[k] = sum phi N_k over the nodes.
    template <size_t n, class Node>
    MPM_INLINE void gather(const Node* nodes, int first, int count, const Weights& w,
                           double (&taken)[n][padded]) const {
        together(first, count, [&](int p, int cell) __attribute__((always_inline)) {
            const auto S = severalOf(w.axis[0].S, p);
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

    // gradient[Dim i + j] = sum v_i d_j phi, of the particles of the batch alone: the next ones may be another thread's.
    MPM_INLINE void gatherGradient(const typename NF::Velocity* nodes, int first, int count, const Weights& w,
                                   double* const (&gradient)[Dim * Dim]) const {
        together(first, count, [&](int p, int cell) __attribute__((always_inline)) {
            const auto S = severalOf(w.axis[0].S, p), G = severalOf(w.axis[0].G, p);
            Several sum[Dim * Dim] = {};
            MPM_UNROLL
            for (int row = 0; row < rows; ++row) {
                const auto* node = inRegister(nodes + cell + rowOffset(row));
                const auto across = w.acrossSeveral(row, p);
                MPM_UNROLL
                for (int i = 0; i < Dim; ++i) {
                    const double a = node[0][i], b = node[1][i], c = node[2][i];
                    const Several along = a * S[0] + b * S[1] + c * S[2];
                    sum[Dim * i] += across.S * (a * G[0] + b * G[1] + c * G[2]);
                    MPM_UNROLL
                    for (int j = 1; j < Dim; ++j) sum[Dim * i + j] += across.G[j - 1] * along;
                }
            }
            MPM_UNROLL
            for (int c = 0; c < Dim * Dim; ++c)
                if (p + lanes <= count)
                    store(gradient[c] + first + p, sum[c]);
                else
                    std::memcpy(gradient[c] + first + p, &sum[c], (count - p) * sizeof(double));
        });
    }

    bool find(int begin, int end) {
        double *x[Dim], *local[Dim];
        for (int k = 0; k < Dim; ++k) x[k] = particles.position.plane(k), local[k] = local_.plane(k);
        return Base::support(begin, end, x, 0.5, cell_.data(), local, "particle", particles.id.integers());
    }

    void endStretches(int begin, int end) {
        for (int p = end - 1, last = end; p >= begin; --p) {
            if (p + 1 < end && cell_[p] != cell_[p + 1]) last = p + 1;
            stretchEnd_[p] = last;
        }
    }

    // Sorts the particles by block and cell.
    void regroup() {
        cell_.resize(particles.size()), local_.resize(particles.size()), stretchEnd_.resize(particles.size());
        find(0, particles.size());
        order.group(grid, cell_);
        particles.permute(order.order);
        splitting_.permute(order.order);
        outline_.find(particles);
        order.order.clear();
        order.prepare(grid, 3);
    }

    std::vector<int> cell_; // lowest node of the support of each particle, found once per step ...
    Field local_{
        "local", "-", "Position within the support, in cells.", {Dim}}; // ... with the position in it
    std::vector<int>
        stretchEnd_; // one past the last of the particles from each one on, in its block, that have the same support
    Field half_{"halfSize", "m", "Half edge of the box domains, one entry per axis."};
    Splitting<Dim> splitting_;
    Outline<Dim> outline_;
    const bool hasOutline_;
    bool isSorted_ = false; // in this round of locate() and resort()
    std::vector<int> runsWhenSorted_{0};
};

class UGIMP : public LatticeType {
  public:
    bool cut = false, outline = true;
    double splitAt = notGiven;

    std::string className() const override { return "UGIMP"; }
    std::string doc() const override {
        return "Particles with fixed box domains (uniform GIMP), for separation and very large deformation.\n\n"
               "phi = 1/(2l) int hat dx over the box of half size l in each direction; the box neither stretches\n"
               "nor turns; a body that is stretched farther than the boxes reach falls apart, unless its long particles are\n"
               "split. Source: Bardenhagen & Kober 2004, Comput. Model. Eng. Sci. 5(6), 477-496.";
    }
    std::vector<Parameter> parameters() override {
        auto all = LatticeType::parameters();
        all.insert(
            all.end(),
            {{"cut", "",
              "Whether boxes that the boundary of the region cuts hold the part inside, at its centroid; False: they are "
              "whole, or left out where their centre is outside. For curved bodies in contact.",
              &cut},
             {"outline", "",
              "With `cut`: whether the outline of the region goes with the particles as the surface that contact sees. False: the "
              "faces of the boxes are; for soil that flows, where the surface becomes another.",
              &outline},
             {"splitAt", "-",
              "Stretch at which a particle is cut in two across its most stretched direction; its halves are cut when "
              "they are that long against the box again. None: never.",
              &splitAt, Range::inside(1, std::numeric_limits<double>::infinity())}});
        return all;
    }
    std::unique_ptr<Domains<2>> make(Particles<2>& p, const Grid<2>& g) const override {
        return std::make_unique<BoxDomains<2>>(p, g, splitAt, cut && outline);
    }
    std::unique_ptr<Domains<3>> make(Particles<3>& p, const Grid<3>& g) const override {
        return std::make_unique<BoxDomains<3>>(p, g, splitAt, cut && outline);
    }
};

MPM_REGISTER(ParticleType, UGIMP);

} // namespace mpm
