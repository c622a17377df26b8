// SPDX-License-Identifier: GPL-2.0-or-later
#include "mpm/contact/rigid/refuseCrossed.hpp"

#include <algorithm>

namespace mpm {

namespace {

// Cosine between normals below which a point is on the other side of a thin shape: round its edge they turn step
// by step.
constexpr double otherSide = -0.9;

bool isFromTheOtherSide(const RigidContactPoint& contact, const std::vector<RigidContactPoint>& before) {
    const auto isBelow = [](const RigidContactPoint& a, const RigidContactPoint& b) {
        return a.pair() < b.pair();
    };
    const auto [first, last] = std::equal_range(before.begin(), before.end(), contact, isBelow);
    return std::any_of(first, last, [&](const RigidContactPoint& old) {
        return old.normal.dot(contact.normal) < otherSide;
    });
}

template <int Dim>
[[noreturn]] void refuse(const Scene<Dim>& scene, const RigidContactPoint& c, const std::string& how) {
    const Body<Dim>& soil = *scene.bodies[c.soil];
    throw RunError(
        message("step ", scene.step, ": RigidContact: rigid body ", c.body, how, " '", soil.name, "' at ",
                place(Vec<Dim>(c.point.template head<Dim>())),
                ": a penalty does not push that back. Lower dt, give a larger stiffness, move the body "
                "more slowly, or start where the two only touch"));
}

} // namespace

template <int Dim>
void refuseCrossed(const Scene<Dim>& scene, const BodyPoints<Dim>& points, const RigidContactPoint& c,
                   const RigidShape& shape, const std::vector<RigidContactPoint>& before) {
    const double most = points.width(c.place, c.normal);
    if (-c.gap > most)
        refuse(scene, c,
               message(" is ", -c.gap, " m deep, more than the width of a ",
                       scene.bodies[c.soil]->type->isMeshed() ? "facet (" : "particle (", most, " m), in"));
    if (shape.isThin() && !c.isOld() && isFromTheOtherSide(c, before))
        refuse(scene, c, " has been passed through by");
}

template void refuseCrossed(const Scene<2>&, const BodyPoints<2>&, const RigidContactPoint&,
                            const RigidShape&, const std::vector<RigidContactPoint>&);
template void refuseCrossed(const Scene<3>&, const BodyPoints<3>&, const RigidContactPoint&,
                            const RigidShape&, const std::vector<RigidContactPoint>&);

} // namespace mpm
