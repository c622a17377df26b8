// SPDX-License-Identifier: GPL-2.0-or-later
// Step 5: velocity gradient, deformation, volume, stress, and the vertices of the domains.
#include "mpm/base/parallel/OrderedSum.hpp"
#include "mpm/scene/Scene.hpp"
#include "mpm/step/CellAverage.hpp"
#include "mpm/step/Conversion.hpp"
#include "mpm/step/ImplicitBodies.hpp"
#include "mpm/step/StressUpdate.hpp"
#include "mpm/step/nodes.hpp"

namespace mpm {

namespace {

// Traces of a tensor field with planes size*i + j.
void traces(const Field& tensor, int size, int begin, int end, double* trace) {
    std::fill(trace, trace + end - begin, 0.0);
    for (int k = 0; k < size; ++k) {
        const double* diagonal = tensor.plane((size + 1) * k);
        for (int p = begin; p < end; ++p) trace[p - begin] += diagonal[p];
    }
}

} // namespace

class DomainUpdater : public EngineOf<DomainUpdater> {
  public:
    std::string className() const override { return "DomainUpdater"; }
    std::string doc() const override {
        return "Updates velocity gradient, deformation, volume and stress of the particles, and "
               "moves the vertices.\n\n"
               "L = sum v_i (x) grad phi,  F <- (I + dt L) F,  V = J V0 (uGIMP) or the polygon area "
               "(APDI), stress by the\n"
               "material; vertices move with the same nodal velocity. Raises RuntimeError for a "
               "domain that is too\n"
               "distorted, or converts it (APDI: onDistortion).";
    }

    template <int Dim> void act(Scene<Dim>& scene) {
        work_.resize(scene.bodies.size());
        partitions_.resize(scene.bodies.size());
        for (size_t b = 0; b < scene.bodies.size(); ++b) {
            const int n = scene.bodies[b]->particles.size();
            work_[b].clear(n);
            if (partitions_[b].count() != chunksOf(n))
                partitions_[b].set(chunksOf(n), [&](int c) {
                    const int begin = c * chunkSize, end = std::min(n, begin + chunkSize);
                    const auto* mesh = scene.bodies[b]->domains->mesh(); // gradients are half of it
                    return end - begin + (mesh ? mesh->workOf(begin, end) : end - begin);
                });
        }
        for (const auto& field : scene.grid.fields) field.velocities(); // may throw, and not in the region
        if (auto* implicit = scene.template find<ImplicitBodies>()) implicit->finishMotion(scene);
        parallel(scene.threads, [&](ParallelRegion& region) {
            for (auto& body : scene.bodies)
                if (auto* mesh = body->domains->mesh())
                    mesh->takeVelocity(region, strainingVelocity(scene, *body));
            for (size_t b = 0; b < scene.bodies.size(); ++b)
                update(region, scene, *scene.bodies[b], partitions_[b], work_[b]);
            region.wait();
            if (scene.scheme->stressFirst)
                sumOnNodes(region, scene, &cells_);
            else
                for (auto& body : scene.bodies)
                    if (auto* mesh = body->domains->mesh()) mesh->advance(region, scene.dt);
        });
        for (size_t b = 0; b < scene.bodies.size(); ++b) {
            scene.bodies[b]->internalWork += work_[b].total();
            refuseDistortion(scene, *scene.bodies[b]);
        }
        if (!scene.scheme->stressFirst) convertDistorted(scene);
    }

  private:
    std::vector<OrderedSum> work_;          // of the stresses, per body
    std::vector<WorkPartition> partitions_; // of the chunks of its particles
    CellAverage average_;                   // of the body at hand
    std::vector<CellForces> cells_;         // of each body

    // Of the nodes. What was solved for is what an implicit body is strained by, whatever the scheme: with another
    // velocity its stiffness would not be symmetric.
    template <int Dim>
    static const typename NodalField<Dim>::Velocity* strainingVelocity(const Scene<Dim>& scene,
                                                                       const Body<Dim>& body) {
        const auto* implicit = body.isImplicit ? scene.template find<ImplicitBodies>() : nullptr;
        return implicit ? implicit->velocities(body) : scene.grid.fields[body.velocityField].velocities();
    }

    // The threads do not wait for each other at the end.
    template <int Dim>
    void update(ParallelRegion& region, Scene<Dim>& scene, Body<Dim>& body, const WorkPartition& partition,
                OrderedSum& work) {
        const auto* nodes = strainingVelocity(scene, body);
        const int n = body.particles.size();
        std::vector<double*> state(body.particles.state.size());
        const auto gradient = [&](int begin, int end) {
            body.domains->takeGradient(begin, end, nodes, scene.dt);
        };
        // The volume of a domain is that between its vertices; boxes have what the stress sees.
        const bool follows = body.fbar && body.domains->boxes();
        const auto rest = [&](int begin, int end) {
            follows ? deform<true>(body.particles, scene.dt, begin, end, average_.values())
                    : deform<false>(body.particles, scene.dt, begin, end, nullptr);
            body.domains->volumes(begin, end);
            work.of(begin) = updateStress(body, scene.dt, begin, end, state.data(),
                                          body.fbar ? average_.values() : nullptr, follows);
        };
        if (!body.fbar)
            return region.chunksNoWait(n, partition, [&](int begin, int end) {
                gradient(begin, end);
                rest(begin, end);
            });
        updateFbar(region, scene, body, gradient, rest);
    }

    // With one increment of volumetric strain per cell, and the mean stress linear in it: see CellAverage.
    template <int Dim, class Gradient, class Rest>
    void updateFbar(ParallelRegion& region, const Scene<Dim>& scene, Body<Dim>& body, Gradient&& gradient,
                    Rest&& rest) {
        const int n = body.particles.size();
        Field &L = body.particles.velocityGradient, &stress = body.particles.stress;
        const bool hasBoxes = body.domains->boxes();
        const auto* nodes = scene.grid.fields[body.velocityField].velocities();
        average_.start(region, n, scene.grid);
        double* change = average_.values();
        region.chunks(n, [&](int begin, int end) {
            gradient(begin, end);
            average_.locate(body.particles, scene.grid, begin, end);
            hasBoxes ? volumeRates<Dim>(L, scene.dt, begin, end, change)
                     : traces(L, Dim, begin, end, change + begin);
        });
        average_.sum<false>(region, body.particles);
        if (hasBoxes) average_.findInside(region, scene.grid);
        region.chunks(n, [&](int begin, int end) {
            if (hasBoxes) {
                average_.toRates(scene.grid, nodes, scene.dt, begin, end);
                toTraces<Dim>(L, scene.dt, begin, end, change);
            } else {
                average_.toMeans(begin, end);
            }
            rest(begin, end);
            traces(stress, 3, begin, end, change + begin);
        });
        average_.sum<true>(region, body.particles);
        region.chunks(n, [&](int begin, int end) {
            average_.toLinear(body.particles, begin, end);
            for (int k = 0; k < 3; ++k)
                for (int p = begin; p < end; ++p) stress.plane(4 * k)[p] += change[p] / 3;
        });
    }
};

MPM_REGISTER(Engine, DomainUpdater);

} // namespace mpm
