// SPDX-License-Identifier: GPL-2.0-or-later
// The mean stress of boxes beside rigid bodies, where it reaches up to the surface: there some cells act
// whole, others by their particles (share s, see CellAverage). A box counts in the cell c of its centre. Its
// part in a cell j that acts whole would act twice, and one beyond such a cell not at all. With the
// volume V_j of these parts and their centres x_j, where hat functions have their means over the part,
//     f_i -= p_c sum_j (s_c - s_j) V_j grad S_i(x_j),
//     r_c = (V_a r_c + eta sum_j (s_c - s_j) V_j sum_i v_i . grad S_i(x_j))/(V_a + sum_j (s_c - s_j) V_j),
// each the transpose of the other. So a pressure that is the same everywhere is in equilibrium with bodies
// that press on the faces of boxes. At a free surface there is no mean stress that could count twice.
#pragma once

#include "mpm/scene/Scene.hpp"
#include "mpm/state/cover.hpp"

#include <functional>
#include <map>

namespace mpm {

// Of one body of the scene.
template <int Dim> class BoxParts {
  public:
    void clear() {
        parts_.clear();
        cells_.clear();
    }
    bool empty() const { return parts_.empty(); }

    // In cells from lowest to highest. isEdge(cell): whose boxes count. insideOf(cell): s.
    template <class IsEdge, class InsideOf>
    void find(const Body<Dim>& body, const Grid<Dim>& grid, int lowest, int highest, IsEdge&& isEdge,
              InsideOf&& insideOf) {
        const Vec<Dim> half = body.domains->boxes()->halfSize();
        body.cellAverage.forCells(lowest, highest, [&](int p, int own) {
            if (isEdge(own)) cut(body, grid, p, own, half, insideOf);
        });
        std::stable_sort(parts_.begin(), parts_.end(),
                         [](const Part& a, const Part& b) { return a.own < b.own; });
        for (const Part& part : parts_) {
            if (cells_.empty() || cells_.back().number != part.own) cells_.push_back({part.own});
            cells_.back().volume += part.volume;
        }
    }
    // Adds the forces of the mean stress of the cells to the nodes.
    void addForces(const Body<Dim>& body, const Grid<Dim>& grid, typename NodalField<Dim>::Sum* nodes) const {
        for (const Part& part : parts_) {
            const auto& cell = *body.cellAverage.occupied(part.own);
            if (cell.shared > 0) continue;
            forCorners(grid, part, [&](int node, const Vec<Dim>& slope) {
                for (int k = 0; k < Dim; ++k)
                    NodalField<Dim>::addForce(nodes[node], k, -cell.mean * part.volume * slope[k]);
            });
        }
    }
    // Before rate(): what flows into the parts of each cell.
    template <class Velocity> void takeFluxes(const Grid<Dim>& grid, const Velocity* nodes) {
        auto cell = cells_.begin();
        for (auto& each : cells_) each.flux = 0;
        for (const Part& part : parts_) {
            while (cell->number != part.own) ++cell;
            forCorners(grid, part, [&](int node, const Vec<Dim>& slope) {
                for (int k = 0; k < Dim; ++k) cell->flux += part.volume * slope[k] * nodes[node][k];
            });
        }
    }
    // Rate of volume change of a cell with its parts, 1/s, from that without; acting: volume of this one, m3.
    double rate(int number, double without, double acting, double uneven) const {
        const auto at = std::lower_bound(cells_.begin(), cells_.end(), number,
                                         [](const Own& cell, int n) { return cell.number < n; });
        if (at == cells_.end() || at->number != number) return without;
        return (without * acting + uneven * at->flux) / (acting + at->volume);
    }

  private:
    struct Part {
        int own, cell;     // that counts the box, and that the part lies in
        double volume;     // m3, times s_c - s_j
        Vec<Dim> at, over; // its centre, from 0 to 1 along the edges of the cell; 1/m, over these edges
    };
    struct Own {
        int number;
        double volume = 0, flux = 0; // m3, m3/s
    };
    std::vector<Part> parts_; // in the order of the cells that count them
    std::vector<Own> cells_;

    // Along each axis a box reaches into one of the cells beside that of its centre at most.
    template <class InsideOf>
    void cut(const Body<Dim>& body, const Grid<Dim>& grid, int p, int own, const Vec<Dim>& half,
             InsideOf&& insideOf) {
        const Index<Dim> index = grid.indices(own);
        int side[Dim];
        Vec<Dim> low, high, x = vectorAt<Dim>(body.particles.position, p);
        for (int k = 0; k < Dim; ++k) {
            low[k] = grid.line(k, index[k]);
            high[k] = grid.line(k, index[k] + 1);
            side[k] = x[k] - half[k] < low[k] ? -1 : x[k] + half[k] > high[k] ? 1 : 0;
        }
        for (int n = 1; n < corners<Dim>; ++n) { // along which axes it is beside
            Part part{own, own, body.particles.volume.plane()[p], Vec<Dim>::Zero(), Vec<Dim>::Zero()};
            bool isThere = true;
            for (int k = 0; k < Dim; ++k) {
                const int step = (n >> k & 1) * side[k];
                const int at = index[k] + step;
                isThere &= step != 0 || (n >> k & 1) == 0;
                isThere &= at >= grid.ghost && at < grid.ghost + grid.cells[k];
                const double edge = grid.cellSize(k, at), start = grid.line(k, at);
                const double from = step > 0 ? high[k] : std::max(start, x[k] - half[k]);
                const double to = step < 0 ? low[k] : std::min(start + edge, x[k] + half[k]);
                part.cell += step * grid.strides[k];
                part.volume *= (to - from) / (2 * half[k]);
                part.at[k] = (0.5 * (from + to) - start) / edge;
                part.over[k] = 1 / edge;
            }
            if (!isThere || insideOf(part.cell) == insideOf(own)) continue;
            part.volume *= insideOf(own) - insideOf(part.cell);
            parts_.push_back(part);
        }
    }
    // f(node, gradient of its hat function at the centre of a part).
    template <class F> static void forCorners(const Grid<Dim>& grid, const Part& part, F&& f) {
        for (int a = 0; a < corners<Dim>; ++a) {
            Vec<Dim> slope;
            for (int k = 0; k < Dim; ++k) {
                slope[k] = cornerSign(a, k) * part.over[k];
                for (int i = 0; i < Dim; ++i)
                    if (i != k) slope[k] *= cornerSign(a, i) > 0 ? part.at[i] : 1 - part.at[i];
            }
            f(cornerOf(grid, part.cell, a), slope);
        }
    }
};

// Marked cells of the grid, each with its share s. What was marked in a step is forgotten cell by cell: a grid may be
// large, and one thread does this.
template <int Dim> class MarkedCells {
  public:
    void reset(const Grid<Dim>& grid) {
        for (int cell : cells_) isMarked_[cell] = 0;
        cells_.clear();
        edges_.clear();
        isMarked_.resize(grid.count);
        inside_.resize(grid.count);
    }
    void add(int cell) {
        if (!isMarked_[cell]) cells_.push_back(cell);
        isMarked_[cell] = true;
    }
    void widen(const Grid<Dim>& grid) {
        const std::vector<int> before = cells_;
        for (int cell : before) forAround(grid, cell, [&](int other, int) { add(other); });
    }
    template <class F> void setInside(F&& of) {
        for (int cell : cells_) inside_[cell] = of(cell);
    }
    // Whether a cell, but for the outermost, has one beside it with another share.
    bool isEdge(int cell) const { return isMarked_[cell] == 2; }
    void findEdges(const Grid<Dim>& grid) {
        for (int cell : cells_) {
            bool isWithin = true, differs = false;
            forAround(grid, cell, [&](int other, int) {
                isWithin &= isMarked_[other] != 0;
                differs |= inside_[other] != inside_[cell];
            });
            if (isWithin && differs) edges_.push_back(cell);
        }
        for (int cell : edges_) isMarked_[cell] = 2;
    }
    double inside(int cell) const { return inside_[cell]; }
    const std::vector<int>& edges() const { return edges_; }
    bool empty() const { return cells_.empty(); }

  private:
    std::vector<char> isMarked_;
    std::vector<double> inside_; // s, of marked ones
    std::vector<int> cells_, edges_;
};

// An engine whose bodies press on boxes.
class PressingOnBoxes {
  public:
    virtual ~PressingOnBoxes() = default;
    // f(number of the body of the scene, place) for the boxes that were pressed in the last step.
    virtual void forPressed(const std::function<void(int, const Vec3&)>& f) const = 0;

    // Of each body of the scene in this step, kept by the first engine of the chain that presses.
    template <int Dim> std::vector<BoxParts<Dim>>& parts() { return std::get<Found<Dim>>(found_).parts; }
    // Of the bodies of boxes that were pressed, by their numbers; those of others are empty.
    template <int Dim> std::map<int, MarkedCells<Dim>>& cells() { return std::get<Found<Dim>>(found_).cells; }

  private:
    template <int Dim> struct Found {
        std::vector<BoxParts<Dim>> parts;
        std::map<int, MarkedCells<Dim>> cells;
    };
    std::tuple<Found<2>, Found<3>> found_;
};

// Where boxes reach beyond a cell that acts whole, or into one, within two cells of those that were pressed.
// One thread.
template <int Dim> void findBoxParts(const Scene<Dim>& scene, PressingOnBoxes& found) {
    const Grid<Dim>& grid = scene.grid;
    auto& parts = found.parts<Dim>();
    auto& pressed = found.cells<Dim>();
    parts.resize(scene.bodies.size());
    for (auto& of : parts) of.clear();
    for (auto& of : pressed) of.second.reset(grid);
    for (auto& engine : scene.engines)
        if (auto* pressing = dynamic_cast<PressingOnBoxes*>(engine.get()); pressing && !engine->dead)
            pressing->forPressed([&](int soil, const Vec3& where) {
                if (!actsByCells(*scene.bodies.at(soil)) || !scene.bodies[soil]->domains->boxes()) return;
                int number = 0;
                for (int k = 0; k < Dim; ++k) grid.addCells(k, &where[k], 1, &number);
                const auto [at, isNew] = pressed.try_emplace(soil);
                if (isNew) at->second.reset(grid);
                at->second.add(number);
            });
    for (auto& [b, cells] : pressed) {
        if (cells.empty()) continue;
        const Body<Dim>& body = *scene.bodies[b];
        for (int ring = 0; ring < 3; ++ring) cells.widen(grid);
        cells.setInside([&](int cell) {
            double inside = 0;
            for (auto& other : scene.bodies)
                if (other->velocityField == body.velocityField && actsByCells(*other))
                    if (const auto* at = std::as_const(other->cellAverage).occupied(cell))
                        inside = std::max(inside, at->inside);
            return inside;
        });
        cells.findEdges(grid);
        if (cells.edges().empty()) continue;
        const auto [lowest, highest] = std::minmax_element(cells.edges().begin(), cells.edges().end());
        parts[b].find(
            body, grid, *lowest, *highest, [&](int cell) { return cells.isEdge(cell); },
            [&](int cell) { return cells.inside(cell); });
    }
}

// The forces of the parts, once the nodes have those of the cells. One thread.
template <int Dim> void addBoxParts(Scene<Dim>& scene, const std::vector<BoxParts<Dim>>& parts) {
    for (size_t b = 0; b < parts.size(); ++b)
        if (!parts[b].empty())
            parts[b].addForces(*scene.bodies[b], scene.grid,
                               scene.grid.fields[scene.bodies[b]->velocityField].sum.data());
}

} // namespace mpm
