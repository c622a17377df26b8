// SPDX-License-Identifier: GPL-2.0-or-later
// F-bar: one increment of volumetric strain per cell of the grid and body, and one mean stress that is linear in it
// (de Souza Neto et al. 1996; for MPM Coombs et al. 2018); equations and reasons: doc/theory/volumes.md.
//     r_c = uneven [s (V_c' - V_c)/(V_c dt) + (1 - s) sum V_p r_p / sum V_p],   r_p = (det(I + dt L_p) - 1)/dt
// with s = Cell::inside and V_c' the volume between the corners of the cell as they move, for boxes and for meshes that
// move with boxes. Meshes by themselves tile the space and have s = 0. The mean stress acts by the cell, see
// step/CellForces.hpp; empty cells give their flux away, see Holes.
//
// Which particles are in a cell, and s, are those of the start of the step, for rates and forces alike: the elastic
// operator is symmetric only if both have the same.
#pragma once

#include "mpm/particle/apdi/RingShape.hpp"
#include "mpm/scene/AveragedCell.hpp"
#include "mpm/scene/Holes.hpp"
#include "mpm/scene/MeanOfStress.hpp"
#include "mpm/scene/ParticleCells.hpp"
#include "mpm/state/cover.hpp"

#include <numeric>

namespace mpm {

template <int Dim> class CellAverage {
  public:
    using Cell = AveragedCell<Dim>;

    // Which particles are in which cell, see ParticleCells, and their volume and mean stress; called by all threads, and
    // so is all that takes a region.
    // mesh: of domains, nullptr: boxes; isAmongBoxes: they fill cells together with boxes, and act by the cells if none
    // was made larger than a cell. (Nodes between the vertices of larger ones have no mass.) half: of the edge of boxes
    // along the first axis, m.
    void locate(ParallelRegion& region, const Particles<Dim>& particles, const Grid<Dim>& grid,
                Mesh<Dim>* mesh, bool isAmongBoxes, double half, const SecondCells& second) {
        region.once([&] {
            isMesh_ = mesh;
            half_ = half;
            if (mesh && isAmongBoxes && measured_ != particles.size()) {
                measured_ = particles.size();
                fitInCells_ = fitInCells(particles, grid, *mesh);
            }
            actByCells_ = !mesh || (isAmongBoxes && fitInCells_);
            where_.start(particles, grid, !actByCells_, actByCells_ ? mesh : nullptr, second);
            isParted_ = second.isParted;
            resize(grid, second.isSecond ? 2 : 1);
        });
        where_.locate(region, grid);
        forOwn(region, [&](int firstSlab, int endSlab) {
            for (int slab = firstSlab; slab < endSlab; ++slab)
                if (!where_.hasKept(slab)) enter(grid, slab);
        });
        const MeanOfStress<Dim> mean(particles.stress, grid);
        average<false>(region, particles.volume.plane(), mean, [&](int c, Cell& cell, const MeanInCell& of) {
            cell.take(of);
            cell.volume = cell.weight;
            cell.inside = cell.shared = cell.taken = 0;
            cell.uneven = 1;
            cover_[c] = cell.volume / cell.whole;
        });
    }
    // How far each cell lies inside the material, and what share of it is this body's. others: located bodies that
    // move with this one. isFree(cell): no body that does not is in it. mayOpen: the material may stand open, and
    // fill less than its volume. lackMass(cells): those with a corner without mass, which would take force that
    // nothing feels: they leave all to their particles.
    template <class IsFree, class LackMass>
    void findInside(ParallelRegion& region, const Grid<Dim>& grid, const std::vector<CellAverage*>& others,
                    bool mayOpen, IsFree&& isFree, LackMass&& lackMass) {
        addUp(region, others);
        const auto cover = [&](int c) { return total_[c]; };
        const std::vector<int> around = stepsAround(grid);
        const auto isAmongMeshes = [&](int c) { // whose few points do not tell how full a cell is
            return isMesh_ || std::any_of(others.begin(), others.end(), [&](const CellAverage* other) {
                       return other->isMesh_ && std::any_of(around.begin(), around.end(), [&](int step) {
                                  return other->coverOf(c + step) > 0;
                              });
                   });
        };
        forOwnCells(region, [&](int c, Cell& cell) {
            const int at = inGrid(c);
            double least = total_[at], sum = 0; // ghosts round the grid are empty
            for (int step : around) {
                least = std::min(least, total_[at + step]);
                sum += total_[at + step];
            }
            cell.share = cover_[c] / total_[at];
            cell.inside = least >= insideFrom ? 1 : insideBy(grid, at, cover);
            cell.uneven = mayOpen || isAmongMeshes(at) ? 1 : unevenness(cell, sum / double(around.size()));
            if (isMesh_ && cell.inside > 0 && total_[at] < coveredByVertices)
                sparse_[where_.slabOf(c)].push_back(c);
            if (!mayOpen && least == 0) holes_.look(grid, at, where_.slabOf(c), cover);
        });
        region.once([&] {
            for (const auto& hole : holes_) actByCell(hole.cell, Vec<Dim>::Zero()); // those of the last step
            holes_.gather(grid, cover, [&](int c) { return cover_[c]; }, isFree, lackMass);
            for (const auto& hole : holes_) extents_[where_.slabOf(hole.cell)].include(only(grid, hole.cell));
            for (int c : lackMass(takeAll(sparse_))) leaveToParticles(cells_[c]);
        });
    }
    // Whether rates and mean stress act by the cells: of boxes, and of meshes that fill cells together with boxes.
    bool actByCells() const { return actByCells_; }
    // Whether locate() was called in this step; update() is the last to ask.
    bool isLocated(int particles) const { return where_.areLocated(particles); }
    void forget() { where_.forget(); }

    // of[p] = f(point, p) for the particles in cell c; for a particle in several cells, after collect() of its chunk, the
    // mean of what its points are given.
    template <class F> void give(int c, double* of, F&& f) {
        double* to = given_.empty() ? of : given_.data();
        forPoints(c, [&](int point, int p) { to[point] = f(point, p); });
    }
    void collect(int begin, int end, double* of) {
        if (given_.empty()) return;
        for (int p = begin; p < end; ++p) {
            const double* first = &given_[where_.points().at(p)];
            const int per = where_.points().per(p);
            of[p] = std::accumulate(first, first + per, 0.0) / per;
        }
    }
    // Whether the particles from `begin` on, a chunk, are one in each cell, and those in the cells beside, too: none
    // of them takes or gives anything. Known for domains of meshes only.
    bool areAlone(int begin) const { return where_.areAlone(begin); }
    // The cell of a number, where particles are in it; nullptr: none are.
    Cell* occupied(int number) { return where_.has(number) ? &cells_[number] : nullptr; }
    // Volume of the particles in a cell over its own; what is alone in it fills it, more or less.
    double coverOf(int number) const {
        const double cover = cover_[number] + (isParted_ ? cover_[number + count_] : 0);
        return cover > 0 ? cover : where_.hasLone(number);
    }
    const Cell* occupied(int number) const { return const_cast<CellAverage*>(this)->occupied(number); }
    // f(number, cell) for all cells with particles.
    template <class F> void forEach(ParallelRegion& region, F&& f) { forOwnCells(region, f); }
    // f(particle, number of its cell) for the points in the slabs of two cells or between, in their order. One thread.
    template <class F> void forCells(int lowest, int highest, F&& f) const {
        where_.forEach(where_.slabOf(lowest), where_.slabOf(highest) + 1,
                       [&](int, int p, int cell) { f(p, cell); });
    }

    // Means of of(p), weighted with a volume of each particle; withCentres: also the centre of the particles.
    // finish(number, cell, mean) for each cell. What is alone is left out.
    template <bool withCentres, class Of, class Finish>
    void average(ParallelRegion& region, const double* volume, Of&& of, Finish&& finish) {
        const auto& points = where_.points();
        forOwnCells(region, [&](int c, Cell& cell) {
            double weight = 0, sum = 0, centre[Dim] = {};
            forPoints(c, [&](int point, int p) {
                const double V = volume[p] * points.partPer(p);
                weight += V;
                sum += V * of(p);
                for (int k = 0; k < Dim && withCentres; ++k) centre[k] += V * points.position(p, point, k);
            });
            for (int k = 0; k < Dim && withCentres; ++k) cell.centre[k] = centre[k] / weight;
            finish(c, cell, MeanInCell{weight, sum / weight});
        });
    }

    // change[p]: what makes the mean stress of particle p, now stress[p], linear in the cells. Its slope is along each
    // axis the mean of those to both neighbours, at most twice the smaller one (the monotonised central difference of
    // van Leer 1977). Zero at an extremum and where a neighbour is empty.
    void giveLinear(ParallelRegion& region, const Grid<Dim>& grid, const double* stress, double* change) {
        forOwnCells(region, [&](int c, const Cell& cell) {
            double slopes[Dim];
            for (int k = 0; k < Dim; ++k)
                slopes[k] = slope(c, beside(c, -grid.strides[k]), beside(c, grid.strides[k]), k);
            give(c, change, [&](int point, int p) {
                double gain = cell.stress - stress[p];
                for (int k = 0; k < Dim; ++k)
                    gain += slopes[k] * (where_.points().position(p, point, k) - cell.centre[k]);
                return gain;
            });
        });
    }

    // (V' - V_c)/(V_c dt), V' the volume between the corners of a cell after they moved for dt.
    template <class Velocity>
    double growth(const Grid<Dim>& grid, const Velocity* nodes, double dt, int number,
                  const Vec<Dim>& edges) const {
        CornerNumbers<Dim> x;
        for (int a = 0; a < corners<Dim>; ++a) {
            const int node = cornerOf(grid, number, a);
            for (int k = 0; k < Dim; ++k)
                x[k][a] = 0.5 * cornerSign(a, k) + dt * nodes[node][k] / edges[k]; // in cells
        }
        return (grown(grid, inGrid(number), x, half_) - 1) / dt;
    }
    // V'/V_c of a cell with its corners at x, in cells from its middle. half: see Grid::ringMoment().
    static double grown(const Grid<Dim>& grid, int number, CornerNumbers<Dim>& x, double half) {
        if constexpr (Dim == 2)
            if (grid.isAxisymmetric) {
                const double middle = grid.centre(grid.indices(number))[0] / grid.edges(number)[0];
                for (double& r : x[0]) r += middle;
                return RingShape::volumeOf(x, grid.ringMoment(number, half)) / (2 * M_PI * std::abs(middle));
            }
        return ClosedShape<Dim>(x).volume;
    }

    // Rate of volume change of the particles in a cell, from that of the cell and their own mean, 1/s.
    static double rateOf(const Cell& cell, double ofCell, double ofParticles) {
        const double holes = cell.taken == 0 ? 0 : cell.taken / acting(cell, cell.share * cell.whole);
        return cell.uneven * (cell.inside * ofCell + (1 - cell.inside) * ofParticles + holes);
    }
    // Volume that the mean stress of a cell acts with, m3, where `whole` is the volume of the cell that is its own.
    static double acting(const Cell& cell, double whole) {
        return cell.inside * whole + (1 - cell.inside) * cell.weight;
    }

    // Holes give their flux to the cells beside them, which act on the corners of the hole, but for shared cells.
    template <class Velocity>
    void takeFromHoles(ParallelRegion& region, const Grid<Dim>& grid, const Velocity* nodes, double dt) {
        if (holes_.empty()) return;
        region.once([&] {
            for (const auto& hole : holes_) {
                const double flux = hole.volume * growth(grid, nodes, dt, hole.cell, grid.edges(hole.cell));
                forTakers(hole, [&](Cell& cell, double part) { cell.taken += part * flux; });
            }
        });
    }
    void actByHoles(ParallelRegion& region, const Grid<Dim>& grid) {
        if (holes_.empty()) return;
        region.once([&] {
            for (const auto& hole : holes_) {
                double acting = 0;
                forTakers(hole, [&](Cell& cell, double part) { acting += part * hole.volume * cell.stress; });
                actByCell(hole.cell, acting * grid.edges(hole.cell).cwiseInverse());
            }
        });
    }

    // What of the mean of a cell acts by the cell, times its face across each axis.
    void actByCell(int number, const Vec<Dim>& acting) {
        for (int k = 0; k < Dim; ++k) acting_[k][number] = acting[k];
    }
    // f(node, -sum_c acting_c grad phi_ic) for the nodes around cells with particles, grad phi_ic the mean of the
    // gradient of the hat function over the cell.
    template <class F> void forForces(ParallelRegion& region, const Grid<Dim>& grid, F&& f) const {
        forOwn(region, [&](int firstSlab, int endSlab) {
            for (int slab = firstSlab; slab < endSlab; ++slab) {
                Extent extent = extents_[slab];
                if (slab > 0) extent.include(extents_[slab - 1]);
                for (int k = 0; k < Dim - 1; ++k) ++extent.last[k];
                grid.inGeometry([&](auto isRound) {
                    grid.forNodes(extent, slab,
                                  [&](int node) { f(node, this->template force<isRound>(grid, node)); });
                });
            }
        });
    }

  private:
    using Extent = typename NodalField<Dim>::Extent;

    static constexpr double flexibility = 2; // most that an uneven cover changes a rate of volume change by
    static constexpr double sparse = 0.8, dense = 0.9; // mean covers round a cell: it does not count, it does
    // Cover of a cell from which on domains that fit in cells have vertices near all of its corners.
    static constexpr double coveredByVertices = 0.8;

    void resize(const Grid<Dim>& grid, int halves) {
        count_ = grid.count;
        given_.resize(where_.points().isInParts() ? where_.points().size() : 0);
        cells_.resize(halves * count_);
        cover_.resize(halves * count_);
        for (auto& component : acting_) component.resize(halves * count_);
        holes_.resize(halves * grid.slabs());
        sparse_.resize(halves * grid.slabs());
        extents_.resize(halves * grid.slabs());
    }
    int inGrid(int number) const { return number < count_ ? number : number - count_; }
    // The cell that goes on where a cell ends: of the same side where it has one; -1: empty, or both sides are there.
    int beside(int number, int step) const {
        const int next = number + step;
        if (!isParted_) return where_.has(next) ? next : -1;
        const int first = inGrid(next), second = first + count_;
        const bool hasFirst = where_.has(first), hasSecond = where_.has(second);
        if (!isParted_[inGrid(number)])
            return hasFirst && hasSecond ? -1 : hasSecond ? second : hasFirst ? first : -1;
        if (where_.has(next)) return next;
        return hasFirst && !isParted_[first] ? first : -1;
    }

    // The cells of a slab that particles have come to or left.
    void enter(const Grid<Dim>& grid, int slab) {
        const int size = grid.strides[Dim - 1];
        std::fill_n(cover_.begin() + slab * size, size, 0.0);
        for (auto& component : acting_) std::fill_n(component.begin() + slab * size, size, 0.0);
        extents_[slab] = Extent();
        for (int c : where_.occupied(slab)) {
            cells_[c].edges = grid.edges(inGrid(c));
            cells_[c].whole = grid.volume(inGrid(c));
            extents_[slab].include(only(grid, inGrid(c)));
        }
    }
    static void leaveToParticles(Cell& cell) {
        cell.inside = 0;
        cell.uneven = 1;
    }
    static Extent only(const Grid<Dim>& grid, int number) {
        Extent extent;
        extent.first = extent.last = grid.indices(number);
        return extent;
    }

    // full: mean cover of the cells round it, also of what is outside of the grid, where soil may stand off the wall.
    static double unevenness(const Cell& cell, double full) {
        const double ratio = cell.inside * cell.share * cell.whole / cell.volume + 1 - cell.inside;
        if (std::abs(ratio - 1) < 1e-9) return 1;
        const double part = std::clamp((full - sparse) / (dense - sparse), 0.0, 1.0);
        return 1 + part * (std::clamp(ratio, 1 / flexibility, flexibility) - 1);
    }
    // The covers of all bodies that move together, where this one is, and two rows of cells round that.
    void addUp(ParallelRegion& region, const std::vector<CellAverage*>& others) {
        region.once([&] { total_.resize(count_); });
        forOwn(region, [&](int firstSlab, int endSlab) {
            const int halves = int(cover_.size()) / count_, slabs = int(extents_.size()) / halves,
                      size = count_ / slabs;
            for (int slab = firstSlab; slab < std::min(endSlab, slabs); ++slab) {
                bool isNear = false;
                for (int s = std::max(0, slab - 2); s < std::min(slabs, slab + 3); ++s)
                    isNear |=
                        !where_.occupied(s).empty() || !where_.occupied(s + (halves - 1) * slabs).empty();
                if (!isNear) continue;
                for (int c = slab * size; c < (slab + 1) * size; ++c) total_[c] = coverOf(c);
                for (const CellAverage* other : others)
                    for (int c = slab * size; c < (slab + 1) * size; ++c) total_[c] += other->coverOf(c);
            }
        });
        region.wait();
    }

    template <class F> void forTakers(const Hole<Dim>& hole, F&& f) {
        for (auto [number, part] : hole.takers)
            if (Cell* cell = occupied(number); cell && cell->shared == 0) f(*cell, part);
    }

    template <class F> void forOwn(ParallelRegion& region, F&& f) const { where_.forOwn(region, f); }
    template <class F> void forPoints(int cell, F&& f) const { where_.forPoints(cell, f); }
    template <class F> void forOwnCells(ParallelRegion& region, F&& f) {
        forOwn(region, [&](int firstSlab, int endSlab) {
            for (int slab = firstSlab; slab < endSlab; ++slab)
                for (int c : where_.occupied(slab)) f(c, cells_[c]);
        });
    }

    double slope(int number, int last, int next, int axis) const {
        if (last < 0 || next < 0) return 0;
        const Cell &before = cells_[last], &cell = cells_[number], &after = cells_[next];
        const auto between = [&](const Cell& a, const Cell& b) {
            return (b.stress - a.stress) / std::max(b.centre[axis] - a.centre[axis], 0.5 * cell.edges[axis]);
        };
        const double left = between(before, cell), right = between(cell, after), both = 0.5 * (left + right);
        const double least = std::min(std::abs(both), 2 * std::min(std::abs(left), std::abs(right)));
        return left * right > 0 ? std::copysign(least, both) : 0;
    }

    template <bool isAxisymmetric> Vec<Dim> force(const Grid<Dim>& grid, int node) const {
        Vec<Dim> sum = Vec<Dim>::Zero(), slopes[2]; // of the cells beyond the node, and before it
        for (int before = 0; isAxisymmetric && before < 2; ++before)
            slopes[before] = grid.volumeSlopes(std::max(0, inGrid(node) - before), inGrid(node), half_);
        for (int a = 0; a < corners<Dim>; ++a) { // the node is corner a of the cell
            int number = node;
            for (int k = 0; k < Dim; ++k) number -= cornerSign(a, k) > 0 ? grid.strides[k] : 0;
            if (number < 0 || (isAxisymmetric && acting_[Dim - 1][number] == 0)) continue;
            for (int k = 0; k < Dim; ++k)
                sum[k] -= cornerSign(a, k) * acting_[k][number] *
                          (isAxisymmetric ? slopes[cornerSign(a, 0) > 0][k] : 1);
        }
        return sum / (corners<Dim> / 2);
    }

    ParticleCells<Dim> where_;
    int count_ = 0;                  // nodes of the grid
    const char* isParted_ = nullptr; // each cell, see SecondCells
    bool isMesh_ = false, actByCells_ = false;
    bool fitInCells_ = false;   // whether no domain was made larger than a cell,
    int measured_ = -1;         // found when there were so many domains
    double half_ = 0;           // of the edge of boxes along the first axis, m
    std::vector<double> given_; // to the points of particles that count in parts
    std::vector<Cell> cells_;
    std::vector<double> cover_,
        total_; // of each cell of the grid: volume of the particles over its own; of all bodies
    std::vector<double> acting_[Dim]; // of each cell, see actByCell()
    Holes<Dim> holes_;
    std::vector<std::vector<int>> sparse_; // those whose corners may have no mass
    std::vector<Extent> extents_;          // of these
};

} // namespace mpm
