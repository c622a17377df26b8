// SPDX-License-Identifier: GPL-2.0-or-later
#include "mpm/check/unseenEnergy.hpp"

#include "mpm/check/balances.hpp"
#include "mpm/step/nodes.hpp"

namespace mpm {

namespace {

// Stands in for the sums of the nodes as long as it lives: those of the particles as they are. Between two steps the
// particles are found where they stand; in a step the weights are those of its start.
template <int Dim> class PresentSums {
  public:
    explicit PresentSums(Scene<Dim>& scene) : scene_(scene), mirrors_(scene.state.mirrors) {
        parallel(scene.threads, [&](ParallelRegion& region) {
            for (auto& body : scene.bodies)
                if (!scene.state.located) body->domains->locate(region);
        });
        for (auto& body : scene.bodies) // boxes keep the order that users see
            if (!scene.state.located && body->domains->mesh()) body->domains->resort();
        for (auto& field : scene.grid.fields) {
            kept_.push_back({field.extents, field.extents, {}});
            field.forgetExtents();
        }
        for (auto& body : scene.bodies)
            body->domains->order.markExtents(scene.grid.fields[body->velocityField]);
        scene.state.located ? scene.state.parted.markExtents(scene) : scene.state.parted.divide(scene, false);
        for (size_t f = 0; f < kept_.size(); ++f) keep(scene.grid.fields[f], kept_[f]);
        parallel(scene.threads, [&](ParallelRegion& region) {
            for (auto& body : scene.bodies)
                body->domains->addSum(region, scene.grid.fields[body->velocityField].sum.data(),
                                      body->inertiaScale, nullptr);
        });
        scene.state.mirrors.fold(scene.grid, Vec<Dim>::Zero());
        scene.state.parted.bond(scene);
    }
    ~PresentSums() {
        for (size_t f = 0; f < kept_.size(); ++f) {
            auto sum = kept_[f].sum.begin();
            forNodes(kept_[f], [&](int node) { scene_.grid.fields[f].sum[node] = *sum++; });
            scene_.grid.fields[f].extents.swap(kept_[f].extents);
        }
        scene_.state.mirrors = mirrors_;
    }
    PresentSums(const PresentSums&) = delete;

  private:
    using NF = NodalField<Dim>;
    struct Kept {
        decltype(NF::extents) extents, all; // all: with those of the present sums
        std::vector<typename NF::Sum> sum;  // of the nodes in these
    };
    template <class F> void forNodes(const Kept& kept, F&& f) const {
        for (int slab = 0; slab < scene_.grid.slabs(); ++slab) scene_.grid.forNodes(kept.all[slab], slab, f);
    }
    void keep(NF& field, Kept& kept) {
        for (int slab = 0; slab < scene_.grid.slabs(); ++slab) kept.all[slab].include(field.extents[slab]);
        forNodes(kept, [&](int node) {
            kept.sum.push_back(field.sum[node]);
            field.sum[node] = NF::Sum::zero();
        });
    }
    Scene<Dim>& scene_;
    std::vector<Kept> kept_;
    MirrorNodes<Dim> mirrors_;
};

} // namespace

template <int Dim> double unseenEnergy(Scene<Dim>& scene, double kinetic) {
    using NF = NodalField<Dim>;
    const PresentSums<Dim> sums(scene);
    const double least = scene.leastMass();
    double seen = 0;
    forTouchedNodes(scene, [&](const NF& field, int node) {
        const auto& sum = field.sum[node];
        for (int k = 0; k < Dim && sum[NF::mass] > least; ++k) {
            const double own = NF::velocityAtStart(sum, k);
            const int c = field.holder.empty() ? -1 : field.holder[node][k];
            const double v = c < 0 ? own : scene.heldAtStart(c, k, own);
            seen += v * (sum[NF::momentum + k] - 0.5 * sum[NF::mass] * v);
        }
    });
    return kinetic - seen;
}

template double unseenEnergy(Scene<2>& scene, double kinetic);
template double unseenEnergy(Scene<3>& scene, double kinetic);

} // namespace mpm
