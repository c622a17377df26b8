// SPDX-License-Identifier: GPL-2.0-or-later
// The boxes of one group of bodies near the nodes on which it is in contact with another, by their nearest
// node, and their surface as a node sees it.
#pragma once

#include "mpm/contact/ExplicitSurface.hpp"
#include "mpm/contact/HatIntegrals.hpp"
#include "mpm/scene/Scene.hpp"
#include "mpm/state/Bins.hpp"

namespace mpm {

template <int Dim> class NearbyBoxes {
  public:
    bool isEmpty() const { return found_.empty(); }

    // haveSide: only those that have a side of a wall, see PartedSoils.
    void find(const Scene<Dim>& scene, int field, const NearbyNodes<Dim>& nearby, bool haveSide = false) {
        haveSide_ = haveSide;
        found_.clear();
        bin_.clear();
        for (auto& body : scene.bodies)
            if (field >= 0 && body->velocityField == scene.groupOf[field] &&
                !ExplicitSurface<Dim>::isOf(*body))
                findOf(*body, body->velocityField != field, scene.grid, nearby);
        bins_.fill(nearby.size(), bin_);
        sort();
    }

    // Adds to a surface: int over it of phi n = int grad phi dV,  of phi d n^T = int (d grad phi^T + phi I)
    // dV; for each box products of integrals along the axes.
    void addTo(NodalSurface<Dim>& surface, const Grid<Dim>& grid, const NearbyNodes<Dim>& nearby, int node,
               const Vec<Dim>& x) const {
        FourBoxes outward[Dim], moment[Dim][Dim];
        for (int n = 0; n < Dim; ++n) {
            outward[n].setZero();
            for (int m = 0; m < Dim; ++m) moment[m][n].setZero();
        }
        const Vec<Dim> perCell = grid.smallestCell().cwiseInverse();
        const Index<Dim> index = grid.indices(node);
        const bool isEven = grid.isEven(index);
        const auto beside = [&](int k, int step) { return grid.cellSize(k, index[k] + step) * perCell[k]; };
        forRows(grid, nearby, node, [&](int begin, int end) {
            for (int b = begin; b < end; b += atOnce) {
                const auto at = [&](const std::vector<double>& values) {
                    return FourBoxes::Map(values.data() + b);
                };
                HatIntegrals phi[Dim];
                MPM_UNROLL
                for (int k = 0; k < Dim; ++k)
                    phi[k] = isEven ? HatIntegrals((at(centre_[k]) - x[k]) * perCell[k], at(half_[k]))
                                    : HatIntegrals((at(centre_[k]) - x[k]) * perCell[k], at(half_[k]),
                                                   beside(k, -1), beside(k, 0));
                FourBoxes density = at(density_);
                for (int rest = end - b; rest < atOnce; ++rest) density[rest] = 0;
                const auto product = [&](auto&& factor) {
                    FourBoxes all = density;
                    MPM_UNROLL
                    for (int k = 0; k < Dim; ++k) all *= factor(phi[k], k);
                    return all;
                };
                MPM_UNROLL
                for (int n = 0; n < Dim; ++n) {
                    outward[n] +=
                        product([&](auto& phi, int k) -> auto& { return k == n ? phi.slope : phi.N; });
                    MPM_UNROLL
                    for (int m = 0; m < Dim; ++m)
                        moment[m][n] += product([&](auto& phi, int k) -> auto& {
                            return k == n ? (k == m ? phi.slopeOfFirst : phi.slope)
                                          : (k == m ? phi.first : phi.N);
                        });
                }
            }
        });
        for (int n = 0; n < Dim; ++n) {
            surface.outward[n] += outward[n].sum() * perCell[n];
            for (int m = 0; m < Dim; ++m)
                surface.moment(m, n) += moment[m][n].sum() * grid.smallestCell()[m] * perCell[n];
        }
    }

    // How far the centres near a node at x reach along n that have crossed a plane there; -farAway: there are
    // none. Only those within half a cell of size h behind the plane count: what is deeper belongs to the
    // other side. And only those within sqrt(1/2) h of the normal through the node: the plane is that of the
    // vertex nearest to this normal.
    double crossed(const Grid<Dim>& grid, const NearbyNodes<Dim>& nearby, int node, const Vec<Dim>& x,
                   const Vec<Dim>& n, double plane, double h) const {
        const double deepest = 0.5 * h;
        const double widest = 0.5 * h * h; // m2
        double furthest = -farAway;
        forRows(grid, nearby, node, [&](int begin, int end) {
#pragma omp simd reduction(max : furthest)
            for (int b = begin; b < end; ++b) {
                double along = 0, square = 0;
                MPM_UNROLL
                for (int k = 0; k < Dim; ++k) {
                    const double d = centre_[k][b] - x[k];
                    along += n[k] * d;
                    square += d * d;
                }
                const double overlap = along - plane;
                const double beside = square - along * along;
                const double reach =
                    ((overlap >= 0) & (overlap <= deepest) & (beside <= widest)) ? along : -farAway;
                furthest = furthest > reach ? furthest : reach;
            }
        });
        return furthest;
    }

  private:
    static constexpr int atOnce = 4; // boxes, see FourBoxes
    bool haveSide_ = false;

    struct Box {
        Vec<Dim> centre, half;
        double density;
    };
    std::vector<Box> found_;                      // in the order of the particles,
    std::vector<int> bin_;                        // number of the nearest node of each,
    Bins bins_;                                   // and by that number:
    std::vector<double> centre_[Dim], half_[Dim]; // m; smallest cells
    std::vector<double> density_;                 // volume, m3, over that of the box in cells

    // Looks at those of blocks that may have some: the lowest nodes of boxes are at most `wander` nodes away
    // from their block.
    void findOf(const Body<Dim>& body, bool ofSecond, const Grid<Dim>& grid, const NearbyNodes<Dim>& nearby) {
        const std::vector<char>& isSecond = body.domains->boxes()->seconds();
        if (ofSecond && isSecond.empty()) return;
        const auto isFar = [&](int block) {
            const Index<Dim> begin = grid.blockBegin(block);
            bool far = false;
            for (int k = 1; k < Dim; ++k)
                far |= begin[k] + grid.blockWidth < grid.inCells(nearby.lower[k], k) - grid.wander - 1 ||
                       begin[k] > grid.inCells(nearby.upper[k], k) + grid.wander + 1;
            return far;
        };
        const Field& position = body.particles.position;
        const double* V = body.particles.volume.plane();
        const Vec<Dim> half = body.domains->boxes()->halfSize().cwiseQuotient(grid.smallestCell());
        const double size = (2 * half).prod();
        const BlockOrder<Dim>& order = body.domains->order;
        for (int block = 0; block < order.blocks(); ++block) {
            if (isFar(block)) continue;
            for (int begin = order.start[block]; begin < order.start[block + 1]; begin += chunkSize) {
                const int count = std::min(chunkSize, order.start[block + 1] - begin);
                int node[chunkSize];
                nearestNodes(grid, position, begin, count, node);
                for (int i = 0; i < count; ++i) {
                    const int near = nearby.number(node[i]);
                    if (near < 0 || (!isSecond.empty() && isSecond[begin + i] != ofSecond)) continue;
                    if (haveSide_ && !(body.particles.side.plane()[begin + i] > 0)) continue;
                    const Vec<Dim> x = vectorAt<Dim>(position, begin + i);
                    const double thickness = std::max(grid.thicknessAt(x[0]), 1e-9); // m
                    found_.push_back({x, half, V[begin + i] / (thickness * size)});
                    bin_.push_back(near);
                }
            }
        }
    }

    void sort() {
        const size_t room =
            found_.size() + atOnce - 1; // the last ones are looked at together with what follows
        for (int k = 0; k < Dim; ++k) {
            centre_[k].resize(room);
            half_[k].resize(room);
        }
        density_.resize(room);
        for (int b = 0; b < bins_.count(); ++b) {
            const Box& box = found_[bins_.point(b)];
            for (int k = 0; k < Dim; ++k) {
                centre_[k][b] = box.centre[k];
                half_[k][b] = box.half[k];
            }
            density_[b] = box.density;
        }
    }

    // f(begin, end) for the boxes whose nearest node is this one, or next to it.
    template <class F>
    void forRows(const Grid<Dim>& grid, const NearbyNodes<Dim>& nearby, int node, F&& f) const {
        forNeighbours(grid, node, [&](int near, const Index<Dim>& step) {
            const int first = nearby.number(near); // rows of three nodes follow each other
            if (step[0] < 0) f(bins_.begin(first), bins_.end(first + 2));
        });
    }
};

} // namespace mpm
