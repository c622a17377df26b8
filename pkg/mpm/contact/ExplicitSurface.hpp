// SPDX-License-Identifier: GPL-2.0-or-later
// The surface of a body that has an explicit one: the boundary of its mesh, or the outline of its boxes.
#pragma once

#include "mpm/contact/BoundaryFacets.hpp"
#include "mpm/contact/NearbyNodes.hpp"
#include "mpm/scene/Body.hpp"

namespace mpm {

template <int Dim> class ExplicitSurface {
  public:
    static bool isOf(const Body<Dim>& body) {
        return body.type->isMeshed() || body.domains->boxes()->outline();
    }

    // At the boundary of a mesh; or the middle of a facet of an outline, or one of its corners.
    struct Vertex {
        int node;                   // the nearest
        Vec<Dim> position, outward; // m; m2, area vector of its part of the facets,
        double size, extent;        // m2, the size of that vector, and the area of the part
        SurroundingNodes<Dim> around;
        Vec<Dim> across = Vec<Dim>::Zero(); // m2, of the part: facets of a mesh that stand across an axis
        int number = -1;                    // of a vertex of a mesh
        // Outward and extent of what soil on the other side of a wall sees, which is all one where that ends.
        Vec<Dim> hidden = Vec<Dim>::Zero();
        double hiddenExtent = 0;
        bool seesAll = false; // nothing is hidden here

        // What a surface has left of its area when its directions are added up: 1 for a plane, less at an
        // edge.
        bool isFlatter(double flatness) const { return size > flatness * extent; }
        Vec<Dim> normal() const { return outward / size; }
        void add(const Vec<Dim>& part, double area) { // a part of a facet of a mesh
            outward += part;
            extent += area;
            for (int k = 0; k < Dim; ++k)
                if (std::abs(part[k]) > standsAcross * area) across[k] += area;
        }
    };
    std::vector<Vertex> near; // of the vertices of a mesh or the facets of an outline

    // What is near, and what its parts have of the surface: vertices, or the corners of facets. Those of a mesh that look
    // along `hidden` are left out.
    void find(Body<Dim>& body, const Grid<Dim>& grid, const NearbyNodes<Dim>& nearby,
              const Vec<Dim>& hidden = Vec<Dim>::Zero()) {
        hidden_ = hidden;
        body.type->isMeshed() ? findVertices(body, grid, nearby) : findFacets(body, grid, nearby);
    }
    const std::vector<Vertex>& parts(const Body<Dim>& body) const {
        return body.type->isMeshed() ? near : corners_;
    }

    // f(vertex, area vector of its part of a facet, whether that is hidden).
    template <class F> void forParts(Body<Dim>& body, F&& f) const {
        for (const Vertex& corner : corners_) f(corner, corner.outward, false);
        for (auto& facet : facets_.facets)
            for (int v : facet)
                if (place_[v] >= 0) {
                    const Vec<Dim> area = areaOf(body.domains->mesh()->vertexPositions(), facet);
                    f(near[place_[v]], Vec<Dim>(area / facets_.size), isHidden(area));
                }
    }

    // Of a mesh, as it was last found.
    const BoundaryFacets<Dim>& facets() const { return facets_; }
    // f(number of the facet) for the facets at a vertex.
    template <class F> void forFacetsAt(int vertex, F&& f) const {
        for (int i = firstAt_[vertex]; i < firstAt_[vertex + 1]; ++i) f(facetsAt_[i]);
    }

    // A vertex of a mesh with all of its facets.
    Vertex whole(const Body<Dim>& body, Vertex vertex) const {
        vertex.outward = vertex.across = Vec<Dim>::Zero();
        vertex.extent = 0;
        forFacetsAt(vertex.number, [&](int facet) {
            const Vec<Dim> part =
                areaOf(body.domains->mesh()->vertexPositions(), facets_.facets[facet]) / facets_.size;
            vertex.add(part, part.norm());
        });
        vertex.size = vertex.outward.norm();
        vertex.seesAll = true;
        return vertex;
    }
    // The parts of a vertex at an edge of a mesh: one for each face, of facets that look nearly the same way.
    std::vector<Vertex> facesAt(const Body<Dim>& body, const Vertex& vertex) const {
        std::vector<Vertex> faces;
        forFacetsAt(vertex.number, [&](int facet) {
            const Vec<Dim> part =
                areaOf(body.domains->mesh()->vertexPositions(), facets_.facets[facet]) / facets_.size;
            const double area = part.norm();
            if (!vertex.seesAll && isHidden(part)) return;
            const auto isAlike = [&](const Vertex& face) {
                return face.outward.dot(part) > ofOneFace * face.outward.norm() * area;
            };
            auto face = std::find_if(faces.begin(), faces.end(), isAlike);
            if (face == faces.end()) {
                Vertex anew = vertex;
                anew.outward = anew.across = Vec<Dim>::Zero();
                anew.extent = 0;
                face = faces.insert(faces.end(), anew);
            }
            face->add(part, area);
            face->size = face->outward.norm();
        });
        return faces;
    }

  private:
    std::vector<Vertex> corners_; // of facets of an outline
    // Of a mesh:
    BoundaryFacets<Dim> facets_;
    std::vector<int> vertices_;
    std::vector<int> facetsAt_; // numbers of the facets at each vertex, one vertex after the other,
    std::vector<int> firstAt_;  // and where they begin
    std::vector<int> place_;    // of each vertex in `near`, -1: not there
    int particles_ = -1;        // when it was found
    Vec<Dim> hidden_ = Vec<Dim>::Zero();

    // Cosine between a facet and the normal of a wall above which it belongs to one side: flat tips belong to both.
    static constexpr double ofOneSide = 0.5;
    bool isHidden(const Vec<Dim>& area) const { return area.dot(hidden_) > ofOneSide * area.norm(); }

    // Of an area vector, the part along an axis from which on the facet stands across it.
    static constexpr double standsAcross = 1 - 1e-9;
    // Cosine between a facet and a face above which it belongs to that.
    static constexpr double ofOneFace = 0.9;

    static Vec<Dim> areaOf(const Field& X, const typename BoundaryFacets<Dim>::Facet& facet) {
        return areaVector<Dim>([&](int a) { return vectorAt<Dim>(X, facet[a]); });
    }

    void findBoundary(Body<Dim>& body) {
        particles_ = body.particles.size();
        facets_.find(*body.domains);
        const int count = body.domains->mesh()->vertexPositions().size();
        firstAt_.assign(count + 1, 0);
        facetsAt_.resize(facets_.facets.size() * facets_.size);
        for (auto& facet : facets_.facets)
            for (int v : facet) ++firstAt_[v + 1];
        vertices_.clear();
        for (int v = 0; v < count; ++v) {
            if (firstAt_[v + 1] > 0) vertices_.push_back(v);
            firstAt_[v + 1] += firstAt_[v];
        }
        std::vector<int> next = firstAt_;
        for (size_t f = 0; f < facets_.facets.size(); ++f)
            for (int v : facets_.facets[f]) facetsAt_[next[v]++] = int(f);
        place_.assign(count, -1);
    }

    // With their part of the boundary: each facet as equal parts at its vertices.
    void findVertices(Body<Dim>& body, const Grid<Dim>& grid, const NearbyNodes<Dim>& nearby) {
        if (particles_ != body.particles.size()) findBoundary(body); // the first time, or after a conversion
        const Field& X = body.domains->mesh()->vertexPositions();
        std::fill(place_.begin(), place_.end(), -1);
        near.clear();
        for (int v : vertices_) {
            const Vec<Dim> x = vectorAt<Dim>(X, v);
            if (!nearby.holds(grid, x)) continue;
            Vertex vertex{nearestNode(grid, x), x, Vec<Dim>::Zero(), 0, 0, nearby.around(grid, x)};
            for (int i = firstAt_[v]; i < firstAt_[v + 1]; ++i) {
                const Vec<Dim> part = areaOf(X, facets_.facets[facetsAt_[i]]) / facets_.size;
                const double area = part.norm();
                if (isHidden(part)) {
                    vertex.hidden += part;
                    vertex.hiddenExtent += area;
                    continue;
                }
                vertex.add(part, area);
            }
            vertex.size = vertex.outward.norm();
            vertex.number = v;
            place_[v] = int(near.size());
            near.push_back(vertex);
        }
    }

    // And equal parts of each at its corners: a facet is taken to be a square as seen along the axis that it
    // faces most.
    void findFacets(const Body<Dim>& body, const Grid<Dim>& grid, const NearbyNodes<Dim>& nearby) {
        const Outline<Dim>& outline = *body.domains->boxes()->outline();
        near.clear();
        corners_.clear();
        const auto add = [&](std::vector<Vertex>& to, const Vec<Dim>& x, const Vec<Dim>& outward) {
            if (const double size = outward.norm(); nearby.holds(grid, x))
                to.push_back({nearestNode(grid, x), x, outward, size, size, nearby.around(grid, x)});
        };
        for (int i = 0; i < outline.size(); ++i) {
            const Vec<Dim> carrier = vectorAt<Dim>(body.particles.position, outline.particle(i));
            if (((carrier + grid.smallestCell()).array() < nearby.lower.array()).any() ||
                ((carrier - grid.smallestCell()).array() > nearby.upper.array()).any())
                continue;
            const auto [x, outward] = outline.at(body.particles, i);
            add(near, x, outward);
            int facing;
            const double seen = outward.cwiseAbs().maxCoeff(&facing);
            const double half = 0.5 * (Dim == 2 ? seen : std::sqrt(seen));
            for (int corner = 0; corner < BoundaryFacets<Dim>::size; ++corner) {
                Vec<Dim> d;
                for (int k = 0, bit = 0; k < Dim; ++k)
                    d[k] = k == facing ? 0 : corner >> bit++ & 1 ? half : -half;
                d[facing] = -d.dot(outward) / outward[facing];
                add(corners_, x + d, outward / BoundaryFacets<Dim>::size);
            }
        }
    }
};

} // namespace mpm
