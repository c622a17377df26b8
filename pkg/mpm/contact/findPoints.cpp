// SPDX-License-Identifier: GPL-2.0-or-later
// Contact points: where surfaces are curved they overlap between nodes that keep their gap. So the vertices
// of meshes keep their distance, too.
#include "mpm/contact/PairSearch.hpp"

namespace mpm {

namespace {

// Overlap that is let pass, in cells: planes then leave all to the nodes, and a rolling disc is no polygon of
// its vertices.
constexpr double toleratedOverlap = 0.01;
// Gap in cells that is none where points do all: the vertices of loaded bodies do not lie on one plane, and those a
// hair further away would bear no adhesion.
constexpr double closedGap = 1e-3;
// Distance of a vertex from the other surface, in cells, up to which it is a contact point: what is deeper
// has crossed and is not pushed back.
constexpr double furthest = 0.5;
// Area of boxes that faces a vertex, over that of a face of the cell, above which they are seen well enough:
// about half of what a node sees of a plane. Half the value changes nothing in a block that is pressed into clay,
// with twice the value the block resists 10 % more.
constexpr double leastFacingArea = 0.4;
// Part of the area of a node that contact points may own before they do all that it would: at the end of a plane
// they own half of it. With half the value that block resists 1.5 % less, without a bound 11 % more.
constexpr double mostOwned = 0.75;
// Points of a regular mesh may own exactly that part, as beside an edge without points where two domains go to a cell.
// A part that is less by round-off is enough, too.
constexpr double roundOffOfOwned = 1e-6;

// Part of a mesh at a point that boxes face, below which their surface ends there.
constexpr double leastCovered = 0.75;

// Part of the facets of a vertex below which none is left off planes of symmetry: the rest is round-off.
constexpr double leastLeft = 1e-6;

// Size of the direction of edges, see EdgeMotions, from which on they have gone their way: a twentieth of a
// cell. With half the value the thrust on a sheet with its toe in soil is 3 % less, with twice the value the same.
constexpr double onItsWay = 0.2;

// The faces that meet at an edge of a mesh, each of which presses on its own. None where the edge has gone
// its way: the soil that flows round it has several velocities there, and one cannot follow all faces.
template <int Dim>
std::vector<typename PairSearch<Dim>::Vertex>
facesOf(const PairSearch<Dim>& pair, int side, const Body<Dim>& body, const ExplicitSurface<Dim>& surface,
        const typename PairSearch<Dim>::Vertex& vertex) {
    if (pair.lastDirection[side].norm() > onItsWay) return {};
    auto faces = surface.facesAt(body, vertex);
    for (auto& face : faces) face = pair.withoutPlanes(face);
    const auto isNone = [](const auto& face) { return face.size <= leastLeft * face.extent; };
    faces.erase(std::remove_if(faces.begin(), faces.end(), isNone), faces.end());
    return faces;
}

// Vertices at the surface of a mesh that are near, by their nearest node; at an edge against boxes one for
// each face.
template <int Dim> struct SmoothVertices {
    using Vertex = typename PairSearch<Dim>::Vertex;
    std::vector<Vertex> all;
    std::vector<int> bin, body, faces; // number of the body in the scene; faces at an edge, 1: it is none
    Bins bins;

    SmoothVertices(PairSearch<Dim>& pair, int side) {
        if (!pair.isExplicit[side]) return;
        pair.forSurfaces(side, [&](const Body<Dim>& of, const ExplicitSurface<Dim>& surface) {
            const int number = int(&surface - pair.surfaces.data());
            const auto add = [&](const Vertex& vertex, int count) {
                all.push_back(vertex);
                body.push_back(number);
                faces.push_back(count);
                bin.push_back(pair.nearby.number(vertex.node));
            };
            for (Vertex near : surface.near) {
                if (!pair.see(of, surface, near)) continue;
                const Vertex vertex = pair.withoutPlanes(near);
                if (vertex.size <= leastLeft * near.extent) continue;
                if (vertex.isFlatter(edgeFlatness)) {
                    add(vertex, 1);
                } else if (pair.ownsFacets && near.number >= 0 && !pair.isExplicit[1 - side]) {
                    const auto parts = facesOf(pair, side, of, surface, near);
                    for (const Vertex& face : parts) add(face, int(parts.size()));
                }
            }
        });
        bins.fill(pair.nearby.size(), bin);
    }
    bool isEmpty() const { return all.empty(); }
    const Vertex& at(int place) const { return all[bins.point(place)]; }
    int bodyAt(int place) const { return body[bins.point(place)]; }
    int facesAt(int place) const { return faces[bins.point(place)]; }
};

// Boxes as a node sees them. all: those on both sides of a wall, too, where a soil is one.
template <int Dim> struct SeenBoxes {
    Vec<Dim> outward;
    Mat<Dim> moment;
};
template <int Dim>
SeenBoxes<Dim> boxesAt(const PairSearch<Dim>& pair, const ContactNode<Dim>& contact, int side, bool all) {
    SeenBoxes<Dim> seen{contact.surface[side].outward, contact.surface[side].moment};
    if (!all && pair.isBonded(contact.node)) {
        const bool isSecond = contact.field[side] != pair.field[side];
        seen.outward -= contact.sides[isSecond ? 0 : 1].outward;
        seen.moment -= contact.sides[isSecond ? 0 : 1].moment;
    }
    return seen;
}

// Distance of a vertex from boxes, along its normal: from where the nodes round it see them, if that is a
// plane. farAway: it is not. Where points own facets boxes whose faces lie oblique to the vertex are a plane,
// too.
template <int Dim>
double distanceOfBoxes(const PairSearch<Dim>& pair, const typename PairSearch<Dim>::Vertex& own, int side,
                       int faces) {
    const Vec<Dim> n = own.normal();
    double facing = 0, all = 0, distance = 0;
    Vec<Dim> seen = Vec<Dim>::Zero();
    double part = std::pow(0.5, faces - 1); // of a surface that is on this side of planes and edges
    for (int k = 0; k < Dim && pair.ownsFacets; ++k)
        if (pair.isOnPlane(own, k)) part *= 0.5;
    for (int corner = 0; corner < own.around.size; ++corner) {
        if (own.around.contact[corner] < 0) continue;
        const ContactNode<Dim>& contact = (*pair.nodes)[own.around.contact[corner]];
        const auto [outward, moment] = boxesAt(pair, contact, 1 - side, own.seesAll);
        const double S = own.around.S[corner];
        const double area = -S * outward.dot(n);
        facing += area;
        seen += S * outward;
        all += S * (pair.ownsFacets ? outward.norm() : outward.template lpNorm<1>());
        distance += area * (contact.position - own.position).dot(n) - S * n.dot(moment * n);
    }
    const double face = std::pow(pair.grid().sizeAt(own.position).minCoeff(), Dim - 1);
    // At an edge of the mesh boxes have one, too, or they are a plane: then the nodes see its normal.
    const bool isLike =
        faces == 1 ? facing > edgeFlatness * all : seen.norm() < edgeFlatness * seen.template lpNorm<1>();
    return isLike && facing > leastFacingArea * part * face ? distance / facing : farAway;
}

// Distance of a vertex from another mesh: from the tangent plane at its nearest vertex, to which the normal
// is turned half-way. farAway: there is none that faces it.
template <int Dim>
double distanceOfMesh(const PairSearch<Dim>& pair, const typename PairSearch<Dim>::Vertex& own,
                      const SmoothVertices<Dim>& others, Vec<Dim>& normal) {
    if (others.isEmpty()) return farAway;
    const typename PairSearch<Dim>::Vertex* other = nullptr;
    double least = farAway; // m2
    forNeighbours(pair.grid(), own.node, [&](int node, const Index<Dim>&) {
        const int bin = pair.nearby.number(node);
        if (bin < 0) return;
        for (int v = others.bins.begin(bin); v < others.bins.end(bin); ++v) {
            const auto& vertex = others.at(v);
            const double square = (vertex.position - own.position).squaredNorm();
            if (square >= least) continue;
            least = square;
            other = &vertex;
        }
    });
    if (!other) return farAway;
    const Vec<Dim> n = own.normal(), facing = other->normal();
    if (n.dot(facing) > -edgeFlatness) return farAway;
    normal = (n - facing).normalized();
    return (own.position - other->position).dot(facing);
}

template <int Dim> void close(ContactSite<Dim>& site, double cell) {
    if (site.gap > 0) site.gap = std::max(site.gap - closedGap * cell, 0.0);
}

// The point takes its share of the facets from the nodes round it.
template <int Dim>
void takeFacets(PairSearch<Dim>& pair, const typename PairSearch<Dim>::Vertex& own, double cell,
                ContactPoint<Dim>& point) {
    close(point, cell);
    point.area = own.size;
    point.tolerated = 0;
    for (int corner = 0; corner < own.around.size; ++corner) {
        ContactNode<Dim>& contact = (*pair.nodes)[own.around.contact[corner]];
        contact.owned += own.around.S[corner] * own.size;
        contact.gapOfPoints += own.around.S[corner] * own.size * point.gap;
    }
}

// What a node has left of its area when points own the rest; with too little of it it does not act.
template <int Dim> void leaveTheRest(const PairSearch<Dim>& pair, ContactNode<Dim>& contact, int owner) {
    if (!contact.hasPoints) return;
    const double all = std::max(contact.area, contact.weight);
    contact.isLeftOut = contact.owned > (mostOwned - roundOffOfOwned) * all;
    if (contact.isLeftOut) {
        contact.scaleOfOwned =
            (pair.isExplicit[1 - owner] ? contact.area : contact.areaOf(owner)) / contact.owned;
        contact.gap = contact.gapOfPoints / contact.owned;
    }
    contact.area = std::max(0.0, contact.area - contact.owned);
}

// And the points take all of the surface at nodes that do not act, or what the other group has of it where that ends:
// the surface of boxes is uneven, and the mean of the smaller areas is too small.
template <int Dim> void takeTheRest(const PairSearch<Dim>& pair, ContactPoint<Dim>& point, int owner) {
    const double size = point.area;
    double own = 0, other = 0;
    point.area = 0;
    for (int corner = 0; corner < point.size; ++corner) {
        const ContactNode<Dim>& contact = (*pair.nodes)[point.contact[corner]];
        point.area += point.S[corner] * size * contact.scaleOfOwned;
        if (!contact.isLeftOut) continue;
        own += point.S[corner] * contact.areaOf(owner);
        other += point.S[corner] * contact.areaOf(1 - owner);
    }
    if (!pair.isExplicit[1 - owner] && other < leastCovered * own) point.area *= std::max(0.0, other / own);
}

template <int Dim> bool isBetweenContactNodes(const SurroundingNodes<Dim>& around) {
    bool areAll = true;
    for (int contact : around.contact) areAll &= contact >= 0;
    return areAll;
}

// Of a vertex on a grid line, as on the upper of two planes of symmetry, the nodes on one side feel nothing:
// a neighbour stands for those that are none of contact.
template <int Dim> SurroundingNodes<Dim> withFeeling(SurroundingNodes<Dim> around) {
    for (int corner = 0; corner < around.size; ++corner)
        for (int k = 0; k < Dim && around.contact[corner] < 0 && around.S[corner] == 0; ++k)
            around.contact[corner] = around.contact[corner ^ 1 << k];
    return around;
}

// The hat functions where the other surface is, a gap away, in the cell of the point.
template <int Dim> void weighOther(const Grid<Dim>& grid, ContactPoint<Dim>& point) {
    const Vec<Dim> outward = point.side == 0 ? point.normal : Vec<Dim>(-point.normal),
                   other = point.position + std::max(point.gap, 0.0) * outward;
    double part[Dim];
    for (int k = 0; k < Dim; ++k)
        part[k] = PlaceInCell(grid.inCells(point.position[k], k)).partOf(grid.inCells(other[k], k));
    point.weigh(part, point.otherS);
}

} // namespace

template <int Dim> void findPoints(PairSearch<Dim>& pair, std::vector<ContactPoint<Dim>>& points) {
    const SmoothVertices<Dim> vertices[2] = {{pair, 0}, {pair, 1}};
    // Of two meshes only the finer one owns facets.
    const int coarser = vertices[0].bins.count() < vertices[1].bins.count() ? 0 : 1;
    if (!vertices[0].isEmpty() || !vertices[1].isEmpty()) pair.owner = 1 - coarser;
    for (int side = 0; side < 2; ++side)
        for (int v = 0; v < vertices[side].bins.count(); ++v) {
            if (pair.ownsFacets && side == coarser && !vertices[1 - side].isEmpty()) break;
            auto own = vertices[side].at(v);
            const int faces = vertices[side].facesAt(v);
            if (pair.ownsFacets) own.around = withFeeling<Dim>(own.around);
            if (!isBetweenContactNodes<Dim>(own.around)) continue;
            const double h = pair.grid().sizeAt(own.position).minCoeff();
            ContactPoint<Dim> point;
            point.normal = own.normal();
            point.tolerated = toleratedOverlap * h;
            point.gap = pair.isExplicit[1 - side]
                            ? distanceOfMesh(pair, own, vertices[1 - side], point.normal)
                            : distanceOfBoxes(pair, own, side, faces);
            if (side == 1) point.normal = -point.normal;
            point.side = side;
            point.body = vertices[side].bodyAt(v);
            point.vertex = own.number;
            point.position = own.position;
            if (std::abs(point.gap) > furthest * h) continue;
            static_cast<SurroundingNodes<Dim>&>(point) = own.around;
            weighOther(pair.grid(), point);
            for (int corner = 0; corner < point.size; ++corner)
                if (point.S[corner] > 0) (*pair.nodes)[point.contact[corner]].hasPoints = true;
            if (pair.ownsFacets) takeFacets(pair, own, h, point);
            points.push_back(point);
        }
}

template <int Dim>
void shareFacets(const PairSearch<Dim>& pair, std::vector<ContactPoint<Dim>>& points, size_t first) {
    pair.forNodes([&](ContactNode<Dim>& contact) {
        close(contact, pair.grid().meanSize(contact.node).minCoeff());
        leaveTheRest(pair, contact, pair.owner);
    });
    for (size_t i = first; i < points.size(); ++i) takeTheRest(pair, points[i], pair.owner);
}

template void findPoints(PairSearch<2>&, std::vector<ContactPoint<2>>&);
template void findPoints(PairSearch<3>&, std::vector<ContactPoint<3>>&);
template void shareFacets(const PairSearch<2>&, std::vector<ContactPoint<2>>&, size_t);
template void shareFacets(const PairSearch<3>&, std::vector<ContactPoint<3>>&, size_t);

} // namespace mpm
