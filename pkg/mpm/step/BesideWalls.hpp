// SPDX-License-Identifier: GPL-2.0-or-later
// A fixed face stops nodes and not the particles beside it (doc/development/decisions/0033), whose velocities are
// their own then: a node of the face does not feel them. So a particle beside it must not be faster than the nodes
// that it moves with. Of what it has beyond their mean v, the mean weight on them phi, it gives these nodes
//     loss = phi [v_p - clip(v_p; 0, v)],   per component,
// as soil that is braked by soil. The face takes no part: its force is that of the stresses alone. Each exchange loses
// energy, for m_i >= sum m_p phi_ip.
#pragma once

#include "mpm/scene/Scene.hpp"

#include <map>

namespace mpm {

template <int Dim> class BesideWalls {
    using NF = NodalField<Dim>;

  public:
    // Once the images of nodes behind rollers are known.
    explicit BesideWalls(Scene<Dim>& scene) : scene_(scene) {
        for (size_t c = 0; c < scene.constraints.size(); ++c) {
            const Constraint& face = *scene.constraints[c];
            isFixed_.push_back(face.isWall && face.active && !scene.mirrors.isRoller(int(c)));
            if (!isFixed_.back() || face.nodes.empty()) continue;
            // Nodes are in their order, and those of a face are a box.
            const int first = face.nodes.front(), last = face.nodes.back();
            zones_.push_back({scene.grid.nodePosition(first) - scene.grid.twoCells(first),
                              scene.grid.nodePosition(last) + scene.grid.twoCells(last)});
        }
        if (zones_.empty()) return;
        for (const auto& image : scene.mirrors.images()) images_[{image.field, image.ghost}] = &image;
    }
    // After the solution, before the particles take it.
    void brake() const {
        if (zones_.empty()) return;
        std::vector<std::vector<Gift>> gifts;
        for (auto& body : scene_.bodies) gifts.resize(gifts.size() + chunksOf(body->particles.size()));
        parallel(scene_.threads, [&](ParallelRegion& region) {
            size_t first = 0;
            for (auto& body : scene_.bodies) {
                const int n = body->particles.size();
                region.chunks(n, [&](int begin, int end) {
                    std::vector<Weight> weights;
                    for (int p = begin; p < end; ++p)
                        if (isNear(body->particles, p))
                            brake(*body, p, weights, gifts[first + begin / chunkSize]);
                });
                first += chunksOf(n);
            }
        });
        size_t chunk = 0;
        for (auto& body : scene_.bodies)
            for (int begin = 0; begin < body->particles.size(); begin += chunkSize)
                for (const Gift& gift : gifts[chunk++]) give(scene_.grid.fields[body->velocityField], gift);
    }

  private:
    struct Zone {
        Vec<Dim> lower, upper; // m, that particles which reach the face have their centres in
    };
    struct Gift {
        int node, axis;
        double momentum;
    };
    struct Weight {
        int node;
        double phi;
        const typename MirrorNodes<Dim>::Image* image; // that it is of; nullptr: none
        double sign(int k) const { return image ? image->sign[k] : 1; }
    };
    Scene<Dim>& scene_;
    std::vector<char> isFixed_; // each constraint
    std::vector<Zone> zones_;
    std::map<std::pair<int, int>, const typename MirrorNodes<Dim>::Image*> images_; // by field and ghost

    bool isNear(const Particles<Dim>& particles, int p) const {
        for (const Zone& zone : zones_) {
            bool is = true;
            for (int k = 0; k < Dim; ++k) {
                const double x = particles.position.plane(k)[p];
                is &= x >= zone.lower[k] && x <= zone.upper[k];
            }
            if (is) return true;
        }
        return false;
    }

    Weight weightOf(int f, int node, double phi) const {
        if (scene_.grid.fields[f].sum[node][NF::mass] > 0) return {node, phi, nullptr};
        const auto found = images_.find({f, node});
        if (found != images_.end()) return {found->second->node, phi, found->second};
        return {node % scene_.grid.count, phi, nullptr}; // of a parted soil that is one here
    }

    void brake(Body<Dim>& body, int p, std::vector<Weight>& weights, std::vector<Gift>& gifts) const {
        const auto& field = scene_.grid.fields[body.velocityField];
        const auto holderOf = [&](int node, int k) { return field.holder[node % scene_.grid.count][k]; };
        const auto isFree = [&](int node, int k) {
            return holderOf(node, k) < 0 && field.sum[node][NF::mass] > 0;
        };
        weights.clear();
        body.domains->weights(p, [&](int node, double phi, const Vec<Dim>&) {
            if (phi > 0) weights.push_back(weightOf(body.velocityField, node, phi));
        });
        const double m = body.inertiaScale * body.particles.mass.plane()[p];
        for (int k = 0; k < Dim; ++k) {
            double fixed = 0, free = 0, moving = 0;
            for (const Weight& weight : weights) {
                const int c = holderOf(weight.node, k);
                const auto& motion = field.motion[weight.node];
                const double start = motion[NF::velocity + k] - scene_.dt * motion[NF::acceleration + k];
                if (c >= 0 && isFixed_[c])
                    fixed += weight.phi;
                else
                    moving += weight.phi * weight.sign(k) * start;
                if (isFree(weight.node, k)) free += weight.phi;
            }
            if (fixed == 0 || free == 0) continue;
            double& v = body.particles.velocity.plane(k)[p];
            const double mean = moving / (1 - fixed);
            const double loss = free * (v - std::clamp(v, std::min(0.0, mean), std::max(0.0, mean)));
            if (loss == 0) continue;
            v -= loss;
            for (const Weight& weight : weights)
                if (isFree(weight.node, k))
                    gifts.push_back({weight.node, k, weight.sign(k) * weight.phi / free * m * loss});
        }
    }

    void give(NF& field, const Gift& gift) const {
        const double gain = gift.momentum / field.sum[gift.node][NF::mass];
        auto& motion = field.motion[gift.node];
        for (auto [first, value] :
             {std::pair{int(NF::velocity), gain}, {int(NF::acceleration), gain / scene_.dt}})
            motion.set(first + gift.axis, motion[first + gift.axis] + value);
        if (field.straining == NF::Straining::velocity)
            field.setVelocity(gift.node, gift.axis, field.velocityOf(gift.node, gift.axis) + gain);
    }
};

} // namespace mpm
