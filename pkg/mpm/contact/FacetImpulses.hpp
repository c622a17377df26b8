// SPDX-License-Identifier: GPL-2.0-or-later
// What contact gives to each facet of the meshes of a structure, summed up over time: facePressure() makes pressures
// of it. A vertex of the mesh gives its impulse to its own facets, a node of the grid and a shared cell to the facets
// in front of them that face the same way. All that a group takes goes to one facet or another.
#pragma once

#include "mpm/contact/ContactSearch.hpp"

namespace mpm {

template <int Dim> class FacetImpulses {
  public:
    // Where the facets are in this step. `sums`: what checkpoints keep, for each body with a mesh its number in the
    // scene, the time of its first entry, the number of its facets, and three numbers for each of them, kN s.
    void find(const Scene<Dim>& scene, const ContactSearch<Dim>& search, std::vector<double>& sums) {
        if (bodies_.empty()) restore(sums);
        for (size_t b = 0; b < scene.bodies.size(); ++b)
            if (const auto& body = *scene.bodies[b];
                body.type->isMeshed() && body.particles.size() > 0 && search.isOfMeshes(body.velocityField))
                find(scene, search.surfaceOf(int(b)).facets(), int(b));
    }

    // impulse: on the group of bodies, kN s; outward: normal of its surface there.
    void add(const Scene<Dim>& scene, int group, const Vec<Dim>& x, const Vec<Dim>& outward,
             const Vec<Dim>& impulse) {
        weights_.clear();
        double all = 0;
        const Vec<Dim> h = scene.grid.sizeAt(x);
        forNear(scene.grid, nearestNode(scene.grid, x), [&](OfBody& body, int facet) {
            if (scene.bodies[body.number]->velocityField != group) return;
            const Vec<Dim> d = body.centre[facet] - x, along = d - d.dot(outward) * outward;
            double weight = std::max(0.0, body.area[facet].dot(outward));
            for (int k = 0; k < Dim; ++k) weight *= std::max(0.0, 1 - std::abs(along[k]) / h[k]);
            all += weight;
            if (weight > 0) weights_.push_back({&body, facet, weight});
        });
        if (!(all > 0)) addToNearest(scene, group, x, impulse);
        for (const auto& [body, facet, weight] : weights_)
            if (all > 0) body->impulse[facet] += weight / all * impulse;
    }

    // The same at a vertex of a mesh.
    void addAt(const ExplicitSurface<Dim>& surface, const ContactPoint<Dim>& point, const Vec<Dim>& outward,
               const Vec<Dim>& impulse) {
        OfBody& body = bodies_.at(point.body);
        double all = 0;
        const auto weightOf = [&](int facet) {
            return std::max(1e-12 * body.area[facet].norm(), body.area[facet].dot(outward));
        };
        surface.forFacetsAt(point.vertex, [&](int facet) { all += weightOf(facet); });
        surface.forFacetsAt(point.vertex,
                            [&](int facet) { body.impulse[facet] += weightOf(facet) / all * impulse; });
    }

    void store(std::vector<double>& sums) const {
        if (bodies_.empty()) return;
        sums.clear();
        for (const auto& [number, body] : bodies_) {
            sums.insert(sums.end(), {double(number), body.since, double(body.impulse.size())});
            for (const Vec<Dim>& impulse : body.impulse)
                for (int k = 0; k < 3; ++k) sums.push_back(k < Dim ? impulse[k] : 0.0);
        }
    }
    void clear() { bodies_.clear(); }

  private:
    struct OfBody {
        int number;
        double since = 0; // s
        std::vector<Vec<Dim>> centre, area, impulse;
        std::vector<std::pair<int, int>> near; // nearest node, facet
    };
    struct Weight {
        OfBody* body;
        int facet;
        double weight;
    };
    std::map<int, OfBody> bodies_; // by their numbers in the scene
    std::vector<Weight> weights_;

    void restore(const std::vector<double>& sums) {
        for (size_t at = 0; at + 3 <= sums.size();) {
            OfBody& body = bodies_[int(sums[at])];
            body.number = int(sums[at]);
            body.since = sums[at + 1];
            body.impulse.resize(size_t(sums[at + 2]));
            at += 3;
            for (Vec<Dim>& impulse : body.impulse) {
                for (int k = 0; k < Dim; ++k) impulse[k] = sums[at + k];
                at += 3;
            }
        }
    }

    void find(const Scene<Dim>& scene, const BoundaryFacets<Dim>& boundary, int number) {
        const size_t count = boundary.facets.size();
        if (count == 0) return; // not near another group so far
        OfBody& body = bodies_[number];
        body.number = number;
        if (body.impulse.size() != count) { // the first time, or after a conversion of domains
            body.impulse.assign(count, Vec<Dim>::Zero());
            body.since = scene.time;
        }
        body.centre.assign(count, Vec<Dim>::Zero());
        body.area.resize(count);
        body.near.resize(count);
        const Field& X = scene.bodies[number]->domains->mesh()->vertexPositions();
        for (size_t f = 0; f < count; ++f) {
            const auto& facet = boundary.facets[f];
            for (int v : facet) body.centre[f] += vectorAt<Dim>(X, v) / BoundaryFacets<Dim>::size;
            body.area[f] = areaVector<Dim>([&](int a) { return vectorAt<Dim>(X, facet[a]); });
            body.near[f] = {nearestNode(scene.grid, body.centre[f]), int(f)};
        }
        std::sort(body.near.begin(), body.near.end());
    }

    // f(body, facet) for the facets up to two nodes away.
    template <class F> void forNear(const Grid<Dim>& grid, int node, F&& f) {
        constexpr int reach = 2;
        for (auto& [number, body] : bodies_) {
            Index<Dim> step;
            for (int k = 0; k < Dim; ++k) step[k] = -reach;
            for (int k = 1; k < Dim;) { // nodes in a row have numbers in a row
                int first = node;
                for (int j = 0; j < Dim; ++j) first += step[j] * grid.strides[j];
                auto at = std::lower_bound(body.near.begin(), body.near.end(), std::make_pair(first, -1));
                for (; at != body.near.end() && at->first <= first + 2 * reach; ++at) f(body, at->second);
                for (k = 1; k < Dim && ++step[k] > reach; ++k) step[k] = -reach;
            }
        }
    }

    void addToNearest(const Scene<Dim>& scene, int group, const Vec<Dim>& x, const Vec<Dim>& impulse) {
        Vec<Dim>* nearest = nullptr;
        double least = farAway;
        for (auto& [number, body] : bodies_)
            for (size_t f = 0; f < body.centre.size(); ++f)
                if (const double square = (body.centre[f] - x).squaredNorm();
                    scene.bodies[number]->velocityField == group && square < least) {
                    least = square;
                    nearest = &body.impulse[f];
                }
        if (nearest) *nearest += impulse;
    }
};

} // namespace mpm
