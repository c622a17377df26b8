// SPDX-License-Identifier: GPL-2.0-or-later
// The surface of a body that has an explicit one: the boundary of its mesh, or the outline of its boxes.
#pragma once

#include "mpm/contact/BoundaryFacets.hpp"
#include "mpm/contact/Neighbourhood.hpp"
#include "mpm/scene/Body.hpp"

namespace mpm {

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

template <int Dim> class ExplicitSurface {
  public:
    static bool isOf(const Body<Dim>& body) { return body.type->isMeshed() || body.domains->outline(); }

    struct
        Vertex {  // at the boundary of a mesh; or the middle of a facet of an outline, or one of its corners
        int node; // the nearest
        Vec<Dim> position, outward; // area vector of its share of the facets, from
        double size, extent;        // its size, and the area of the share
        NodesRound<Dim> round;
    };
    std::vector<Vertex> near; // of the vertices of a mesh or the facets of an outline

    // What is near, and what its parts have of the surface: vertices, or the corners of facets.
    void find(Body<Dim>& body, const Grid<Dim>& grid, const Neighbourhood<Dim>& neighbourhood) {
        body.type->isMeshed() ? findVertices(body, grid, neighbourhood)
                              : findFacets(body, grid, neighbourhood);
    }
    const std::vector<Vertex>& parts(const Body<Dim>& body) const {
        return body.type->isMeshed() ? near : corners_;
    }

    // f(vertex, area vector of its share of a facet).
    template <class F> void forShares(Body<Dim>& body, F&& f) const {
        for (const Vertex& corner : corners_) f(corner, corner.outward);
        for (auto& facet : facets_.facets)
            for (int v : facet)
                if (place_[v] >= 0)
                    f(near[place_[v]],
                      areaVector<Dim>(*body.domains->vertexPositions(), facet) / facets_.size);
    }

  private:
    std::vector<Vertex> corners_; // of facets of an outline
    // Of a mesh:
    BoundaryFacets<Dim> facets_;
    std::vector<int> vertices_;
    std::vector<int> facetsAt_,
        firstAt_; // numbers of the facets at each vertex, one vertex after the other; where they begin
    std::vector<int> place_; // of each vertex in `near`, -1: not there
    int particles_ = -1;     // when it was found

    void findBoundary(Body<Dim>& body) {
        particles_ = body.particles.size();
        facets_.find(*body.domains);
        const int count = body.domains->vertexPositions()->size();
        firstAt_.assign(count + 1, 0), facetsAt_.resize(facets_.facets.size() * facets_.size);
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

    // With their share of the boundary: each facet as equal parts at its vertices.
    void findVertices(Body<Dim>& body, const Grid<Dim>& grid, const Neighbourhood<Dim>& neighbourhood) {
        if (particles_ != body.particles.size()) findBoundary(body); // the first time, or after a conversion
        const Field& X = *body.domains->vertexPositions();
        std::fill(place_.begin(), place_.end(), -1), near.clear();
        for (int v : vertices_) {
            const Vec<Dim> x = vectorAt<Dim>(X, v);
            if (!neighbourhood.holds(grid, x)) continue;
            Vertex vertex{nearestNode(grid, x), x, Vec<Dim>::Zero(), 0, 0, neighbourhood.round(grid, x)};
            for (int i = firstAt_[v]; i < firstAt_[v + 1]; ++i) {
                const Vec<Dim> share = areaVector<Dim>(X, facets_.facets[facetsAt_[i]]) / facets_.size;
                vertex.outward += share, vertex.extent += share.norm();
            }
            vertex.size = vertex.outward.norm();
            place_[v] = int(near.size()), near.push_back(vertex);
        }
    }

    // And equal parts of each at its corners: a facet is taken to be a square as seen along the axis that it faces most.
    void findFacets(const Body<Dim>& body, const Grid<Dim>& grid, const Neighbourhood<Dim>& neighbourhood) {
        const Outline<Dim>& outline = *body.domains->outline();
        near.clear(), corners_.clear();
        const auto add = [&](std::vector<Vertex>& to, const Vec<Dim>& x, const Vec<Dim>& outward) {
            if (const double size = outward.norm(); neighbourhood.holds(grid, x))
                to.push_back({nearestNode(grid, x), x, outward, size, size, neighbourhood.round(grid, x)});
        };
        for (int i = 0; i < outline.size(); ++i) {
            const Vec<Dim> carrier = vectorAt<Dim>(body.particles.position, outline.particle(i));
            if (((carrier + grid.cell).array() < neighbourhood.lower.array()).any() ||
                ((carrier - grid.cell).array() > neighbourhood.upper.array()).any())
                continue;
            const auto [x, outward] = outline.at(body.particles, i);
            add(near, x, outward);
            int facing;
            const double seen = outward.cwiseAbs().maxCoeff(&facing),
                         half = 0.5 * (Dim == 2 ? seen : std::sqrt(seen));
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
