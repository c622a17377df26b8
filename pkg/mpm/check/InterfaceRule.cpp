// SPDX-License-Identifier: GPL-2.0-or-later
#include "mpm/check/InterfaceRule.hpp"

#include "mpm/state/Bins.hpp"

namespace mpm {

namespace {

// Part of a cell that a box must be nearer than: a mesh that begins one cell away does not meet it.
constexpr double nearlyOne = 1 - 1e-6;
template <int Dim> struct Extent {
    Vec<Dim> lower = Vec<Dim>::Constant(1e300), upper = -lower;

    bool isNear(const Extent& other, const Vec<Dim>& reach) const {
        return (upper.array() > (other.lower - reach).array()).all() &&
               (lower.array() < (other.upper + reach).array()).all();
    }
    Vec<Dim> centre() const { return 0.5 * (lower + upper); }
};

template <int Dim> Extent<Dim> extentOf(const Body<Dim>& body, int p) {
    Extent<Dim> extent;
    if (auto* mesh = body.domains->mesh()) {
        for (int a = 0; a < corners<Dim>; ++a) {
            const Vec<Dim> X =
                vectorAt<Dim>(mesh->vertexPositions(), mesh->cornerTable()[corners<Dim> * p + a]);
            extent.lower = extent.lower.cwiseMin(X);
            extent.upper = extent.upper.cwiseMax(X);
        }
        return extent;
    }
    const Vec<Dim> x = vectorAt<Dim>(body.particles.position, p), half = body.domains->boxes()->halfSize();
    return {x - half, x + half};
}

// All domains that a mesh may meet, by the cells of the grid.
template <int Dim> struct Neighbours {
    const Grid<Dim>& grid;
    struct Entry {
        const Body<Dim>* body;
        Extent<Dim> extent;
    };
    std::vector<Entry> entries;
    CellBins<Dim> cells;
    Vec<Dim> largestHalf = Vec<Dim>::Zero(); // how far one reaches beyond the cell that its centre is in, m

    explicit Neighbours(const Scene<Dim>& scene) : grid(scene.grid) {
        for (auto& body : scene.bodies) {
            if (body->type->isMeshed() && scene.groups.size() == 1) continue;
            for (int p = 0; p < body->particles.size(); ++p) {
                entries.push_back({body.get(), extentOf(*body, p)});
                const Extent<Dim>& extent = entries.back().extent;
                largestHalf = largestHalf.cwiseMax(0.5 * (extent.upper - extent.lower));
            }
        }
        cells.fill(grid, int(entries.size()), [&](int i, int k) { return entries[i].extent.centre()[k]; });
    }
    // The first body with boxes or of another group that is closer than `reach` to a domain of a mesh.
    const Body<Dim>* near(const Body<Dim>& mesh, const Extent<Dim>& extent, const Vec<Dim>& reach) const {
        const Vec<Dim> margin = reach + largestHalf;
        Index<Dim> first, last;
        if (!cells.range(grid, extent.lower - margin, extent.upper + margin, first, last)) return nullptr;
        const Body<Dim>* found = nullptr;
        CellBins<Dim>::anyOf(grid, first, last, [&](int bin, const Index<Dim>&) {
            for (int j = cells.bins().begin(bin); j < cells.bins().end(bin) && !found; ++j) {
                const Entry& entry = entries[cells.bins().point(j)];
                const bool isOne =
                    entry.body->type->isMeshed() && entry.body->velocityField == mesh.velocityField;
                if (!isOne && entry.extent.isNear(extent, reach)) found = entry.body;
            }
            return found != nullptr;
        });
        return found;
    }
};

} // namespace

template <int Dim> InterfaceFault checkInterface(const Scene<Dim>& scene, double limit) {
    InterfaceFault fault;
    std::unique_ptr<Neighbours<Dim>> neighbours;
    for (auto& body : scene.bodies) {
        auto* mesh = body->domains->mesh();
        if (!mesh || body->domains->section) continue; // of a beam soil meets the edges along it
        for (int p = 0; p < body->particles.size(); ++p) {
            const double edge = mesh->longestEdge(p);
            const Vec<Dim> cell = scene.grid.sizeAt(vectorAt<Dim>(body->particles.position, p));
            const double shortest = cell.minCoeff();
            if (edge <= limit * shortest || edge * fault.cell <= fault.edge * shortest) continue;
            if (!neighbours) neighbours = std::make_unique<Neighbours<Dim>>(scene);
            const Extent<Dim> extent = extentOf(*body, p);
            if (auto* other = neighbours->near(*body, extent, nearlyOne * cell))
                fault = {true, body->name,           other->name, place(extent.centre()),
                         edge, mesh->initialEdge(p), shortest};
        }
    }
    return fault;
}

template InterfaceFault checkInterface<2>(const Scene<2>&, double);
template InterfaceFault checkInterface<3>(const Scene<3>&, double);

} // namespace mpm
