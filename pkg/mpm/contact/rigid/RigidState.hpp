// SPDX-License-Identifier: GPL-2.0-or-later
// Where a rigid body is, how it is turned and how it moves, and what has pushed it. Turning is about
// `position`.
#pragma once

#include "mpm/base/types.hpp"

#include <Eigen/Geometry>

namespace mpm {

struct RigidState {
    Vec3 position = Vec3::Zero(), velocity = Vec3::Zero(), angularVelocity = Vec3::Zero();
    Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();

    template <class Self, class Visit> static void members(Self& row, Visit&& visit) {
        visit("position", "m", row.position);
        visit("orientation", "-", row.orientation);
        visit("velocity", "m/s", row.velocity);
        visit("angularVelocity", "rad/s", row.angularVelocity);
    }

    Vec3 velocityAt(const Vec3& x) const { return velocity + angularVelocity.cross(x - position); }

    // The body moves on with its velocities.
    void advance(double dt) {
        for (int k = 0; k < 3; ++k) position[k] = position[k] + dt * velocity[k];
        if (angularVelocity.isZero(0)) return;
        const double angle = angularVelocity.norm() * dt;
        orientation = (Eigen::AngleAxisd(angle, angularVelocity.normalized()) * orientation).normalized();
    }
};

// Integrals of force and torque over time.
struct RigidImpulse {
    Vec3 force = Vec3::Zero(), torque = Vec3::Zero();

    template <class Self, class Visit> static void members(Self& row, Visit&& visit) {
        visit("force", "kN s", row.force);
        visit("torque", "kN m s", row.torque);
    }
};

} // namespace mpm
