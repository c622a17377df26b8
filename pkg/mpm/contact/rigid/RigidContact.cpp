// SPDX-License-Identifier: GPL-2.0-or-later
// Rigid bodies touch the scene by a penalty: a point (uGIMP box, boundary vertex of a mesh) that stands for
// the area A and overlaps by -g gets
//     F = A [(-kappa g) n - kappa_t s],   |kappa_t s| <= mu (-kappa g)
// with the slip s of the history (Cundall & Strack 1979); adhesion adds c_a A to what friction holds. One thread does all of it, in the order of the
// points' numbers: the same bits for any number of threads, and after a restart. RigidForce.hpp tells how it
// goes to the nodes, findRigidContacts.cpp which points overlap.
#include "mpm/contact/rigid/RigidContact.hpp"

#include "mpm/contact/rigid/RigidForce.hpp"
#include "mpm/contact/rigid/refuseCrossed.hpp"

namespace mpm {

namespace {

// Largest part of an orientation out of the plane of a 2D scene: round-off of a host.
constexpr double inPlane = 1e-9;
constexpr double anyMass = 1e300;  // Mg/m2, no point has that much
constexpr double softShare = 0.05; // of a cell

} // namespace

template <int Dim> void RigidContact::check(Scene<Dim>& scene) {
    require(bodies() > 0, "RigidContact: there is no rigid body; add one with addBody(shapes=[...])");
    require(soilFriction.empty() || soilFriction.size() == scene.bodies.size(),
            "RigidContact: soilFriction has ", soilFriction.size(), " entries for ", scene.bodies.size(),
            " bodies of the scene; give one each");
    pairUp(int(scene.bodies.size()));
    bool isAnyMeshed = false;
    for (auto& soil : scene.bodies) isAnyMeshed |= soil->type->isMeshed();
    makeShapes(Dim);
    area_.assign(bodies(), 0.0);
    for (const RigidShape& shape : shape_) {
        require(!isAnyMeshed || !shape.isThin() || shape.thickness() > 0,
                "RigidContact: a facet of rigid body ", shape.body,
                " has no thickness, and vertices of APDI bodies would slip through; give it a thickness");
        area_[shape.body] += shape.facingArea(Dim);
        require(Dim == 3 || shape.kind != RigidShape::Triangle, "RigidContact: rigid body ", shape.body,
                " has a facet with three vertices in a 2D scene; give two");
    }
    for (const HeightRecord& field : heightFields)
        require((Dim == 3) == (field.rows > 1), "RigidContact: the height field of rigid body ", field.body,
                " has ", field.rows, " rows of heights; give ",
                Dim == 3 ? "an array (columns, rows) in a 3D scene" : "a profile (columns,) in a 2D scene");
    for (int b = 0; Dim == 2 && b < bodies(); ++b) {
        const Eigen::Quaterniond& q = states[b].orientation;
        require(std::abs(q.x()) + std::abs(q.y()) < inPlane, "RigidContact: rigid body ", b,
                " is turned out of the plane; a 2D scene takes rotation about z only");
    }
}

void RigidContact::pairUp(int soils) {
    ownPair_.assign(pairs.empty() ? 0 : size_t(bodies()) * soils, -1);
    for (size_t row = 0; row < pairs.size(); ++row) {
        require(pairs[row].soil < soils, "RigidContact: there is no body ", pairs[row].soil,
                " in the scene for a pair; it has ", soils);
        ownPair_[pairs[row].body * soils + pairs[row].soil] = int(row);
    }
}

// The smaller friction of the two bodies, and the adhesion of the rigid one, unless the pair has its own.
RigidPair RigidContact::pairOf(int body, int soil, int soils) const {
    if (const int row = pairs.empty() ? -1 : ownPair_[body * soils + soil]; row >= 0) return pairs[row];
    const double limit = soilFriction.empty() ? friction[body] : std::min(friction[body], soilFriction[soil]);
    return {body, soil, limit, adhesion[body]};
}

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

// kappa = factor min(m/A)/dt^2. By Jensen's inequality the nodes see no higher frequency than the points
// alone, for any number of contacts at once: omega^2 <= kappa A/m, for boxes of half size l times
// 1/(1 - l/h) + 4 l/h, which is the largest sum w_i^2/phi_i: a face just beyond a line of the grid.
template <int Dim>
double RigidContact::chooseStiffness(const Scene<Dim>& scene, const Points<Dim>& points) const {
    double least = anyMass;
    for (auto& p : points)
        if (p.count() > 0) least = std::min(least, p.massPerArea());
    const double most = least / (scene.dt * scene.dt);
    if (std::isnan(stiffness)) return stiffnessFactor * most;
    require(stiffness <= most, "RigidContact: stiffness = ", stiffness, " kPa/m is unstable; give at most ",
            most, " for dt = ", scene.dt, " s, or lower dt");
    return stiffness;
}

// A body of mass M that is touched on the area A answers with kappa A/M, which dt has to resolve as it does the
// points' own kappa/(m/A): a sphere lighter than a box would leave faster than it came.
template <int Dim>
void RigidContact::softenForLightBodies(const Scene<Dim>& scene, const Points<Dim>& points) {
    double onePoint = 0;
    for (auto& p : points)
        if (p.count() > 0) onePoint = std::max(onePoint, p.largestArea());
    bodyStiffness_.resize(bodies());
    for (int b = 0; b < bodies(); ++b) {
        bodyStiffness_[b] = stiffnessUsed;
        if (!(masses[b] > 0)) continue;
        const double massPerArea = masses[b] / std::max(area_[b], onePoint);
        bodyStiffness_[b] = std::min(stiffnessUsed, stiffnessFactor * massPerArea / (scene.dt * scene.dt));
    }
}

template <int Dim> Reach RigidContact::reachOf(const Scene<Dim>& scene, const Points<Dim>& points) const {
    const double far = std::numeric_limits<double>::infinity();
    Reach reach{Vec3::Constant(-far), Vec3::Constant(far), scene.grid.largestCell().maxCoeff()};
    reach.lower.template head<Dim>().setConstant(far);
    reach.upper.template head<Dim>().setConstant(-far);
    for (auto& p : points) p.widen(scene.grid, reach.lower, reach.upper);
    return reach;
}

// Vertices have new numbers after domains were converted; particles keep theirs.
template <int Dim> void RigidContact::forgetRenumbered(const Scene<Dim>& scene) {
    const std::vector<BodySize> before = sizes;
    sizes.clear();
    for (auto& soil : scene.bodies) sizes.push_back({soil->particles.size()});
    const auto isRenumbered = [&](const RigidContactPoint& contact) {
        return before.at(contact.soil).particles != sizes[contact.soil].particles &&
               scene.bodies[contact.soil]->type->isMeshed();
    };
    history.erase(std::remove_if(history.begin(), history.end(), isRenumbered), history.end());
}

std::vector<int> RigidContact::particlesBefore() const {
    std::vector<int> counts;
    for (const BodySize& size : sizes) counts.push_back(size.particles);
    return counts;
}

// Where the points of the scene are.
template <int Dim> RigidContact::Points<Dim>& RigidContact::look(Scene<Dim>& scene) {
    auto& points = std::get<Points<Dim>>(points_);
    points.resize(scene.bodies.size());
    for (size_t s = 0; s < points.size(); ++s) points[s].update(*scene.bodies[s], scene.grid);
    return points;
}

template <int Dim> std::vector<RigidContactPoint> RigidContact::findOverlaps(Scene<Dim>& scene) {
    std::vector<RigidContactPoint> contacts;
    near_.find(scene, look(scene), shape_, states, contacts);
    return contacts;
}

template <int Dim> std::vector<int> RigidContact::overlapping(Scene<Dim>& scene, int soil) {
    std::vector<int> points;
    for (const RigidContactPoint& c : findOverlaps(scene))
        if (c.soil == soil && c.gap < 0) points.push_back(c.place);
    return points;
}

template <int Dim> std::vector<RigidContact::Overlap> RigidContact::overlaps(Scene<Dim>& scene) {
    std::vector<Overlap> deepest;
    for (int b = 0; b < bodies(); ++b) deepest.push_back({b, 0, 0.0});
    std::vector<RigidContactPoint> contacts = findOverlaps(scene);
    const auto& points = std::get<Points<Dim>>(points_);
    remember(contacts, history);
    fitNewBoxes(scene, points, shape_, particlesBefore(), contacts);
    for (const RigidContactPoint& c : contacts) {
        const double depth = points[c.soil].halfAlong(c.normal) * (c.stretch - 1) - c.gap;
        if (depth > deepest[c.body].depth) deepest[c.body] = {c.body, c.soil, depth};
    }
    const auto isNone = [](const Overlap& o) { return o.depth == 0; };
    deepest.erase(std::remove_if(deepest.begin(), deepest.end(), isNone), deepest.end());
    return deepest;
}

template <int Dim> void RigidContact::act(Scene<Dim>& scene) {
    const Points<Dim>& points = look(scene);
    reach = reachOf(scene, points);
    stiffnessUsed = chooseStiffness(scene, points);
    softenForLightBodies(scene, points);
    pairUp(int(scene.bodies.size())); // attributes may change between two steps
    softTo_ = normalLaw == "penalty"     ? 0
              : std::isnan(hertzOverlap) ? softShare * scene.grid.smallestCell().minCoeff()
                                         : hertzOverlap;
    std::vector<RigidContactPoint>& contacts = contacts_;
    near_.find(scene, points, shape_, states, contacts);
    const std::vector<int> known = particlesBefore();
    forgetRenumbered(scene);
    cutHistory(scene, points, history);
    remember(contacts, history);
    fitNewBoxes(scene, points, shape_, known, contacts);
    std::get<MappedVelocities<Dim>>(velocities_).begin(scene);
    forces.fill(0);
    torques.fill(0);
    largestPenetration = 0;
    sliding = 0;
    springEnergy = 0;
    RigidBalance<Dim> balance(scene, checkBalance ? bodies() : 0);
    size_t kept = 0;
    for (RigidContactPoint& c : contacts)
        if (mayTouch(scene, c) && touch(scene, points, c, balance)) {
            if (&contacts[kept] != &c) contacts[kept] = c;
            ++kept;
        }
    contacts.resize(kept);
    if (checkBalance) balance.check(states, forces, torques);
    history.swap(contacts);
    moveOn(scene.dt);
}

// Follows one contact, and pushes where it overlaps; returns whether it stays.
template <int Dim>
bool RigidContact::touch(Scene<Dim>& scene, const Points<Dim>& points, RigidContactPoint& c,
                         RigidBalance<Dim>& balance) {
    const Body<Dim>& soil = *scene.bodies[c.soil];
    std::optional<BoxNodes<Dim>> ofBox; // a vertex has none
    if (!soil.type->isMeshed()) ofBox.emplace(soil, scene.grid, c.place, points[c.soil].weighsByHats());
    const BoxNodes<Dim>* box = ofBox ? &*ofBox : nullptr;
    if (!followStrain(scene, points[c.soil], std::get<MappedVelocities<Dim>>(velocities_), box, c))
        return false;
    refuseCrossed(scene, points[c.soil], c, shape_[c.shape], history);
    if (c.pushes()) push(scene, points[c.soil], box, c, balance);
    return true;
}

void RigidContact::moveOn(double dt) {
    for (int b = 0; b < bodies(); ++b) {
        for (int k = 0; k < 3; ++k) {
            impulses[b].force[k] += dt * forces.plane(k)[b];
            impulses[b].torque[k] += dt * torques.plane(k)[b];
        }
        states[b].advance(dt);
    }
}

// The force of one contact, on the nodes and on the rigid body.
template <int Dim>
void RigidContact::push(Scene<Dim>& scene, const BodyPoints<Dim>& points, const BoxNodes<Dim>* box,
                        RigidContactPoint& c, RigidBalance<Dim>& balance) {
    const Body<Dim>& soil = *scene.bodies[c.soil];
    const RigidState& rigid = states[c.body];
    const int index = points.index(c.place);
    const Vec3 n = c.normal;
    const Arms arms{points.armAlong(n, c.stretch), -points.exitAlong(n) * std::min(c.stretch, 1.0) * n};
    const Vec3 at = points.position(c.place) + arms.friction; // where the nodes find it
    const double area = points.area(c.place, n);
    const double kn = bodyStiffness_[c.body] * area, kt = shearRatio * kn;

    std::optional<BoxHats<Dim>> ofBox;
    if (box) ofBox.emplace(soil, scene.grid, index, arms.normal);
    const BoxHats<Dim>* hats = ofBox ? &*ofBox : nullptr;

    const bool isOld = c.isOld();
    const Vec3 against = frictionVelocity(std::get<MappedVelocities<Dim>>(velocities_), soil, c, arms, hats);
    const Vec3 carried = scene.dt * rigid.velocityAt(at);
    const Vec3 slid =
        isOld ? Vec3(movedSince(scene.dt, c, against) - carried)
              : slidSinceTouch(scene.dt, soil, index, c, against, points.position(c.place), carried);
    const double opened = isOld ? c.gap - c.gapBefore : 0;
    const double viscous = 2 * normalDamping * std::sqrt(kn * points.mass(c.place)) * opened / scene.dt;
    const double normal = std::max(0.0, kn * overlapFelt(-c.gap) - viscous);
    const Vec3 along = slid - slid.dot(n) * n;
    c.slip += along;
    const RigidPair pair = pairOf(c.body, c.soil, int(scene.bodies.size()));
    const double held = pair.friction * normal + pair.adhesion * area;
    if (const double most = held / kt, length = c.slip.norm(); length > most) {
        frictionWork += kt * most * (length - most);
        c.slip *= most / length;
        ++sliding;
    }
    const Vec3 pushed = normal * n, dragged = -kt * c.slip;
    c.force = pushed + dragged;

    addForce(soil, index, arms, box, hats, pushed, dragged, scene.grid.fields[soil.velocityField].sum.data());
    if (checkBalance) balance.add(c.soil, c.body, index, arms, box, hats, pushed, dragged);
    const Vec3 torque = (at - rigid.position).cross(c.force);
    for (int k = 0; k < 3; ++k) {
        forces.plane(k)[c.body] -= c.force[k];
        torques.plane(k)[c.body] -= torque[k];
    }
    springEnergy += kn * storedBy(-c.gap) + 0.5 * kt * c.slip.squaredNorm();
    if (isOld) {
        const Vec3 mean = 0.5 * (c.forceBefore + c.force);
        const double ofBody = mean.dot(carried), ofSoil = ofBody + mean.dot(opened * n + along);
        bodyWork += ofBody;
        soilWork += ofSoil;
        scene.energies.loads += ofSoil;
    }
    largestPenetration = std::max(largestPenetration, -c.gap);
    if (deep.body < 0 && -c.gap > deepShare * points.width(c.place, n))
        deep = {c.body, c.soil, -c.gap, scene.step};
}

template void RigidContact::check<2>(Scene<2>&);
template void RigidContact::check<3>(Scene<3>&);
template void RigidContact::act<2>(Scene<2>&);
template void RigidContact::act<3>(Scene<3>&);
template std::vector<RigidContact::Overlap> RigidContact::overlaps(Scene<2>&);
template std::vector<RigidContact::Overlap> RigidContact::overlaps(Scene<3>&);
template std::vector<int> RigidContact::overlapping(Scene<2>&, int);
template std::vector<int> RigidContact::overlapping(Scene<3>&, int);

MPM_REGISTER(Engine, RigidContact);

} // namespace mpm
