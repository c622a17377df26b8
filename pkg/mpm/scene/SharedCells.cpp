// SPDX-License-Identifier: GPL-2.0-or-later
#include "mpm/scene/SharedCells.hpp"

#include "mpm/scene/soilInCells.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace mpm {

namespace {

constexpr double ownShare = 0.5;   // open part of a cell from which on its own soil takes all of its flux
constexpr double leastOpen = 0.25; // part of a cell that a taker counts as open at least
constexpr double leastWeight = 0.05;
// Density of a body over that of the soil from which on cells are shared, unless it is driven: the step falls with it.
constexpr double leastDensity = 0.04;

// Integral of the hat function of a node over the grid, m3; of its ring with axial symmetry.
template <int Dim> double hatVolume(const Grid<Dim>& grid, int node) {
    const Index<Dim> index = grid.indices(node);
    double volume = 1;
    for (int k = 0; k < Dim; ++k) {
        const int line = index[k] - grid.ghost;
        const double before = line > 0 && line <= grid.cells[k] ? grid.cellSize(k, index[k] - 1) : 0,
                     after = line >= 0 && line < grid.cells[k] ? grid.cellSize(k, index[k]) : 0;
        if (k == 0 &&
            grid.isAxisymmetric) { // with the thickness where the halves of the hat have their middle
            const double r = grid.line(0, index[0]);
            volume *=
                0.5 * (before * grid.thicknessAt(r - before / 3) + after * grid.thicknessAt(r + after / 3));
        } else
            volume *= 0.5 * (before + after);
    }
    return volume;
}

// f(cell) for the cells of the grid around a node.
template <int Dim, class F> void forCellsAround(const Grid<Dim>& grid, int node, F&& f) {
    const Index<Dim> index = grid.indices(node);
    for (int a = 0; a < corners<Dim>; ++a) { // the node is corner a of the cell
        int cell = node;
        bool isInGrid = true;
        for (int k = 0; k < Dim; ++k) {
            const int step = cornerSign(a, k) > 0, at = index[k] - step - grid.ghost;
            isInGrid &= at >= 0 && at < grid.cells[k];
            cell -= step * grid.strides[k];
        }
        if (isInGrid) f(cell);
    }
}

// Whether a prescribed motion moves all of a body along all axes.
template <int Dim> bool isDrivenWhole(const Scene<Dim>& scene, const Body<Dim>& body) {
    for (auto& drive : scene.constraints) {
        bool isWhole = drive->active && drive->body == body.name && drive->ids.empty();
        for (int k = 0; k < Dim && isWhole; ++k)
            isWhole = !std::isnan(drive->velocity[k]) && drive->lower[k] <= scene.grid.lower[k] &&
                      drive->upper[k] >= scene.grid.upper[k];
        if (isWhole) return true;
    }
    return false;
}

// Of the soil that has most of a cell.
template <int Dim> int groupOf(const Scene<Dim>& scene, int cell) {
    std::vector<double> covers(scene.groupOf.size(), 0.0);
    for (auto& body : scene.bodies)
        if (actsByCells(*body)) covers[body->velocityField] += body->cellAverage.coverOf(cell);
    return int(std::max_element(covers.begin(), covers.end()) - covers.begin());
}

} // namespace

template <int Dim> void SharedCells<Dim>::clear() {
    for (int node : nodes_)
        for (auto& volume : volumes_)
            if (!volume.empty()) volume[node] = 0;
    for (int cell : near_) solid_[cell] = isNear_[cell] = 0;
    for (int cell : air_) isAir_[cell] = 0;
    for (int node : touched_) isTouched_[node] = 0;
    for (const Giver& giver : givers_) giverAt_[giver.cell] = -1;
    touched_.clear();
    nodes_.clear();
    near_.clear();
    air_.clear();
    givers_.clear();
    forces_.clear();
    ofCells_.clear();
    takers_.clear();
    fullness_.clear();
}

template <int Dim> void SharedCells<Dim>::find(const Scene<Dim>& scene) {
    if (step_ == scene.step) return;
    clear();
    step_ = scene.step;
    findGroups(scene);
    if (!isWanted || std::count(isSoil_.begin(), isSoil_.end(), 1) == 0 ||
        std::count(isSolid_.begin(), isSolid_.end(), 1) == 0)
        return gaps_.clear();
    findSides(scene);
    findSolids(scene);
    findAir(scene);
    findGivers(scene);
    findGrowths(scene);
    decide(scene);
}

// Groups with boxes that act by cells, and groups of meshes alone, unless they are too light.
template <int Dim> void SharedCells<Dim>::findGroups(const Scene<Dim>& scene) {
    const size_t groups = scene.groupOf.size();
    std::vector<double> lightest(groups, std::numeric_limits<double>::infinity());
    double heaviest = 0;
    isSoil_.assign(groups, 0);
    isSolid_.assign(groups, 1);
    for (auto& body : scene.bodies) {
        const int group = body->velocityField;
        const double density = body->inertiaScale * body->material->density;
        if (body->particles.size() == 0) continue;
        if (body->domains->boxes()) {
            isSolid_[group] = 0;
            if (body->fbar && heaviest == 0) half_ = body->domains->boxes()->halfSize()[0];
            if (body->fbar) isSoil_[group] = 1;
            if (body->fbar) heaviest = std::max(heaviest, density);
        } else if (!isDrivenWhole(scene, *body)) {
            lightest[group] = std::min(lightest[group], density);
        }
    }
    lightness_ = 1;
    for (size_t g = 0; g < groups; ++g) {
        isSolid_[g] &= lightest[g] >= leastDensity * heaviest;
        if (isSolid_[g]) lightness_ = std::min(lightness_, lightest[g] / heaviest);
    }
    // Parted soil has two fields; beside another soil it shares none.
    const auto soils = std::count(isSoil_.begin(), isSoil_.end(), 1);
    for (size_t g = scene.groups.size(); g < groups; ++g) {
        isSolid_[g] = 0;
        isSoil_[g] = isSoil_[scene.groupOf[g]] &= soils == 1;
    }
    const int count = scene.grid.count, halves = groups > scene.groups.size() ? 2 : 1;
    if (volumes_.size() == groups && giverAt_.size() == size_t(halves * count)) return;
    volumes_.assign(groups, {});
    scratch_.assign(halves * count, 0.0);
    isTouched_.assign(halves * count, 0);
    solid_.assign(count, 0.0);
    hat_.resize(count);
    for (int node = 0; node < count; ++node) hat_[node] = hatVolume(scene.grid, node);
    isNear_.assign(count, 0);
    isAir_.assign(count, 0);
    isReached_.assign(count, 0);
    giverAt_.assign(halves * count, -1);
}

template <int Dim> void SharedCells<Dim>::findSides(const Scene<Dim>& scene) {
    int parted = -1;
    for (size_t g = scene.groups.size(); g < isSoil_.size(); ++g)
        if (isSoil_[g]) parted = scene.groupOf[g];
    sides_.find(scene, parted);
}

template <int Dim> double SharedCells<Dim>::stepFactor(const Scene<Dim>& scene) {
    if (!isWanted) return 1;
    findGroups(scene);
    const bool hasSoil = std::count(isSoil_.begin(), isSoil_.end(), 1) > 0;
    return hasSoil ? std::sqrt(lightness_) : 1;
}

template <int Dim> void SharedCells<Dim>::setVolume(int group, int node, double volume) {
    if (volumes_[group].empty()) volumes_[group].resize(hat_.size(), 0.0);
    if (volumeAt(node) == 0) nodes_.push_back(node);
    volumes_[group][node] = volume;
}

template <int Dim> double SharedCells<Dim>::volumeAt(int node) const {
    double sum = 0;
    for (size_t g = 0; g < volumes_.size(); ++g) sum += volumeOf(int(g), node);
    return sum;
}

// The volumes of the solids at the nodes, the cells of the grid around these, and what part of cells they fill.
template <int Dim> void SharedCells<Dim>::findSolids(const Scene<Dim>& scene) {
    const Grid<Dim>& grid = scene.grid;
    std::vector<int> all, touched;
    for (auto& body : scene.bodies) {
        const int group = body->velocityField;
        if (!isSolid_[group]) continue;
        all.resize(body->particles.size());
        std::iota(all.begin(), all.end(), 0);
        touched.clear();
        body->domains->addQuantity(body->particles.volume.plane(), all, scratch_.data(), touched);
        for (int node : touched) {
            setVolume(group, node, volumeOf(group, node) + scratch_[node]);
            scratch_[node] = 0;
        }
    }
    for (int node : nodes_) {
        const double part = volumeAt(node) / hat_[node] / corners<Dim>;
        forCellsAround(grid, node, [&](int cell) {
            if (!isNear_[cell]) near_.push_back(cell);
            isNear_[cell] = 1;
            solid_[cell] += part;
        });
    }
}

// The part of a cell that solids leave to the soil, on its side of a wall.
template <int Dim> double SharedCells<Dim>::openPart(const Grid<Dim>& grid, int number) const {
    const int cell = sides_.inGrid(number), field = sides_.fieldOf(number);
    return field < 0 ? std::clamp(1 - solid_[cell], 0.0, 1.0) : sides_.open(grid, field, cell);
}

template <int Dim> void SharedCells<Dim>::findGivers(const Scene<Dim>& scene) {
    for (int cell : near_) sides_.forNumbers(cell, [&](int number) { give(scene, number); });
    for (auto& [cell, taker] : takers_) {
        const double whole = scene.grid.volume(sides_.inGrid(cell));
        if (giverAt_[cell] < 0) { // whole cells beside: with their own flux
            giverAt_[cell] = int(givers_.size());
            givers_.emplace_back();
            givers_.back().cell = cell;
            givers_.back().to.push_back({cell, 1});
            taker.from.push_back({cell, 1});
            taker.volume += whole;
        }
        taker.volume = std::max(taker.volume, leastOpen * whole);
    }
}

// Volume of the soils in a cell over its own, of those on its side where it is parted.
template <int Dim> double SharedCells<Dim>::coverOfSoils(const Scene<Dim>& scene, int number) const {
    if (sides_.fieldOf(number) >= 0) return coverOnSide(scene, sides_.first(), number);
    double cover = 0;
    for (size_t g = 0; g < isSoil_.size(); ++g)
        if (isSoil_[g]) cover += coverOf(scene, int(g), number);
    return cover;
}

// The flux of a cell goes to its own soil as far as that has room, else to the neighbours that have more; diagonal
// ones where no other has soil.
template <int Dim> void SharedCells<Dim>::give(const Scene<Dim>& scene, int number) {
    const Grid<Dim>& grid = scene.grid;
    const int cell = sides_.inGrid(number);
    const double open = openPart(grid, number), volume = open * grid.volume(cell);
    const bool hasOwn = coverOfSoils(scene, number) > 0;
    double own = hasOwn ? std::min(1.0, open / ownShare) : 0, sum = 0;
    Giver giver;
    giver.cell = number;
    giver.field = sides_.fieldOf(number);
    if (giver.field >= 0) giver.part = sides_.part(grid, giver.field, cell);
    const auto offer = [&](int other, double part) {
        if (!(coverOfSoils(scene, other) > 0)) return;
        const double there = std::max(openPart(grid, other), leastWeight);
        giver.to.push_back({other, there * there * part});
        sum += there * there * part;
    };
    for (int ring = 1; ring <= 2 && own < 1 && sum == 0; ++ring)
        sides_.forBeside(grid, number, [&](int other, int axes, double part) {
            if ((axes == 1) == (ring == 1)) offer(other, part);
        });
    if (giver.field >= 0 && !hasOwn && sum == 0) // soil that begins two cells away reaches its corners
        sides_.forBeside(grid, number, [&](int next, int axes, double) {
            if (axes != 1 || sides_.fieldOf(next) != giver.field) return;
            sides_.forBeside(grid, next, [&](int other, int its, double part) {
                if (its == 1) offer(other, part);
            });
        });
    for (Part& part : giver.to) part.part *= (1 - own) / sum;
    if (sum == 0) own = hasOwn;
    if (own > 0) giver.to.push_back({number, own});
    if (giver.to.empty()) return;
    for (const Part& part : giver.to) {
        Taker& taker = takers_[part.cell];
        taker.from.push_back({number, part.part});
        taker.volume += part.part * volume;
    }
    giverAt_[number] = int(givers_.size());
    givers_.push_back(std::move(giver));
}

// The domains of a solid count in a cell by the parts of them that lie in it; where a wall parts the cell, for a side by
// the part of the wall there: half of the whole wall for each would bend it by what stretches the face of the other side.
template <int Dim> void SharedCells<Dim>::findGrowths(const Scene<Dim>& scene) {
    for (auto& body : scene.bodies)
        if (isSolid_[body->velocityField] && body->particles.size() > 0) addGrowth(scene, *body);
}

template <int Dim> void SharedCells<Dim>::addGrowth(const Scene<Dim>& scene, Body<Dim>& body) {
    const Grid<Dim>& grid = scene.grid;
    const int n = body.particles.size();
    double stiffness[Mesh<Dim>::patterns];
    std::vector<int> cells(chunkSize * corners<Dim>);
    CellPoints<Dim> points;
    points.start(body.particles, body.domains->mesh());
    std::vector<double> part; // of the solids, for each giver
    for (const Giver& giver : givers_)
        part.push_back(giver.field < 0 ? 1 : sides_.solids(grid, giver.field, sides_.inGrid(giver.cell)));
    const auto forGivers = [&](int cell, auto&& f) { // f(giver, part of the solids)
        sides_.forNumbers(cell, [&](int number) {
            if (giverAt_[number] < 0) return;
            f(givers_[giverAt_[number]], part[giverAt_[number]]);
        });
    };
    for (int begin = 0; begin < n; begin += chunkSize) {
        const int end = std::min(n, begin + chunkSize);
        points.place(grid, begin, end, cells.data());
        for (int p = begin; p < end; ++p) {
            const int *const first = &cells[points.at(p) - points.at(begin)], *const last =
                                                                                  first + points.per(p);
            bool isAny = false;
            for (const int* cell = first; cell < last; ++cell)
                forGivers(*cell, [&](Giver&, double) { isAny = true; });
            if (!isAny) continue;
            const double volume = body.particles.volume.plane()[p] / points.per(p);
            for (const int* cell = first; cell < last; ++cell)
                forGivers(*cell, [&](Giver& giver, double its) { giver.ofSolids += its * volume; });
            body.domains->mesh()->strains(
                p,
                [&](int node, double, const Vec<Dim>& gradient, double hoop, const double*) {
                    const Vec<Dim> slope = volume * (gradient + hoop * Vec<Dim>::Unit(0));
                    for (const int* cell = first; cell < last; ++cell)
                        forGivers(*cell, [&](Giver& giver, double its) {
                            giver.grow(body.velocityField, node, its * slope);
                        });
                },
                stiffness);
        }
    }
}

template <int Dim> void SharedCells<Dim>::takeVolumes(const Scene<Dim>& scene) {
    for (const Giver& giver : givers_)
        for (int a = 0; a < corners<Dim>; ++a) {
            const int node = cornerOf(scene.grid, sides_.inGrid(giver.cell), a);
            for (size_t g = 0; g < volumes_.size(); ++g)
                if (isSoil_[g]) setVolume(int(g), node, volumeOfSoil(scene, int(g), node, false));
        }
}

// The weight of the velocity of a group in the motion of a corner of a giver.
template <int Dim> double SharedCells<Dim>::partOf(const Giver& giver, int group, int node) const {
    const double own = volumeOf(group, node);
    if (own == 0) return 0;
    const double all = volumeAt(node);
    if (giver.field < 0 || sides_.isOne(node)) return giver.part * own / all;
    const double ofSoil = volumeOf(giver.field, node) / all;
    if (group == giver.field) return ofSoil;
    if (!isSolid_[group]) return 0;
    double solids = 0;
    for (size_t g = 0; g < volumes_.size(); ++g)
        if (isSolid_[g]) solids += volumeOf(int(g), node);
    return (giver.part - ofSoil) * own / solids;
}

template <int Dim> void SharedCells<Dim>::addForces(Scene<Dim>& scene) {
    using NF = NodalField<Dim>;
    Grid<Dim>& grid = scene.grid;
    forces_.clear();
    ofCells_.clear();
    for (const Giver& giver : givers_) {
        double stress = 0; // mean one that acts on its corners, kPa
        for (const Part& to : giver.to) {
            const Taker& taker = takers_.at(to.cell);
            stress += to.part * taker.acting / taker.volume;
        }
        if (stress == 0) continue;
        const int cell = sides_.inGrid(giver.cell);
        const int ofMost = groupOf(scene, sides_.inGrid(giver.to.front().cell));
        const auto soilAt = [&](int node) {
            return giver.field < 0 || sides_.isOne(node) ? ofMost : giver.field;
        };
        for (const Growth& solid : giver.solids) {
            const Vec<Dim> force = stress * solid.slope;
            for (int k = 0; k < Dim; ++k) NF::addForce(grid.fields[solid.group].sum[solid.node], k, force[k]);
            forces_.push_back({soilAt(solid.node), solid.group, solid.node, force});
        }
        for (int g = 0; g < int(volumes_.size()); ++g) {
            Vec<Dim> sum = Vec<Dim>::Zero();
            for (int a = 0; a < corners<Dim>; ++a) {
                const int node = cornerOf(grid, cell, a);
                const double part = partOf(giver, g, node);
                if (part == 0) continue;
                const Vec<Dim> force = -part * stress * slopeOf(grid, cell, a);
                for (int k = 0; k < Dim; ++k) NF::addForce(grid.fields[g].sum[node], k, force[k]);
                if (isSolid_[g]) forces_.push_back({soilAt(node), g, node, force});
                sum += force;
            }
            if (!isSolid_[g] || sum.isZero(0)) continue;
            ofCells_.push_back({ofMost, g, cell, sum});
        }
    }
}

template class SharedCells<2>;
template class SharedCells<3>;

} // namespace mpm
