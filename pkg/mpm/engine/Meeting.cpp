// SPDX-License-Identifier: GPL-2.0-or-later
// Normals and gaps come from the surfaces as the node sees them: int phi n dA and int phi d n^T dA, d from the node. Both are sums
// over the facets of a mesh, or, by the theorem of Gauss, over boxes. With A = n . int phi n dA, a group reaches n . int ... n / A
// along n.
#include "mpm/engine/Meeting.hpp"

#include <Eigen/Geometry>

namespace mpm {

namespace {

constexpr double edge = 0.9;       // flatness of a surface below which it has an edge
constexpr double tolerated = 0.01; // overlap between nodes, in cells

// f(node) for the 3^Dim nodes round one.
template <int Dim, class F> void forNeighbours(const Grid<Dim>& grid, int node, F&& f) {
    if constexpr (Dim == 2) {
        for (int j = -1; j <= 1; ++j)
            for (int i = -1; i <= 1; ++i) f(node + i + j * grid.strides[1], Vec<2>(i, j));
    } else
        for (int l = -1; l <= 1; ++l)
            for (int j = -1; j <= 1; ++j)
                for (int i = -1; i <= 1; ++i) f(node + i + j * grid.strides[1] + l * grid.strides[2], Vec<3>(i, j, l));
}

// f(node, hat function) for the nodes round a point.
template <int Dim, class F> void forHats(const Grid<Dim>& grid, const Vec<Dim>& x, F&& f) {
    int first = 0;
    double part[Dim];
    for (int k = 0; k < Dim; ++k) {
        const double c = grid.inCells(x[k], k), below = std::floor(c);
        first += int(below) * grid.strides[k], part[k] = c - below;
    }
    for (int corner = 0; corner < (1 << Dim); ++corner) {
        int node = first;
        double S = 1;
        for (int k = 0; k < Dim; ++k) {
            const bool upper = corner >> k & 1;
            node += upper ? grid.strides[k] : 0, S *= upper ? part[k] : 1 - part[k];
        }
        f(node, S);
    }
}

template <int Dim> Vec<Dim> areaVector(const Field& X, const typename BoundaryFacets<Dim>::Facet& facet) {
    const auto at = [&](int a) { return vectorAt<Dim>(X, facet[a]); };
    if constexpr (Dim == 2) {
        const Vec<2> along = at(1) - at(0);
        return Vec<2>(along[1], -along[0]);
    } else {
        const Vec<3> first = at(2) - at(0), second = at(3) - at(1);
        return 0.5 * first.cross(second);
    }
}

// Integrals over the interval c - l ... c + l, in cells from a node, of the hat function N(y) = 1 - |y|, N', y N and y N'.
struct HatIntegrals {
    double N = 0, slope = 0, first = 0, firstOfSlope = 0;

    HatIntegrals() = default;
    HatIntegrals(double c, double l) { add(c + l, 1), add(c - l, -1); }

  private:
    void add(double end, double sign) {
        const double y = std::min(1.0, std::max(-1.0, end)), size = std::abs(y);
        N += sign * (y - 0.5 * y * size), slope += sign * (1 - size);
        first += sign * (0.5 - size / 3) * y * y, firstOfSlope -= sign * 0.5 * y * size;
    }
};

} // namespace

template <int Dim> void Meeting<Dim>::Boundary::find(Body<Dim>& body) {
    particles = body.particles.size();
    facets.find(*body.domains);
    vertices.clear();
    for (auto& facet : facets.facets) vertices.insert(vertices.end(), facet.begin(), facet.end());
    std::sort(vertices.begin(), vertices.end());
    vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
    outward.assign(body.domains->vertexPositions()->size(), Vec<Dim>::Zero()), extent.assign(outward.size(), 0.0);
    node.assign(outward.size(), -1);
}

template <int Dim> void Meeting<Dim>::prepare(const Scene<Dim>& scene) {
    slot_.assign(scene.grid.count, -1), isNear_.assign(scene.grid.count, 0);
    boundaries_.assign(scene.bodies.size(), {});
    meets.clear(), touches.clear(), pairs.clear(), step_ = -1;
}

template <int Dim> void Meeting<Dim>::find(const Scene<Dim>& scene, bool normalsByMass) {
    meets.clear(), touches.clear(), pairs.clear(), step_ = scene.step;
    isMeshed_.assign(scene.groups.size(), true);
    for (auto& body : scene.bodies)
        if (!body->type->isMeshed() && body->particles.size() > 0) isMeshed_[body->velocityField] = false;
    const int groups = int(scene.groups.size());
    for (int a = 0; a < groups; ++a)
        for (int b = a + 1; b < groups; ++b) {
            const size_t first = meets.size(), touched = touches.size();
            if (!findNodes(scene, a, b)) continue;
            findSurfaces(scene, 0, a), findSurfaces(scene, 1, b);
            normalsByMass ? findNormalsByMass(scene.grid, first) : findNormals(scene.grid, first);
            turnAtEdges(scene, 0, a, first), turnAtEdges(scene, 1, b, first);
            findFaces(scene, 0, a), findFaces(scene, 1, b);
            findIntruders(scene.grid, 0, a, b), findIntruders(scene.grid, 1, b, a);
            findGaps(scene.grid, first), borrow(scene.grid, first);
            findTouches(scene, a, b);
            pairs.push_back({first, meets.size(), touched, touches.size()});
            forget(scene.grid, first);
        }
}

// The nodes on which both groups have mass.
template <int Dim> bool Meeting<Dim>::findNodes(const Scene<Dim>& scene, int a, int b) {
    const Grid<Dim>& grid = scene.grid;
    const auto &fieldA = grid.fields[a], &fieldB = grid.fields[b];
    const double least = scene.leastMass();
    const size_t first = meets.size();
    for (int slab = 0; slab < grid.slabs(); ++slab) {
        auto both = fieldA.extents[slab];
        for (int k = 0; k < Dim - 1; ++k) {
            both.first[k] = std::max(both.first[k], fieldB.extents[slab].first[k]);
            both.last[k] = std::min(both.last[k], fieldB.extents[slab].last[k]);
        }
        grid.forNodes(both, slab, [&](int node) {
            if (!(fieldA.sum[node][NodalField<Dim>::mass] > least && fieldB.sum[node][NodalField<Dim>::mass] > least)) return;
            slot_[node] = int(meets.size());
            meets.emplace_back();
            meets.back().node = node, meets.back().field[0] = a, meets.back().field[1] = b;
            forNeighbours(grid, node, [&](int other, const Vec<Dim>&) { isNear_[other] = 1; });
        });
    }
    return meets.size() > first;
}

template <int Dim> void Meeting<Dim>::forget(const Grid<Dim>& grid, size_t first) {
    for (size_t i = first; i < meets.size(); ++i) {
        slot_[meets[i].node] = -1;
        forNeighbours(grid, meets[i].node, [&](int other, const Vec<Dim>&) { isNear_[other] = 0; });
    }
}

template <int Dim> int Meeting<Dim>::nearest(const Grid<Dim>& grid, const Field& position, int i) const {
    int node = 0;
    for (int k = 0; k < Dim; ++k) node += int(grid.inCells(position.plane(k)[i], k) + 0.5) * grid.strides[k];
    return node;
}

template <int Dim> void Meeting<Dim>::findSurfaces(const Scene<Dim>& scene, int side, int field) {
    boxes_[side].clear();
    for (size_t b = 0; b < scene.bodies.size(); ++b) {
        Body<Dim>& body = *scene.bodies[b];
        if (body.velocityField != field) continue;
        if (body.type->isMeshed())
            addFacets(body, boundaries_[b], scene.grid, side);
        else
            addBoxes(body, scene.grid, side);
    }
}

// int over the surface of phi n = int grad phi dV,  of phi d n^T = int (d grad phi^T + phi I) dV.
template <int Dim> void Meeting<Dim>::addBoxes(const Body<Dim>& body, const Grid<Dim>& grid, int side) {
    const Field& position = body.particles.position;
    const double* V = body.particles.volume.plane();
    const Vec<Dim> half = body.domains->halfSize().cwiseQuotient(grid.cell);
    for (int p = 0; p < body.particles.size(); ++p) {
        const int centre = nearest(grid, position, p);
        if (!isNear_[centre]) continue;
        const Vec<Dim> x = vectorAt<Dim>(position, p), middle = grid.nodePosition(centre);
        boxes_[side].push_back({centre, x});
        const double density = V[p] / (2 * half).prod();
        HatIntegrals axes[Dim][3];
        for (int k = 0; k < Dim; ++k)
            for (int i = 0; i < 3; ++i) axes[k][i] = HatIntegrals((x[k] - middle[k]) / grid.cell[k] - (i - 1), half[k]);
        const Mat<Dim> scale = density * grid.cell * grid.cell.cwiseInverse().transpose();
        forNeighbours(grid, centre, [&](int node, const Vec<Dim>& step) {
            if (slot_[node] < 0) return;
            const auto axis = [&](int k) -> const HatIntegrals& { return axes[k][int(step[k]) + 1]; };
            FaceSeen<Dim>& surface = meets[slot_[node]].surface[side];
            for (int n = 0; n < Dim; ++n) {
                double outward = density / grid.cell[n];
                for (int k = 0; k < Dim; ++k) outward *= k == n ? axis(k).slope : axis(k).N;
                surface.outward[n] += outward;
                for (int m = 0; m < Dim; ++m) {
                    double moment = scale(m, n);
                    for (int k = 0; k < Dim; ++k)
                        moment *= k == n ? (k == m ? axis(k).firstOfSlope + axis(k).N : axis(k).slope)
                                         : (k == m ? axis(k).first : axis(k).N);
                    surface.moment(m, n) += moment;
                }
            }
        });
    }
}

// Each facet as equal parts at its vertices.
template <int Dim> void Meeting<Dim>::addFacets(Body<Dim>& body, Boundary& boundary, const Grid<Dim>& grid, int side) {
    if (boundary.particles != body.particles.size()) boundary.find(body); // the first time, or after a conversion
    const Field& X = *body.domains->vertexPositions();
    for (int v : boundary.vertices) {
        const int node = nearest(grid, X, v);
        boundary.outward[v].setZero(), boundary.extent[v] = 0, boundary.node[v] = isNear_[node] ? node : -1;
    }
    for (auto& facet : boundary.facets.facets) {
        bool isClose = false;
        for (int v : facet) isClose |= boundary.node[v] >= 0;
        if (!isClose) continue;
        const Vec<Dim> share = areaVector<Dim>(X, facet) / boundary.facets.size;
        for (int v : facet) boundary.outward[v] += share, boundary.extent[v] += share.norm();
    }
    for (int v : boundary.vertices) {
        if (boundary.node[v] < 0) continue;
        const Vec<Dim> x = vectorAt<Dim>(X, v);
        forHats<Dim>(grid, x, [&](int node, double phi) {
            if (slot_[node] < 0) return;
            FaceSeen<Dim>& surface = meets[slot_[node]].surface[side];
            surface.outward += phi * boundary.outward[v], surface.extent += phi * boundary.extent[v];
            surface.moment += phi * (x - grid.nodePosition(node)) * boundary.outward[v].transpose();
        });
    }
}

// Boxes have faces along the axes; of two groups of them those count that look at each other. Else, at an edge of one group, the
// flatter surface of the other counts. Flatness is what a surface has left of its area when its directions are added up. Of equals
// the mesh counts.
template <int Dim> void Meeting<Dim>::findNormals(const Grid<Dim>& grid, size_t first) {
    for (size_t i = first; i < meets.size(); ++i) {
        Meet<Dim>& meet = meets[i];
        const bool meshed[2] = {isMeshed_[meet.field[0]], isMeshed_[meet.field[1]]};
        const Vec<Dim> outward[2] = {meet.surface[0].outward, -meet.surface[1].outward}; // along the normal, both
        Vec<Dim> sum = Vec<Dim>::Zero();
        if (!meshed[0] && !meshed[1]) {
            for (int k = 0; k < Dim; ++k)
                if (const double a = outward[0][k], b = outward[1][k]; a * b > 0) sum[k] = std::abs(a) < std::abs(b) ? a : b;
            meet.normal = unit<Dim>(sum, 0.0);
            continue;
        }
        double size[2], flatness[2];
        for (int side = 0; side < 2; ++side) {
            size[side] = outward[side].norm();
            const double extent = meshed[side] ? meet.surface[side].extent : outward[side].template lpNorm<1>();
            flatness[side] = size[side] / std::max(extent, 1e-300);
        }
        const double flattest = std::max(flatness[0], flatness[1]);
        bool counts[2];
        for (int side = 0; side < 2; ++side) counts[side] = size[side] > 0 && flatness[side] > 0.99 * flattest;
        if (meshed[0] != meshed[1]) { // boxes count where they are flat and the mesh has an edge, or at a plane of symmetry
            const int mesh = meshed[0] ? 0 : 1;
            const bool isHeld = grid.fields[meet.field[0]].isHeld(meet.node) || grid.fields[meet.field[1]].isHeld(meet.node);
            const bool face = outward[0].dot(outward[1]) > 0; // else boxes caught inside the mesh hide the surface of the others
            if (counts[mesh] || (!isHeld && (!face || flatness[1 - mesh] < edge))) counts[mesh] = size[mesh] > 0, counts[1 - mesh] = !counts[mesh];
        }
        for (int side = 0; side < 2; ++side)
            if (counts[side]) sum += outward[side] / size[side];
        meet.normal = unit<Dim>(sum, 1e-6);
        for (int side = 0; side < 2; ++side)
            if (counts[side] && meshed[side] && !meshed[1 - side] && flatness[side] < edge) meet.edgeOf = side;
    }
}

// At an edge of a mesh against boxes the facets count as far as they move towards these: the tip of a pile pushes what lies below
// it down, not aside.
template <int Dim> void Meeting<Dim>::turnAtEdges(const Scene<Dim>& scene, int side, int field, size_t first) {
    if (!isMeshed_[field]) return;
    const Grid<Dim>& grid = scene.grid;
    std::vector<Vec<Dim>> sum(meets.size() - first, Vec<Dim>::Zero());
    forMeshes(scene, field, [&](const Field& X, const Boundary& boundary) {
        for (auto& facet : boundary.facets.facets)
            for (int v : facet) {
                if (boundary.node[v] < 0) continue;
                const Vec<Dim> share = areaVector<Dim>(X, facet) / boundary.facets.size;
                forHats<Dim>(grid, vectorAt<Dim>(X, v), [&](int node, double phi) {
                    if (slot_[node] < 0 || meets[slot_[node]].edgeOf != side) return;
                    const Meet<Dim>& meet = meets[slot_[node]];
                    double closing = 0;
                    for (int k = 0; k < Dim; ++k)
                        closing += share[k] * (grid.fields[meet.field[side]].motion[node][k] - grid.fields[meet.field[1 - side]].motion[node][k]);
                    if (closing > 0) sum[slot_[node] - first] += phi * closing / share.norm() * share;
                });
            }
    });
    for (size_t i = first; i < meets.size(); ++i)
        if (meets[i].edgeOf == side && !sum[i - first].isZero(0)) meets[i].normal = (side == 0 ? 1 : -1) * sum[i - first].normalized();
}

template <int Dim> void Meeting<Dim>::findNormalsByMass(const Grid<Dim>& grid, size_t first) {
    for (size_t i = first; i < meets.size(); ++i) {
        Vec<Dim> slope[2] = {Vec<Dim>::Zero(), Vec<Dim>::Zero()};
        for (int side = 0; side < 2; ++side)
            forNeighbours(grid, meets[i].node, [&](int node, const Vec<Dim>& step) {
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
    if (!isMeshed_[field]) return;
    const Grid<Dim>& grid = scene.grid;
    const double sign = side == 0 ? 1 : -1, h = grid.cell.minCoeff();
    forMeshes(scene, field, [&](const Field& X, const Boundary& boundary) {
        for (int v : boundary.vertices) {
            const int centre = boundary.node[v];
            if (centre < 0) continue;
            const Vec<Dim> x = vectorAt<Dim>(X, v), &outward = boundary.outward[v];
            forNeighbours(grid, centre, [&](int node, const Vec<Dim>&) {
                if (slot_[node] < 0) return;
                Meet<Dim>& meet = meets[slot_[node]];
                FaceSeen<Dim>& face = meet.surface[side];
                const Vec<Dim> d = x - grid.nodePosition(node);
                const double along = sign * d.dot(meet.normal), beside = std::max(0.0, d.squaredNorm() - along * along);
                const double faces = sign * outward.dot(meet.normal) / outward.norm();
                if (beside > h * h || beside >= face.nearest || !(faces > 0.5)) return;
                face.nearest = beside, face.reach = faces > 0.9 ? d.dot(outward) / (faces * outward.norm()) : along;
            });
        }
    });
}

// Boxes against a mesh: where the centre of one has crossed its face, the gap is closed, whatever the others do. What lies deeper than
// half a cell belongs to the other side.
template <int Dim> void Meeting<Dim>::findIntruders(const Grid<Dim>& grid, int side, int field, int other) {
    if (isMeshed_[field] || !isMeshed_[other]) return;
    const double sign = side == 0 ? 1 : -1, h = grid.cell.minCoeff();
    for (const Box& box : boxes_[side])
        forNeighbours(grid, box.node, [&](int node, const Vec<Dim>&) {
            if (slot_[node] < 0) return;
            Meet<Dim>& meet = meets[slot_[node]];
            const FaceSeen<Dim>& face = meet.surface[1 - side];
            const Vec<Dim> d = box.centre - grid.nodePosition(node);
            const double along = sign * d.dot(meet.normal);
            const double overlap = along + face.reach;
            if (face.nearest == 1e300 || overlap < 0 || overlap > 0.5 * h || d.squaredNorm() - along * along > 0.5 * h * h) return;
            double& furthest = meet.surface[side].intruded;
            furthest = std::max(furthest, along);
        });
}

// How far each group reaches along the normal. Surfaces of boxes that seem to cross by half a cell face away from each other.
template <int Dim> void Meeting<Dim>::findGaps(const Grid<Dim>& grid, size_t first) {
    for (size_t i = first; i < meets.size(); ++i) {
        Meet<Dim>& meet = meets[i];
        const Vec<Dim>& n = meet.normal;
        const double area[2] = {meet.surface[0].outward.dot(n), -meet.surface[1].outward.dot(n)};
        const bool isMesh[2] = {isMeshed_[meet.field[0]], isMeshed_[meet.field[1]]};
        meet.area = std::max(0.0, std::min(area[0], area[1]));
        const bool intruded = meet.surface[0].intruded > -1e300 || meet.surface[1].intruded > -1e300;
        meet.weight = intruded ? area[isMesh[0] ? 0 : 1] : meet.area;
        if (!(meet.weight > 0)) continue;
        double reach[2];
        for (int side = 0; side < 2; ++side) {
            const FaceSeen<Dim>& face = meet.surface[side];
            reach[side] = isMesh[side] && face.nearest < 1e300 ? face.reach
                          : area[side] > 0.05 * meet.weight    ? n.dot(face.moment * n) / area[side]
                                                               : -1e300;
            reach[side] = std::max(reach[side], face.intruded);
        }
        meet.gap = -reach[1] - reach[0];
        if (!isMesh[0] && !isMesh[1] && meet.gap < -0.5 * grid.cell.minCoeff()) meet.weight = 0;
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
        forNeighbours(grid, meet.node, [&](int node, const Vec<Dim>&) {
            if (slot_[node] < 0 || !(meets[slot_[node]].weight > least)) return;
            const Meet<Dim>& other = meets[slot_[node]];
            normal += other.weight * other.normal, weight += other.weight, gap += other.weight * other.gap;
        });
        meet.normal = unit<Dim>(normal, 0.1 * weight), meet.gap = weight > 0 ? gap / weight : 0;
    }
}

// Vertices at the surface of a mesh that are near to a meet and at no edge, by their nearest node.
template <int Dim> auto Meeting<Dim>::skin(const Scene<Dim>& scene, int field) const -> std::vector<Skin> {
    std::vector<Skin> found;
    if (!isMeshed_[field]) return found;
    forMeshes(scene, field, [&](const Field& X, const Boundary& boundary) {
        for (int v : boundary.vertices) {
            const int node = boundary.node[v];
            const Vec<Dim>& outward = boundary.outward[v];
            const double size = outward.norm();
            if (node >= 0 && size > edge * boundary.extent[v]) found.push_back({node, vectorAt<Dim>(X, v), outward / size});
        }
    });
    std::stable_sort(found.begin(), found.end());
    return found;
}

// Distance of a vertex from boxes, along its normal: from where the nodes round it see them, if that is a plane. 1e300: it is not.
template <int Dim> double Meeting<Dim>::distanceOfBoxes(const Grid<Dim>& grid, const Skin& own, int side) const {
    double facing = 0, all = 0, distance = 0;
    forHats<Dim>(grid, own.position, [&](int node, double S) {
        if (slot_[node] < 0) return;
        const FaceSeen<Dim>& boxes = meets[slot_[node]].surface[1 - side];
        const double area = -S * boxes.outward.dot(own.outward);
        facing += area, all += S * boxes.outward.template lpNorm<1>();
        distance += area * (grid.nodePosition(node) - own.position).dot(own.outward) - S * own.outward.dot(boxes.moment * own.outward);
    });
    return facing > 0.4 * std::pow(grid.cell.minCoeff(), Dim - 1) && facing > edge * all ? distance / facing : 1e300;
}

// Distance of a vertex from another mesh: from the tangent plane at its nearest vertex, to which the normal is turned half-way.
template <int Dim>
double Meeting<Dim>::distanceOfMesh(const Grid<Dim>& grid, const Skin& own, const std::vector<Skin>& others, Vec<Dim>& normal) const {
    const Skin* other = nullptr;
    double least = 1e300;
    forNeighbours(grid, own.node, [&](int node, const Vec<Dim>& step) {
        if (step[0] > -1) return; // rows of three nodes follow each other
        auto it = std::lower_bound(others.begin(), others.end(), node, [](const Skin& skin, int node) { return skin.node < node; });
        for (; it != others.end() && it->node < node + 3; ++it)
            if (const double d = (it->position - own.position).squaredNorm(); d < least) least = d, other = &*it;
    });
    if (!other || own.outward.dot(other->outward) > -edge) return 1e300;
    normal = (own.outward - other->outward).normalized();
    return (own.position - other->position).dot(other->outward);
}

// Where surfaces are curved they overlap between nodes that keep their gap. So the vertices of meshes keep their distance, too.
template <int Dim> void Meeting<Dim>::findTouches(const Scene<Dim>& scene, int a, int b) {
    const Grid<Dim>& grid = scene.grid;
    const double h = grid.cell.minCoeff();
    const std::vector<Skin> skins[2] = {skin(scene, a), skin(scene, b)};
    for (int side = 0; side < 2; ++side)
        for (const Skin& own : skins[side]) {
            Touch<Dim> touch;
            touch.normal = own.outward, touch.tolerated = tolerated * h;
            touch.gap = isMeshed_[side == 0 ? b : a] ? distanceOfMesh(grid, own, skins[1 - side], touch.normal) : distanceOfBoxes(grid, own, side);
            if (side == 1) touch.normal = -touch.normal;
            if (std::abs(touch.gap) > 0.5 * h) continue;
            int corner = 0;
            bool isShared = true;
            forHats<Dim>(grid, own.position, [&](int node, double S) {
                isShared &= slot_[node] >= 0;
                touch.meet[corner] = slot_[node], touch.S[corner++] = S;
            });
            if (!isShared) continue;
            for (int meet : touch.meet) meets[meet].hasTouches = true;
            touches.push_back(touch);
        }
}

template class Meeting<2>;
template class Meeting<3>;

} // namespace mpm
