// SPDX-License-Identifier: GPL-2.0-or-later
#include "mpm/scene/SharedCells.hpp"

#include "mpm/scene/Scene.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace mpm {

namespace {

constexpr double ownShare = 0.5;   // open part of a cell from which on its own soil takes all of its flux
constexpr double leastOpen = 0.25; // part of a cell that a taker counts as open at least
constexpr double leastWeight = 0.05;
// How full cells around are where there is a free surface, and from which on there is none.
constexpr double emptyAround = 0.66, filledAround = 0.72;
// Density of a body over that of the soil from which on cells are shared, unless it is driven: the step falls with it.
constexpr double leastDensity = 0.04;
// How full the corners of a taker are to be for it to close: 0.75 at a flat free surface, about 1 inside. At first, for
// boxes round a body that was put in its place leave gaps; later; beside a closed one.
constexpr double fullAtFirst = 0.95, full = 0.98, fullBesideClosed = 0.7;

// f(cell, along how many axes it is beside) for the cells of the grid beside one.
template <int Dim, class F> void forNeighbours(const Grid<Dim>& grid, int cell, F&& f) {
    forAround(grid, cell, [&](int other, int axes) {
        if (axes > 0) f(other, axes);
    });
}

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

// Whether the bodies of a field may have given mass to a node in this step.
template <int Dim> bool mayHaveMass(const Grid<Dim>& grid, const NodalField<Dim>& field, int node) {
    const Index<Dim> index = grid.indices(node);
    const auto& extent = field.extents[index[Dim - 1]];
    bool isIn = true;
    for (int k = 0; k < Dim - 1; ++k) isIn &= index[k] >= extent.first[k] && index[k] <= extent.last[k];
    return isIn && extent.first[0] <= extent.last[0];
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

// Of the bodies of a soil on a node, or so far of its meshes, m3. They have about one density: that of the first.
template <int Dim> double volumeOfSoil(const Scene<Dim>& scene, int group, int node, bool ofMeshes) {
    double density = 0;
    for (auto& body : scene.bodies)
        if (density == 0 && body->velocityField == group && (!ofMeshes || body->domains->mesh()))
            density = body->material->density;
    const auto& field = scene.grid.fields[group];
    return density > 0 && mayHaveMass(scene.grid, field, node)
               ? field.sum[node][NodalField<Dim>::weightMass] / density
               : 0;
}

// Volume of what has F-bar of a group in a cell over that of the cell.
template <int Dim> double coverOf(const Scene<Dim>& scene, int group, int cell) {
    double sum = 0;
    for (auto& body : scene.bodies)
        if (body->velocityField == group && body->fbar) sum += body->cellAverage.coverOf(cell);
    return sum;
}

// Of the soil that has most of a cell.
template <int Dim> int groupOf(const Scene<Dim>& scene, int cell) {
    std::vector<double> covers(scene.groups.size(), 0.0);
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
    findSolids(scene);
    findAir(scene);
    findGivers(scene);
    findGrowths(scene);
    decide(scene);
}

// Groups with boxes that act by cells, and groups of meshes alone, unless they are too light.
template <int Dim> void SharedCells<Dim>::findGroups(const Scene<Dim>& scene) {
    const size_t groups = scene.groups.size();
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
    if (volumes_.size() == groups) return;
    const int count = scene.grid.count;
    volumes_.assign(groups, {});
    scratch_.assign(count, 0.0);
    isTouched_.assign(count, 0);
    solid_.assign(count, 0.0);
    hat_.resize(count);
    for (int node = 0; node < count; ++node) hat_[node] = hatVolume(scene.grid, node);
    isNear_.assign(count, 0);
    isAir_.assign(count, 0);
    isReached_.assign(count, 0);
    giverAt_.assign(count, -1);
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

// Whether soil that acts by cells is in a cell.
template <int Dim> bool SharedCells<Dim>::hasSoil(const Scene<Dim>& scene, int cell) const {
    return coverOfSoils(scene, cell) > 0;
}

template <int Dim> void SharedCells<Dim>::findGivers(const Scene<Dim>& scene) {
    for (int cell : near_) give(scene, cell);
    for (auto& [cell, taker] : takers_) {
        const double whole = scene.grid.volume(cell);
        if (giverAt_[cell] < 0) { // whole cells beside: with their own flux
            giverAt_[cell] = int(givers_.size());
            givers_.push_back({cell, {{cell, 1}}});
            taker.from.push_back({cell, 1});
            taker.volume += whole;
        }
        taker.volume = std::max(taker.volume, leastOpen * whole);
    }
}

// Volume of the soils in a cell over its own.
template <int Dim> double SharedCells<Dim>::coverOfSoils(const Scene<Dim>& scene, int cell) const {
    double cover = 0;
    for (size_t g = 0; g < isSoil_.size(); ++g)
        if (isSoil_[g]) cover += coverOf(scene, int(g), cell);
    return cover;
}

// Empty cells beside the solids with a way out, through faces of empty cells, to one that is not beside them. The others
// are the wake of a body in soil that has not yet followed.
template <int Dim> void SharedCells<Dim>::findAir(const Scene<Dim>& scene) {
    const Grid<Dim>& grid = scene.grid;
    const auto isEmpty = [&](int cell) { return solid_[cell] < 1 && coverOfSoils(scene, cell) == 0; };
    std::vector<int> empty;
    std::copy_if(near_.begin(), near_.end(), std::back_inserter(empty), isEmpty);
    const auto add = [&](int cell) {
        if (!isAir_[cell]) air_.push_back(cell);
        isAir_[cell] = 1;
    };
    for (int cell : empty)
        forNeighbours(grid, cell, [&](int other, int axes) {
            if (axes == 1 && !isNear_[other] && isEmpty(other)) add(cell);
        });
    for (size_t i = 0; i < air_.size(); ++i)
        forNeighbours(grid, air_[i], [&](int other, int axes) {
            if (axes == 1 && isNear_[other] && isEmpty(other)) add(other);
        });
}

// How full a cell and those round it are of soil and solids. What solids alone surround counts the less the more they
// do: a hole in them is no free surface.
template <int Dim> double SharedCells<Dim>::fullAround(const Scene<Dim>& scene, int number) {
    const auto [found, isNew] = fullness_.try_emplace(number, 1.0);
    if (!isNew) return found->second;
    double sum = 0, weights = 0;
    const auto add = [&](int cell, int) {
        const double soil = coverOfSoils(scene, cell);
        const double cover = soil == 0 && isNear_[cell] && !isAir_[cell] ? 1 : soil + solid_[cell];
        double weight = 1;
        if (soil == 0 && cover < 1) {
            double soils = 0, solids = solid_[cell];
            forNeighbours(scene.grid, cell, [&](int other, int) {
                soils += coverOfSoils(scene, other);
                solids += solid_[other];
            });
            weight = soils > 0 ? 1 : std::max(0.0, 1 - solids);
        }
        sum += weight * std::min(1.0, cover);
        weights += weight;
    };
    add(number, 0);
    forNeighbours(scene.grid, number, add);
    return found->second = weights > 0 ? sum / weights : 1;
}

// How far a taker lies from free surfaces, from 0 at one to 1: by the cells round it, for single cells in the wake of a
// body may be empty. At the ends of a body that stands on a free surface it is 0: what the cells there put on the
// body's sides would push it along the surface. (0.75: one cell of a row beside the taker, across, is at a surface.)
template <int Dim> double SharedCells<Dim>::insideOfAll(const Scene<Dim>& scene, int number) {
    const auto full = [&](int cell) {
        return std::clamp((fullAround(scene, cell) - emptyAround) / (filledAround - emptyAround), 0.0, 1.0);
    };
    return insideBy(scene.grid, number, full, 0.75, 1.0);
}

// The flux of a cell goes to its own soil as far as that has room, else to the neighbours that have more; diagonal
// ones where no other has soil.
template <int Dim> void SharedCells<Dim>::give(const Scene<Dim>& scene, int cell) {
    const Grid<Dim>& grid = scene.grid;
    const double open = openPart(cell), volume = open * grid.volume(cell);
    const bool hasOwn = hasSoil(scene, cell);
    double own = hasOwn ? std::min(1.0, open / ownShare) : 0, sum = 0;
    Giver giver{cell, {}};
    for (int ring = 1; ring <= 2 && own < 1 && sum == 0; ++ring)
        forNeighbours(grid, cell, [&](int other, int axes) {
            if ((axes == 1) != (ring == 1) || !hasSoil(scene, other)) return;
            const double there = std::max(openPart(other), leastWeight);
            giver.to.push_back({other, there * there});
            sum += there * there;
        });
    for (Part& part : giver.to) part.part *= (1 - own) / sum;
    if (sum == 0) own = hasOwn;
    if (own > 0) giver.to.push_back({cell, own});
    if (giver.to.empty()) return;
    for (const Part& part : giver.to) {
        Taker& taker = takers_[part.cell];
        taker.from.push_back({cell, part.part});
        taker.volume += part.part * volume;
    }
    giverAt_[cell] = int(givers_.size());
    givers_.push_back(giver);
}

// The domains of a solid count in a cell by the parts of them that lie in it.
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
    for (int begin = 0; begin < n; begin += chunkSize) {
        const int end = std::min(n, begin + chunkSize);
        points.place(grid, begin, end, cells.data());
        for (int p = begin; p < end; ++p) {
            const int *const first = &cells[points.at(p) - points.at(begin)], *const last =
                                                                                  first + points.per(p);
            if (std::all_of(first, last, [&](int cell) { return giverAt_[cell] < 0; })) continue;
            const double part = body.particles.volume.plane()[p] / points.per(p);
            for (const int* cell = first; cell < last; ++cell)
                if (giverAt_[*cell] >= 0) givers_[giverAt_[*cell]].ofSolids += part;
            body.domains->mesh()->strains(
                p,
                [&](int node, double, const Vec<Dim>& gradient, double hoop, const double*) {
                    const Vec<Dim> slope = part * (gradient + hoop * Vec<Dim>::Unit(0));
                    for (const int* cell = first; cell < last; ++cell)
                        if (giverAt_[*cell] >= 0)
                            givers_[giverAt_[*cell]].grow(body.velocityField, node, slope);
                },
                stiffness);
        }
    }
}

// Whether a taker stands beside one that was closed. Soil that has flowed round a body covers the cells there unevenly.
template <int Dim>
bool SharedCells<Dim>::isBesideClosed(const Grid<Dim>& grid, int cell,
                                      const std::map<int, double>& gaps) const {
    bool isBeside = false;
    forNeighbours(grid, cell, [&](int other, int axes) {
        const auto found = axes == 1 ? gaps.find(other) : gaps.end();
        isBeside |= found != gaps.end() && found->second == 0;
    });
    return isBeside;
}

// How full the corners of takers are with matter: 0.75 at a flat free surface, about 1 inside. Exact, for the masses
// on the nodes have not the volumes that boxes have now.
template <int Dim>
std::map<int, double> SharedCells<Dim>::fillings(const Scene<Dim>& scene, const std::vector<int>& cells) {
    const Grid<Dim>& grid = scene.grid;
    std::map<int, double> filled;
    if (cells.empty()) return filled;
    std::vector<int> reach = cells, touched, which; // cells whose boxes reach the corners
    for (int cell : cells) isReached_[cell] = 1;
    for (size_t begin = 0, ring = 0; ring < 2; ++ring) {
        const size_t end = reach.size();
        for (; begin < end; ++begin)
            forNeighbours(grid, reach[begin], [&](int cell, int) {
                if (!isReached_[cell]) reach.push_back(cell);
                isReached_[cell] = 1;
            });
    }
    const auto [lowest, highest] = std::minmax_element(reach.begin(), reach.end());
    for (auto& body : scene.bodies) {
        if (!isSoil_[body->velocityField] || !actsByCells(*body)) continue;
        which.clear();
        body->cellAverage.forCells(*lowest, *highest, [&](int p, int cell) {
            if (isReached_[cell] && (which.empty() || which.back() != p)) which.push_back(p);
        });
        body->domains->addQuantity(body->particles.volume.plane(), which, scratch_.data(), touched);
    }
    for (int cell : cells)
        for (int a = 0; a < corners<Dim>; ++a) {
            const int node = cornerOf(grid, cell, a);
            double volume = volumeAt(node) + scratch_[node];
            for (size_t g = 0; g < volumes_.size(); ++g)
                if (isSoil_[g]) volume += volumeOfSoil(scene, int(g), node, true);
            filled[cell] += volume / hat_[node] / corners<Dim>;
        }
    for (int node : touched) scratch_[node] = 0;
    for (int cell : reach) isReached_[cell] = 0;
    return filled;
}

// Soil that is pulled opens, and closes again once the gap of that is used up. What comes anew beside a closed taker
// goes on with it: soil that has flowed round a body covers the cells there unevenly. What is full and pressed at first is
// closed from the first step on: a body that is put in its place in soil under pressure holds this pressure. All others
// wait until surfaces meet, see closeTouched().
template <int Dim> void SharedCells<Dim>::decide(const Scene<Dim>& scene) {
    std::map<int, double> gaps;
    std::vector<int> asked;
    for (auto& [cell, taker] : takers_) {
        const auto before = gaps_.find(cell);
        double& gap = gaps[cell] = before != gaps_.end() ? before->second : gaps_.empty() ? placed : unknown;
        const bool isPressed = meanStressIn(scene, cell) < 0;
        taker.isClosed = isPressed && (gap == 0 || gap == usedUp);
        if (gap == 0 || gap == usedUp) gap = isPressed ? 0 : usedUp;
        if (isPressed && !taker.isClosed) asked.push_back(cell);
    }
    const bool isFirst = gaps_.empty();
    std::vector<int> closing;
    for (const auto& [cell, filled] : fillings(scene, asked)) {
        takers_.at(cell).filled = filled;
        const bool isNew = !isFirst && gaps_.count(cell) == 0;
        const bool mayGoOn =
            isFirst || ((isNew || gaps[cell] == placed) && isBesideClosed(scene.grid, cell, gaps_));
        if (mayGoOn && filled >= (isNew ? fullBesideClosed : fullAtFirst)) closing.push_back(cell);
    }
    const auto close = [&] {
        for (int cell : closing) {
            takers_.at(cell).isClosed = true;
            gaps[cell] = 0;
        }
        closing.clear();
    };
    close();
    for (int cell : asked) { // at the corners of a mesh that lies at an angle to the grid
        const Taker& taker = takers_.at(cell);
        if (isFirst && !taker.isClosed && taker.filled >= fullBesideClosed &&
            isBesideClosed(scene.grid, cell, gaps) && insideOfAll(scene, cell) == 1)
            closing.push_back(cell);
    }
    close();
    gaps_.swap(gaps);
    for (const auto& [cell, taker] : takers_)
        if (gaps_.at(cell) >= 0) tell(scene, cell, taker);
}

// Where the groups press on each other and the cell is full. What is left of a known gap is lost then: a body that slides
// or bounces on its soil would get energy from gaps that any touch closes.
template <int Dim> void SharedCells<Dim>::closeTouched(const Grid<Dim>& grid) {
    const auto touches = [&](const Part& from) {
        bool is = false;
        for (int a = 0; a < corners<Dim>; ++a) is |= isTouched_[cornerOf(grid, from.cell, a)];
        return is;
    };
    for (const auto& [cell, taker] : takers_) {
        double& gap = gaps_.at(cell);
        const bool isFull = taker.filled >= (gap == placed ? fullAtFirst : full);
        if (isFull && std::any_of(taker.from.begin(), taker.from.end(), touches)) gap = 0;
    }
}

// Times volume; of the boxes in a cell.
template <int Dim> double SharedCells<Dim>::meanStressIn(const Scene<Dim>& scene, int number) const {
    double sum = 0;
    for (auto& body : scene.bodies) {
        if (!isSoil_[body->velocityField] || !actsByCells(*body)) continue;
        if (const auto* cell = body->cellAverage.occupied(number)) sum += cell->weight * cell->mean;
    }
    return sum;
}

// Tells the bodies with boxes in a taker their part of its volume, negative where it is open, and how far inside of all
// material a closed one lies.
template <int Dim> void SharedCells<Dim>::tell(const Scene<Dim>& scene, int number, const Taker& taker) {
    const double soils = coverOfSoils(scene, number);
    for (auto& body : scene.bodies) {
        const int group = body->velocityField;
        auto* cell = isSoil_[group] && actsByCells(*body) ? body->cellAverage.occupied(number) : nullptr;
        if (!cell) continue;
        cell->shared =
            (taker.isClosed ? 1 : -1) * taker.volume * cell->share * coverOf(scene, group, number) / soils;
        if (taker.isClosed) cell->inside = insideOfAll(scene, number);
    }
}

template <int Dim> void SharedCells<Dim>::takeVolumes(const Scene<Dim>& scene) {
    for (const Giver& giver : givers_)
        for (int a = 0; a < corners<Dim>; ++a) {
            const int node = cornerOf(scene.grid, giver.cell, a);
            for (size_t g = 0; g < volumes_.size(); ++g)
                if (isSoil_[g]) setVolume(int(g), node, volumeOfSoil(scene, int(g), node, false));
        }
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
        const int soil = groupOf(scene, giver.to.front().cell);
        for (const Growth& solid : giver.solids) {
            const Vec<Dim> force = stress * solid.slope;
            for (int k = 0; k < Dim; ++k) NF::addForce(grid.fields[solid.group].sum[solid.node], k, force[k]);
            forces_.push_back({soil, solid.group, solid.node, force});
        }
        for (int g = 0; g < int(volumes_.size()); ++g) {
            Vec<Dim> sum = Vec<Dim>::Zero();
            for (int a = 0; a < corners<Dim>; ++a) {
                const int node = cornerOf(grid, giver.cell, a);
                const double own = volumeOf(g, node), part = own > 0 ? own / volumeAt(node) : 0;
                if (part == 0) continue;
                const Vec<Dim> force = -part * stress * slopeOf(grid, giver.cell, a);
                for (int k = 0; k < Dim; ++k) NF::addForce(grid.fields[g].sum[node], k, force[k]);
                if (isSolid_[g]) forces_.push_back({soil, g, node, force});
                sum += force;
            }
            if (!isSolid_[g] || sum.isZero(0)) continue;
            ofCells_.push_back({soil, g, giver.cell, sum});
        }
    }
}

template <int Dim> void SharedCells<Dim>::store(std::vector<double>& cells, std::vector<double>& gaps) const {
    cells.clear();
    gaps.clear();
    for (const auto& [cell, gap] : gaps_) {
        cells.push_back(cell);
        gaps.push_back(gap);
    }
}

template <int Dim>
void SharedCells<Dim>::restore(const std::vector<double>& cells, const std::vector<double>& gaps) {
    clear();
    step_ = -1;
    gaps_.clear();
    for (size_t i = 0; i < std::min(cells.size(), gaps.size()); ++i) gaps_[int(cells[i])] = gaps[i];
}

template class SharedCells<2>;
template class SharedCells<3>;

} // namespace mpm
