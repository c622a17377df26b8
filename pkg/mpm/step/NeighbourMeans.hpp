// SPDX-License-Identifier: GPL-2.0-or-later
// Softening by the plastic strain of the neighbours (NeighbourMean of a law): what softens a particle gains
//     (1 - m) e_p + m <e>_p,   <e>_p = int w e dV / int w dV,   w = exp(-r^2/l^2),   m = 2
// where e_p is the gain of its own plastic strain in the step. m > 1 is what gives bands of shear a width of their own
// (Bazant & Jirasek 2002, J. Eng. Mech. 128, 1119-1149; Galavi & Schweiger 2010, Int. J. Geomech. 10, 30-44).
//
// The mean takes three steps: particles give V e and V to the nodes of their cell by the hat function, w acts on the
// nodes axis by axis, and particles take the ratio by the hat function. The two hats have the variance h^2/3 along each
// axis, so w has what is left of l^2/2. Where nothing is left, of cells longer than 1.2 l, the mean counts with the part
// l^2/2 over h^2/3: the variance stays that of l, and the law becomes local as l goes to 0.
#pragma once

#include "mpm/scene/Scene.hpp"
#include "mpm/step/NodeSmoothing.hpp"

namespace mpm {

template <int Dim> class NeighbourMeans {
  public:
    // Finds the bodies of each law, one thread. Bodies with one velocity field and one law are neighbours.
    void start(const Scene<Dim>& scene) {
        const int bodies = int(scene.bodies.size());
        cells_.resize(bodies);
        gains_.resize(bodies);
        size_t count = 0;
        for (int b = 0; b < bodies; ++b) {
            const Body<Dim>& body = *scene.bodies[b];
            const NeighbourMean of = body.material->neighbourMean();
            gains_[b].resize(of.length > 0 ? body.particles.size() : 0);
            if (of.length == 0 || body.particles.size() == 0) continue;
            size_t own = 0;
            while (own < count &&
                   !(groups_[own].law == body.material.get() && groups_[own].field == body.velocityField))
                ++own;
            if (own == count) begin(count++, scene, body, of);
            groups_[own].bodies.push_back(b);
        }
        groups_.resize(count);
    }
    // The strain of particles [begin, end) of a body, before its stress is updated.
    void keep(int number, const Body<Dim>& body, int begin, int end) {
        if (gains_[number].empty()) return;
        const double* strain = body.particles.state[body.material->neighbourMean().strain].plane();
        std::copy(strain + begin, strain + end, gains_[number].begin() + begin);
    }
    // Adds the mean; called by all threads.
    void take(ParallelRegion& region, Scene<Dim>& scene) {
        for (Group& group : groups_) {
            region.wait();
            for (int b : group.bodies) findGains(region, scene, group, b);
            region.once([&] { group.extent = Extent(); });
            for (int b : group.bodies) sumInCells(region, scene, group, b);
            region.once([&] {
                for (auto& extent : group.extents) group.extent.include(std::exchange(extent, Extent()));
            });
            group.smoothing.smooth(region, group.extent);
            for (int b : group.bodies) give(region, scene, group, b);
        }
    }

  private:
    using Extent = typename NodalField<Dim>::Extent;
    static constexpr double overshoot = 2; // m

    struct Group {
        const Material* law = nullptr;
        int field = 0;
        NeighbourMean of;
        std::vector<int> bodies;
        std::vector<Extent> extents; // of the nodes of the particles in each slab of cells; of all
        Extent extent;
        NodeSmoothing<Dim> smoothing;
    };

    void begin(size_t number, const Scene<Dim>& scene, const Body<Dim>& body, const NeighbourMean& of) {
        if (groups_.size() <= number) groups_.emplace_back();
        Group& group = groups_[number];
        group.law = body.material.get();
        group.field = body.velocityField;
        group.of = of;
        group.bodies.clear();
        group.extents.resize(scene.grid.slabs());
        group.smoothing.start(scene.grid, of.length);
    }

    void findGains(ParallelRegion& region, Scene<Dim>& scene, const Group& group, int b) {
        auto& particles = scene.bodies[b]->particles;
        region.once([&] { cells_[b].start(particles, scene.grid, false, nullptr); });
        cells_[b].locate(region, scene.grid);
        const double* strain = particles.state[group.of.strain].plane();
        region.chunks(particles.size(), [&](int begin, int end) {
            for (int p = begin; p < end; ++p) gains_[b][p] = strain[p] - gains_[b][p];
        });
    }
    void sumInCells(ParallelRegion& region, Scene<Dim>& scene, Group& group, int b) {
        const auto& particles = scene.bodies[b]->particles;
        const double* volume = particles.volume.plane();
        cells_[b].forOwn(region, [&](int firstSlab, int endSlab) {
            for (int slab = firstSlab; slab < endSlab; ++slab)
                for (int cell : cells_[b].occupied(slab)) {
                    const Index<Dim> lowest = scene.grid.indices(cell);
                    Extent extent;
                    extent.first = extent.last = lowest;
                    for (int k = 0; k < Dim; ++k) ++extent.last[k];
                    group.extents[slab].include(extent);
                    double sums[2][corners<Dim>] = {};
                    cells_[b].forPoints(cell, [&](int, int p) {
                        double hat[corners<Dim>];
                        hats(scene.grid, particles, lowest, p, hat);
                        for (int a = 0; a < corners<Dim>; ++a) {
                            sums[0][a] += hat[a] * volume[p];
                            sums[1][a] += hat[a] * volume[p] * gains_[b][p];
                        }
                    });
                    group.smoothing.add(cell, sums);
                }
        });
    }
    void give(ParallelRegion& region, Scene<Dim>& scene, const Group& group, int b) {
        auto& particles = scene.bodies[b]->particles;
        double* mean = particles.state[group.of.mean].plane();
        const double variance = group.of.length * group.of.length / 2;
        region.chunks(particles.size(), [&](int begin, int end) {
            for (int p = begin; p < end; ++p) {
                const int cell = cells_[b][p];
                double hat[corners<Dim>], sum = 0;
                hats(scene.grid, particles, scene.grid.indices(cell), p, hat);
                for (int a = 0; a < corners<Dim>; ++a) sum += hat[a] * group.smoothing.mean(cell, a);
                const double edge = scene.grid.edges(cell).maxCoeff();
                mean[p] += overshoot * std::min(1.0, variance / (edge * edge / 3)) * (sum - gains_[b][p]);
            }
        });
    }
    // Values of the hat functions of the corners of a cell, at a particle in it.
    static void hats(const Grid<Dim>& grid, const Particles<Dim>& particles, const Index<Dim>& lowest, int p,
                     double* hat) {
        hat[0] = 1;
        for (int k = 0; k < Dim; ++k) {
            const double t =
                std::clamp(grid.inCells(particles.position.plane(k)[p], k) - lowest[k], 0.0, 1.0);
            for (int a = 0; a < 1 << k; ++a) {
                hat[a + (1 << k)] = t * hat[a];
                hat[a] *= 1 - t;
            }
        }
    }

    std::vector<Group> groups_;
    std::vector<ParticleCells<Dim>> cells_;  // of each body
    std::vector<std::vector<double>> gains_; // of each of its particles in the step; of bodies without, empty
};

} // namespace mpm
