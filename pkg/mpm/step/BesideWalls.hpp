// SPDX-License-Identifier: GPL-2.0-or-later
// A fixed face stops nodes and not the particles beside it (doc/development/decisions/0033): a part of their velocity
// moves nothing. While soil flows, that is momentum it needs; in a heap at rest it is noise that nothing ends. So what
// moves nothing,
//     r = v_p - sum_i phi_ip v_i,   and of it   e = |r| - mostUnseen |v|   beyond the mean v of the free nodes,
// ends on a way of a cell h, de/dt = -phi e^2/h, with the weight phi on the face, which takes the momentum.
#pragma once

#include "mpm/scene/Scene.hpp"

namespace mpm {

template <int Dim> class BesideWalls {
    using NF = NodalField<Dim>;

  public:
    // By how many times what moves nothing may be faster than what moves. Half of it and twice change run-outs by -5 to 8 %,
    // 1 and 10 by up to 14 %, where they scatter by 4 % (decision 0033).
    static constexpr double mostUnseen = 3;

    // Once images of nodes move.
    explicit BesideWalls(Scene<Dim>& scene) : scene_(scene) {
        for (size_t c = 0; c < scene.constraints.size(); ++c) {
            const Constraint& face = *scene.constraints[c];
            isFixed_.push_back(face.isWall && face.active && !scene.state.mirrors.isRoller(int(c)));
            if (!isFixed_.back() || face.nodes.empty()) continue;
            // Nodes are in their order, and those of a face are a box.
            const int first = face.nodes.front(), last = face.nodes.back();
            zones_.push_back({scene.grid.nodePosition(first), scene.grid.nodePosition(last),
                              scene.grid.twoCells(first), scene.grid.twoCells(last)});
        }
    }
    // Before the particles move, and keep the share flip of their velocity.
    void brake(double flip) const {
        if (zones_.empty()) return;
        for (auto& body : scene_.bodies) {
            if (isSolvedImplicitly(scene_, *body)) continue;
            const int n = body->particles.size();
            const Vec<Dim> part = reach(*body);
            std::vector<std::vector<Loss>> losses(chunksOf(n));
            parallel(scene_.threads, [&](ParallelRegion& region) {
                region.chunks(n, [&](int begin, int end) {
                    for (int p = begin; p < end; ++p)
                        if (isNear(body->particles, p, part)) brake(*body, p, losses[begin / chunkSize]);
                });
            });
            for (const auto& chunk : losses)
                for (const Loss& loss : chunk) {
                    Constraint& face = *scene_.constraints[loss.face];
                    addReaction<Dim>(loss.position, face.centre, loss.axis, -flip * loss.momentum / scene_.dt,
                                     face.reaction, face.moment);
                }
        }
    }

  private:
    struct Zone {
        Vec<Dim> lower, upper, before, beyond; // m; of the face, and two cells before and beyond it
    };
    struct Loss {
        int face, axis;
        double momentum; // Mg m/s
        Vec<Dim> position;
    };
    Scene<Dim>& scene_;
    std::vector<char> isFixed_; // each constraint
    std::vector<Zone> zones_;

    // The part of two cells from which a particle reaches a face: a box by a cell and half of its edge; on graded grids
    // the second cell may be wider.
    Vec<Dim> reach(const Body<Dim>& body) const {
        const auto* boxes = body.domains->boxes();
        if (!boxes || scene_.grid.isGraded()) return Vec<Dim>::Ones();
        return 0.5 * (Vec<Dim>::Ones() + boxes->halfSize().cwiseQuotient(scene_.grid.smallestCell()));
    }
    bool isNear(const Particles<Dim>& particles, int p, const Vec<Dim>& part) const {
        for (const Zone& zone : zones_) {
            bool is = true;
            for (int k = 0; k < Dim; ++k) {
                const double x = particles.position.plane(k)[p];
                is &= x >= zone.lower[k] - part[k] * zone.before[k] &&
                      x <= zone.upper[k] + part[k] * zone.beyond[k];
            }
            if (is) return true;
        }
        return false;
    }
    void brake(Body<Dim>& body, int p, std::vector<Loss>& losses) const {
        const auto& field = scene_.grid.fields[body.velocityField];
        Vec<Dim> fixed = Vec<Dim>::Zero(), moving = fixed, r = fixed, mean = fixed, most = fixed, x;
        const int count = scene_.grid.count;
        int face[Dim]; // of the node with the largest weight
        body.domains->weights(p, [&](int node, double phi, const Vec<Dim>&) {
            if (phi == 0) return;
            const auto& motion = field.motion[node];
            const auto& holder =
                field.holder[node < count ? node : node - count]; // of soil on two sides of a wall
            for (int k = 0; k < Dim; ++k) {
                const int c = holder[k];
                if (c >= 0 && isFixed_[c]) {
                    fixed[k] += phi;
                    if (phi > most[k]) most[k] = phi, face[k] = c;
                } else
                    moving[k] += phi * (motion[NF::velocity + k] - scene_.dt * motion[NF::acceleration + k]);
            }
        });
        for (int k = 0; k < Dim; ++k) {
            x[k] = body.particles.position.plane(k)[p];
            if (!(fixed[k] > 0 && fixed[k] < 1)) continue;
            r[k] = body.particles.velocity.plane(k)[p] - moving[k];
            mean[k] = moving[k] / (1 - fixed[k]);
        }
        const double unseen = r.norm(), excess = unseen - mostUnseen * mean.norm();
        if (!(excess > 0)) return;
        const double m = body.inertiaScale * body.particles.mass.plane()[p];
        const double rate = excess / scene_.grid.sizeAt(x).minCoeff();
        for (int k = 0; k < Dim; ++k) {
            if (r[k] == 0) continue;
            const double part = fixed[k] * rate * scene_.dt,
                         loss = part / (1 + part) * excess / unseen * r[k];
            body.particles.velocity.plane(k)[p] -= loss;
            losses.push_back({face[k], k, m * loss, x});
        }
    }
};

} // namespace mpm
