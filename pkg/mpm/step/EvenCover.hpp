// SPDX-License-Identifier: GPL-2.0-or-later
// Keeps boxes that flow spread evenly over the cells of the grid. Flow leaves some cells with too many
// particles and others with none, where no stress resists. With the cover of a cell
//     f_c = 1/V_c sum_p V_p (share of the box of p that is in c),   e_c = f_c - 1,
// a particle whose box lies across a face goes from the fuller cell to the other,
//     dx_k = -2 l_k min(1, rate |D| dt) (e_beyond - e_before),
// with |D| the norm of the strain rate: what does not deform stays where it is. Towards cells that are not full
// particles go inside the material alone, e_c = s_c (f_c - 1) where f_c < 1, and at a surface only from cells
// that are too full. Velocity and displacement of a particle stay, and so does the momentum. (In the manner of
// the position corrections of Baumgarte & Kamrin 2023, Int. J. Numer. Methods Eng.)
#pragma once

#include "mpm/scene/Scene.hpp"
#include "mpm/state/cover.hpp"

namespace mpm {

class EvenCover {
  public:
    // Called by one thread, before particles are located. Slabs of the grid belong to threads, and a cell sums its
    // particles in their order.
    template <int Dim> void act(Scene<Dim>& scene) {
        if (scene.step % everySteps != 0) return;
        if (std::none_of(scene.bodies.begin(), scene.bodies.end(), [](auto& body) { return moves(*body); }))
            return;
        cover_.resize(scene.grid.count);
        excess_.resize(scene.grid.count);
        extents_.resize(scene.bodies.size());
        for (size_t b = 0; b < extents_.size(); ++b)
            extents_[b].resize(chunksOf(scene.bodies[b]->particles.size()));
        std::array<Vec<Dim>, 2> reach;
        parallel(scene.threads, [&](ParallelRegion& region) {
            for (size_t b = 0; b < extents_.size(); ++b)
                region.chunksNoWait(scene.bodies[b]->particles.size(), [&](int begin, int end) {
                    extents_[b][begin / chunkSize] = extentOf(scene.grid, *scene.bodies[b], begin, end);
                });
            region.wait();
            region.once([&] {
                reach = reachOf(scene);
                divide(scene.grid.slabs());
            });
            region.forOwnRange(slabs_, [&](int first, int end) { findCover(scene, reach, first, end); });
            region.forOwnRange(slabs_, [&](int first, int end) { findExcess(scene.grid, first, end); });
            for (auto& body : scene.bodies)
                if (moves(*body))
                    region.chunksNoWait(body->particles.size(), [&](int begin, int end) {
                        shift(*body, scene.grid, everySteps * scene.dt, begin, end);
                    });
        });
    }

  private:
    static constexpr int everySteps =
        10;                           // by the Courant limit, particles move a small part of a cell meanwhile
    static constexpr double rate = 3; // share of the excess that goes per unit of strain

    template <int Dim> static bool moves(const Body<Dim>& body) { return body.fbar && body.domains->boxes(); }

    // Of a chunk of particles: where they are, and the slabs that their boxes may reach.
    struct Extent {
        double low[3], high[3]; // m
        int firstSlab, lastSlab;
    };
    template <int Dim>
    static Extent extentOf(const Grid<Dim>& grid, const Body<Dim>& body, int begin, int end) {
        Extent extent;
        for (int k = 0; k < Dim; ++k) {
            const double* x = body.particles.position.plane(k);
            const auto [least, most] = std::minmax_element(x + begin, x + end);
            extent.low[k] = *least;
            extent.high[k] = *most;
        }
        const auto slab = [&](double x, int beyond) { // no box is larger than a cell
            return int(std::min(std::max(0.0, grid.inCells(x, Dim - 1) + beyond), grid.slabs() - 1.0));
        };
        extent.firstSlab = slab(extent.low[Dim - 1], -1);
        extent.lastSlab = slab(extent.high[Dim - 1], 1);
        return extent;
    }
    // The slabs among the threads.
    void divide(int slabs) {
        std::vector<int> inSlab(slabs, 0);
        for (const auto& chunks : extents_)
            for (const Extent& chunk : chunks) ++inSlab[(chunk.firstSlab + chunk.lastSlab) / 2];
        slabs_.set(slabs, [&](int slab) { return inSlab[slab]; });
    }

    // What is outside of this box does not cover the cells that count: those that particles which move reach, and
    // those beside them.
    template <int Dim> std::array<Vec<Dim>, 2> reachOf(const Scene<Dim>& scene) const {
        constexpr int cells = 3;
        const auto& grid = scene.grid;
        Vec<Dim> low = grid.upper, high = grid.lower;
        for (size_t b = 0; b < extents_.size(); ++b)
            for (const Extent& chunk : extents_[b])
                for (int k = 0; k < Dim && moves(*scene.bodies[b]); ++k) {
                    low[k] = std::min(low[k], chunk.low[k]);
                    high[k] = std::max(high[k], chunk.high[k]);
                }
        for (int k = 0; k < Dim; ++k) {
            const auto line = [&](double x, int beyond) {
                return grid.line(k, std::clamp(int(grid.inCells(x, k)) + beyond, 0, grid.nodes[k] - 1));
            };
            low[k] = line(low[k], -cells);
            high[k] = line(high[k], 1 + cells);
        }
        return {low, high};
    }

    // A box of half size `half` around x: the lowest cell that it reaches, and its shares before and beyond the
    // face above that cell.
    template <int Dim> struct Shares {
        int cell = 0;
        double share[Dim][2];

        Shares(const Grid<Dim>& grid, const Vec<Dim>& x, const Vec<Dim>& half) {
            for (int k = 0; k < Dim; ++k) {
                const double l = half[k] / grid.smallestCell()[k], last = grid.nodes[k] - 2.0;
                const double from =
                    grid.isGraded() ? grid.inCells(x[k] - half[k], k) : grid.inCells(x[k], k) - l;
                const double low = std::min(std::max(0.0, from), last), face = std::floor(low) + 1;
                const double beyond = grid.isGraded()
                                          ? (x[k] + half[k] - grid.line(k, int(face))) / (2 * half[k])
                                          : (low + 2 * l - face) / (2 * l);
                share[k][1] = std::clamp(beyond, 0.0, 1.0);
                if (k == 0 && grid.isAxisymmetric && x[0] > half[0]) // the outer part is the longer ring
                    share[0][1] *= 1 + (1 - share[0][1]) * half[0] / x[0];
                share[k][0] = 1 - share[k][1];
                cell += (int(face) - 1) * grid.strides[k];
            }
        }
        // f(cell, share) with that across the axes other than `without`.
        template <class F> void each(const Grid<Dim>& grid, int without, F&& f) const {
            for (int n = 0; n < corners<Dim>; ++n) {
                int number = cell;
                double part = 1;
                for (int k = 0; k < Dim; ++k) {
                    number += (n >> k & 1) * grid.strides[k];
                    if (k != without) part *= share[k][n >> k & 1];
                }
                if (part > 0) f(number, part, without >= 0 && (n >> without & 1));
            }
        }
    };

    // In slabs [first, end); of all bodies, whatever their velocity: a cell that a pile fills is no room for soil.
    template <int Dim>
    void findCover(const Scene<Dim>& scene, const std::array<Vec<Dim>, 2>& reach, int first, int end) {
        const int size = scene.grid.strides[Dim - 1];
        std::fill_n(cover_.begin() + first * size, (end - first) * size, 0.0);
        for (size_t b = 0; b < extents_.size(); ++b)
            for (int c = 0; c < int(extents_[b].size()); ++c)
                if (extents_[b][c].lastSlab >= first && extents_[b][c].firstSlab < end)
                    addCover(scene.grid, *scene.bodies[b], c * chunkSize, reach, first * size, end * size);
        for (int c = first * size; c < end * size; ++c)
            if (cover_[c] != 0) cover_[c] /= scene.grid.volume(c);
    }

    // Of the particles of a chunk in cells [first, end).
    template <int Dim>
    void addCover(const Grid<Dim>& grid, const Body<Dim>& body, int begin,
                  const std::array<Vec<Dim>, 2>& reach, int first, int end) {
        const auto* boxes = body.domains->boxes();
        for (int p = begin; p < std::min(begin + chunkSize, body.particles.size()); ++p) {
            const double volume = body.particles.volume.plane()[p];
            const Vec<Dim> x = vectorAt<Dim>(body.particles.position, p);
            if (!((x - reach[0]).array() >= 0).all() || !((reach[1] - x).array() >= 0).all()) continue;
            // A domain of a mesh stands for a box of its volume.
            const double size = volume / std::max(grid.thicknessAt(x[0]), 1e-9);
            const Vec<Dim> half =
                boxes ? boxes->halfSize()
                      : Vec<Dim>(Vec<Dim>::Constant(0.5 * (Dim == 2 ? std::sqrt(size) : std::cbrt(size)))
                                     .cwiseMin(0.5 * grid.sizeAt(x)));
            Shares<Dim>(grid, x, half).each(grid, -1, [&](int c, double part, bool) {
                if (c >= first && c < end) cover_[c] += part * volume;
            });
        }
    }

    // In slabs [first, end).
    template <int Dim> void findExcess(const Grid<Dim>& grid, int first, int end) {
        const int size = grid.strides[Dim - 1];
        for (int c = first * size; c < end * size; ++c) {
            const double excess = cover_[c] - 1;
            excess_[c] = cover_[c] == 0 ? 0
                         : excess > 0   ? excess
                                        : excess * insideBy(grid, c, [&](int n) { return cover_[n]; });
        }
    }

    // Of particles [begin, end).
    template <int Dim>
    void shift(Body<Dim>& body, const Grid<Dim>& grid, double time, int begin, int end) const {
        auto& particles = body.particles;
        const Vec<Dim> half = body.domains->boxes()->halfSize();
        for (int p = begin; p < end; ++p) {
            Mat<Dim> L;
            for (int i = 0; i < Dim; ++i)
                for (int j = 0; j < Dim; ++j) L(i, j) = particles.velocityGradient.plane(Dim * i + j)[p];
            const double part = std::min(1.0, rate * time * (0.5 * (L + L.transpose())).norm());
            if (!(part > 0)) continue;
            const Vec<Dim> x = vectorAt<Dim>(particles.position, p);
            const Shares<Dim> box(grid, x, half);
            Vec<Dim> by = Vec<Dim>::Zero();
            for (int k = 0; k < Dim; ++k) {
                if (box.share[k][1] == 0) continue; // in one cell
                double rise = 0;
                box.each(grid, k,
                         [&](int c, double w, bool isBeyond) { rise += (isBeyond ? w : -w) * excess_[c]; });
                by[k] = -2 * half[k] * part * std::clamp(rise, -1.0, 1.0);
                // Boxes stay on this side of the walls of the grid.
                if (by[k] < 0) by[k] = std::min(0.0, std::max(by[k], grid.lower[k] + half[k] - x[k]));
                if (by[k] > 0) by[k] = std::max(0.0, std::min(by[k], grid.upper[k] - half[k] - x[k]));
            }
            for (int k = 0; k < Dim; ++k) {
                particles.position.plane(k)[p] += by[k];
                particles.reference.plane(k)[p] += by[k];
            }
        }
    }

    std::vector<std::vector<Extent>> extents_; // of the chunks of each body
    WorkPartition slabs_;
    std::vector<double> cover_, excess_; // of each cell: f; f - 1 or what counts of it
};

} // namespace mpm
