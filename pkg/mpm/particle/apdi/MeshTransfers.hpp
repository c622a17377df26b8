// SPDX-License-Identifier: GPL-2.0-or-later
// The transfers of APDI, in two stages: particle <-> vertex <-> grid. Domains are treated in batches.
#pragma once

#include "mpm/particle/Transfers.hpp"
#include "mpm/particle/apdi/Beam.hpp"
#include "mpm/particle/apdi/CarriedByVertices.hpp"
#include "mpm/particle/apdi/DomainPieces.hpp"
#include "mpm/particle/apdi/DomainQuality.hpp"

#include <atomic>

namespace mpm {

template <int Dim> class MeshTransfers : public Transfers<Dim> {
  public:
    using Base = Transfers<Dim>;
    using Base::particles, Base::grid, Base::order, Base::moved_;
    using typename Base::NF, typename Base::Planes;
    static constexpr int NC = corners<Dim>;

    MeshTransfers(Particles<Dim>& particles, const Grid<Dim>& grid, double hourglass, bool converts)
        : Base(particles, grid), mesh_(grid, order), hourglass_(hourglass),
          skew_{"skew",
                "-",
                "What the corner weights differ from 1/2^Dim by, for the step.",
                {grid.isAxisymmetric ? 3
                 : Dim == 2          ? 2
                                     : 7}},
          converts_(converts) {}

    // What follows from the connectivity.
    void restored() override {
        mesh_.restored();
        carried_.resize(mesh_.vertices.size());
        skew_.resize(particles.size());
        grid.inGeometry([&](auto isRound) { hourglass_.template restored<isRound>(mesh_); });
        if (Base::section) beam_.restored(mesh_, particles, *Base::section, grid.isAxisymmetric);
        pieces_.cut(mesh_);
        if (!order.isOf(grid)) regroup();
    }

    // --- the step -----------------------------------------------------------------------------------
    void locate(ParallelRegion& region) override {
        region.chunksNoWait(mesh_.vertices.size(), [&](int begin, int end) {
            find(begin, end);
            carried_.clear(begin, end);
        });
        region.chunksNoWait(particles.size(), [&](int begin, int end) {
            hourglass_.takeStiffness(begin, end, Base::stiffness, Base::shearStrength);
        });
    }

    bool resort() override {
        distorted_.clear();
        moved_.assign(pieces_.count(), {});
        isCleared_ = true;
        mesh_.vertices.resort();
        return false;
    }

    // Domains -> vertices -> nodes.
    void addSum(ParallelRegion& region, typename NF::Sum* nodes, double inertiaScale,
                const ActingStress* stress) override {
        if (!isCleared_) carried_.clear(region);
        grid.inGeometry([&](auto isRound) {
            this->template sumAtVertices<isRound>(region, inertiaScale, stress,
                                                  particles.hasBodyForce && stress);
        });
        carried_.toNodes(region, mesh_.vertices, nodes, 1 / inertiaScale);
    }

    void internalForces(const std::function<void(int, const Vec<Dim>&)>& each) override {
        ParallelRegion alone;
        carried_.clear(alone);
        const ActingStress stress(particles.stress);
        grid.inGeometry(
            [&](auto isRound) { this->template sumAtVertices<isRound>(alone, 1, &stress, false); });
        alone.rethrow();
        const auto force = carried_.template planes<Dim>(Carried::force);
        for (int v = 0; v < mesh_.vertices.size(); ++v) {
            Vec<Dim> its;
            for (int k = 0; k < Dim; ++k) its[k] = force[k][v];
            forNodes(v, [&](int node, double part, double S) { each(node, part * S * its); });
        }
    }

  private:
    // What the domains give to their vertices, which have to be clear.
    template <bool isRound>
    void sumAtVertices(ParallelRegion& region, double inertiaScale, const ActingStress* stress,
                       bool hasBodyForce) {
        const Planes q(particles);
        const typename HourglassControl<Dim>::DeformedPattern deformed(hourglass_, particles);
        pieces_.forBatches(region, mesh_, [&](const Batch<Dim>& batch, int) {
            const BatchShapes<Dim, isRound> d(batch, mesh_.vertices.position, skew_);
            GivenByDomains<Dim, isRound> given;
            q.momenta(batch.first, batch.count, inertiaScale, given.momentum);
            if (stress) {
                q.tension(batch.first, batch.count, *stress, given.tension);
                given.takeRing(q.volume, *stress, batch.first, batch.count);
            } else {
                std::memset(given.ring, 0, sizeof given.ring);
                std::memset(given.tension, 0, sizeof given.tension);
                std::memset(given.control.force, 0, sizeof given.control.force);
            }
            const auto add = [&](auto isPatterned) {
                if (isPatterned) given.control.take(batch, deformed);
                if (stress) hourglass_.template resist<isPatterned>(batch, d, given.control);
                batch.addToCorners(carried_.template planes<Carried::sums>(0),
                                   [&](int a, int k, int p) MPM_INLINE_LAMBDA {
                                       return given.template toCorner<isPatterned>(d, a, k, p);
                                   });
            };
            hourglass_.isPatterned() ? add(std::true_type()) : add(std::false_type());
            if (hasBodyForce) {
                q.bodyForces(batch.first, batch.count, given.bodyForce);
                batch.addToCorners(carried_.template planes<Dim>(Carried::force),
                                   [&](int a, int k, int p)
                                       MPM_INLINE_LAMBDA { return d.w[a][p] * given.bodyForce[k][p]; });
            }
        });
        if (beam_.isHere())
            region.once([&] {
                beam_.addSpin(mesh_, particles, inertiaScale,
                              carried_.template planes<Dim>(Carried::momentum).data());
                if (stress)
                    beam_.addForces(mesh_, particles, carried_.template planes<Dim>(Carried::force).data());
            });
    }

  public:
    // Nodes -> vertices -> domains, and back with what the domains have then.
    void move(ParallelRegion& region, const typename NF::Motion* nodes, typename NF::Velocity* momentum,
              const Move& how) override {
        grid.inGeometry([&](auto isRound) { this->template move<isRound>(region, nodes, momentum, how); });
    }
    template <bool isRound>
    void move(ParallelRegion& region, const typename NF::Motion* nodes, typename NF::Velocity* momentum,
              const Move& how) {
        const Planes q(particles);
        isCleared_ = false;
        if (momentum) carried_.clearBack(region);
        nodes ? carried_.takeMotion(region, mesh_.vertices, nodes) : region.wait();
        pieces_.forBatches(region, mesh_, [&](const Batch<Dim>& batch, int piece) {
            const BatchWeights<Dim, isRound> d(batch, skew_);
            if (nodes) {
                const AtCorners<Dim, 2 * Dim> at(batch, carried_.template planes<2 * Dim>(Carried::motion));
                moved_[piece] += q.move(batch.first, batch.count, how, [&](int k, int p) MPM_INLINE_LAMBDA {
                    double sum = 0;
                    MPM_UNROLL
                    for (int a = 0; a < NC; ++a) sum += d.w[a][p] * at.x[a][k][p];
                    return sum;
                });
            }
            if (momentum) {
                double given[Dim + 1][Batch<Dim>::most];
                q.momenta(batch.first, batch.count, how.inertiaScale, given);
                batch.addToCorners(carried_.template planes<Dim>(Carried::back),
                                   [&](int a, int k, int p)
                                       MPM_INLINE_LAMBDA { return d.w[a][p] * given[k][p]; });
            }
        });
        if (momentum) carried_.momentumToNodes(region, mesh_.vertices, momentum);
    }

    // With the gradient comes the volume after the step: the polygon area (polyhedron volume) itself; J V0
    // differs from it by O(dt). The shapes are made anew: that takes less time than to fetch them from
    // memory.
    void takeGradient(int begin, int end, const typename NF::Velocity*, double dt) override {
        mesh_.forBatches(begin, end, [&](const Batch<Dim>& batch) {
            const auto velocity = vectorPlanes<Dim>(mesh_.vertices.velocity);
            grid.inGeometry([&](auto isRound) {
                dt > 0 ? this->template gradients<true, isRound>(batch, dt, velocity)
                       : this->template gradients<false, isRound>(batch, 0, velocity);
            });
        });
    }

    // --- besides the step ---------------------------------------------------------------------------
    // With the forces of hourglass control as a stiffness: those of the motion that the velocity of the
    // vertices holds, over unit time.
    void addForce(ParallelRegion& region, typename NF::Sum* nodes, const double* const tensor[9]) override {
        grid.inGeometry([&](auto isRound) { this->template addForce<isRound>(region, nodes, tensor); });
    }
    template <bool isRound>
    void addForce(ParallelRegion& region, typename NF::Sum* nodes, const double* const tensor[9]) {
        const Planes q(particles);
        const ActingStress stress(tensor);
        const typename HourglassControl<Dim>::DeformedPattern deformed(hourglass_, particles);
        carried_.clear(region);
        pieces_.forBatches(region, mesh_, [&](const Batch<Dim>& batch, int) {
            const BatchShapes<Dim, isRound> d(batch, mesh_.vertices.position, skew_);
            GivenByDomains<Dim, isRound> given;
            q.tension(batch.first, batch.count, stress, given.tension);
            given.takeRing(q.volume, stress, batch.first, batch.count);
            const AtCorners<Dim, Dim> V(batch, vectorPlanes<Dim>(mesh_.vertices.velocity));
            const auto add = [&](auto isPatterned) {
                if (isPatterned) given.control.take(batch, deformed);
                hourglass_.template resistRates<isPatterned>(batch, d, V, given.control);
                batch.addToCorners(carried_.template planes<Dim>(Carried::force),
                                   [&](int a, int k, int p) MPM_INLINE_LAMBDA {
                                       return given.template toCorner<isPatterned>(d, a, Carried::force + k,
                                                                                   p);
                                   });
            };
            hourglass_.isPatterned() ? add(std::true_type()) : add(std::false_type());
        });
        carried_.toNodes(region, mesh_.vertices, nodes, 1);
    }

    // By way of the vertices, like all transfers.
    void addQuantity(const double* quantity, const std::vector<int>& which, double* nodal,
                     std::vector<int>& touched) const override {
        std::vector<double> atVertex(mesh_.vertices.size(), 0.0);
        std::vector<int> with;
        for (int p : which) {
            inShape(mesh_.cornerNumbersOf(p), [&](const auto& shape) {
                for (int a = 0; a < NC; ++a)
                    Base::addTo(mesh_.corner[NC * p + a], shape.w[a] * quantity[p], atVertex.data(), with);
            });
        }
        for (int v : with)
            forNodes(v, [&](int node, double part, double S) {
                Base::addTo(node, part * atVertex[v] * S, nodal, touched);
            });
    }

    void weights(int p, const std::function<void(int, double, const Vec<Dim>&)>& each) const override {
        const Shape<Dim> shape =
            inShape(mesh_.cornerNumbersOf(p), [](const auto& closed) { return Shape<Dim>(closed); });
        for (int a = 0; a < NC; ++a)
            forNodes(mesh_.corner[NC * p + a], [&](int node, double part, double S) {
                each(node, part * shape.w[a] * S, Vec<Dim>(part * S * shape.g[a]));
            });
    }

  protected:
    using Carried = CarriedByVertices<Dim>;

    // f(shape of a domain, of its ring with axial symmetry).
    template <class F> decltype(auto) inShape(const CornerNumbers<Dim>& X, F&& f) const {
        return grid.inGeometry([&](auto isRound) { return f(DomainShape<Dim, isRound>(X)); });
    }

    // f(node, part, S) for the nodes of vertex v, or of its masters where it hangs, which take their parts of
    // it.
    template <class F> void forNodes(int v, F&& f) const {
        const typename MeshVertices<Dim>::Hat hat(mesh_.vertices);
        mesh_.vertices.hanging.through(
            v, [&](int vertex, double part) { hat(vertex, [&](int node, double S) { f(node, part, S); }); });
    }

    void find(int begin, int end) {
        mesh_.vertices.locate(begin, end,
                              [&](int from, int to, double* const x[], int* cell, double* const local[]) {
                                  return Base::support(from, to, x, 0.0, cell, local, "vertex", nullptr);
                              });
    }

    void regroup() {
        const int count = mesh_.vertices.size();
        for (int begin = 0; begin < count; begin += chunkSize)
            find(begin, std::min(count, begin + chunkSize));
        mesh_.vertices.group();
    }

    DomainMesh<Dim> mesh_;
    HourglassControl<Dim> hourglass_;
    CarriedByVertices<Dim> carried_;
    Field skew_;
    DomainPieces<Dim> pieces_;
    Beam<Dim> beam_;
    DistortedList distorted_; // found in the last takeGradient()

  private:
    const bool converts_;
    std::atomic<bool> isCleared_{false}; // whether the vertices hold nothing, since locate()

    // moves: and the volume after the step. Not asked in the loop: its stores would be masked ones, which are
    // slow.
    template <bool moves, bool isRound, class Number>
    void gradients(const Batch<Dim>& batch, double dt, const std::array<Number*, Dim>& velocityPlanes) {
        double *volume = particles.volume.plane(), *L[Dim * Dim];
        double* hoopRate = isRound ? particles.hoopRate.plane() : nullptr;
        for (int c = 0; c < Dim * Dim; ++c) L[c] = particles.velocityGradient.plane(c);
        const int first = batch.first, count = batch.count;
        const AtCorners<Dim, Dim> X(batch, vectorPlanes<Dim>(mesh_.vertices.position)),
            V(batch, velocityPlanes);
        double quality[Batch<Dim>::most];
        auto one = [&](int p) MPM_INLINE_LAMBDA {
            const DomainShape<Dim, isRound> shape(X.at(p));
            MPM_UNROLL
            for (int i = 0; i < Dim; ++i) MPM_UNROLL
            for (int j = 0; j < Dim; ++j) {
                double sum = 0;
                MPM_UNROLL
                for (int a = 0; a < NC; ++a) sum += V.x[a][i][p] * shape.g[a][j];
                L[Dim * i + j][first + p] = sum;
            }
            if constexpr (isRound) {
                double sum = 0;
                MPM_UNROLL
                for (int a = 0; a < NC; ++a) sum += V.x[a][0][p] * shape.hoop[a];
                hoopRate[first + p] = sum;
            }
            if constexpr (!moves) return;
            const auto before = X.at(p), velocity = V.at(p);
            CornerNumbers<Dim> x;
            MPM_UNROLL
            for (int k = 0; k < Dim; ++k) MPM_UNROLL
            for (int a = 0; a < NC; ++a) x[k][a] = before[k][a] + dt * velocity[k][a];
            const DomainShape<Dim, isRound> after(x);
            volume[first + p] = after.volume;
            quality[p] = qualityOf<Dim>(after, smallestCorner(after, x));
        };
        forEachSimd(count, one);
        if constexpr (moves) noteDistorted(first, count, quality);
    }

    void noteDistorted(int first, int count, const double* quality) {
        int bad = converts_;
#pragma omp simd reduction(| : bad)
        for (int p = 0; p < count; ++p) bad |= !(quality[p] > worstQuality);
        for (int p = 0; p < count && bad; ++p)
            if (!(quality[p] > worstQuality) || (converts_ && isStretched(mesh_, first + p)))
                distorted_.note({first + p, quality[p]});
    }
};

} // namespace mpm
