// SPDX-License-Identifier: GPL-2.0-or-later
// How a force on the surface of a point goes to the nodes. Vertices pass it on with their own hat
// functions. The normal force of a box acts at the ball inscribed in it, which is touched, by the weights
// of BoxSurface.hpp. Friction acts where the normal leaves the box, by
//     f_i = (w_i + grad phi_i . (d_t - d_n)) F_t
// (with friction at the ball pairs of boxes stuck below the edges of a wedge, and slipped off). Both are
// as much nearer to the centre as the box is thinner than at first. So sum f_i = F and sum x_i x f_i = x_c
// x F (d x F_n = 0): force and moment balance to round-off, and both springs see the motion that their
// force does work on. With a gap that follows x_p alone the stiffness matrix is not symmetric, and a
// bouncing disc gains energy.
#pragma once

#include "mpm/contact/rigid/BoxSurface.hpp"
#include "mpm/contact/rigid/RigidContactPoint.hpp"
#include "mpm/contact/rigid/RigidState.hpp"
#include "mpm/state/cover.hpp"

#include <map>
#include <optional>

namespace mpm {

// Where the forces on a point act, from its centre.
struct Arms {
    Vec3 normal, friction;
};

// How fast the place where friction acts moves against the centre of the point.
template <int Dim>
Vec3 frictionVelocity(MappedVelocities<Dim>& velocities, const Body<Dim>& soil,
                      const RigidContactPoint& contact, const Arms& arms, const BoxHats<Dim>* hats) {
    if (!hats) return Vec3::Zero();
    return strainVelocity(velocities, soil, contact, *hats, arms.normal) +
           velocityGradientOf(soil, contact.place) * (arms.friction - arms.normal);
}

// How far the place where friction acts has moved since the last step. A particle's own part is taken from
// its place: under FLIP its velocity is another one. against: frictionVelocity.
inline Vec3 movedSince(double dt, const RigidContactPoint& contact, const Vec3& against) {
    return contact.point - contact.pointBefore + dt * against;
}

// How far it has slid since a touch that is new in this step: the overlap tells when that was. Without it no
// touch would bear friction in its first step, and what chatters would slide too fast. carried: by the rigid
// body in a step.
template <int Dim>
Vec3 slidSinceTouch(double dt, const Body<Dim>& soil, int index, const RigidContactPoint& contact,
                    const Vec3& against, const Vec3& position, const Vec3& carried) {
    Vec3 moved = contact.point - position; // of a box: from where it is to where it is strained
    const Field& velocity =
        soil.type->isMeshed() ? soil.domains->mesh()->vertexVelocities() : soil.particles.velocity;
    moved.head<Dim>() += dt * vectorAt<Dim>(velocity, index);
    moved += dt * against;
    const Vec3 slid = moved - carried;
    const double closed = -slid.dot(contact.normal);
    if (!(closed > 0)) return Vec3::Zero();
    return std::min(1.0, -contact.gap / closed) * slid;
}

// A point in touch, with all that its force needs: found before the force is.
template <int Dim> struct Touching {
    int contact = 0, site = -1;       // numbers
    std::optional<BoxNodes<Dim>> box; // a vertex has none,
    std::optional<BoxHats<Dim>> hats; // nor any at arms.normal
    Arms arms;
    Vec3 at, carried, along; // m; where the nodes find the force; moves in a step of the body, and along it
    double area = 0, opened = 0;                        // m2 (2D: m); m since the last step
    Vec3 pushed = Vec3::Zero(), dragged = Vec3::Zero(); // kN, on the soil along and across the normal

    const BoxNodes<Dim>* nodes() const { return box ? &*box : nullptr; }
    const BoxHats<Dim>* atSurface() const { return hats ? &*hats : nullptr; }
};

// f(node, weight of a normal force, of friction), as addForce() has them; a node as often as it comes.
// (a vertex as if it did not hang).
template <int Dim, class F>
void forNodesOf(const Body<Dim>& soil, const Grid<Dim>& grid, int index, const Touching<Dim>& touching,
                F&& f) {
    const BoxNodes<Dim>* box = touching.nodes();
    if (!box) {
        int cell = 0;
        double in[Dim];
        for (int k = 0; k < Dim; ++k) {
            const double x = grid.inCells(soil.domains->mesh()->vertexPositions().plane(k)[index], k);
            cell += int(x) * grid.strides[k];
            in[k] = x - int(x);
        }
        for (int a = 0; a < corners<Dim>; ++a) {
            double S = 1;
            for (int k = 0; k < Dim; ++k) S *= cornerSign(a, k) > 0 ? in[k] : 1 - in[k];
            f(cornerOf(grid, cell, a), S, S);
        }
        return;
    }
    const Vec<Dim> beyond = (touching.arms.friction - touching.arms.normal).template head<Dim>();
    for (int i = 0; i < box->count; ++i) {
        const double phi = box->inside ? box->phi(i) : 0;
        f(box->node[i], phi, phi + box->gradient(i).dot(beyond));
    }
    touching.hats->forNodes([&](int node, double H) { f(node, H, H); });
    if (box->inside) box->inside->forNodes([&](int node, double H) { f(node, -H, -H); });
}

// Adds what nodes get of a normal and a friction force. box, hats: of a box, and at arms.normal.
template <int Dim>
void addForce(const Body<Dim>& soil, int index, const Arms& arms, const BoxNodes<Dim>* box,
              const BoxHats<Dim>* hats, const Vec3& normal, const Vec3& friction,
              typename NodalField<Dim>::Sum* nodes) {
    using NF = NodalField<Dim>;
    const Vec<Dim> force = (normal + friction).template head<Dim>(), dragged = friction.template head<Dim>();
    if (!box) {
        soil.domains->mesh()->addVertexForce(index, force, nodes);
        return;
    }
    Quad all{}, sideways{};
    for (int k = 0; k < Dim; ++k) {
        all[NF::lane(k)] = force[k];
        sideways[NF::lane(k)] = dragged[k];
    }
    const Vec<Dim> beyond = (arms.friction - arms.normal).template head<Dim>();
    for (int i = 0; i < box->count; ++i)
        nodes[box->node[i]].part[1] += box->gradient(i).dot(beyond) * sideways;
    hats->forNodes([&](int node, double H) { nodes[node].part[1] += H * all; });
    if (!box->inside) return;
    for (int i = 0; i < box->count; ++i) nodes[box->node[i]].part[1] += box->phi(i) * all;
    box->inside->forNodes([&](int node, double H) { nodes[node].part[1] += -H * all; });
}

// What the nodes get from each rigid body by each body of the scene, against what the rigid body gets.
template <int Dim> class RigidBalance {
  public:
    using NF = NodalField<Dim>;

    RigidBalance(const Scene<Dim>& scene, int bodies) : scene_(scene), nodes_(bodies) {}

    void add(int soil, int body, int index, const Arms& arms, const BoxNodes<Dim>* box,
             const BoxHats<Dim>* hats, const Vec3& normal, const Vec3& friction) {
        auto& nodes = nodes_[body][soil];
        if (nodes.empty()) nodes.assign(scene_.grid.count, NF::Sum::zero());
        addForce(*scene_.bodies[soil], index, arms, box, hats, normal, friction, nodes.data());
    }

    // forces, torques: on the rigid bodies.
    void check(const std::vector<RigidState>& states, const Field& forces, const Field& torques) const {
        for (size_t b = 0; b < nodes_.size(); ++b) {
            Vec3 force = vectorAt<3>(forces, int(b)), torque = vectorAt<3>(torques, int(b));
            double size = 0, moments = 0;
            for (const auto& [soil, nodes] : nodes_[b])
                for (int node = 0; node < int(nodes.size()); ++node) {
                    Vec3 f = Vec3::Zero(), x = Vec3::Zero();
                    f.head<Dim>() = NF::forceOf(nodes[node]);
                    if (f.isZero(0)) continue;
                    x.head<Dim>() = placeOf(*scene_.bodies[soil], node);
                    const Vec3 arm = x - states[b].position;
                    force += f;
                    torque += arm.cross(f);
                    size += f.norm();
                    moments += arm.norm() * f.norm();
                }
            if (force.norm() <= roundOff * size && torque.norm() <= roundOff * moments) continue;
            throw RunError(message("step ", scene_.step, ": RigidContact: rigid body ", b,
                                   " and the nodes differ by ", force.norm(), " kN of ", size, " and ",
                                   torque.norm(), " kN m of ", moments, "; this is an error in the solver"));
        }
    }

  private:
    static constexpr double roundOff = 1e-12; // of the sum of the sizes of all forces and moments

    const Scene<Dim>& scene_;
    std::vector<std::map<int, std::vector<typename NF::Sum>>> nodes_;

    // Under USF vertices have moved with the nodes before they are touched: a force on them acts there.
    Vec<Dim> placeOf(const Body<Dim>& soil, int node) const {
        Vec<Dim> x = scene_.grid.nodePosition(node);
        if (!soil.type->isMeshed() || !scene_.scheme->stressFirst) return x;
        const auto& field = scene_.grid.fields[soil.velocityField];
        for (int k = 0; k < Dim; ++k) x[k] += scene_.dt * field.velocityOf(node, k);
        return x;
    }
};

} // namespace mpm
