// SPDX-License-Identifier: GPL-2.0-or-later
// A particle type made from a kernel: points on a lattice that reach a few nodes along each axis, with
//
//   phi_ip = prod_k S(x_k),   d_k phi_ip the same with the derivative G of S along axis k.
//
// All transfers go through stencil(); they are written to be read, and fast types are tested against them. A
// Kernel has
//
//   static constexpr const char *name, *doc;      as users see the type
//   static constexpr int support;                 nodes per axis, 2 or 3
//   static AxisWeights<support> along(double c, double l);
//
// where c is the position of the point from the middle of its nodes, in cells and in [-1/2, 1/2), and l half
// the edge of its share of the lattice, in cells. With axial symmetry stress and strain round the axis go by
// phi/r. BSpline.cpp is an example; doc/development/adding-a-particle-type.md goes on from here.
#pragma once

#include "mpm/particle/LatticeType.hpp"
#include "mpm/particle/Transfers.hpp"

namespace mpm {

// Along one axis: weights of the nodes that a point reaches, and their derivatives over c. R: what those along
// the radius gain with axial symmetry, times the radius in cells, so that S + r G is the mean of d(r S)/dr over
// the share of the point and a uniform stress is in equilibrium. Zero is right for hats of points.
template <int nodes> struct AxisWeights {
    double S[nodes], G[nodes], R[nodes] = {};
};

template <int Dim, class Kernel> class StencilDomains : public Transfers<Dim>, public EqualBoxes<Dim> {
    static_assert(Kernel::support >= 2, "a kernel needs two nodes per axis or more for its derivatives");
    static_assert(Kernel::support <= BlockOrder<Dim>::largestSupport,
                  "the kernel reaches more nodes per axis than threads keep apart, see BlockOrder");

  public:
    using Base = Transfers<Dim>;
    using Base::particles, Base::grid, Base::order, Base::moved_, Base::Base;
    using typename Base::NF, typename Base::Planes;

    // --- making -------------------------------------------------------------------------------------
    void build(const Geometry<Dim>& geometry) override {
        require(
            takesUnequalCells() || !grid.isGraded(), Kernel::name, " in '", Base::bodyName,
            "': its kernel is made for equal cells, and the grid is graded; use UGIMP or APDI, or a scene "
            "without grading");
        half_.resize(Dim);
        for (int k = 0; k < Dim; ++k) half_.plane()[k] = geometry.halfSize[k];
        double volume = 1;
        for (int k = 0; k < Dim; ++k) volume *= 2 * geometry.halfSize[k];
        std::vector<double> volumes;
        for (const Vec<Dim>& x : geometry.positions) volumes.push_back(volume * grid.thicknessAt(x[0]));
        Base::create(geometry.positions, volumes);
        group();
    }

    std::vector<Field*> fields() override { return {&half_}; }

    void restored() override {
        isSecond_.clear();
        cell_.assign(particles.size(), -1);
        local_.resize(particles.size());
        if (grid.isAxisymmetric) overRadius_.resize(particles.size());
        order.isOf(grid) ? order.prepare(grid, support) : group();
    }

    // --- the step -----------------------------------------------------------------------------------
    void locate(ParallelRegion& region) override {
        region.forPiecesNoWait(order.coloured.partition, [&](int block) {
            const int begin = order.start[block], end = order.start[block + 1];
            if (!find(begin, end) && order.isKnown(block)) return;
            order.inspect(block, grid, cell_);
            addHalves(begin, end);
            cellsChanged(begin, end);
        });
    }

    bool resort() override {
        isSorted_ = !isSorted_ && (order.broken(grid) || isScattered());
        if (isSorted_) group();
        moved_.assign(order.blocks(), {});
        return isSorted_;
    }

    void addSum(ParallelRegion& region, typename NF::Sum* nodes, double inertiaScale,
                const ActingStress* stress) override {
        forParticles(region, [&](int p, int) {
            addMomentum(nodes, p, inertiaScale);
            if (stress) addTension(nodes, p, *stress);
            if (stress && particles.hasBodyForce) addBodyForce(nodes, p);
        });
    }

    void addForce(ParallelRegion& region, typename NF::Sum* nodes, const double* const tensor[9]) override {
        const ActingStress stress(tensor);
        forParticles(region, [&](int p, int) { addTension(nodes, p, stress); });
    }

    void move(ParallelRegion& region, const typename NF::Motion* nodes, typename NF::Velocity* momentum,
              const Move& how) override {
        forParticles(region, [&](int p, int block) {
            if (nodes) moved_[block] += gather(nodes, p, how);
            if (momentum) scatter(momentum, p, how.inertiaScale);
        });
    }

    void takeGradient(int begin, int end, const typename NF::Velocity* nodes, double) override {
        grid.inGeometry([&](auto isRound) {
            for (int p = begin; p < end; ++p) gatherGradient<isRound>(nodes, p);
        });
    }

    void volumes(int begin, int end) override { Base::volumesFromGradient(begin, end); }

    // --- besides the step ---------------------------------------------------------------------------
    void addQuantity(const double* quantity, const std::vector<int>& which, double* nodal,
                     std::vector<int>& touched) const override {
        for (int p : which)
            stencil(p, [&](int node, double phi, const Vec<Dim>&) {
                Base::addTo(node, phi * quantity[p], nodal, touched);
            });
    }

    void weights(int p, const std::function<void(int, double, const Vec<Dim>&)>& each) const override {
        stencil(p, each);
    }

    size_t bytes() const override {
        return sizeof(int) * cell_.size() + sizeof(double) * overRadius_.size() + local_.bytes();
    }

    double overRadius(int p) const final { return grid.isAxisymmetric ? overRadius_[p] : 0; }

    EqualBoxes<Dim>* boxes() override { return this; }
    Vec<Dim> halfSize() const override { return Eigen::Map<const Vec<Dim>>(half_.plane()); }
    void setHalfSize(const Vec<Dim>& half) override { Eigen::Map<Vec<Dim>>(half_.plane()) = half; }
    void grown() override { group(); }

    void divide(const std::vector<short>& wallAt, const std::function<int(int, int)>& sideOf,
                bool mayDecide) override {
        const bool isFirst = isSecond_.empty();
        isSecond_.resize(particles.size(), 0);
        first_.resize(particles.size());
        double* const side = particles.side.plane();
        for (int block = 0; block < order.blocks(); ++block) {
            bool hasChanged = isFirst;
            for (int p = order.start[block]; p < order.start[block + 1]; ++p) {
                const int wall = wallAt[cell_[p]] - 1;
                const double its = wall < 0 ? 0 : side[p] > 0 ? side[p] : sideOf(p, wall);
                if (mayDecide) side[p] = its;
                hasChanged |= isSecond_[p] != (its == 2);
                isSecond_[p] = its == 2;
            }
            if (!hasChanged) continue;
            addHalves(order.start[block], order.start[block + 1]);
            cellsChanged(order.start[block], order.start[block + 1]);
        }
    }
    void unite() override {
        if (isSecond_.empty()) return;
        isSecond_.clear();
        for (int block = 0; block < order.blocks(); ++block)
            cellsChanged(order.start[block], order.start[block + 1]);
    }
    const std::vector<char>& seconds() const override { return isSecond_; }

  protected:
    static constexpr int support = Kernel::support;

    // f(node, weight, gradient) for every node that particle p reaches, where locate() found it.
    template <class F> void stencil(int p, F&& f) const {
        AxisWeights<support> axis[Dim];
        for (int k = 0; k < Dim; ++k)
            axis[k] = Kernel::along(local_.plane(k)[p] - middle, half_.plane()[k] / grid.smallestCell()[k]);
        const double overCells = overRadius(p) * grid.smallestCell()[0];
        for (int i = 0; i < support; ++i) axis[0].G[i] += overCells * axis[0].R[i];
        forLattice([&](const Index<Dim>& i) {
            int node = firstNodes()[p];
            double weight = 1;
            Vec<Dim> gradient = grid.smallestCell().cwiseInverse();
            for (int k = 0; k < Dim; ++k) {
                node += i[k] * grid.strides[k];
                weight *= axis[k].S[i[k]];
                for (int m = 0; m < Dim; ++m) gradient[m] *= m == k ? axis[k].G[i[k]] : axis[k].S[i[k]];
            }
            f(node, weight, gradient);
        });
    }

    // Cells of particles [begin, end); returns whether one has changed.
    bool find(int begin, int end) {
        double *x[Dim], *local[Dim];
        for (int k = 0; k < Dim; ++k) {
            x[k] = particles.position.plane(k);
            local[k] = local_.plane(k);
        }
        if (grid.isAxisymmetric) {
            const double least = 0.5 * half_.plane()[0];
            for (int p = begin; p < end; ++p) overRadius_[p] = 1 / std::max(x[0][p], least);
        }
        return Base::support(begin, end, x, middle - 0.5, cell_.data(), local, "particle",
                             particles.id.integers());
    }

    // Sorts the particles by block and cell.
    virtual void group() {
        cell_.resize(particles.size());
        local_.resize(particles.size());
        if (grid.isAxisymmetric) overRadius_.resize(particles.size());
        isSecond_.clear();
        find(0, particles.size());
        order.group(grid, cell_);
        particles.permute(order.order);
        permuted(order.order);
        order.order.clear();
        order.prepare(grid, support);
    }

    // With the half of the memory that each particle moves with.
    const int* firstNodes() const { return isSecond_.empty() ? cell_.data() : first_.data(); }
    void addHalves(int begin, int end) {
        if (isSecond_.empty()) return;
        for (int p = begin; p < end; ++p) first_[p] = cell_[p] + isSecond_[p] * grid.count;
    }

    // For types that keep more: after the particles of a block have moved to other cells; after all were
    // sorted; and whether neighbours in memory are so far apart that sorting pays.
    virtual void cellsChanged(int /*begin*/, int /*end*/) {}
    virtual void permuted(const std::vector<int>& /*numbers*/) {}
    virtual bool isScattered() const { return false; }
    // Whether a type finds its weights where cells differ; along() of a kernel does not.
    virtual bool takesUnequalCells() const { return false; }

    // With axial symmetry 1/r of each particle where locate() found it, 1/m; a box on the axis has its middle half way
    // from its inner to its outer half at least.
    std::vector<double> overRadius_;
    std::vector<int> cell_;      // lowest node of the support of each particle, found once per step ...
    std::vector<char> isSecond_; // of each particle, whether it moves with the second half; empty: none does
    std::vector<int> first_;     // cell_ in the half of each
    Field local_{"local", "-", "Position from that node, in cells.", {Dim}}; // ... and
    Field half_{"halfSize", "m", "Half edge of the box domains, one entry per axis."};
    bool isSorted_ = false; // in this round of locate() and resort()

  private:
    static constexpr double middle = 0.5 * (support - 1); // of the support, in cells from its lowest node

    // f(i) for the nodes of a support, by their numbers along each axis; the first axis is the fastest.
    template <class F> static void forLattice(F&& f) {
        Index<Dim> i{};
        for (int k = 0; k < Dim;) {
            if (k == 0) f(i);
            if (++i[k] < support) {
                k = 0;
            } else {
                i[k++] = 0;
            }
        }
    }

    // f(p, block) for all particles; blocks that share nodes take turns.
    template <class F> void forParticles(ParallelRegion& region, F&& f) {
        region.forColoured(order.coloured, [&](int block) {
            for (int p = order.start[block]; p < order.start[block + 1]; ++p) f(p, block);
        });
    }

    template <class Node> static void add(Node& node, int lane, double value) {
        node.set(lane, node[lane] + value);
    }

    // node += phi {momentum, inertial mass, mass}
    void addMomentum(typename NF::Sum* nodes, int p, double inertiaScale) const {
        const double m = particles.mass.plane()[p], inertia = inertiaScale * m;
        const Vec<Dim> momentum = inertia * vectorAt<Dim>(particles.velocity, p);
        stencil(p, [&](int node, double phi, const Vec<Dim>&) {
            for (int k = 0; k < Dim; ++k) add(nodes[node], NF::momentum + k, phi * momentum[k]);
            add(nodes[node], NF::mass, phi * inertia);
            add(nodes[node], NF::weightMass, phi * m);
        });
    }

    // node += - V tensor grad phi, of which the upper triangle is read (planes 3 i + j), and along r
    // - V sigma_theta phi/r
    void addTension(typename NF::Sum* nodes, int p, const ActingStress& stress) const {
        Mat<Dim> tension;
        for (int i = 0; i < Dim; ++i)
            for (int j = 0; j < Dim; ++j)
                tension(i, j) =
                    -particles.volume.plane()[p] *
                    (i == j ? stress.diagonal(i, p) : stress.planes[3 * std::min(i, j) + std::max(i, j)][p]);
        const double hoop = -particles.volume.plane()[p] * stress.diagonal(2, p) * overRadius(p);
        stencil(p, [&](int node, double phi, const Vec<Dim>& gradient) {
            Vec<Dim> force = tension * gradient;
            force[0] += hoop * phi;
            for (int k = 0; k < Dim; ++k) NF::addForce(nodes[node], k, force[k]);
        });
    }

    void addBodyForce(typename NF::Sum* nodes, int p) const {
        const Vec<Dim> force = particles.mass.plane()[p] * vectorAt<Dim>(particles.bodyForce, p);
        stencil(p, [&](int node, double phi, const Vec<Dim>&) {
            for (int k = 0; k < Dim; ++k) NF::addForce(nodes[node], k, phi * force[k]);
        });
    }

    // Particle p follows the nodes; returns the energy that damping took.
    MovedEnergy gather(const typename NF::Motion* nodes, int p, const Move& how) {
        double motion[2 * Dim] = {};
        stencil(p, [&](int node, double phi, const Vec<Dim>&) {
            for (int k = 0; k < 2 * Dim; ++k) motion[k] += phi * nodes[node][k];
        });
        return Planes(particles).move(p, 1, how, [&](int k, int) { return motion[k]; });
    }

    template <bool isRound, class Node> void gatherGradient(const Node* nodes, int p) {
        Mat<Dim> L = Mat<Dim>::Zero();
        double radial = 0;
        stencil(p, [&](int node, double phi, const Vec<Dim>& gradient) {
            for (int i = 0; i < Dim; ++i) L.row(i) += nodes[node][i] * gradient.transpose();
            radial += phi * nodes[node][0];
        });
        if constexpr (isRound) particles.hoopRate.plane()[p] = radial * overRadius(p);
        for (int i = 0; i < Dim; ++i)
            for (int j = 0; j < Dim; ++j) particles.velocityGradient.plane(Dim * i + j)[p] = L(i, j);
    }

    void scatter(typename NF::Velocity* nodes, int p, double inertiaScale) const {
        const double inertia = inertiaScale * particles.mass.plane()[p];
        const Vec<Dim> momentum = inertia * vectorAt<Dim>(particles.velocity, p);
        stencil(p, [&](int node, double phi, const Vec<Dim>&) {
            for (int k = 0; k < Dim; ++k) add(nodes[node], k, phi * momentum[k]);
        });
    }
};

// The type that users choose; MPM_REGISTER(ParticleType, ...) makes it known.
template <class Kernel> class StencilType : public LatticeType {
  public:
    std::string className() const override { return Kernel::name; }
    std::string doc() const override { return Kernel::doc; }
    std::unique_ptr<Domains<2>> make(Particles<2>& particles, const Grid<2>& grid) const override {
        return std::make_unique<StencilDomains<2, Kernel>>(particles, grid);
    }
    std::unique_ptr<Domains<3>> make(Particles<3>& particles, const Grid<3>& grid) const override {
        return std::make_unique<StencilDomains<3, Kernel>>(particles, grid);
    }
};

} // namespace mpm
