// SPDX-License-Identifier: GPL-2.0-or-later
// Structures in soil with water: bodies of other groups. They are impermeable, and the water presses on them
// as on the soil. Soil and structure fill the cells beside a surface together, so the balance of water there
// is that of the mean velocity by volumes,
//     u_i = sum_g V_ig v_ig / sum_g V_ig,   V_ig: volume of group g at node i,
// and the pressure acts on each group by its share of the volume. A cell with little room for soil hands a
// share of its flow to the cells beside it that have soil, and has the same share of their pressure. So does
// a cell inside of a structure with soil at its corners: what the water does to a surface then acts on the
// structure, and contact transfers effective stress alone (doc/theory/water.md). Cells that soil with F-bar shares with
// a structure hand on what they hand on there (scene/SharedCells.hpp): what the water lets flow is what strains the soil.
#pragma once

#include "mpm/scene/SharedCells.hpp"
#include "mpm/step/PoreFill.hpp"
#include "mpm/step/PoreSystem.hpp"

#include <numeric>

namespace mpm {

template <int Dim> class PoreSolids {
  public:
    static constexpr double ownFrom = 0.5; // open part of a cell from which on all of its flow is its soil's
    static constexpr double leastOpen = 0.05; // part of a cell that counts as open at least

    bool isEmpty() const { return near_.empty(); }
    double solidPart(int cell) const { return isEmpty() ? 0 : solid_[cell]; } // of the volume of a cell
    double openPart(int cell) const { return std::max(leastOpen, 1 - solidPart(cell)); }
    bool isNear(int cell) const { return !isEmpty() && isNear_[cell]; }
    int groups() const { return int(volumes_.size()); }
    // Volume of a group on a node over that of all groups; beside no structure all is soil.
    double partOf(int group, int node) const { return volumes_[group][node] / total_[node]; }
    bool isShared(int node) const { return !isEmpty() && total_[node] > 0; }

    void find(const Scene<Dim>& scene, int soil, const PoreFill<Dim>& fill) {
        clear();
        shared_ = scene.state.sharedCells.get();
        if (scene.grid.fields.size() < 2) return;
        makeRoom(scene);
        for (auto& body : scene.bodies) // of all particles
            if (body->velocityField != soil) addVolume(*body, allOf(*body));
        findNear(scene.grid);
        addSoil(scene, fill);
        takeShared();
        for (int node : nodes_) total_[node] = volumeAt(node); // some are there twice
        soil_ = soil;
    }
    // Whether a structure parts the soils of a cell and of the next one along an axis: it fills more than
    // half a cell of the two, and the soils are farther apart than points of one soil are.
    bool isBetween(const Grid<Dim>& grid, const PoreFill<Dim>& fill, int cell, int axis) const {
        const int next = cell + grid.strides[axis];
        return solidPart(cell) + solidPart(next) > PoreFill<Dim>::fullFrom &&
               fill.gap(cell, next, axis) > grid.edges(cell)[axis];
    }
    // f(cell, part) for the cells beside one that have a share of its flow; returns its own part. A cell
    // without soil has none to give where it lies inside of a structure, or in the air.
    template <class F>
    double forTakers(const Grid<Dim>& grid, const PoreFill<Dim>& fill, int cell, F&& f) const {
        const bool hasSoil = fill[cell].saturated > 0;
        if (const auto* to = closedTakersOf(cell, hasSoil)) {
            double rest = 0;
            for (const auto& [other, part] : *to)
                if (other == cell)
                    rest = part;
                else if (fill[other].saturated > 0)
                    f(other, part);
            return hasSoil ? rest : 0;
        }
        const double own = hasSoil ? std::clamp((1 - solid_[cell]) / ownFrom, leastOpen, 1.0) : 0;
        if (own == 1) return 1;
        const auto weight = [&](int other) { return openPart(other) * openPart(other); };
        double sum = 0;
        const auto forBeside = [&](auto&& visit) {
            forAround(grid, cell, [&](int other, int axes) {
                if (axes == 1 && fill[other].saturated > 0) visit(other);
            });
        };
        forBeside([&](int other) { sum += weight(other); });
        if (sum == 0) return hasSoil ? 1 : 0;
        forBeside([&](int other) { f(other, (1 - own) * weight(other) / sum); });
        return own;
    }
    // f(cell) for cells without soil of their own that take part: inside of a structure, with soil at a
    // corner.
    template <class F> void forHanding(const Grid<Dim>& grid, const PoreFill<Dim>& fill, F&& f) const {
        for (int cell : near_) {
            if (fill[cell].saturated > 0) continue;
            bool hasSoil = closedTakersOf(cell, false);
            if (!hasSoil && !(solid_[cell] > PoreFill<Dim>::fullFrom)) continue;
            for (int a = 0; a < corners<Dim>; ++a) hasSoil |= volumes_[soil_][cornerOf(grid, cell, a)] > 0;
            if (hasSoil) f(cell);
        }
    }

  private:
    const SharedCells<Dim>* shared_ = nullptr;
    int soil_ = 0;
    std::vector<std::vector<double>> volumes_; // of each group at the nodes, m3
    std::vector<double> total_, hat_; // of all groups, where there is a structure; of the hat functions
    std::vector<int> nodes_;          // with any volume
    std::vector<int> near_;           // cells with a corner that a structure reaches, sorted
    std::vector<char> isNear_;
    std::vector<double> solid_; // part of each cell that structures fill, by its corners: smooth as they move

    static std::vector<int> allOf(const Body<Dim>& body) {
        std::vector<int> all(body.particles.size());
        std::iota(all.begin(), all.end(), 0);
        return all;
    }
    void clear() {
        for (int node : nodes_) {
            total_[node] = 0;
            for (auto& volume : volumes_) volume[node] = 0;
        }
        for (int cell : near_) solid_[cell] = isNear_[cell] = 0;
        nodes_.clear();
        near_.clear();
    }
    void makeRoom(const Scene<Dim>& scene) {
        const Grid<Dim>& grid = scene.grid;
        if (volumes_.size() == grid.fields.size()) return;
        volumes_.assign(grid.fields.size(), std::vector<double>(grid.count));
        total_.assign(grid.count, 0.0);
        solid_.assign(grid.count, 0.0);
        isNear_.assign(grid.count, 0);
        hat_.assign(grid.count, 0.0);
        for (int cell = 0; cell < grid.count; ++cell)
            if (isInGrid(grid, grid.indices(cell)))
                for (int a = 0; a < corners<Dim>; ++a)
                    hat_[cornerOf(grid, cell, a)] += grid.volume(cell) / corners<Dim>;
    }
    static bool isInGrid(const Grid<Dim>& grid, const Index<Dim>& index) {
        bool is = true;
        for (int k = 0; k < Dim; ++k) is &= index[k] >= grid.ghost && index[k] < grid.ghost + grid.cells[k];
        return is;
    }
    double volumeAt(int node) const {
        double sum = 0;
        for (const auto& volume : volumes_) sum += volume[node];
        return sum;
    }
    void addVolume(const Body<Dim>& body, const std::vector<int>& which) {
        body.domains->addQuantity(body.particles.volume.plane(), which, volumes_[body.velocityField].data(),
                                  nodes_);
    }
    void findNear(const Grid<Dim>& grid) {
        std::sort(nodes_.begin(), nodes_.end());
        nodes_.erase(std::unique(nodes_.begin(), nodes_.end()), nodes_.end());
        for (int node : nodes_) {
            if (!(hat_[node] > 0)) continue;         // behind a face of the grid
            for (int a = 0; a < corners<Dim>; ++a) { // the node is corner a of the cell
                int cell = node;
                for (int k = 0; k < Dim; ++k) cell -= cornerSign(a, k) > 0 ? grid.strides[k] : 0;
                if (!isInGrid(grid, grid.indices(cell))) continue;
                if (!isNear_[cell]) near_.push_back(cell);
                isNear_[cell] = 1;
                solid_[cell] += std::min(1.0, volumeAt(node) / hat_[node]) / corners<Dim>;
            }
        }
        std::sort(near_.begin(), near_.end());
    }
    // Those of the shared cells, where one at least strains its soil by what it takes; nullptr: none does.
    const std::vector<typename SharedCells<Dim>::Part>* closedTakersOf(int cell, bool hasSoil) const {
        const auto* to = shared_->takersOf(cell);
        if (to && hasSoil &&
            std::none_of(to->begin(), to->end(), [&](const auto& part) { return part.cell == cell; }))
            return nullptr; // no taker: what strains its soil is not known there
        if (to && !hasSoil && shared_->isAir(cell) && !(solid_[cell] > PoreFill<Dim>::fullFrom))
            return nullptr; // over a free surface, where the nodes have next to no mass that pressure could act on
        const bool is = to && std::any_of(to->begin(), to->end(),
                                          [&](const auto& part) { return shared_->isClosed(part.cell); });
        return is ? to : nullptr;
    }
    // What is known there counts.
    void takeShared() {
        std::vector<char> isOurs(total_.size(), 0);
        for (int node : nodes_) isOurs[node] = 1;
        shared_->forVolumes([&](int node, int group, double volume) {
            if (isOurs[node] && volume > 0) volumes_[group][node] = volume;
        });
    }
    // Of the soil at all corners of those cells.
    void addSoil(const Scene<Dim>& scene, const PoreFill<Dim>& fill) {
        std::vector<char> isAround(scene.grid.count, 0); // from where soil may reach a corner
        for (int cell : near_) forAround(scene.grid, cell, [&](int other, int) { isAround[other] = 1; });
        for (const auto& wet : fill.wet) {
            std::vector<int> which;
            for (int p = 0; p < wet.body->particles.size(); ++p)
                if (isAround[wet.cell[wet.points.at(p)]]) which.push_back(p);
            addVolume(*wet.body, which);
        }
    }
};

} // namespace mpm
