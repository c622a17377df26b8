// SPDX-License-Identifier: GPL-2.0-or-later
#include "mpm/scene/PartedSoils.hpp"

#include "mpm/scene/Scene.hpp"
#include "mpm/scene/soilInCells.hpp"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <numeric>

namespace mpm {

namespace {

constexpr double thick = 2 * (1 - 1e-6); // cells; no node reaches the soil on both sides of such a wall
// Half and twice of these three change the thrust on a wall by 1.2 % at most (twice fromEnd).
// Part of a body that may lie on the other side of a wall: soil moves a little round its toe.
constexpr double mostAstray = 0.01;
// How far inside the ends of a wall it parts the soil, in cells: at its toe a node feels as much soil that goes through.
constexpr double fromEnd = 0.5;
// An end that is nearer than this to the border of the grid, in cells, has no soil beyond.
constexpr double atBorder = 0.5;
constexpr double ofNone = 1e-6;     // cells, a distance that is round-off
constexpr double beyondAll = 1e300; // m

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
        normal = Eigen::SelfAdjointEigenSolver<Mat<Dim>>(square).eigenvectors().col(0);
        int across;
        normal.cwiseAbs().maxCoeff(&across);
        if (normal[across] < 0) normal = -normal;
    }
};

// Part of a body in front of a plane.
template <int Dim> double partInFront(const Body<Dim>& body, const Vec<Dim>& middle, const Vec<Dim>& normal) {
    double front = 0, all = 0;
    for (int p = 0; p < body.particles.size(); ++p) {
        const double m = body.particles.mass.plane()[p];
        all += m;
        if ((vectorAt<Dim>(body.particles.reference, p) - middle).dot(normal) > 0) front += m;
    }
    return front / all;
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
    const Body<Dim>& body = *scene.bodies[wall.body];
    const Field& X = body.domains->mesh()->vertexPositions();
    const double* V = body.particles.initialVolume.plane();
    double volume = std::accumulate(V, V + body.particles.size(), 0.0) * std::abs(wall.normal[wall.across]);
    for (int k = 0; k < Dim; ++k) {
        const auto [least, most] = std::minmax_element(X.plane(k), X.plane(k) + X.size());
        if (k != wall.across) volume /= *most - *least;
    }
    return volume < thick * scene.grid.sizeAt(wall.middle).minCoeff(); // it is the thickness now
}

// Gives the bodies of a group their fields; false: no wall parts them.
template <int Dim> bool PartedSoils<Dim>::findOf(Scene<Dim>& scene, int soil) {
    std::vector<Body<Dim>*> all;
    std::vector<int> walls;
    for (size_t b = 0; b < scene.bodies.size(); ++b) {
        Body<Dim>& body = *scene.bodies[b];
        if (body.particles.size() == 0) continue;
        if (body.velocityField == soil) {
            const bool isDriven = std::any_of(scene.constraints.begin(), scene.constraints.end(),
                                              [&](auto& c) { return c->body == body.name; });
            auto* boxes = body.domains->boxes();
            if (!boxes || boxes->outline() || body.isImplicit || isDriven) return false;
            all.push_back(&body);
        } else if (body.domains->mesh())
            walls.push_back(int(b));
    }
    std::vector<int> inFrontOf(all.size(), 0); // so many walls
    const size_t first = walls_.size();
    for (int b : walls) {
        const Spread<Dim> before(scene.bodies[b]->particles.reference);
        Wall wall{};
        wall.body = b;
        wall.soil = soil;
        wall.normal = before.normal;
        place(scene, wall);
        if (!isWall(scene, wall)) continue;
        std::vector<double> part;
        for (Body<Dim>* body : all) part.push_back(partInFront(*body, before.middle, before.normal));
        const auto isBehind = [](double p) { return p < mostAstray; };
        const auto isInFront = [](double p) { return p > 1 - mostAstray; };
        const size_t behind = std::count_if(part.begin(), part.end(), isBehind),
                     inFront = std::count_if(part.begin(), part.end(), isInFront);
        if (behind + inFront < all.size() || behind == 0 || inFront == 0) continue;
        for (size_t i = 0; i < all.size(); ++i) inFrontOf[i] += isInFront(part[i]);
        walls_.push_back(wall);
    }
    if (walls_.size() == first) return false;
    const int second = int(scene.groupOf.size());
    scene.groupOf.push_back(soil);
    for (size_t i = 0; i < all.size(); ++i) all[i]->velocityField = inFrontOf[i] % 2 ? second : soil;
    // The soil next to a wall has the colour of those in front of so many walls as this one and those behind it.
    for (size_t w = first; w < walls_.size(); ++w) {
        int behind = 0;
        for (size_t v = first; v < walls_.size(); ++v)
            behind += (walls_[w].middle - walls_[v].middle).dot(walls_[v].normal) >= 0;
        walls_[w].front = behind % 2 ? second : soil;
    }
    soils_.push_back({soil, second, {}, {}});
    return true;
}

template <int Dim> void PartedSoils<Dim>::find(Scene<Dim>& scene) {
    walls_.clear();
    soils_.clear();
    const bool isWanted = std::none_of(scene.engines.begin(), scene.engines.end(),
                                       [](auto& engine) { return !engine->dead && engine->needsOneField(); });
    if (scene.scheme->stressFirst || !isWanted) return;
    for (int group = 0; group < int(scene.groups.size()); ++group) findOf(scene, group);
}

// Whether a wall stands between the fields of a soil on a node.
template <int Dim> bool PartedSoils<Dim>::parts(const Scene<Dim>& scene, const Soil& soil, int node) const {
    const double least = scene.leastMass();
    for (const Wall& wall : walls_) {
        if (wall.soil != soil.first) continue;
        const auto& field = scene.grid.fields[scene.bodies[wall.body]->velocityField];
        if (!mayHaveMass(scene.grid, field, node) || !(field.sum[node][NodalField<Dim>::mass] > least))
            continue;
        const Vec<Dim> x = scene.grid.nodePosition(node), small = ofNone * scene.grid.meanSize(node);
        bool isBeside = true;
        for (int k = 0; k < Dim; ++k)
            isBeside &=
                k == wall.across || (x[k] >= wall.lower[k] - small[k] && x[k] <= wall.upper[k] + small[k]);
        if (isBeside) return true;
    }
    return false;
}

template <int Dim> void PartedSoils<Dim>::bond(Scene<Dim>& scene) {
    using NF = NodalField<Dim>;
    for (Wall& wall : walls_) place(scene, wall);
    for (Soil& soil : soils_) {
        soil.isBonded.resize(scene.grid.count, 0);
        for (int node : soil.nodes) soil.isBonded[node] = 0;
        soil.nodes.clear();
        NF &first = scene.grid.fields[soil.first], &second = scene.grid.fields[soil.second];
        for (int slab = 0; slab < scene.grid.slabs(); ++slab)
            scene.grid.forNodes(second, slab, [&](int node) {
                if (!(second.sum[node][NF::mass] > 0) || parts(scene, soil, node)) return;
                first.sum[node] += second.sum[node];
                second.sum[node] = NF::Sum::zero();
                soil.nodes.push_back(node);
                soil.isBonded[node] = 1;
            });
    }
}

template <int Dim> void PartedSoils<Dim>::tellMotion(Scene<Dim>& scene) const {
    for (const Soil& soil : soils_)
        for (int node : soil.nodes)
            scene.grid.fields[soil.second].motion[node] = scene.grid.fields[soil.first].motion[node];
}

template <int Dim> void PartedSoils<Dim>::bondMomenta(Scene<Dim>& scene) const {
    for (const Soil& soil : soils_)
        for (int node : soil.nodes)
            for (int k = 0; k < Dim; ++k) {
                auto& first = scene.grid.fields[soil.first];
                first.setVelocity(
                    node, k, first.velocityOf(node, k) + scene.grid.fields[soil.second].velocityOf(node, k));
            }
}

template <int Dim> void PartedSoils<Dim>::tellVelocity(Scene<Dim>& scene) const {
    for (const Soil& soil : soils_)
        for (int node : soil.nodes)
            for (int k = 0; k < Dim; ++k)
                scene.grid.fields[soil.second].setVelocity(node, k,
                                                           scene.grid.fields[soil.first].velocityOf(node, k));
}

template class PartedSoils<2>;
template class PartedSoils<3>;

} // namespace mpm
