// SPDX-License-Identifier: GPL-2.0-or-later
// Frictional contact of rigid bodies with everything in the scene. See RigidContact.cpp; the derivation is in
// doc/explanation/rigid-contact.md.
#pragma once

#include "mpm/contact/rigid/findRigidContacts.hpp"
#include "mpm/scene/Scene.hpp"

#include <optional>

namespace mpm {

// Box around all points that a rigid body could touch, as they stood in the last step. None moves by more
// than a cell in a step.
struct Reach {
    Vec3 lower, upper;
    double cell; // m, longest edge
    double distance(const Vec3& x) const { return (x - x.cwiseMax(lower).cwiseMin(upper)).norm(); }
};

template <int Dim> class RigidBalance;
template <int Dim> struct Touching;

// What holds between a rigid body and a body of the scene instead of what each has by itself.
struct RigidPair {
    int body = 0, soil = 0;
    double friction = 0, adhesion = 0; // -, kPa
    template <class Self, class Visit> static void members(Self& row, Visit&& visit) {
        visit("body", "", row.body);
        visit("soil", "", row.soil);
        visit("friction", "-", row.friction);
        visit("adhesion", "kPa", row.adhesion);
    }
};

class RigidContact : public EngineOf<RigidContact>, public PressingOnBoxes, public VelocityCoupling {
  public:
    bool needsOneField() const override { return true; }

    std::vector<double> friction;     // -, of each rigid body,
    std::vector<double> masses;       // Mg (2D: Mg/m), and its mass; zero: it does not yield
    std::vector<double> soilFriction; // -, of each body of the scene; empty: no limit
    std::vector<double> adhesion;     // kPa, of each rigid body
    std::vector<RigidPair> pairs;
    std::vector<ShapeRecord> shapes;
    std::vector<HeightRecord> heightFields;
    std::vector<double> heights;        // m, of all height fields, one after the other
    std::vector<RigidState> states;     // of each rigid body,
    std::vector<RigidImpulse> impulses; // and what it got since clearImpulses()
    std::vector<RigidContactPoint> history;
    struct BodySize {
        int particles = 0;
        template <class Self, class Visit> static void members(Self& row, Visit&& visit) {
            visit("particles", "", row.particles);
        }
    };
    std::vector<BodySize> sizes; // of the bodies of the scene in the last step
    double stiffness = notGiven, stiffnessFactor = 0.3, shearRatio = 0.8, normalDamping = 0;
    double frictionWork = 0, bodyWork = 0, soilWork = 0; // kJ, since the start
    double longestStep = 0;                              // s, so far
    double lightest = 0;                                 // Mg/m2, m/A of the lightest point in the last step
    std::string normalLaw = "penalty";
    double hertzOverlap = notGiven;
    bool checkBalance = false;

    // Outputs of the last step.
    Field forces{"forces", "kN", "", {3}}, torques{"torques", "kN m", "", {3}};
    double largestPenetration = 0, stiffnessUsed = 0; // stiffness: of bodies that do not yield
    double springEnergy = 0;                          // kJ, in all contacts
    int sliding = 0;
    std::optional<Reach> reach; // who reads it takes it, so it is there only after a step

    std::string className() const override { return "RigidContact"; }
    std::string doc() const override;
    std::vector<Parameter> attributes() override;
    void finish() override;
    void prepare(Scene<2>& scene) override { check(scene); }
    void prepare(Scene<3>& scene) override { check(scene); }

    int bodies() const { return int(friction.size()); }
    int contacts() const {
        return int(std::count_if(history.begin(), history.end(), [](auto& c) { return c.pushes(); }));
    }
    // All bodies at once: N x 3, N x 4 (w, x, y, z), N x 3, N x 3.
    void setStates(const std::vector<double>& positions, const std::vector<double>& orientations,
                   const std::vector<double>& velocities, const std::vector<double>& angularVelocities);
    void setState(int body, const RigidState& state);
    void forPressed(const std::function<void(int, const Vec3&)>& f) const override {
        for (const RigidContactPoint& c : history)
            if (c.pushes()) f(c.soil, c.point);
    }
    void clearImpulses() { impulses.assign(bodies(), {}); }

    template <int Dim> void act(Scene<Dim>& scene);
    void couple(Scene<2>& scene) override { tie(scene); }
    void couple(Scene<3>& scene) override { tie(scene); }

    // Deepest overlap of every rigid body that has one, as all stand now.
    struct Overlap {
        int body, soil; // numbers of the two bodies
        double depth;   // m
    };
    template <int Dim> std::vector<Overlap> overlaps(Scene<Dim>& scene);
    // The points of a body of the scene that overlap with any, likewise.
    template <int Dim> std::vector<int> overlapping(Scene<Dim>& scene, int soil);

    // The first overlap of more than deepShare of what the point is wide; body -1: none so far. From a whole
    // width on the run ends.
    static constexpr double deepShare = 0.25;
    struct Deep {
        int body = -1, soil = 0;
        double depth = 0; // m
        long step = 0;
    } deep;

  private:
    template <int Dim> using Points = std::vector<BodyPoints<Dim>>; // per body of the scene
    std::tuple<Points<2>, Points<3>> points_;
    std::vector<RigidShape> shape_;
    struct Step; // what is found in each step; keeps its memory
    std::shared_ptr<Step> step_;
    std::vector<double> area_;          // m2 (2D: m), that may touch each body at once
    std::vector<double> bodyStiffness_; // kPa/m, of each body in this step
    std::vector<double> softer_;        // by which factor it falls in this step, for what is lighter is new
    std::vector<int> ownPair_;          // of each rigid body with each of the scene: row of pairs, or -1
    NearContacts near_;
    std::vector<RigidContactPoint> contacts_; // of this step; keeps its memory
    double softTo_ = 0;                       // m, overlap up to which the contact is softer than the penalty

    void makeShapes(int dim);
    void checkState(int body, const RigidState& state) const;
    template <int Dim> void check(Scene<Dim>& scene);
    void pairUp(int soils);
    RigidPair pairOf(int body, int soil, int soils) const;
    double overlapFelt(double overlap) const;
    double storedBy(double overlap) const;
    template <int Dim> Reach reachOf(const Scene<Dim>& scene, const Points<Dim>& points) const;
    double chooseStiffness(double dt) const;
    template <int Dim> void softenForLightBodies(const Points<Dim>& points, double before);
    template <int Dim> void setPenalty(const Scene<Dim>& scene, const Points<Dim>& points);
    std::vector<int> particlesBefore() const;
    std::vector<Softness> softness() const;
    template <int Dim> Points<Dim>& look(Scene<Dim>& scene);
    template <int Dim> std::vector<RigidContactPoint> findOverlaps(Scene<Dim>& scene);
    template <int Dim> void forgetRenumbered(const Scene<Dim>& scene);
    template <int Dim>
    bool touch(Scene<Dim>& scene, const Points<Dim>& points, RigidContactPoint& contact,
               Touching<Dim>& touching);
    template <int Dim>
    int addSite(const Scene<Dim>& scene, const Points<Dim>& points, const RigidContactPoint& contact,
                const Touching<Dim>& touching);
    template <int Dim>
    void takeImpulse(const Scene<Dim>& scene, Touching<Dim>& touching, RigidContactPoint& contact);
    template <int Dim>
    void takePenalty(const Scene<Dim>& scene, const BodyPoints<Dim>& points, Touching<Dim>& touching,
                     RigidContactPoint& contact);
    template <int Dim>
    void push(Scene<Dim>& scene, const BodyPoints<Dim>& points, const Touching<Dim>& touching,
              const RigidContactPoint& contact, RigidBalance<Dim>& balance);
    template <int Dim> void tie(Scene<Dim>& scene);
    bool isSoft() const { return normalLaw != "rigid"; }
    void moveOn(double dt);
};

} // namespace mpm
