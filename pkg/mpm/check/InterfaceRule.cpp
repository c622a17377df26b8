// SPDX-License-Identifier: GPL-2.0-or-later
#include "mpm/check/InterfaceRule.hpp"

namespace mpm {

namespace {

// Particles of bodies with box domains, binned by grid cell.
template <int Dim> struct Boxes {
    const Grid<Dim>& grid;
    struct Entry {
        const Body<Dim>* body;
        int particle;
    };
    std::vector<std::vector<Entry>> bins;

    explicit Boxes(const Scene<Dim>& scene) : grid(scene.grid), bins(scene.grid.count) {
        for (auto& body : scene.bodies) {
            if (body->type->isMeshed()) continue;
            for (int p = 0; p < body->particles.size(); ++p)
                bins[bin(vectorAt<Dim>(body->particles.position, p))].push_back({body.get(), p});
        }
    }
    int bin(const Vec<Dim>& x) const {
        int number = 0;
        for (int k = 0; k < Dim; ++k) number += indexAlong(x[k], k) * grid.strides[k];
        return number;
    }
    int indexAlong(double x, int k) const {
        return std::min(grid.nodes[k] - 1, std::max(0, int(std::floor(grid.inCells(x, k)))));
    }
    // The first box closer than `reach` to the region [lower, upper].
    const Entry* near(const Vec<Dim>& lower, const Vec<Dim>& upper, const Vec<Dim>& reach) const {
        Index<Dim> first, last, at;
        for (int k = 0; k < Dim; ++k) { // a box reaches at most half a cell beyond its bin
            first[k] = indexAlong(lower[k] - reach[k] - 0.5 * grid.cell[k], k);
            last[k] = indexAlong(upper[k] + reach[k] + 0.5 * grid.cell[k], k);
        }
        at = first;
        while (true) {
            int number = 0;
            for (int k = 0; k < Dim; ++k) number += at[k] * grid.strides[k];
            for (const Entry& entry : bins[number])
                if (close(entry, lower, upper, reach)) return &entry;
            int k = 0;
            while (k < Dim && ++at[k] > last[k]) at[k] = first[k], ++k;
            if (k == Dim) return nullptr;
        }
    }
    static bool close(const Entry& entry, const Vec<Dim>& lower, const Vec<Dim>& upper,
                      const Vec<Dim>& reach) {
        const Vec<Dim> x = vectorAt<Dim>(entry.body->particles.position, entry.particle);
        const Vec<Dim> half = entry.body->domains->halfSize();
        for (int k = 0; k < Dim; ++k)
            if (!(x[k] + half[k] > lower[k] - reach[k] && x[k] - half[k] < upper[k] + reach[k])) return false;
        return true;
    }
};

} // namespace

template <int Dim> InterfaceFault checkInterface(const Scene<Dim>& scene, double limit) {
    InterfaceFault fault;
    double allowed = limit * scene.grid.cell.minCoeff();
    std::unique_ptr<Boxes<Dim>> boxes;
    for (auto& body : scene.bodies) {
        if (!body->type->isMeshed()) continue;
        const auto& corner = *body->domains->cornerTable();
        for (int p = 0; p < body->particles.size(); ++p) {
            const double edge = body->domains->longestEdge(p);
            if (edge <= allowed) continue;
            if (!boxes) boxes = std::make_unique<Boxes<Dim>>(scene);
            Vec<Dim> lower = Vec<Dim>::Constant(1e300), upper = -lower;
            for (int a = 0; a < corners<Dim>; ++a) {
                const Vec<Dim> X =
                    vectorAt<Dim>(*body->domains->vertexPositions(), corner[corners<Dim> * p + a]);
                lower = lower.cwiseMin(X), upper = upper.cwiseMax(X);
            }
            const Vec<Dim> reach = (1 - 1e-6) * scene.grid.cell;
            if (auto* entry = boxes->near(lower, upper, reach)) {
                fault = {true,
                         body->name,
                         entry->body->name,
                         place(Vec<Dim>(0.5 * (lower + upper))),
                         edge,
                         body->domains->initialEdge(p)};
                allowed = edge;
            }
        }
    }
    return fault;
}

template InterfaceFault checkInterface<2>(const Scene<2>&, double);
template InterfaceFault checkInterface<3>(const Scene<3>&, double);

} // namespace mpm
