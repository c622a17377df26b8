// SPDX-License-Identifier: GPL-2.0-or-later
// A point of a body of the scene that overlaps with a rigid body, and what it carries on to the next step.
#pragma once

#include "mpm/base/parameters.hpp"

#include <tuple>

namespace mpm {

// Sums over the nodes round a box, with the velocities that are mapped from the particles.
struct NodalMotion {
    Vec3 centre = Vec3::Zero(), inBox = Vec3::Zero(); // m/s, by the weights of the box, and by H(0)
    Mat<3> excess = Mat<3>::Zero();                   // 1/s, velocity gradient of the box over theirs
};

struct RigidContactPoint {
    int soil = 0, body = 0;     // numbers of the two bodies
    int64_t id = 0;             // of the particle or vertex
    Vec3 normal = Vec3::Zero(); // out of the rigid body
    Vec3 slip = Vec3::Zero();   // m, tangential displacement that the spring holds
    // M, the vertex, or where the particle would be had it moved as it is strained
    Vec3 point = Vec3::Zero();
    double gap = 0;     // m, negative where they overlap
    double stretch = 1; // of a box along the normal, since it was touched
    double cutTo = 1;   // of a box, what the ground left of its thickness: so much wider it is for its volume
    Vec3 force = Vec3::Zero(); // kN, on the soil
    // m/s, of the surface of a box against its centre, by the velocities of the nodes that have strained it and that
    // contact has tied (MUSL), beyond what its velocity gradient says; not a number: not tied
    Vec3 bend = Vec3::Constant(notGiven);

    template <class Self, class Visit> static void members(Self& row, Visit&& visit) {
        visit("soil", "", row.soil);
        visit("body", "", row.body);
        visit("id", "", row.id);
        visit("normal", "-", row.normal);
        visit("slip", "m", row.slip);
        visit("point", "m", row.point);
        visit("gap", "m", row.gap);
        visit("stretch", "-", row.stretch);
        visit("cutTo", "-", row.cutTo);
        visit("force", "kN", row.force);
        visit("bend", "m/s", row.bend);
    }

    // Of this step only.
    int place = -1; // of the point in its body
    int shape = -1;
    Vec3 forceBefore = Vec3::Zero();             // force,
    Vec3 pointBefore = Vec3::Constant(notGiven); // point (not a number: a new contact)
    double gapBefore = 0;                        // and gap in the step before

    NodalMotion motion;   // of a box
    bool isKnown = false; // whether the history has the stretch
    bool isClear = true;  // whether a box would be, with its first thickness

    bool pushes() const { return gap < 0 || !force.isZero(0); }
    // Whether it pushed in the step before.
    bool isOld() const { return pointBefore.allFinite(); }
    // Which point of which body touches which rigid body.
    auto pair() const { return std::tie(soil, id, body); }
};

} // namespace mpm
