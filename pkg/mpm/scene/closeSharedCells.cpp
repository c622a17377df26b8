// SPDX-License-Identifier: GPL-2.0-or-later
// Which shared cells are closed, by how full they are, and how far they lie from free surfaces.
#include "mpm/scene/SharedCells.hpp"
#include "mpm/scene/soilInCells.hpp"

#include <algorithm>

namespace mpm {

namespace {

// How full cells around are where there is a free surface, and from which on there is none.
constexpr double emptyAround = 0.66, filledAround = 0.72;
// How full the corners of a taker are to be for it to close: 0.75 at a flat free surface, about 1 inside. At first, for
// boxes round a body that was put in its place leave gaps; later; beside a closed one.
constexpr double fullAtFirst = 0.95, full = 0.98, fullBesideClosed = 0.7;

} // namespace

// Volume of the soils on both sides over that of a cell.
template <int Dim> double SharedCells<Dim>::coverOfAll(const Scene<Dim>& scene, int cell) const {
    double cover = 0;
    sides_.forNumbers(cell, [&](int number) { cover += coverOfSoils(scene, number); });
    return cover;
}

// Empty cells beside the solids with a way out, through faces of empty cells, to one that is not beside them. The others
// are the wake of a body in soil that has not yet followed.
template <int Dim> void SharedCells<Dim>::findAir(const Scene<Dim>& scene) {
    const Grid<Dim>& grid = scene.grid;
    const auto isEmpty = [&](int cell) { return solid_[cell] < 1 && coverOfAll(scene, cell) == 0; };
    std::vector<int> empty;
    std::copy_if(near_.begin(), near_.end(), std::back_inserter(empty), isEmpty);
    const auto add = [&](int cell) {
        if (!isAir_[cell]) air_.push_back(cell);
        isAir_[cell] = 1;
    };
    for (int cell : empty)
        forCellsBeside(grid, cell, [&](int other, int axes) {
            if (axes == 1 && !isNear_[other] && isEmpty(other)) add(cell);
        });
    for (size_t i = 0; i < air_.size(); ++i)
        forCellsBeside(grid, air_[i], [&](int other, int axes) {
            if (axes == 1 && isNear_[other] && isEmpty(other)) add(other);
        });
}

// How full a cell and those round it are of soil and solids. What solids alone surround counts the less the more they
// do: a hole in them is no free surface.
template <int Dim> double SharedCells<Dim>::fullAround(const Scene<Dim>& scene, int number, int field) {
    const auto [found, isNew] = fullness_.try_emplace({number, field}, 1.0);
    if (!isNew) return found->second;
    const auto soilIn = [&](int cell) {
        if (field < 0) return coverOfAll(scene, cell);
        const double part = sides_.fieldOf(cell) < 0 ? sides_.part(scene.grid, field, cell) : 1;
        return part * coverOfSoils(scene, sides_.fieldOf(cell) < 0 ? cell : sides_.place(field, cell));
    };
    const auto solidIn = [&](int cell) {
        return field < 0 ? solid_[cell] : std::max(solid_[cell], 1 - sides_.open(scene.grid, field, cell));
    };
    double sum = 0, weights = 0;
    const auto add = [&](int cell, int) {
        const double soil = soilIn(cell);
        const double cover = soil == 0 && isNear_[cell] && !isAir_[cell] ? 1 : soil + solidIn(cell);
        double weight = 1;
        if (soil == 0 && cover < 1) {
            double soils = 0, solids = solidIn(cell);
            forCellsBeside(scene.grid, cell, [&](int other, int) {
                soils += soilIn(other);
                solids += solidIn(other);
            });
            weight = soils > 0 ? 1 : std::max(0.0, 1 - solids);
        }
        sum += weight * std::min(1.0, cover);
        weights += weight;
    };
    add(number, 0);
    forCellsBeside(scene.grid, number, add);
    return found->second = weights > 0 ? sum / weights : 1;
}

// How far a taker lies from free surfaces, from 0 at one to 1: by the cells round it, for single cells in the wake of a
// body may be empty. At the ends of a body that stands on a free surface it is 0: what the cells there put on the
// body's sides would push it along the surface. (0.75: one cell of a row beside the taker, across, is at a surface.)
template <int Dim> double SharedCells<Dim>::insideOfAll(const Scene<Dim>& scene, int number) {
    const int field = sides_.fieldOf(number);
    const auto full = [&](int cell) {
        return std::clamp((fullAround(scene, cell, field) - emptyAround) / (filledAround - emptyAround), 0.0,
                          1.0);
    };
    return insideBy(scene.grid, sides_.inGrid(number), full, 0.75, 1.0);
}

// Whether a taker stands beside one that was closed. Soil that has flowed round a body covers the cells there unevenly.
template <int Dim>
bool SharedCells<Dim>::isBesideClosed(const Grid<Dim>& grid, int number,
                                      const std::map<int, Gap>& gaps) const {
    bool isBeside = false;
    sides_.forBeside(grid, number, [&](int other, int axes, double) {
        const auto found = axes == 1 ? gaps.find(other) : gaps.end();
        isBeside |= found != gaps.end() && found->second.is == Gap::Is::closed;
    });
    return isBeside;
}

// How full the corners of takers are with matter: 0.75 at a flat free surface, about 1 inside. Exact, for the masses
// on the nodes have not the volumes that boxes have now.
template <int Dim>
std::map<int, double> SharedCells<Dim>::fillings(const Scene<Dim>& scene, const std::vector<int>& numbers) {
    const Grid<Dim>& grid = scene.grid;
    std::map<int, double> filled;
    if (numbers.empty()) return filled;
    std::vector<int> reach, touched; // cells whose boxes reach the corners
    for (int number : numbers) {
        const int cell = sides_.inGrid(number);
        if (!isReached_[cell]) reach.push_back(cell);
        isReached_[cell] = 1;
    }
    for (size_t begin = 0, ring = 0; ring < 2; ++ring) {
        const size_t end = reach.size();
        for (; begin < end; ++begin)
            forCellsBeside(grid, reach[begin], [&](int cell, int) {
                if (!isReached_[cell]) reach.push_back(cell);
                isReached_[cell] = 1;
            });
    }
    addBoxes(scene, reach, touched);
    for (int number : numbers)
        for (int a = 0; a < corners<Dim>; ++a) {
            const int node = cornerOf(grid, sides_.inGrid(number), a), field = sides_.fieldOf(number);
            double volume = volumeAt(node);
            if (field >= 0 && !sides_.isOne(node))
                volume += scratch_[sides_.place(field, node)] + sides_.beyond(grid, field, node) * hat_[node];
            else
                volume +=
                    scratch_[node] + (sides_.areAny() ? scratch_[sides_.place(sides_.second(), node)] : 0);
            for (size_t g = 0; g < volumes_.size(); ++g)
                if (isSoil_[g]) volume += volumeOfSoil(scene, int(g), node, true);
            filled[number] += volume / hat_[node] / corners<Dim>;
        }
    for (int place : touched) scratch_[place] = 0;
    for (int cell : reach) isReached_[cell] = 0;
    return filled;
}

// The volumes of the boxes in some cells at the nodes, of each field of a parted soil.
template <int Dim>
void SharedCells<Dim>::addBoxes(const Scene<Dim>& scene, const std::vector<int>& reach,
                                std::vector<int>& touched) {
    const auto [lowest, highest] = std::minmax_element(reach.begin(), reach.end());
    for (auto& body : scene.bodies) {
        if (!isSoil_[body->velocityField] || !actsByCells(*body)) continue;
        const bool isParted = sides_.areAny() && body->particles.size() > 0 && body->domains->boxes();
        std::vector<int> which[2]; // of the first and of the second field
        const auto look = [&](int p, int number) {
            auto& its = which[isParted && body->domains->boxes()->seconds()[p]];
            if (isReached_[sides_.inGrid(number)] && (its.empty() || its.back() != p)) its.push_back(p);
        };
        body->cellAverage.forCells(*lowest, *highest, look);
        if (isParted)
            body->cellAverage.forCells(sides_.place(sides_.second(), *lowest),
                                       sides_.place(sides_.second(), *highest), look);
        for (int half = 0; half < 1 + isParted; ++half) {
            const int begin = half == 0 ? 0 : sides_.place(sides_.second(), 0);
            std::vector<int> nodes;
            body->domains->addQuantity(body->particles.volume.plane(), which[half], scratch_.data() + begin,
                                       nodes);
            for (int node : nodes) touched.push_back(begin + node);
        }
    }
}

// Soil that is pulled opens, and closes again once the gap of that is used up. What comes anew beside a closed taker
// goes on with it: soil that has flowed round a body covers the cells there unevenly. What is full and pressed at first is
// closed from the first step on: a body that is put in its place in soil under pressure holds this pressure. All others
// wait until surfaces meet, see closeTouched().
template <int Dim> void SharedCells<Dim>::decide(const Scene<Dim>& scene) {
    std::map<int, Gap> gaps;
    std::vector<int> asked;
    for (auto& [cell, taker] : takers_) {
        const auto before = gaps_.find(cell);
        Gap& gap = gaps[cell];
        if (before != gaps_.end())
            gap = before->second;
        else
            gap.is = gaps_.empty() ? Gap::Is::placed : Gap::Is::unknown;
        const bool isPressed = meanStressIn(scene, cell) < 0;
        taker.isClosed = isPressed && gap.isUsedUp();
        if (gap.isUsedUp()) gap = isPressed ? Gap{Gap::Is::closed} : Gap::after(0);
        if (isPressed && !taker.isClosed) asked.push_back(cell);
    }
    const bool isFirst = gaps_.empty();
    std::vector<int> closing;
    for (const auto& [cell, filled] : fillings(scene, asked)) {
        takers_.at(cell).filled = filled;
        const bool isNew = !isFirst && gaps_.count(cell) == 0;
        const bool mayGoOn = isFirst || ((isNew || gaps[cell].is == Gap::Is::placed) &&
                                         isBesideClosed(scene.grid, cell, gaps_));
        if (mayGoOn && filled >= (isNew ? fullBesideClosed : fullAtFirst)) closing.push_back(cell);
    }
    const auto close = [&] {
        for (int cell : closing) {
            takers_.at(cell).isClosed = true;
            gaps[cell] = {Gap::Is::closed};
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
        if (gaps_.at(cell).isKnown()) tell(scene, cell, taker);
}

// Where the groups press on each other and the cell is full. What is left of a known gap is lost then: a body that slides
// or bounces on its soil would get energy from gaps that any touch closes.
template <int Dim> void SharedCells<Dim>::closeTouched(const Grid<Dim>& grid) {
    const auto touches = [&](const Part& from) {
        bool is = false;
        const int cell = sides_.inGrid(from.cell), field = sides_.fieldOf(from.cell);
        for (int a = 0; a < corners<Dim>; ++a) is |= isTouched_[sides_.place(field, cornerOf(grid, cell, a))];
        return is;
    };
    for (const auto& [cell, taker] : takers_) {
        Gap& gap = gaps_.at(cell);
        const bool isFull = taker.filled >= (gap.is == Gap::Is::placed ? fullAtFirst : full);
        if (isFull && std::any_of(taker.from.begin(), taker.from.end(), touches)) gap = {Gap::Is::closed};
    }
}

// Times volume; of the boxes in a cell.
template <int Dim> double SharedCells<Dim>::meanStressIn(const Scene<Dim>& scene, int number) const {
    double sum = 0;
    for (auto& body : scene.bodies) {
        if (!isSoil_[body->velocityField] || !actsByCells(*body)) continue;
        if (const auto* cell = body->cellAverage.occupied(number)) sum += cell->weight * cell->stress;
    }
    return sum;
}

// Tells the bodies with boxes in a taker their part of its volume, whether it is open, and how far inside of all material
// a closed one lies.
template <int Dim> void SharedCells<Dim>::tell(const Scene<Dim>& scene, int number, const Taker& taker) {
    const double soils = coverOfSoils(scene, number);
    for (auto& body : scene.bodies) {
        const int group = body->velocityField;
        auto* cell = isSoil_[group] && actsByCells(*body) ? body->cellAverage.occupied(number) : nullptr;
        if (!cell) continue;
        const double share = sides_.fieldOf(number) < 0 ? cell->share * coverOf(scene, group, number)
                                                        : cell->volume / cell->whole;
        cell->shared = taker.volume * share / soils;
        cell->isOpen = !taker.isClosed;
        if (taker.isClosed) cell->inside = insideOfAll(scene, number);
    }
}

template <int Dim> void SharedCells<Dim>::store(std::vector<double>& cells, std::vector<double>& gaps) const {
    cells.clear();
    gaps.clear();
    for (const auto& [cell, gap] : gaps_) {
        cells.push_back(cell);
        gaps.push_back(gap.number());
    }
}

template <int Dim>
void SharedCells<Dim>::restore(const std::vector<double>& cells, const std::vector<double>& gaps) {
    clear();
    step_ = -1;
    gaps_.clear();
    for (size_t i = 0; i < std::min(cells.size(), gaps.size()); ++i) gaps_[int(cells[i])] = Gap::of(gaps[i]);
}

template class SharedCells<2>;
template class SharedCells<3>;

} // namespace mpm
