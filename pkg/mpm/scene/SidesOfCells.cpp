// SPDX-License-Identifier: GPL-2.0-or-later
#include "mpm/scene/SidesOfCells.hpp"

#include "mpm/scene/thicknessOfWall.hpp"
#include "mpm/state/cover.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace mpm {

namespace {

// How far beyond the places where a wall parts the soil a cell may lie that belongs to this wall, in cells: cells with a
// node on which the soil is two lie up to one beyond, and those beside them up to two.
constexpr double mostBeyond = 2;

// The part of an integral that lies below x, in cells: of a hat function, x from its node; of the mean of the hat functions
// at both ends of a cell, x from its middle.
double ofHat(double x) {
    if (x > 0) return 1 - ofHat(-x);
    return x < -1 ? 0 : 0.5 * (1 + x) * (1 + x);
}
double ofHats(double x) {
    if (x > 0) return 1 - ofHats(-x);
    return x < -1.5 ? 0 : x < -0.5 ? 0.25 * (1.5 + x) * (1.5 + x) : 0.5 * (1 + x);
}

} // namespace

template <int Dim> void SidesOfCells<Dim>::find(const Scene<Dim>& scene, int soil) {
    planes_.clear();
    parted_ = &scene.state.parted;
    count_ = scene.grid.count;
    first_ = soil;
    second_ = soil < 0 ? -1 : scene.state.parted.partnerOf(soil);
    isParted_ = nullptr;
    for (auto& body : scene.bodies)
        if (second_ >= 0 && body->velocityField == soil && body->particles.size() > 0)
            isParted_ = scene.state.parted.secondCells(*body).isParted;
    if (!isParted_) return;
    for (const auto& wall : scene.state.parted.walls())
        if (wall.soil == soil) add(scene, wall);
}

// The middle of a wall by rows of cells, for it may be bent: of its particles there and in the rows beside.
template <int Dim>
void SidesOfCells<Dim>::add(const Scene<Dim>& scene, const typename PartedSoils<Dim>::Wall& wall) {
    const Grid<Dim>& grid = scene.grid;
    const Field& x = scene.bodies[wall.body]->particles.position;
    Plane plane;
    plane.front = wall.front;
    plane.across = wall.across;
    plane.normal = wall.normal;
    plane.middle = wall.middle;
    plane.half = 0.5 * thicknessOf(*scene.bodies[wall.body], wall.normal, wall.across);
    for (int k = 0; k < Dim; ++k) {
        const double room = mostBeyond * grid.sizeAt(wall.middle)[k];
        plane.lower[k] = wall.lower[k] - room;
        plane.upper[k] = wall.upper[k] + room;
    }
    std::map<int, std::pair<double, int>> sums;
    for (int p = 0; p < x.size(); ++p) {
        const Vec<Dim> at = vectorAt<Dim>(x, p);
        const int row = rowOf(grid, at, wall.across);
        forAround(grid, row + grid.ghost * grid.strides[wall.across], [&](int cell, int) {
            const Index<Dim> index = grid.indices(cell);
            if (index[wall.across] != grid.ghost) return;
            auto& [sum, number] = sums[cell - grid.ghost * grid.strides[wall.across]];
            sum += at.dot(wall.normal);
            ++number;
        });
    }
    for (const auto& [row, its] : sums) plane.along[row] = its.first / its.second;
    planes_.push_back(std::move(plane));
}

// The number of the cell at a place, without its index across.
template <int Dim> int SidesOfCells<Dim>::rowOf(const Grid<Dim>& grid, const Vec<Dim>& x, int across) {
    int row = 0;
    for (int k = 0; k < Dim; ++k)
        if (k != across) row += int(std::floor(grid.inCells(x[k], k))) * grid.strides[k];
    return row;
}

template <int Dim>
double SidesOfCells<Dim>::middleAt(const Grid<Dim>& grid, const Plane& plane, const Vec<Dim>& x) {
    const auto found = plane.along.find(rowOf(grid, x, plane.across));
    return found != plane.along.end() ? found->second : plane.middle.dot(plane.normal);
}

// Of several walls the nearest one beside the place.
template <int Dim>
const typename SidesOfCells<Dim>::Plane& SidesOfCells<Dim>::planeAt(const Grid<Dim>& grid,
                                                                    const Vec<Dim>& x) const {
    if (planes_.size() == 1) return planes_.front();
    const Plane* nearest = &planes_.front();
    double least = std::numeric_limits<double>::infinity();
    for (const Plane& plane : planes_) {
        bool isBeside = true;
        for (int k = 0; k < Dim; ++k)
            isBeside &= k == plane.across || (x[k] >= plane.lower[k] && x[k] <= plane.upper[k]);
        const double away = std::abs(x.dot(plane.normal) - middleAt(grid, plane, x));
        if (!isBeside || away >= least) continue;
        least = away;
        nearest = &plane;
    }
    return *nearest;
}

template <int Dim>
typename SidesOfCells<Dim>::Depth SidesOfCells<Dim>::depth(const Grid<Dim>& grid, int field,
                                                           const Vec<Dim>& x) const {
    const Plane& plane = planeAt(grid, x);
    const double beyond = x.dot(plane.normal) - middleAt(grid, plane, x),
                 width = plane.normal.cwiseAbs().dot(grid.sizeAt(x));
    return {(field == plane.front ? beyond : -beyond) / width, plane.half / width};
}

template <int Dim> double SidesOfCells<Dim>::part(const Grid<Dim>& grid, int field, int cell) const {
    const Vec<Dim> middle = grid.nodePosition(cell) + 0.5 * grid.edges(cell);
    return std::clamp(0.5 + depth(grid, field, middle).before, 0.0, 1.0);
}

template <int Dim> double SidesOfCells<Dim>::solids(const Grid<Dim>& grid, int field, int cell) const {
    const double before = part(grid, field, cell);
    const double half = depth(grid, field, grid.nodePosition(cell) + 0.5 * grid.edges(cell)).half;
    const double own = std::min(before, half), other = std::min(1 - before, half);
    return own / (own + other);
}

template <int Dim> double SidesOfCells<Dim>::open(const Grid<Dim>& grid, int field, int cell) const {
    const Vec<Dim> middle = grid.nodePosition(cell) + 0.5 * grid.edges(cell);
    const Depth its = depth(grid, field, middle);
    return ofHats(its.before - its.half);
}

template <int Dim> double SidesOfCells<Dim>::beyond(const Grid<Dim>& grid, int field, int node) const {
    const Depth its = depth(grid, field, grid.nodePosition(node));
    return ofHat(-its.before - its.half);
}

template class SidesOfCells<2>;
template class SidesOfCells<3>;

} // namespace mpm
