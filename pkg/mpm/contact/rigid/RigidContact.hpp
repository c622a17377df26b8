// SPDX-License-Identifier: GPL-2.0-or-later
// Frictional contact of rigid bodies with everything in the scene. See RigidContact.cpp; the derivation is in
// doc/rigid-contact.md.
#pragma once

#include "mpm/contact/rigid/TouchPoints.hpp"
#include "mpm/scene/Engine.hpp"

#include <optional>

namespace mpm {

// A point of a body that overlaps with a rigid body, and what it carries on to the next step.
struct RigidTouch {
    int soil, body; // numbers of the two bodies
    int64_t id;     // of the particle or vertex
    Vec3 normal;    // out of the rigid body
    Vec3 slip;      // m, tangential displacement that the spring holds
    Vec3 point;     // m, the vertex, or where the particle would be had it moved as it is strained
    double gap;     // m, negative
    Vec3 force;     // kN, on the soil
    // Not kept.
    int place = -1; // of the point in its body
    int shape = -1;
    Vec3 edge = Vec3::Zero(); // point of the shape nearest to the particle, in the frame of the rigid body
    Vec3 forceBefore = Vec3::Zero();        // force,
    Vec3 before = Vec3::Constant(notGiven); // point (not a number: a new touch)
    double gapBefore = 0;                   // and gap in the step before

    static constexpr int size = 16;
};

// Box around all points that a rigid body could touch, as they stood in the last step. None moves by more than a cell in a step.
struct Reach {
    Vec3 lower, upper;
    double cell; // m, longest edge
    double distance(const Vec3& x) const { return (x - x.cwiseMax(lower).cwiseMin(upper)).norm(); }
};

class RigidContact : public EngineOf<RigidContact> {
  public:
    std::vector<double> friction, shapes, states, history, sizes, impulses;
    double stiffness = notGiven, stiffnessFactor = 0.3, shearRatio = 0.8, normalDamping = 0, frictionWork = 0;
    bool checkBalance = false;

    // Outputs of the last step.
    Field forces{"forces", "kN", "", {3}}, torques{"torques", "kN m", "", {3}};
    double largestPenetration = 0, stiffnessUsed = 0;
    int sliding = 0;
    std::optional<Reach> reach; // who reads it takes it, so it is there only after a step

    std::string className() const override { return "RigidContact"; }
    std::string doc() const override;
    std::vector<Parameter> attributes() override;
    void finish() override;
    void prepare(Scene<2>& scene) override { check(scene); }
    void prepare(Scene<3>& scene) override { check(scene); }

    int bodies() const { return int(friction.size()); }
    int contacts() const { return int(history.size()) / RigidTouch::size; }
    // All bodies at once: N x 3, N x 4 (w, x, y, z), N x 3, N x 3.
    void setStates(const std::vector<double>& positions, const std::vector<double>& orientations,
                   const std::vector<double>& velocities, const std::vector<double>& angularVelocities);
    void setState(int body, const double* state); // 13 numbers as in RigidState
    void clearImpulses() { std::fill(impulses.begin(), impulses.end(), 0.0); }

    template <int Dim> void act(Scene<Dim>& scene);

    // Deepest overlap of every rigid body that has one, as all stand now.
    struct Overlap {
        int body, soil; // numbers of the two bodies
        double depth;   // m
    };
    template <int Dim> std::vector<Overlap> overlaps(Scene<Dim>& scene);

  private:
    template <int Dim> struct Points {
        std::vector<TouchPoints<Dim>> of; // per body of the scene
    };
    std::tuple<Points<2>, Points<3>> points_;
    std::vector<RigidState> state_;
    std::vector<RigidShape> shape_;

    void checkState(int body, const double* state) const;
    template <int Dim> void check(Scene<Dim>& scene);
    template <int Dim>
    Reach reachOf(const Scene<Dim>& scene, const std::vector<TouchPoints<Dim>>& points) const;
    template <int Dim>
    double chooseStiffness(const Scene<Dim>& scene, const std::vector<TouchPoints<Dim>>& points) const;
    template <int Dim> std::vector<TouchPoints<Dim>>& look(Scene<Dim>& scene);
    template <int Dim>
    std::vector<RigidTouch> find(const Scene<Dim>& scene, const std::vector<TouchPoints<Dim>>& points) const;
    template <int Dim>
    void moveToStrainedPlaces(const Scene<Dim>& scene, std::vector<RigidTouch>& touches) const;
    template <int Dim> void forgetRenumbered(const Scene<Dim>& scene);
    void dropRepeats(std::vector<RigidTouch>& touches) const;
    void remember(std::vector<RigidTouch>& touches) const;
    void pack(const std::vector<RigidTouch>& touches);
    template <int Dim> class Balance;
    template <int Dim>
    void push(Scene<Dim>& scene, const TouchPoints<Dim>& points, RigidTouch& t, Balance<Dim>& balance);
};

} // namespace mpm
