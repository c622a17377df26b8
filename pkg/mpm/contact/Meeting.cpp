// SPDX-License-Identifier: GPL-2.0-or-later
// Normals and gaps come from the surfaces as the node sees them: int phi n dA and int phi d n^T dA, d from the node. Both are sums
// over the facets of a mesh, or, by the theorem of Gauss, over boxes. With A = n . int phi n dA, a group reaches n . int ... n / A
// along n.
#include "mpm/contact/Meeting.hpp"

namespace mpm {

namespace {

constexpr double edge = 0.9;       // flatness of a surface below which it has an edge
constexpr double tolerated = 0.01; // overlap between nodes, in cells

} // namespace

template <int Dim> void Meeting<Dim>::prepare(const Scene<Dim>& scene) {
    neighbourhood_.prepare(scene.grid);
    surfaces_.resize(scene.bodies.size()); // bodies stay; a mesh that loses domains is looked at anew
    meets.clear(), touches.clear(), pairs.clear(), step_ = -1;
}

template <int Dim> void Meeting<Dim>::find(const Scene<Dim>& scene, bool normalsByMass) {
    meets.clear(), touches.clear(), pairs.clear(), step_ = scene.step;
    isExplicit_.assign(scene.groups.size(), true), hasOutline_.assign(scene.groups.size(), false);
    for (auto& body : scene.bodies) {
        if (!ExplicitSurface<Dim>::isOf(*body) && body->particles.size() > 0)
            isExplicit_[body->velocityField] = false;
        if (body->domains->outline()) hasOutline_[body->velocityField] = true;
    }
    const int groups = int(scene.groups.size());
    for (int a = 0; a < groups; ++a)
        for (int b = a + 1; b < groups; ++b) {
            const size_t first = meets.size(), touched = touches.size();
            if (!findNodes(scene, a, b)) continue;
            findSurfaces(scene, 0, a, first), findSurfaces(scene, 1, b, first);
            normalsByMass ? findNormalsByMass(scene.grid, first) : findNormals(scene.grid, first);
            turnAtEdges(scene, 0, a, first), turnAtEdges(scene, 1, b, first);
            if (hasOutline_[a] || hasOutline_[b]) straighten(scene.grid, first);
            findFaces(scene, 0, a), findFaces(scene, 1, b);
            findIntruders(scene.grid, 0, a, b, first), findIntruders(scene.grid, 1, b, a, first);
            findGaps(scene.grid, first), borrow(scene.grid, first);
            findTouches(scene, a, b);
            pairs.push_back({first, meets.size(), touched, touches.size()});
        }
}

// The nodes on which both groups have mass.
template <int Dim> bool Meeting<Dim>::findNodes(const Scene<Dim>& scene, int a, int b) {
    const Grid<Dim>& grid = scene.grid;
    const auto &fieldA = grid.fields[a], &fieldB = grid.fields[b];
    const double least = scene.leastMass();
    const size_t first = meets.size();
    neighbourhood_.clear();
    for (int slab = 0; slab < grid.slabs(); ++slab) {
        auto both = fieldA.extents[slab];
        for (int k = 0; k < Dim - 1; ++k) {
            both.first[k] = std::max(both.first[k], fieldB.extents[slab].first[k]);
            both.last[k] = std::min(both.last[k], fieldB.extents[slab].last[k]);
        }
        grid.forNodes(both, slab, [&](int node) {
            if (!(fieldA.sum[node][NodalField<Dim>::mass] > least &&
                  fieldB.sum[node][NodalField<Dim>::mass] > least))
                return;
            neighbourhood_.add(grid, node, int(meets.size()));
            meets.emplace_back();
            Meet<Dim>& meet = meets.back();
            meet.node = node, meet.field[0] = a, meet.field[1] = b, meet.position = grid.nodePosition(node);
        });
    }
    neighbourhood_.finish();
    return meets.size() > first;
}

template <int Dim>
void Meeting<Dim>::findSurfaces(const Scene<Dim>& scene, int side, int field, size_t first) {
    boxes_[side].find(scene, field, neighbourhood_);
    if (!boxes_[side].isEmpty())
        for (size_t i = first; i < meets.size(); ++i)
            boxes_[side].addTo(meets[i].surface[side], scene.grid, neighbourhood_, meets[i].node,
                               meets[i].position);
    forSurfaces(scene, field, [&](Body<Dim>& body, ExplicitSurface<Dim>& surface) {
        surface.find(body, scene.grid, neighbourhood_);
        addParts(surface.parts(body), side);
    });
}

template <int Dim> void Meeting<Dim>::addParts(const std::vector<Vertex>& vertices, int side) {
    for (const Vertex& vertex : vertices)
        for (int corner = 0; corner < vertex.round.size; ++corner) {
            if (vertex.round.meet[corner] < 0) continue;
            const double phi = vertex.round.S[corner];
            Meet<Dim>& meet = meets[vertex.round.meet[corner]];
            FaceSeen<Dim>& surface = meet.surface[side];
            surface.outward += phi * vertex.outward, surface.extent += phi * vertex.extent;
            surface.moment += phi * (vertex.position - meet.position) * vertex.outward.transpose();
        }
}

// Boxes have faces along the axes; of two groups of them those count that look at each other. Else, at an edge of one group, the
// flatter surface of the other counts. Flatness is what a surface has left of its area when its directions are added up. Of equals
// the mesh counts.
template <int Dim> void Meeting<Dim>::findNormals(const Grid<Dim>& grid, size_t first) {
    for (size_t i = first; i < meets.size(); ++i) {
        Meet<Dim>& meet = meets[i];
        const bool explicitly[2] = {isExplicit_[meet.field[0]], isExplicit_[meet.field[1]]};
        const Vec<Dim> outward[2] = {meet.surface[0].outward,
                                     -meet.surface[1].outward}; // along the normal, both
        Vec<Dim> sum = Vec<Dim>::Zero();
        if (!explicitly[0] && !explicitly[1]) {
            for (int k = 0; k < Dim; ++k)
                if (const double a = outward[0][k], b = outward[1][k]; a * b > 0)
                    sum[k] = std::abs(a) < std::abs(b) ? a : b;
            meet.normal = unit<Dim>(sum, 0.0);
            continue;
        }
        double size[2], flatness[2];
        for (int side = 0; side < 2; ++side) {
            size[side] = outward[side].norm();
            const double extent =
                explicitly[side] ? meet.surface[side].extent : outward[side].template lpNorm<1>();
            flatness[side] = size[side] / std::max(extent, 1e-300);
        }
        const double flattest = std::max(flatness[0], flatness[1]);
        bool counts[2];
        for (int side = 0; side < 2; ++side)
            counts[side] = size[side] > 0 && flatness[side] > 0.99 * flattest;
        if (explicitly[0] !=
            explicitly
                [1]) { // boxes count where they are flat and the mesh has an edge, or at a plane of symmetry
            const int mesh = explicitly[0] ? 0 : 1;
            const bool isHeld =
                grid.fields[meet.field[0]].isHeld(meet.node) || grid.fields[meet.field[1]].isHeld(meet.node);
            const bool face = outward[0].dot(outward[1]) >
                              0; // else boxes caught inside the mesh hide the surface of the others
            if (counts[mesh] || (!isHeld && (!face || flatness[1 - mesh] < edge)))
                counts[mesh] = size[mesh] > 0, counts[1 - mesh] = !counts[mesh];
        }
        for (int side = 0; side < 2; ++side)
            if (counts[side]) sum += outward[side] / size[side];
        meet.normal = unit<Dim>(sum, 1e-6);
        for (int side = 0; side < 2; ++side)
            if (counts[side] && explicitly[side] && !explicitly[1 - side] && flatness[side] < edge)
                meet.edgeOf = side;
    }
}

// At an edge of a mesh against boxes the facets count as far as they move towards these: the tip of a pile pushes what lies below
// it down, not aside.
template <int Dim>
void Meeting<Dim>::turnAtEdges(const Scene<Dim>& scene, int side, int field, size_t first) {
    bool isAny = false;
    for (size_t i = first; i < meets.size(); ++i) isAny |= meets[i].edgeOf == side;
    if (!isAny) return;
    const Grid<Dim>& grid = scene.grid;
    std::vector<Vec<Dim>> sum(meets.size() - first, Vec<Dim>::Zero());
    forSurfaces(scene, field, [&](Body<Dim>& body, const ExplicitSurface<Dim>& surface) {
        surface.forShares(body, [&](const Vertex& vertex, const Vec<Dim>& share) {
            for (int corner = 0; corner < vertex.round.size; ++corner) {
                const int slot = vertex.round.meet[corner];
                if (slot < 0 || meets[slot].edgeOf != side) continue;
                const Meet<Dim>& meet = meets[slot];
                double closing = 0;
                for (int k = 0; k < Dim; ++k)
                    closing += share[k] * (grid.fields[meet.field[side]].motion[meet.node][k] -
                                           grid.fields[meet.field[1 - side]].motion[meet.node][k]);
                if (closing > 0) sum[slot - first] += vertex.round.S[corner] * closing / share.norm() * share;
            }
        });
    });
    for (size_t i = first; i < meets.size(); ++i)
        if (meets[i].edgeOf == side && !sum[i - first].isZero(0))
            meets[i].normal = (side == 0 ? 1 : -1) * sum[i - first].normalized();
}

// Where a constraint holds both groups along an axis they do not push each other along it: at a plane of symmetry an outline has facets on
// that plane, and the normal would tilt.
template <int Dim> void Meeting<Dim>::straighten(const Grid<Dim>& grid, size_t first) {
    for (size_t i = first; i < meets.size(); ++i) {
        Meet<Dim>& meet = meets[i];
        Vec<Dim> free = meet.normal;
        for (int k = 0; k < Dim; ++k)
            if (grid.fields[meet.field[0]].holder[meet.node][k] >= 0 &&
                grid.fields[meet.field[1]].holder[meet.node][k] >= 0)
                free[k] = 0;
        if (free.norm() > 0.1) meet.normal = free.normalized();
    }
}

template <int Dim> void Meeting<Dim>::findNormalsByMass(const Grid<Dim>& grid, size_t first) {
    for (size_t i = first; i < meets.size(); ++i) {
        Vec<Dim> slope[2] = {Vec<Dim>::Zero(), Vec<Dim>::Zero()};
        for (int side = 0; side < 2; ++side)
            forNeighbours(grid, meets[i].node, [&](int node, const Index<Dim>& at) {
                const Vec<Dim> step =
                    Eigen::Map<const Eigen::Matrix<int, Dim, 1>>(at.data()).template cast<double>();
                const double even = std::pow(0.5, step.squaredNorm()); // 1 2 1 across
                const double mass = grid.fields[meets[i].field[side]].sum[node][NodalField<Dim>::mass];
                slope[side] += even * mass * step.cwiseQuotient(grid.cell);
            });
        meets[i].normal = unit<Dim>(unit<Dim>(slope[1], 0.0) - unit<Dim>(slope[0], 0.0), 1e-6);
    }
}

// Where the tangent plane of the nearest vertex crosses the normal through a node, for groups that are meshes; vertices at edges
// have no such plane, and count by themselves.
template <int Dim> void Meeting<Dim>::findFaces(const Scene<Dim>& scene, int side, int field) {
    if (!isExplicit_[field]) return;
    const Grid<Dim>& grid = scene.grid;
    const double sign = side == 0 ? 1 : -1, h = grid.cell.minCoeff();
    forSurfaces(scene, field, [&](const Body<Dim>&, const ExplicitSurface<Dim>& surface) {
        for (const Vertex& vertex : surface.near)
            forNeighbours(grid, vertex.node, [&](int node, const Index<Dim>&) {
                const int slot = neighbourhood_.meet(node);
                if (slot < 0) return;
                Meet<Dim>& meet = meets[slot];
                FaceSeen<Dim>& face = meet.surface[side];
                const Vec<Dim> d = vertex.position - meet.position;
                const double along = sign * d.dot(meet.normal),
                             beside = std::max(0.0, d.squaredNorm() - along * along);
                const double faces = sign * vertex.outward.dot(meet.normal) / vertex.size;
                if (beside > h * h || beside >= face.nearest || !(faces > 0.5)) return;
                face.nearest = beside,
                face.reach = faces > 0.9 ? d.dot(vertex.outward) / (faces * vertex.size) : along;
            });
    });
}

// Boxes against a mesh: where the centre of one has crossed its face, the gap is closed, whatever the others do. What lies deeper than
// half a cell belongs to the other side.
template <int Dim>
void Meeting<Dim>::findIntruders(const Grid<Dim>& grid, int side, int field, int other, size_t first) {
    if (isExplicit_[field] || !isExplicit_[other]) return;
    const double sign = side == 0 ? 1 : -1, h = grid.cell.minCoeff();
    for (size_t i = first; i < meets.size(); ++i) {
        Meet<Dim>& meet = meets[i];
        const FaceSeen<Dim>& face = meet.surface[1 - side];
        if (face.nearest < 1e300)
            meet.surface[side].intruded = boxes_[side].crossed(grid, neighbourhood_, meet.node, meet.position,
                                                               sign * meet.normal, -face.reach, h);
    }
}

// How far each group reaches along the normal. Surfaces of boxes that seem to cross by half a cell face away from each other.
template <int Dim> void Meeting<Dim>::findGaps(const Grid<Dim>& grid, size_t first) {
    for (size_t i = first; i < meets.size(); ++i) {
        Meet<Dim>& meet = meets[i];
        const Vec<Dim>& n = meet.normal;
        const double area[2] = {meet.surface[0].outward.dot(n), -meet.surface[1].outward.dot(n)};
        const bool explicitly[2] = {isExplicit_[meet.field[0]], isExplicit_[meet.field[1]]};
        meet.area = std::max(0.0, std::min(area[0], area[1]));
        const bool intruded = meet.surface[0].intruded > -1e300 || meet.surface[1].intruded > -1e300;
        meet.weight = intruded ? area[explicitly[0] ? 0 : 1] : meet.area;
        if (!(meet.weight > 0)) continue;
        double reach[2];
        for (int side = 0; side < 2; ++side) {
            const FaceSeen<Dim>& face = meet.surface[side];
            reach[side] = explicitly[side] && face.nearest < 1e300 ? face.reach
                          : area[side] > 0.05 * meet.weight        ? n.dot(face.moment * n) / area[side]
                                                                   : -1e300;
            reach[side] = std::max(reach[side], face.intruded);
        }
        meet.gap = -reach[1] - reach[0];
        if (!explicitly[0] && !explicitly[1] && meet.gap < -0.5 * grid.cell.minCoeff()) meet.weight = 0;
    }
}

// Nodes that hardly feel one of the surfaces take normal and gap of their neighbours.
template <int Dim> void Meeting<Dim>::borrow(const Grid<Dim>& grid, size_t first) {
    const double least = 0.05 * std::pow(grid.cell.minCoeff(), Dim - 1);
    for (size_t i = first; i < meets.size(); ++i) {
        Meet<Dim>& meet = meets[i];
        if (meet.weight > least) continue;
        Vec<Dim> normal = Vec<Dim>::Zero();
        double weight = 0, gap = 0;
        forNeighbours(grid, meet.node, [&](int node, const Index<Dim>&) {
            const int slot = neighbourhood_.meet(node);
            if (slot < 0 || !(meets[slot].weight > least)) return;
            const Meet<Dim>& other = meets[slot];
            normal += other.weight * other.normal, weight += other.weight, gap += other.weight * other.gap;
        });
        meet.normal = unit<Dim>(normal, 0.1 * weight), meet.gap = weight > 0 ? gap / weight : 0;
    }
}

// Vertices at the surface of a mesh that are near to a meet and at no edge, by their nearest node.
template <int Dim> void Meeting<Dim>::findSkin(const Scene<Dim>& scene, int side, int field) {
    skins_[side].clear();
    if (!isExplicit_[field]) return;
    forSurfaces(scene, field, [&](const Body<Dim>&, const ExplicitSurface<Dim>& surface) {
        for (const Vertex& vertex : surface.near)
            if (vertex.size > edge * vertex.extent) skins_[side].push_back(&vertex);
    });
    std::stable_sort(skins_[side].begin(), skins_[side].end(),
                     [](const Vertex* a, const Vertex* b) { return a->node < b->node; });
}

// Distance of a vertex from boxes, along its normal: from where the nodes round it see them, if that is a plane. 1e300: it is not.
template <int Dim>
double Meeting<Dim>::distanceOfBoxes(const Grid<Dim>& grid, const Vertex& own, int side) const {
    const Vec<Dim> n = own.outward / own.size;
    double facing = 0, all = 0, distance = 0;
    for (int corner = 0; corner < own.round.size; ++corner) {
        if (own.round.meet[corner] < 0) continue;
        const Meet<Dim>& meet = meets[own.round.meet[corner]];
        const FaceSeen<Dim>& boxes = meet.surface[1 - side];
        const double S = own.round.S[corner], area = -S * boxes.outward.dot(n);
        facing += area, all += S * boxes.outward.template lpNorm<1>();
        distance += area * (meet.position - own.position).dot(n) - S * n.dot(boxes.moment * n);
    }
    return facing > 0.4 * std::pow(grid.cell.minCoeff(), Dim - 1) && facing > edge * all ? distance / facing
                                                                                         : 1e300;
}

// Distance of a vertex from another mesh: from the tangent plane at its nearest vertex, to which the normal is turned half-way.
template <int Dim>
double Meeting<Dim>::distanceOfMesh(const Grid<Dim>& grid, const Vertex& own, int side,
                                    Vec<Dim>& normal) const {
    const auto& others = skins_[1 - side];
    const Vertex* other = nullptr;
    double least = 1e300;
    forNeighbours(grid, own.node, [&](int node, const Index<Dim>& step) {
        if (step[0] > -1) return; // rows of three nodes follow each other
        auto it = std::lower_bound(others.begin(), others.end(), node,
                                   [](const Vertex* vertex, int node) { return vertex->node < node; });
        for (; it != others.end() && (*it)->node < node + 3; ++it)
            if (const double d = ((*it)->position - own.position).squaredNorm(); d < least)
                least = d, other = *it;
    });
    if (!other) return 1e300;
    const Vec<Dim> n = own.outward / own.size, facing = other->outward / other->size;
    if (n.dot(facing) > -edge) return 1e300;
    normal = (n - facing).normalized();
    return (own.position - other->position).dot(facing);
}

// Where surfaces are curved they overlap between nodes that keep their gap. So the vertices of meshes keep their distance, too.
template <int Dim> void Meeting<Dim>::findTouches(const Scene<Dim>& scene, int a, int b) {
    const Grid<Dim>& grid = scene.grid;
    const double h = grid.cell.minCoeff();
    findSkin(scene, 0, a), findSkin(scene, 1, b);
    for (int side = 0; side < 2; ++side)
        for (const Vertex* own : skins_[side]) {
            bool isShared = true;
            for (int meet : own->round.meet) isShared &= meet >= 0;
            if (!isShared) continue;
            Touch<Dim> touch;
            touch.normal = own->outward / own->size, touch.tolerated = tolerated * h;
            touch.gap = isExplicit_[side == 0 ? b : a] ? distanceOfMesh(grid, *own, side, touch.normal)
                                                       : distanceOfBoxes(grid, *own, side);
            if (side == 1) touch.normal = -touch.normal;
            if (std::abs(touch.gap) > 0.5 * h) continue;
            static_cast<NodesRound<Dim>&>(touch) = own->round;
            for (int meet : touch.meet) meets[meet].hasTouches = true;
            touches.push_back(touch);
        }
}

template class Meeting<2>;
template class Meeting<3>;

} // namespace mpm
