// SPDX-License-Identifier: GPL-2.0-or-later
// Rigid bodies of a host program and a RigidContact: states in and forces out. The host is known by the
// interface HostBody alone.
#pragma once

#include "mpm/contact/rigid/RigidContact.hpp"

#include <limits>
#include <memory>
#include <vector>

namespace mpm {

// A body of the host, in the host's axes.
class HostBody {
  public:
    virtual ~HostBody() = default;
    virtual Vec3 position() const = 0;
    virtual Eigen::Quaterniond orientation() const = 0;
    virtual Vec3 velocity() const = 0;
    virtual Vec3 angularVelocity() const = 0;
    // Whether the velocity can be read without cost: only such bodies are left out while they are far.
    virtual bool isWatched() const = 0;
    virtual void addForce(const Vec3& force) = 0;
    virtual void addTorque(const Vec3& torque) = 0;
};

class BodyExchange {
  public:
    // bodies: in the order of the rigid bodies of the contact. turns: of the frame of each body's shapes
    // against that of its state, in the axes of the scene. frame: a rotation, whose rows are the axes of the
    // scene in the host's.
    BodyExchange(std::shared_ptr<RigidContact> contact, std::vector<std::unique_ptr<HostBody>> bodies,
                 const std::vector<Eigen::Quaterniond>& turns, const Mat<3>& frame);
    virtual ~BodyExchange() = default;

    // A step of the host.
    struct HostStep {
        long number;
        double dt; // s
    };

    // States to the contact at the beginning of a cycle, which lasts until the next call. cycle: s; steps: of
    // the scene; all: none is left out. A body is left out while it cannot touch anything before the next
    // call. How far it may be from where it was seen last is added up from its velocity in every step,
    // whatever pushes it.
    virtual void read(HostStep step, double cycle, int steps, bool all);

    // Mean forces of the cycle, which took `duration`, to the host. Once in every step of the host.
    virtual void apply(HostStep step, double duration);

    long seen() const { return seen_; } // states read

  private:
    static constexpr double unbounded = std::numeric_limits<double>::infinity();

    struct Body {
        std::unique_ptr<HostBody> host;
        Eigen::Quaterniond turn;
        double radius = 0;            // m, of a sphere around the position that holds the body
        bool isRound = true;          // its orientation is of no use
        Vec3 seenAt = Vec3::Zero();   // in the scene
        double travelled = unbounded; // m, since then, at most
    };
    std::shared_ptr<RigidContact> contact_;
    std::vector<Body> bodies_;
    Mat<3> frame_;
    HostStep step_{-1, 0};
    long seen_ = 0;

    void travel(HostStep step);
    RigidState see(Body& body);
};

} // namespace mpm
