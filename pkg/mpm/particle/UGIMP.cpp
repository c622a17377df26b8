// SPDX-License-Identifier: GPL-2.0-or-later
// Uniform GIMP: particles with fixed box domains (Bardenhagen & Kober 2004, CMES 5(6), contiguous
// particles of constant size). Good for separation and very large deformation. The box neither stretches
// nor turns: in tension gaps open between boxes, and from a stretch of 2 (h + l)/(2 l) on neighbours
// no longer share a node (numerical fracture).
#include "mpm/particle/Transfers.hpp"

namespace mpm {



// One direction of a box: half size l in cells, in (0, 1/2], and what follows from it and the cell size h.
struct BoxAxis {
    double l, quarter, slope; // l, 1/(4 l), 1/(2 l h)

    BoxAxis() = default;
    BoxAxis(double half, double h) : l(half / h), quarter(h / (4 * half)), slope(0.5 / half) {}
};

// Weights of the three nodes that a particle reaches in one direction, and their gradients; c: position
// in cells from the lowest of them, in [1/2, 3/2). S is the hat function averaged over the box,
// S = 1/(2l) int hat, written without branches: `below` and `above` are the lengths of the box on the
// outer flanks of the first and the last hat.
struct BoxWeights {
    double S[3], G[3];

    MPM_INLINE BoxWeights(double c, const BoxAxis& axis) {
        const double l = axis.l, below = std::min(std::max(1 + l - c, 0.0), 2 * l),
                     above = std::min(std::max(l - 1 + c, 0.0), 2 * l);
        S[0] = below * below * axis.quarter + std::max(0.0, 1 - l - c);
        S[2] = above * above * axis.quarter + std::max(0.0, c - 1 - l);
        S[1] = 1 - S[0] - S[2];
        G[0] = -below * axis.slope;
        G[2] = above * axis.slope;
        G[1] = -G[0] - G[2];
    }
    BoxWeights() = default;
};



template <int Dim> class BoxDomains : public Transfers<BoxDomains<Dim>, Dim> {
  public:
    using Base = Transfers<BoxDomains<Dim>, Dim>;
    using NF = typename Base::NF;
    using Base::Base, Base::particles, Base::grid, Base::order;

    void build(const Geometry<Dim>& geometry) override {
        const Vec<Dim> half = geometry.halfSize;
        half_.resize(Dim);
        double volume = 1;
        for (int k = 0; k < Dim; ++k) {
            half_.plane()[k] = half[k];
            require(half[k] > 0 && half[k] <= 0.5 * grid.cell[k] * (1 + 1e-12), "UGIMP in '", Base::bodyName,
                    "': half size ", half[k], " m must be positive and at most half a cell (", 0.5 * grid.cell[k],
                    " m); use more particles per cell");
            volume *= 2 * half[k];
        }
        Base::create(geometry.positions, std::vector<double>(geometry.positions.size(), volume));
        regroup();
    }

    std::vector<Field*> fields() override { return {&half_}; }
    std::vector<std::pair<std::string, std::vector<int>*>> tables() override {
        auto all = Base::tables();
        all.emplace_back("runsWhenSorted", &runsWhenSorted_);
        return all;
    }

    void locate(Team& team) override {
        double *local[Dim], *position[Dim];
        for (int k = 0; k < Dim; ++k) local[k] = particles.local.plane(k), position[k] = particles.position.plane(k);
        auto find = [&](int p) {
            Vec<Dim> x;
            for (int k = 0; k < Dim; ++k) x[k] = position[k][p];
            const int cell = Base::support(x, 0.5, local, p);
            if (cell < 0) Base::outside("particle", particles.id.integers()[p], x);
            return particles.cell[p] = cell;
        };
        order.locate(team, grid, 3, find);
        team.once([&] {
            sorted_ = order.broken(grid) || order.runs() > 2 * runsWhenSorted_[0] + 64;
            if (sorted_) regroup();
        });
        if (sorted_) {
            order.locate(team, grid, 3, find);
            team.once([&] { runsWhenSorted_[0] = order.runs(); });
        }
    }

    void volumes(int begin, int end, double) override {
        const double* F[9];
        for (int i = 0; i < 9; ++i) F[i] = particles.deformationGradient.plane(i);
        double* V = particles.volume.plane();
        const double* V0 = particles.initialVolume.plane();
        for (int p = begin; p < end; ++p) {
            if (Dim == 2)
                V[p] = V0[p] * (F[0][p] * F[4][p] - F[1][p] * F[3][p]) * F[8][p];
            else
                V[p] = V0[p] * (F[0][p] * (F[4][p] * F[8][p] - F[5][p] * F[7][p]) -
                                F[1][p] * (F[3][p] * F[8][p] - F[5][p] * F[6][p]) +
                                F[2][p] * (F[3][p] * F[7][p] - F[4][p] * F[6][p]));
        }
    }

    void grown() override { regroup(); }

    Vec<Dim> halfSize() const override { return Eigen::Map<const Vec<Dim>>(half_.plane()); }
    double longestEdge(int) const override { return 2 * halfSize().maxCoeff(); }

    template <class F> void eachWeight(int p, F&& each) const {
        const Stencil w = Stencils(*this)(p);
        for (int n = 0; n < power(3, Dim); ++n) {
            int node = particles.cell[p];
            double phi = 1;
            Vec<Dim> gradient = Vec<Dim>::Ones();
            for (int k = 0, rest = n; k < Dim; ++k, rest /= 3) {
                node += rest % 3 * grid.strides[k];
                phi *= w[k].S[rest % 3];
                for (int m = 0; m < Dim; ++m) gradient[m] *= m == k ? w[k].G[rest % 3] : w[k].S[rest % 3];
            }
            each(node, phi, gradient);
        }
    }

    // Particles in a row with the same support are summed in local accumulators before the grid is touched.
    template <int W, bool grads = true, class Load>
    void scatter(Team& team, Pack<W>* nodes, Load&& load, double = 0) {
        const Stencils stencils(*this);
        const int* cells = particles.cell.data();
        team.twoColours(order.blocks(), [&](int b) {
            Pack<W> sum[power(3, Dim)];
            for (auto& s : sum) s = Pack<W>::zero();
            const int end = order.start[b + 1];
            for (int p = order.start[b]; p < end;) {
                const int cell = cells[p];
                do {
                    Pack<W> P = Pack<W>::zero();
                    Pack<4> Q[Dim];
                    for (auto& q : Q) q = Pack<4>::zero();
                    load(p, P, Q);
                    spread<Dim - 1, W, grads>(stencils(p), P, Q, sum);
                } while (++p < end && cells[p] == cell);
                flush<Dim - 1>(nodes + cell, sum);
            }
        });
    }

    template <int W, bool grads, class Store> void gather(Team& team, const Pack<W>* nodes, Store&& store) {
        const Stencils stencils(*this);
        const int* cells = particles.cell.data();
        team.chunks(particles.size(), [&](int begin, int end) {
            for (int p = begin; p < end; ++p) {
                Pack<W> value, gradient[Dim];
                collect<Dim - 1, W, grads>(stencils(p), nodes + cells[p], value, gradient);
                store(p, value, gradient);
            }
        });
    }

  private:
    static constexpr int power(int base, int exponent) { return exponent == 0 ? 1 : base * power(base, exponent - 1); }

    using Stencil = std::array<BoxWeights, Dim>;

    // Where the stencils of the particles come from, hoisted out of the loops.
    struct Stencils {
        BoxAxis axis[Dim];
        const double* local[Dim];

        explicit Stencils(const BoxDomains& d) {
            for (int k = 0; k < Dim; ++k) {
                axis[k] = BoxAxis(d.half_.plane()[k], d.grid.cell[k]);
                local[k] = d.particles.local.plane(k);
            }
        }
        MPM_INLINE Stencil operator()(int p) const {
            Stencil w;
            for (int k = 0; k < Dim; ++k) w[k] = BoxWeights(local[k][p], axis[k]);
            return w;
        }
    };

    // Axis by axis from the last to the first: of the value part A and the gradient parts B_k only those
    // with k <= axis are still to be weighted.
    template <int axis, int W, bool grads>
    MPM_INLINE void spread(const Stencil& stencil, const Pack<W>& A, const Pack<4>* B, Pack<W>* sum) const {
        const BoxWeights& w = stencil[axis];
#pragma GCC unroll 3
        for (int i = 0; i < 3; ++i) {
            if constexpr (axis == 0) {
                sum[i].add(w.S[i], A);
                if (grads) sum[i].addLast(w.G[i], B[0]);
            } else {
                Pack<W> a = w.S[i] * A;
                Pack<4> b[axis];
                if (grads) {
                    a.addLast(w.G[i], B[axis]);
                    for (int k = 0; k < axis; ++k) b[k] = w.S[i] * B[k];
                }
                spread<axis - 1, W, grads>(stencil, a, b, sum + i * power(3, axis));
            }
        }
    }

    template <int axis, int W, bool grads>
    MPM_INLINE void collect(const Stencil& stencil, const Pack<W>* node, Pack<W>& value, Pack<W>* gradient) const {
        const BoxWeights& w = stencil[axis];
        value = Pack<W>::zero();
        for (int k = 0; k <= axis; ++k) gradient[k] = Pack<W>::zero();
#pragma GCC unroll 3
        for (int i = 0; i < 3; ++i) {
            Pack<W> v, g[Dim];
            if constexpr (axis == 0)
                v = node[i];
            else
                collect<axis - 1, W, grads>(stencil, node + i * grid.strides[axis], v, g);
            value.add(w.S[i], v);
            if (!grads) continue;
            gradient[axis].add(w.G[i], v);
            for (int k = 0; k < axis; ++k) gradient[k].add(w.S[i], g[k]);
        }
    }

    // Adds the sums of a support to its nodes and clears them.
    template <int axis, int W> MPM_INLINE void flush(Pack<W>* node, Pack<W>* sum) const {
#pragma GCC unroll 3
        for (int i = 0; i < 3; ++i) {
            if constexpr (axis == 0)
                node[i] += sum[i], sum[i] = Pack<W>::zero();
            else
                flush<axis - 1>(node + i * grid.strides[axis], sum + i * power(3, axis));
        }
    }

    // Sorts the particles by block and cell.
    void regroup() {
        for (int p = 0; p < particles.size(); ++p) {
            double* local[Dim];
            for (int k = 0; k < Dim; ++k) local[k] = particles.local.plane(k);
            const int cell = Base::support(vectorAt<Dim>(particles.position, p), 0.5, local, p);
            if (cell < 0) Base::outside("particle", particles.id.integers()[p], vectorAt<Dim>(particles.position, p));
            particles.cell[p] = cell;
        }
        order.group(grid, particles.cell);
        particles.permute(order.order);
        order.order.clear();
    }

    Field half_{"halfSize", "m", "Half edge of the box domains, one entry per axis."};
    bool sorted_ = false;
    std::vector<int> runsWhenSorted_{0};
};

class UGIMP : public ParticleType {
  public:
    std::vector<double> perCell{2};

    std::string className() const override { return "UGIMP"; }
    std::string doc() const override {
        return "Particles with fixed box domains (uniform GIMP), for separation and very large deformation.\n\n"
               "phi = 1/(2l) int hat dx over the box of half size l in each direction; the box neither stretches\n"
               "nor turns. Source: Bardenhagen & Kober 2004, Comput. Model. Eng. Sci. 5(6), 477-495.";
    }
    std::vector<Parameter> parameters() override {
        return {{"perCell", "-", "Particles per cell and direction: one number, or one per direction.", &perCell,
                 Range::between(1, 1000)}};
    }
    void finish() override {
        require(perCell.size() >= 1 && perCell.size() <= 3, "UGIMP: perCell takes one number or one per direction");
        for (double n : perCell)
            require(n == std::floor(n), "UGIMP: perCell = ", n, " is not allowed; give a whole number of particles "
                                        "per cell and direction");
    }
    bool isMeshed() const override { return false; }
    std::unique_ptr<Domains<2>> make(Particles<2>& p, const Grid<2>& g) const override {
        return std::make_unique<BoxDomains<2>>(p, g);
    }
    std::unique_ptr<Domains<3>> make(Particles<3>& p, const Grid<3>& g) const override {
        return std::make_unique<BoxDomains<3>>(p, g);
    }
};

MPM_REGISTER(ParticleType, UGIMP);

} // namespace mpm
