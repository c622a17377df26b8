// SPDX-License-Identifier: GPL-2.0-or-later
// Forces that an engine puts on nodes in a step, and their work: with the mean of the nodal velocities at its start
// and its end.
#pragma once

#include "mpm/scene/Scene.hpp"

namespace mpm {

template <int Dim> class NodalForces {
  public:
    using NF = NodalField<Dim>;

    void begin(Scene<Dim>& scene) {
        scene_ = &scene;
        given_.clear();
    }
    void add(int field, int node, const Vec<Dim>& force) {
        auto& sum = scene_->grid.fields[field].sum[node];
        if (!(sum[NF::mass] > 0)) return;
        for (int k = 0; k < Dim; ++k) NF::addForce(sum, k, force[k]);
        given_.push_back({field, node, force});
    }
    // Once at the end of the step; returns the work, kJ.
    double finish(double dt) {
        double work = 0;
        for (const auto& [field, node, force] : given_) {
            const auto& nodal = scene_->grid.fields[field];
            // Where a parted soil is one the first half of the memory has all.
            const int at = nodal.sum[node][NF::mass] > 0 ? node : node % scene_->grid.count;
            const Vec<Dim> start = velocityAtStart(field, at);
            for (int k = 0; k < Dim; ++k) work += 0.5 * dt * force[k] * (start[k] + nodal.motion[at][k]);
        }
        if (scene_) scene_->energies.loads += work;
        given_.clear();
        return work;
    }

  private:
    struct Given {
        int field, node;
        Vec<Dim> force;
    };
    Scene<Dim>* scene_ = nullptr;
    std::vector<Given> given_;

    // What particles gave to an image behind a roller is with the node before it.
    Vec<Dim> velocityAtStart(int field, int node) const {
        Vec<Dim> v, sign = Vec<Dim>::Ones();
        const auto& sums = scene_->grid.fields[field].sum;
        if (!(sums[node][NF::mass] > 0))
            for (const auto& image : scene_->state.mirrors.images())
                if (image.field == field && image.ghost == node) {
                    node = image.node, sign = image.sign;
                    break;
                }
        for (int k = 0; k < Dim; ++k) v[k] = sign[k] * NF::velocityAtStart(sums[node], k);
        return v;
    }
};

// Particles of a body that take a force together, by parts that add up to one.
template <int Dim> class Attachment {
  public:
    // Where the particles with these ids are; RunError, in the name of `who`, where one is gone.
    void find(Body<Dim>& body, const std::vector<double>& ids, const std::vector<double>& parts,
              const std::string& who, long step) {
        body_ = &body;
        parts_ = &parts;
        const int64_t* id = body.particles.id.integers();
        const int count = body.particles.size();
        bool isKnown = places_.size() == ids.size();
        for (size_t i = 0; i < ids.size() && isKnown; ++i)
            isKnown = places_[i] < count && id[places_[i]] == int64_t(ids[i]);
        if (isKnown) return;
        places_.assign(ids.size(), -1);
        for (int p = 0; p < count; ++p)
            for (size_t i = 0; i < ids.size(); ++i)
                if (id[p] == int64_t(ids[i])) places_[i] = p;
        for (int place : places_)
            if (place < 0)
                throw RunError(message("step ", step, ": ", who, ": particles of '", body.name,
                                       "' that it acts on are gone; take it out of scene.engines before they "
                                       "are removed or converted"));
    }
    Vec<Dim> position() const {
        Vec<Dim> x = Vec<Dim>::Zero();
        for (size_t i = 0; i < places_.size(); ++i)
            x += (*parts_)[i] * vectorAt<Dim>(body_->particles.position, places_[i]);
        return x;
    }
    // f(node, weight), a node once.
    template <class F> void forNodes(F&& f) const {
        std::map<int, double> at;
        for (size_t i = 0; i < places_.size(); ++i)
            body_->domains->weights(
                places_[i], [&](int node, double phi, const Vec<Dim>&) { at[node] += (*parts_)[i] * phi; });
        for (const auto& [node, weight] : at) f(node, weight);
    }
    int field() const { return body_->velocityField; }
    // Of what moves when a force acts, one over it, 1/Mg.
    double inverseMass(const Scene<Dim>& scene) const {
        using NF = NodalField<Dim>;
        double sum = 0;
        forNodes([&](int node, double weight) {
            const double mass = scene.grid.fields[field()].sum[node][NF::mass];
            if (mass > 0) sum += weight * weight / mass;
        });
        return sum;
    }

  private:
    Body<Dim>* body_ = nullptr;
    const std::vector<double>* parts_ = nullptr;
    std::vector<int> places_;
};

template <int Dim> Vec<Dim> vectorOf(const std::vector<double>& numbers, size_t first = 0) {
    Vec<Dim> x;
    for (int k = 0; k < Dim; ++k) x[k] = numbers[first + k];
    return x;
}

} // namespace mpm
