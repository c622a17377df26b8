// SPDX-License-Identifier: GPL-2.0-or-later
#include "mpm/scene/PartedSoils.hpp"

#include "mpm/base/spectrum.hpp"
#include "mpm/scene/Scene.hpp"
#include "mpm/scene/thicknessOfWall.hpp"
#include "mpm/state/cover.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

namespace mpm {

namespace {

constexpr double thick = 2 * (1 - 1e-6); // cells; no node reaches the soil on both sides of such a wall
// Slope of a bent wall against its plane: of 60 degrees, for the soil on one side sees no steeper facets.
constexpr double steep = 1.73;
constexpr double slender = 2; // least length of a wall along each axis that it ends on, in thicknesses
// How far inside the ends of a wall it parts the soil, in cells: nearer nodes feel soil that goes through beyond.
constexpr double fromEnd = 1;
// An end that is nearer than this to the border of the grid, in cells, has no soil beyond.
constexpr double atBorder = 0.5;
constexpr double ofNone = 1e-6;     // cells, a distance that is round-off
constexpr double beyondAll = 1e300; // m
constexpr int support = 3;          // nodes that a box reaches along an axis,
constexpr double touching = 1e-9;   // and the weight of one that it only touches, but for round-off

// Middle of particles and the direction in which they are spread least.
template <int Dim> struct Spread {
    Vec<Dim> middle = Vec<Dim>::Zero(), normal = middle;

    explicit Spread(const Field& x) {
        Mat<Dim> square = Mat<Dim>::Zero();
        for (int p = 0; p < x.size(); ++p) middle += vectorAt<Dim>(x, p);
        middle /= std::max(1, x.size());
        for (int p = 0; p < x.size(); ++p) {
            const Vec<Dim> d = vectorAt<Dim>(x, p) - middle;
            square += d * d.transpose();
        }
        normal = spectrumOf<Dim>(square).vectors.col(0);
        int across;
        normal.cwiseAbs().maxCoeff(&across);
        if (normal[across] < 0) normal = -normal;
    }
};

// Whether boxes of a soil lie on both sides of a plane, before anything moves.
template <int Dim>
bool isOnBothSides(const std::vector<Body<Dim>*>& soil, const Vec<Dim>& middle, const Vec<Dim>& normal) {
    bool has[2] = {false, false};
    for (const Body<Dim>* body : soil)
        for (int p = 0; p < body->particles.size(); ++p)
            has[(vectorAt<Dim>(body->particles.reference, p) - middle).dot(normal) > 0] = true;
    return has[0] && has[1];
}

// The middle of a wall beside a place: of its particles that are at most so far away along it, m; its own where there
// are none.
template <int Dim>
Vec<Dim> middleBeside(const Field& wall, const Vec<Dim>& middle, const Vec<Dim>& normal, const Vec<Dim>& x,
                      double reach) {
    Vec<Dim> sum = Vec<Dim>::Zero();
    int count = 0;
    for (int p = 0; p < wall.size(); ++p) {
        const Vec<Dim> at = vectorAt<Dim>(wall, p), d = at - x;
        if ((d - d.dot(normal) * normal).norm() > reach) continue;
        sum += at;
        ++count;
    }
    return count > 0 ? Vec<Dim>(sum / count) : middle;
}

// Whether a mesh is one layer of so much thickness over its plane, within strips of a cell: not a ring or a
// trough, with soil of one side between its legs. strip: width, m.
template <int Dim>
bool isOneLayer(const Field& x, const Vec<Dim>& normal, int across, double thickness, const Vec<Dim>& strip) {
    std::map<std::array<int, Dim - 1>, std::pair<double, double>> reach; // of each strip, along the normal
    for (int p = 0; p < x.size(); ++p) {
        const Vec<Dim> at = vectorAt<Dim>(x, p);
        const double along = at.dot(normal);
        const Vec<Dim> inPlane = at - along * normal;
        std::array<int, Dim - 1> place;
        for (int k = 0, n = 0; k < Dim; ++k)
            if (k != across) place[n++] = int(std::floor(inPlane[k] / strip[k]));
        auto& [least, most] = reach.try_emplace(place, along, along).first->second;
        least = std::min(least, along);
        most = std::max(most, along);
    }
    const double along = strip.maxCoeff() * std::sqrt(Dim - 1.0) / std::abs(normal[across]),
                 allowed = thickness + steep * along;
    return std::all_of(reach.begin(), reach.end(),
                       [&](const auto& its) { return its.second.second - its.second.first <= allowed; });
}

// f(node) for the nodes from one to so many steps away along each axis, in the grid.
template <int Dim, class F> void forNodesFrom(const Grid<Dim>& grid, int node, int from, int to, F&& f) {
    const Index<Dim> index = grid.indices(node);
    const int along = to - from + 1;
    for (int n = 0; n < (Dim == 2 ? along * along : along * along * along); ++n) {
        int other = node;
        bool isInGrid = true;
        for (int k = 0, rest = n; k < Dim; ++k, rest /= along) {
            const int step = from + rest % along;
            isInGrid &= index[k] + step >= 0 && index[k] + step < grid.nodes[k];
            other += step * grid.strides[k];
        }
        if (isInGrid) f(other);
    }
}

// Whether a box lies beyond an end of a wall.
template <int Dim, class Wall>
bool isBeyond(const Grid<Dim>& grid, const Wall& wall, const Vec<Dim>& x, const Vec<Dim>& half) {
    const Vec<Dim> room = (fromEnd - ofNone) * grid.sizeAt(wall.middle);
    bool is = false;
    for (int k = 0; k < Dim; ++k)
        is |= k != wall.across &&
              (x[k] + half[k] < wall.lower[k] - room[k] || x[k] - half[k] > wall.upper[k] + room[k]);
    return is;
}

} // namespace

// How a wall stands now.
template <int Dim> void PartedSoils<Dim>::place(const Scene<Dim>& scene, Wall& wall) const {
    Body<Dim>& body = *scene.bodies[wall.body];
    const Spread<Dim> spread(body.particles.position);
    wall.middle = spread.middle;
    wall.normal = spread.normal.dot(wall.normal) < 0 ? Vec<Dim>(-spread.normal) : spread.normal;
    wall.normal.cwiseAbs().maxCoeff(&wall.across);
    const Field& X = body.domains->mesh()->vertexPositions();
    for (int k = 0; k < Dim; ++k) {
        const auto [least, most] = std::minmax_element(X.plane(k), X.plane(k) + X.size());
        const double h = scene.grid.sizeAt(wall.middle)[k];
        const bool endsBelow = *least > scene.grid.lower[k] + atBorder * h,
                   endsAbove = *most < scene.grid.upper[k] - atBorder * h;
        wall.lower[k] = endsBelow ? *least + fromEnd * h : -beyondAll;
        wall.upper[k] = endsAbove ? *most - fromEnd * h : beyondAll;
    }
}

// Whether a mesh is a plane thinner than two cells.
template <int Dim> bool PartedSoils<Dim>::isWall(const Scene<Dim>& scene, const Wall& wall) const {
    Body<Dim>& body = *scene.bodies[wall.body];
    const Field& X = body.domains->mesh()->vertexPositions();
    const double thickness = thicknessOf(body, wall.normal, wall.across);
    double shortest = beyondAll;
    for (int k = 0; k < Dim; ++k) {
        const auto [least, most] = std::minmax_element(X.plane(k), X.plane(k) + X.size());
        if (k != wall.across && (wall.lower[k] > -beyondAll || wall.upper[k] < beyondAll))
            shortest = std::min(shortest, *most - *least);
    }
    const Vec<Dim> cell = scene.grid.sizeAt(wall.middle);
    return thickness < thick * cell.minCoeff() && shortest > slender * thickness &&
           isOneLayer<Dim>(body.particles.position, wall.normal, wall.across, thickness, cell);
}

// Gives the soil of a group a second field if a wall parts it.
template <int Dim> void PartedSoils<Dim>::findOf(Scene<Dim>& scene, int soil) {
    std::vector<Body<Dim>*> all;
    std::vector<int> meshes;
    for (size_t b = 0; b < scene.bodies.size(); ++b) {
        Body<Dim>& body = *scene.bodies[b];
        if (body.particles.size() == 0) continue;
        if (body.velocityField == soil) {
            const bool isDriven = std::any_of(scene.constraints.begin(), scene.constraints.end(),
                                              [&](auto& c) { return c->body == body.name; });
            auto* boxes = body.domains->boxes();
            if (!boxes || boxes->outline() || body.isImplicit || isDriven) return;
            all.push_back(&body);
        } else if (body.domains->mesh())
            meshes.push_back(int(b));
    }
    const size_t first = walls_.size();
    for (int b : meshes) {
        const Spread<Dim> before(scene.bodies[b]->particles.reference);
        Wall wall{};
        wall.body = b;
        wall.soil = soil;
        wall.normal = before.normal;
        place(scene, wall);
        if (isWall(scene, wall) && isOnBothSides(all, before.middle, before.normal)) walls_.push_back(wall);
    }
    if (walls_.size() == first) return;
    const int second = int(scene.groupOf.size());
    scene.groupOf.push_back(soil);
    for (Body<Dim>* body : all) body->particles.needSides();
    // The soil next to a wall has the field of what lies in front of so many walls as this one and those behind it.
    for (size_t w = first; w < walls_.size(); ++w) {
        int behind = 0;
        for (size_t v = first; v < walls_.size(); ++v)
            behind += (walls_[w].middle - walls_[v].middle).dot(walls_[v].normal) >= 0;
        walls_[w].front = behind % 2 ? second : soil;
    }
    Soil parted{};
    parted.first = soil;
    parted.second = second;
    for (auto* flags : {&parted.parts, &parted.isParted}) flags->assign(scene.grid.count, 0);
    parted.wallAt.assign(scene.grid.count, 0);
    soils_.push_back(std::move(parted));
}

template <int Dim> void PartedSoils<Dim>::find(Scene<Dim>& scene) {
    const std::vector<Wall> before = std::move(walls_);
    walls_.clear();
    soils_.clear();
    for (auto& body : scene.bodies)
        if (auto* boxes = body->domains->boxes()) boxes->unite();
    const bool isWanted = std::none_of(scene.engines.begin(), scene.engines.end(),
                                       [](auto& engine) { return !engine->dead && engine->needsOneField(); });
    if (scene.scheme->stressFirst || !isWanted) return;
    for (int group = 0; group < int(scene.groups.size()); ++group) findOf(scene, group);
    const auto isSame = [](const Wall& a, const Wall& b) {
        return a.body == b.body && a.soil == b.soil && a.front == b.front;
    };
    const bool areSame = std::equal(before.begin(), before.end(), walls_.begin(), walls_.end(), isSame);
    if (before.empty() || areSame) return; // none before: particles may have the sides of a checkpoint
    for (auto& body : scene.bodies)
        if (body->particles.hasSides) body->particles.side.fill(0);
}

template <int Dim> void PartedSoils<Dim>::divide(Scene<Dim>& scene, bool mayDecide) {
    for (Wall& wall : walls_) place(scene, wall);
    for (Soil& soil : soils_) {
        findParting(scene, soil);
        for (auto& body : scene.bodies) {
            if (body->velocityField != soil.first || body->particles.size() == 0) continue;
            const Field& position = body->particles.position;
            const auto sideOf = [&](int p, int number) {
                const Wall& wall = walls_[number];
                const Vec<Dim> x = vectorAt<Dim>(position, p);
                if (isBeyond(scene.grid, wall, x, body->domains->boxes()->halfSize())) {
                    bool isReached = false;
                    body->domains->weights(p, [&](int node, double phi, const Vec<Dim>&) {
                        isReached |= phi > touching && soil.parts[node];
                    });
                    if (!isReached) return 0;
                }
                const Vec<Dim> middle =
                    middleBeside<Dim>(scene.bodies[wall.body]->particles.position, wall.middle, wall.normal,
                                      x, scene.grid.sizeAt(x).maxCoeff());
                const bool isInFront = (x - middle).dot(wall.normal) > 0;
                return isInFront == (wall.front == soil.second) ? 2 : 1;
            };
            body->domains->boxes()->divide(soil.wallAt, sideOf, mayDecide);
        }
    }
    markExtents(scene);
}

// The nodes that the walls of a soil give mass to, but beyond their ends.
template <int Dim> void PartedSoils<Dim>::findParting(const Scene<Dim>& scene, Soil& soil) const {
    const Grid<Dim>& grid = scene.grid;
    for (int node : soil.parting) {
        soil.parts[node] = 0;
        forNodesFrom(grid, node, -1, 0, [&](int cell) { soil.isParted[cell] = 0; });
    }
    for (int node : soil.near) soil.wallAt[node] = 0;
    soil.parting.clear();
    soil.near.clear();
    for (size_t w = 0; w < walls_.size(); ++w) {
        const Wall& wall = walls_[w];
        if (wall.soil != soil.first) continue;
        const Field& X = scene.bodies[wall.body]->domains->mesh()->vertexPositions();
        for (int v = 0; v < X.size(); ++v) {
            int lowest = 0;
            bool isOn[Dim]; // a line of nodes
            for (int k = 0; k < Dim; ++k) {
                const double c = grid.inCells(X.plane(k)[v], k), below = std::floor(c);
                lowest += int(below) * grid.strides[k];
                isOn[k] = c == below;
            }
            for (int a = 0; a < corners<Dim>; ++a) {
                const int node = cornerOf(grid, lowest, a);
                bool isReached = true;
                for (int k = 0; k < Dim; ++k) isReached &= !(isOn[k] && cornerSign(a, k) > 0);
                if (!isReached || soil.parts[node]) continue;
                const Vec<Dim> x = grid.nodePosition(node), small = ofNone * grid.meanSize(node);
                bool isBeside = true;
                for (int k = 0; k < Dim; ++k)
                    isBeside &= k == wall.across ||
                                (x[k] >= wall.lower[k] - small[k] && x[k] <= wall.upper[k] + small[k]);
                if (isBeside) addParting(grid, soil, int(w), node);
            }
        }
    }
}

template <int Dim>
void PartedSoils<Dim>::addParting(const Grid<Dim>& grid, Soil& soil, int wall, int node) const {
    soil.parting.push_back(node);
    soil.parts[node] = 1;
    forNodesFrom(grid, node, -1, 0, [&](int cell) { soil.isParted[cell] = 1; });
    forNodesFrom(grid, node, 1 - support, 0, [&](int lowest) {
        if (soil.wallAt[lowest]) return;
        soil.wallAt[lowest] = short(wall + 1);
        soil.near.push_back(lowest);
    });
}

template <int Dim> void PartedSoils<Dim>::markExtents(Scene<Dim>& scene) const {
    const Grid<Dim>& grid = scene.grid;
    for (const Soil& soil : soils_)
        for (int node : soil.near) {
            typename NodalField<Dim>::Extent extent;
            extent.first = extent.last = grid.indices(node);
            for (int k = 0; k < Dim; ++k)
                extent.last[k] = std::min(extent.last[k] + support, grid.nodes[k]) - 1;
            for (int slab = extent.first[Dim - 1]; slab <= extent.last[Dim - 1]; ++slab)
                scene.grid.fields[soil.second].extents[slab].include(extent);
        }
}

template <int Dim> void PartedSoils<Dim>::bond(Scene<Dim>& scene) {
    using NF = NodalField<Dim>;
    for (Soil& soil : soils_) {
        soil.nodes.clear();
        NF &first = scene.grid.fields[soil.first], &second = scene.grid.fields[soil.second];
        for (int slab = 0; slab < scene.grid.slabs(); ++slab)
            scene.grid.forNodes(second, slab, [&](int node) {
                if (!(second.sum[node][NF::mass] > 0) || soil.parts[node]) return;
                first.sum[node] += second.sum[node];
                second.sum[node] = NF::Sum::zero();
                soil.nodes.push_back(node);
            });
    }
}

template <int Dim> void PartedSoils<Dim>::tellMotion(Scene<Dim>& scene) const {
    forBonded([&](int first, int second, int node) {
        scene.grid.fields[second].motion[node] = scene.grid.fields[first].motion[node];
    });
}

template <int Dim> void PartedSoils<Dim>::bondMomenta(Scene<Dim>& scene) const {
    forBonded([&](int one, int second, int node) {
        auto& first = scene.grid.fields[one];
        for (int k = 0; k < Dim; ++k)
            first.setVelocity(node, k,
                              first.velocityOf(node, k) + scene.grid.fields[second].velocityOf(node, k));
    });
}

template <int Dim> void PartedSoils<Dim>::tellVelocity(Scene<Dim>& scene) const {
    forBonded([&](int first, int second, int node) {
        for (int k = 0; k < Dim; ++k)
            scene.grid.fields[second].setVelocity(node, k, scene.grid.fields[first].velocityOf(node, k));
    });
}

template class PartedSoils<2>;
template class PartedSoils<3>;

} // namespace mpm
