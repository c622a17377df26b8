// SPDX-License-Identifier: GPL-2.0-or-later
#include "mpm/check/InterfaceRule.hpp"

#include "mpm/state/Bins.hpp"

namespace mpm {

namespace {

// Part of a cell that a box must be nearer than: a mesh that begins one cell away does not meet it.
constexpr double nearlyOne = 1 - 1e-6;
// Half size of a box, in the smallest cells, at most: how far one reaches beyond the cell that its centre is in.
constexpr double largestHalf = 0.5;

// Particles of bodies with box domains, by the cells of the grid.
template <int Dim> struct Boxes {
    const Grid<Dim>& grid;
    struct Entry {
        const Body<Dim>* body;
        int particle;
    };
    std::vector<Entry> entries;
    CellBins<Dim> cells;

    explicit Boxes(const Scene<Dim>& scene) : grid(scene.grid) {
        for (auto& body : scene.bodies) {
            if (body->type->isMeshed()) continue;
            for (int p = 0; p < body->particles.size(); ++p) entries.push_back({body.get(), p});
        }
        cells.fill(grid, int(entries.size()), [&](int i, int k) {
            return entries[i].body->particles.position.plane(k)[entries[i].particle];
        });
    }
    // The first box closer than `reach` to the region [lower, upper].
    const Entry* near(const Vec<Dim>& lower, const Vec<Dim>& upper, const Vec<Dim>& reach) const {
        const Vec<Dim> margin = reach + largestHalf * grid.smallestCell();
        Index<Dim> first, last;
        if (!cells.range(grid, lower - margin, upper + margin, first, last)) return nullptr;
        const Entry* found = nullptr;
        CellBins<Dim>::anyOf(grid, first, last, [&](int bin, const Index<Dim>&) {
            for (int j = cells.bins().begin(bin); j < cells.bins().end(bin) && !found; ++j)
                if (const Entry& entry = entries[cells.bins().point(j)]; close(entry, lower, upper, reach))
                    found = &entry;
            return found != nullptr;
        });
        return found;
    }
    static bool close(const Entry& entry, const Vec<Dim>& lower, const Vec<Dim>& upper,
                      const Vec<Dim>& reach) {
        const Vec<Dim> x = vectorAt<Dim>(entry.body->particles.position, entry.particle);
        const Vec<Dim> half = entry.body->domains->boxes()->halfSize();
        for (int k = 0; k < Dim; ++k)
            if (!(x[k] + half[k] > lower[k] - reach[k] && x[k] - half[k] < upper[k] + reach[k])) return false;
        return true;
    }
};

} // namespace

template <int Dim> InterfaceFault checkInterface(const Scene<Dim>& scene, double limit) {
    InterfaceFault fault;
    std::unique_ptr<Boxes<Dim>> boxes;
    for (auto& body : scene.bodies) {
        auto* mesh = body->domains->mesh();
        if (!mesh || body->domains->section) continue; // of a beam soil meets the edges along it
        const auto& corner = mesh->cornerTable();
        for (int p = 0; p < body->particles.size(); ++p) {
            const double edge = mesh->longestEdge(p);
            const Vec<Dim> cell = scene.grid.sizeAt(vectorAt<Dim>(body->particles.position, p));
            const double shortest = cell.minCoeff();
            if (edge <= limit * shortest || edge * fault.cell <= fault.edge * shortest) continue;
            if (!boxes) boxes = std::make_unique<Boxes<Dim>>(scene);
            Vec<Dim> lower = Vec<Dim>::Constant(1e300), upper = -lower;
            for (int a = 0; a < corners<Dim>; ++a) {
                const Vec<Dim> X = vectorAt<Dim>(mesh->vertexPositions(), corner[corners<Dim> * p + a]);
                lower = lower.cwiseMin(X);
                upper = upper.cwiseMax(X);
            }
            const Vec<Dim> reach = nearlyOne * cell;
            if (auto* entry = boxes->near(lower, upper, reach)) {
                fault = {
                    true, body->name,           entry->body->name, place(Vec<Dim>(0.5 * (lower + upper))),
                    edge, mesh->initialEdge(p), shortest};
            }
        }
    }
    return fault;
}

template InterfaceFault checkInterface<2>(const Scene<2>&, double);
template InterfaceFault checkInterface<3>(const Scene<3>&, double);

} // namespace mpm
