// SPDX-License-Identifier: GPL-2.0-or-later
// The penalty of rigid bodies: a point that stands for the area A and overlaps by -g gets
//     F = A [(-kappa g) n - kappa_t s],   |kappa_t s| <= mu (-kappa g)
// with the slip s of the history (Cundall & Strack 1979); adhesion adds c_a A to what friction holds.
#include "mpm/contact/rigid/RigidContact.hpp"
#include "mpm/contact/rigid/RigidForce.hpp"

namespace mpm {

namespace {

constexpr double anyMass = 1e300;  // Mg/m2, no point has that much
constexpr double softShare = 0.05; // of a cell

} // namespace

// The overlap at which the penalty would push as hard. Hertz's law p ~ d^1.5 up to an overlap d_0, where its
// slope is that of the penalty, and straight on from there: no law is steeper than the time step resolves.
double RigidContact::overlapFelt(double overlap) const {
    if (overlap >= softTo_) return overlap - softTo_ / 3;
    return 2.0 / 3 * overlap * std::sqrt(std::max(0.0, overlap) / softTo_);
}

// Its integral over the overlap, m2: the energy of the spring over its stiffness.
double RigidContact::storedBy(double overlap) const {
    const double felt = overlapFelt(overlap);
    if (overlap >= softTo_) return 0.5 * felt * felt + 2.0 / 45 * softTo_ * softTo_;
    return 0.4 * overlap * felt;
}

// kappa = factor min(m/A)/dt^2, with the longest step so far: with that of each step the springs would kick
// what they hold whenever a step is shorter, as the last ones before a time that was asked for. By Jensen's
// inequality the nodes see no higher frequency than the points
// alone, for any number of contacts at once: omega^2 <= kappa A/m, for boxes of half size l times
// 1/(1 - l/h) + 4 l/h, which is the largest sum w_i^2/phi_i: a face just beyond a line of the grid.
double RigidContact::chooseStiffness(double dt) const {
    if (std::isnan(stiffness)) return stiffnessFactor * lightest / (longestStep * longestStep);
    const double most = lightest / (dt * dt);
    require(stiffness <= most, "RigidContact: stiffness = ", stiffness, " kPa/m is unstable; give at most ",
            most, " for dt = ", dt, " s, or lower dt");
    return stiffness;
}

// A body of mass M that is touched on the area A answers with kappa A/M, which dt has to resolve as it does the
// points' own kappa/(m/A): a sphere lighter than a box would leave faster than it came. before: kPa/m, what
// the stiffness was before what is new.
template <int Dim> void RigidContact::softenForLightBodies(const Points<Dim>& points, double before) {
    double onePoint = 0;
    for (auto& p : points)
        if (p.count() > 0) onePoint = std::max(onePoint, p.largestArea());
    bodyStiffness_.resize(bodies());
    softer_.resize(bodies());
    for (int b = 0; b < bodies(); ++b) {
        double most = std::numeric_limits<double>::infinity();
        if (masses[b] > 0)
            most = stiffnessFactor * masses[b] / (std::max(area_[b], onePoint) * longestStep * longestStep);
        bodyStiffness_[b] = std::min(stiffnessUsed, most);
        softer_[b] = std::max(1.0, std::min(before, most) / bodyStiffness_[b]);
    }
}

template <int Dim>
void RigidContact::takePenalty(const Scene<Dim>& scene, const BodyPoints<Dim>& points,
                               Touching<Dim>& touching, RigidContactPoint& c) {
    const double kn = bodyStiffness_[c.body] * touching.area, kt = shearRatio * kn;
    const double viscous =
        2 * normalDamping * std::sqrt(kn * points.mass(c.place)) * touching.opened / scene.dt;
    const double normal = std::max(0.0, kn * overlapFelt(-c.gap) - viscous);
    const RigidPair pair = pairOf(c.body, c.soil, int(scene.bodies.size()));
    const double held = pair.friction * normal + pair.adhesion * touching.area;
    if (const double most = held / kt, length = c.slip.norm(); length > most) {
        frictionWork += kt * most * (length - most);
        c.slip *= most / length;
        ++sliding;
    }
    touching.pushed = normal * c.normal;
    touching.dragged = -kt * c.slip;
    c.force = touching.pushed + touching.dragged;
    springEnergy += kn * storedBy(-c.gap) + 0.5 * kt * c.slip.squaredNorm();
}

// For the points as they are in this step.
template <int Dim> void RigidContact::setPenalty(const Scene<Dim>& scene, const Points<Dim>& points) {
    softer_.clear();
    if (!isSoft()) return;
    const double before = lightest;
    longestStep = std::max(longestStep, scene.dt);
    lightest = anyMass;
    for (auto& p : points)
        if (p.count() > 0) lightest = std::min(lightest, p.massPerArea());
    stiffnessUsed = chooseStiffness(scene.dt);
    const bool keepsForces = std::isnan(stiffness) && normalLaw == "penalty";
    softenForLightBodies(points, keepsForces ? stiffnessUsed * std::max(1.0, before / lightest) : 0.0);
    softTo_ = normalLaw != "Hertz"       ? 0
              : std::isnan(hertzOverlap) ? softShare * scene.grid.smallestCell().minCoeff()
                                         : hertzOverlap;
}

// Of the straight law.
std::vector<Softness> RigidContact::softness() const {
    std::vector<Softness> of(bodies());
    for (int b = 0; b < bodies() && isSoft(); ++b)
        of[b] = {1 / bodyStiffness_[b], 1 / (shearRatio * bodyStiffness_[b])};
    return of;
}

template void RigidContact::setPenalty(const Scene<2>&, const Points<2>&);
template void RigidContact::setPenalty(const Scene<3>&, const Points<3>&);
template void RigidContact::takePenalty(const Scene<2>&, const BodyPoints<2>&, Touching<2>&,
                                        RigidContactPoint&);
template void RigidContact::takePenalty(const Scene<3>&, const BodyPoints<3>&, Touching<3>&,
                                        RigidContactPoint&);

} // namespace mpm
