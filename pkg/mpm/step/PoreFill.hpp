// SPDX-License-Identifier: GPL-2.0-or-later
// Where soil with water is: how much of it is in each cell of the grid, its middle there, and means of its
// state.
#pragma once

#include "mpm/scene/CellPoints.hpp"
#include "mpm/scene/Scene.hpp"
#include "mpm/step/WaterTable.hpp"

#include <algorithm>
#include <array>

namespace mpm {

// What the particles of a body with water have besides the state of their material, in this order.
struct PoreState {
    static constexpr int count = 5;
    static std::array<Field, count> fields(int dim); // pressure, saturation, permeability, porosity, flow
    // Number of the first in the state of a body, -1: it has no water.
    template <int Dim> static int in(const Particles<Dim>& particles) {
        const int first = int(particles.state.size()) - count;
        return first >= 0 && particles.state[first].name == "porePressure" ? first : -1;
    }
    template <int Dim> static void addTo(Particles<Dim>& particles) {
        if (in(particles) >= 0) return;
        for (const Field& field : fields(Dim)) {
            particles.state.push_back(field);
            particles.state.back().resize(particles.size());
        }
    }
};

// A body with water: the state of its particles, and which cell each point of it is in.
template <int Dim> struct WetBody {
    Body<Dim>* body;
    double *pressure, *saturation, *permeability, *porosity;
    std::array<double*, Dim> flow;
    CellPoints<Dim> points;
    std::vector<int> cell; // of each point

    explicit WetBody(Body<Dim>& body) : body(&body) {
        auto& state = body.particles.state;
        const int first = PoreState::in(body.particles);
        pressure = state[first].plane();
        saturation = state[first + 1].plane();
        permeability = state[first + 2].plane();
        porosity = state[first + 3].plane();
        for (int k = 0; k < Dim; ++k) flow[k] = state[first + 4].plane(k);
    }
};

template <int Dim> class PoreFill {
  public:
    static constexpr double fullFrom =
        0.5; // cover of a cell from which its neighbours may be inside of the soil

    // Of a cell of the grid: volumes of soil that is full of water, of dry soil, and of bodies without water;
    // and means over the first.
    struct Cell {
        double saturated = 0, dry = 0, strange = 0;
        double excess = 0, head = 0, permeability = 0, porosity = 0;
        bool isInside = false;
        Vec<Dim> centre = Vec<Dim>::Zero(); // of its points
    };
    std::vector<WetBody<Dim>> wet;

    const Cell& operator[](int number) const { return cells_[number]; }
    const std::vector<int>& touched() const { return touched_; } // cells with anything, by number
    // The gap between the points of a cell and those of the next one along an axis, m. Known with several groups only.
    double gap(int cell, int next, int axis) const { return ends_[next][0][axis] - ends_[cell][1][axis]; }
    bool isClosed(const Grid<Dim>& grid, int number) const {
        return cells_[number].strange > fullFrom * grid.volume(number);
    }

    // isDenser: soil that has less volume lets less water through (Kozeny & Carman).
    void find(const Scene<Dim>& scene, const WaterTable& water, bool isDenser) {
        cells_.resize(scene.grid.count);
        ends_.resize(scene.grid.fields.size() > 1 ? scene.grid.count : 0);
        for (int number : touched_) cells_[number] = {};
        touched_.clear();
        for (auto& one : wet) addPoints(scene.grid, one, water, isDenser);
        addStrange(scene);
        sortTouched();
        for (int number : touched_) takeMeans(scene.grid, number);
    }

  private:
    std::vector<Cell> cells_;                   // of the grid
    std::vector<std::array<Vec<Dim>, 2>> ends_; // of the points in each, m
    std::vector<int> touched_, sorted_;         // sorted_: those of the step before

    // Most steps touch the same cells.
    void sortTouched() {
        const bool areSame = touched_.size() == sorted_.size() &&
                             std::all_of(sorted_.begin(), sorted_.end(),
                                         [&](int number) { return isTouched(cells_[number]); });
        if (!areSame) {
            sorted_ = touched_;
            std::sort(sorted_.begin(), sorted_.end());
        }
        touched_ = sorted_;
    }
    static bool isTouched(const Cell& cell) {
        return !(cell.saturated == 0 && cell.dry == 0 && cell.strange == 0);
    }
    Cell& touch(int number) {
        Cell& cell = cells_[number];
        if (!isTouched(cell)) touched_.push_back(number);
        return cell;
    }

    // n^3/(1 - n)^2 over that at the start, of grains that keep their volume: n0 there, and V/V0.
    static double kozenyCarman(double porosity, double volume) {
        const double now = std::max(1 - (1 - porosity) / volume, 0.0), pores = now / porosity;
        return pores * pores * pores * volume * volume;
    }

    void addPoints(const Grid<Dim>& grid, WetBody<Dim>& one, const WaterTable& water, bool isDenser) {
        auto& particles = one.body->particles;
        one.points.start(particles, one.body->domains->mesh());
        one.cell.resize(one.points.size());
        for (int begin = 0; begin < particles.size(); begin += chunkSize)
            one.points.place(grid, begin, std::min(particles.size(), begin + chunkSize),
                             one.cell.data() + one.points.at(begin));
        for (int p = 0; p < particles.size(); ++p) {
            const int count = one.points.per(p);
            const double volume = particles.volume.plane()[p] / count;
            const Vec<Dim> at = vectorAt<Dim>(particles.position, p);
            const double there = water.pressure<Dim>(at);
            double k = one.permeability[p];
            if (isDenser)
                k *= kozenyCarman(one.porosity[p],
                                  particles.volume.plane()[p] / particles.initialVolume.plane()[p]);
            for (int point = one.points.at(p); point < one.points.at(p) + count; ++point) {
                Cell& cell = touch(one.cell[point]);
                if (!(one.saturation[p] > 0)) {
                    cell.dry += volume;
                    continue;
                }
                cell.excess += volume * (one.pressure[p] - there);
                cell.head += volume * (there + water.weight * at[Dim - 1]);
                cell.permeability += volume * k;
                cell.porosity += volume * one.porosity[p];
                Vec<Dim> x;
                for (int k = 0; k < Dim; ++k) x[k] = one.points.position(p, point, k);
                if (!ends_.empty()) {
                    auto& [lowest, highest] = ends_[one.cell[point]];
                    const bool isFirst = cell.saturated == 0;
                    lowest = isFirst ? x : lowest.cwiseMin(x);
                    highest = isFirst ? x : highest.cwiseMax(x);
                }
                cell.centre += volume * x;
                cell.saturated += volume;
            }
        }
    }

    // What no water passes: bodies without water.
    void addStrange(const Scene<Dim>& scene) {
        for (auto& body : scene.bodies) {
            if (PoreState::in(body->particles) >= 0) continue;
            const auto& particles = body->particles;
            std::vector<int> number(particles.size(), 0);
            for (int k = 0; k < Dim; ++k)
                scene.grid.addCells(k, particles.position.plane(k), particles.size(), number.data());
            for (int p = 0; p < particles.size(); ++p)
                touch(number[p]).strange += particles.volume.plane()[p];
        }
    }

    // Inside of the soil, the middle of it in a cell is that of the cell.
    void takeMeans(const Grid<Dim>& grid, int number) {
        Cell& cell = cells_[number];
        if (!(cell.saturated > 0)) return;
        for (double* sum : {&cell.excess, &cell.head, &cell.permeability, &cell.porosity})
            *sum /= cell.saturated;
        cell.centre /= cell.saturated;
        const auto isFull = [&](int other) {
            return cells_[other].saturated > fullFrom * grid.volume(other);
        };
        const Index<Dim> index = grid.indices(number);
        cell.isInside = isFull(number);
        for (int k = 0; k < Dim; ++k) {
            if (index[k] > grid.ghost) cell.isInside &= isFull(number - grid.strides[k]);
            if (index[k] < grid.ghost + grid.cells[k] - 1) cell.isInside &= isFull(number + grid.strides[k]);
        }
        if (cell.isInside) cell.centre = grid.centre(index);
    }
};

} // namespace mpm
