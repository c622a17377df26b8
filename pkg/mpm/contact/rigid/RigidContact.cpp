// SPDX-License-Identifier: GPL-2.0-or-later
// Rigid bodies touch the scene at its points (uGIMP boxes, boundary vertices of meshes), by a penalty
// (RigidPenalty.cpp) or by impulses (RigidImpulses.hpp). One thread does all of it, in the order of the points'
// numbers: the same bits for any number of threads, and after a restart. RigidForce.hpp tells how a force
// goes to the nodes, findRigidContacts.cpp which points overlap.
#include "mpm/contact/rigid/RigidContact.hpp"

#include "mpm/contact/rigid/RigidForce.hpp"
#include "mpm/contact/rigid/RigidImpulses.hpp"
#include "mpm/contact/rigid/refuseCrossed.hpp"

namespace mpm {

namespace {

// Largest part of an orientation out of the plane of a 2D scene: round-off of a host.
constexpr double inPlane = 1e-9;

} // namespace

struct RigidContact::Step {
    std::vector<RigidMass> masses;
    std::tuple<MappedVelocities<2>, MappedVelocities<3>> velocities;
    std::tuple<std::vector<Touching<2>>, std::vector<Touching<3>>> touching;
    std::tuple<RigidImpulses<2>, RigidImpulses<3>> impulses;
};

template <int Dim> void RigidContact::check(Scene<Dim>& scene) {
    require(bodies() > 0, "RigidContact: there is no rigid body; add one with addBody(shapes=[...])");
    require(soilFriction.empty() || soilFriction.size() == scene.bodies.size(),
            "RigidContact: soilFriction has ", soilFriction.size(), " entries for ", scene.bodies.size(),
            " bodies of the scene; give one each");
    pairUp(int(scene.bodies.size()));
    bool isAnyMeshed = false;
    for (auto& soil : scene.bodies) isAnyMeshed |= soil->type->isMeshed();
    makeShapes(Dim);
    if (!step_) step_ = std::make_shared<Step>();
    step_->masses = rigidMasses(shape_, masses, Dim);
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
    fitNewBoxes(scene, points, shape_, particlesBefore(), std::vector<Softness>(bodies()), contacts);
    for (const RigidContactPoint& c : contacts) {
        const double depth = points[c.soil].halfAlong(c.normal) * (c.stretch - 1) - c.gap;
        if (depth > deepest[c.body].depth) deepest[c.body] = {c.body, c.soil, depth};
    }
    const auto isNone = [](const Overlap& o) { return o.depth == 0; };
    deepest.erase(std::remove_if(deepest.begin(), deepest.end(), isNone), deepest.end());
    return deepest;
}

namespace {

// Leaves out contacts that are over.
template <int Dim>
void forgetLeft(std::vector<RigidContactPoint>& contacts, std::vector<Touching<Dim>>& all) {
    size_t kept = 0;
    auto touching = all.begin();
    for (size_t i = 0; i < contacts.size(); ++i) {
        const bool stays = contacts[i].pushes() || !contacts[i].isClear;
        if (touching != all.end() && touching->contact == int(i))
            (touching++)->contact = stays ? int(kept) : -1;
        if (!stays) continue;
        if (kept != i) contacts[kept] = contacts[i];
        ++kept;
    }
    contacts.resize(kept);
}

} // namespace

template <int Dim> void RigidContact::act(Scene<Dim>& scene) {
    const Points<Dim>& points = look(scene);
    reach = reachOf(scene, points);
    setPenalty(scene, points);
    pairUp(int(scene.bodies.size())); // attributes may change between two steps
    std::vector<RigidContactPoint>& contacts = contacts_;
    near_.find(scene, points, shape_, states, contacts);
    const std::vector<int> known = particlesBefore();
    forgetRenumbered(scene);
    cutHistory(scene, points, history);
    remember(contacts, history);
    keepForces(points, softer_, contacts);
    fitNewBoxes(scene, points, shape_, known, softness(), contacts);
    std::get<MappedVelocities<Dim>>(step_->velocities).begin(scene);
    forces.fill(0);
    torques.fill(0);
    largestPenetration = 0;
    sliding = 0;
    springEnergy = 0;
    auto& all = std::get<std::vector<Touching<Dim>>>(step_->touching);
    auto& impulses = std::get<RigidImpulses<Dim>>(step_->impulses);
    all.clear();
    if (!isSoft()) impulses.begin(scene, states, step_->masses);
    size_t kept = 0;
    for (RigidContactPoint& c : contacts) {
        if (!mayTouch(scene, c)) continue;
        all.emplace_back().contact = int(kept);
        if (!touch(scene, points, c, all.back())) all.pop_back();
        c.bend.setConstant(notGiven); // tie() gives the next one
        if (&contacts[kept] != &c) contacts[kept] = c;
        ++kept;
    }
    contacts.resize(kept);
    if (!isSoft()) impulses.solve();
    RigidBalance<Dim> balance(scene, checkBalance ? bodies() : 0);
    for (Touching<Dim>& touching : all) {
        RigidContactPoint& c = contacts[touching.contact];
        if (isSoft())
            takePenalty(scene, points[c.soil], touching, c);
        else
            takeImpulse(scene, touching, c);
        push(scene, points[c.soil], touching, c, balance);
    }
    if (checkBalance) balance.check(states, forces, torques);
    forgetLeft(contacts, all);
    history.swap(contacts);
    moveOn(scene.dt);
}

// The velocities that strain the soil, when they have been mapped back from the particles.
template <int Dim> void RigidContact::tie(Scene<Dim>& scene) {
    if (isSoft() || !scene.scheme->remapsSolution()) return;
    std::get<RigidImpulses<Dim>>(step_->impulses).tie(scene);
    for (const Touching<Dim>& touching : std::get<std::vector<Touching<Dim>>>(step_->touching)) {
        if (touching.contact < 0 || !touching.box) continue;
        RigidContactPoint& c = history[touching.contact];
        c.bend = bendOf(scene.grid.fields[scene.bodies[c.soil]->velocityField], *touching.box, *touching.hats,
                        touching.arms.normal);
    }
}

// Follows one contact; returns whether it may push.
template <int Dim>
bool RigidContact::touch(Scene<Dim>& scene, const Points<Dim>& all, RigidContactPoint& c,
                         Touching<Dim>& touching) {
    const BodyPoints<Dim>& points = all[c.soil];
    const Body<Dim>& soil = *scene.bodies[c.soil];
    auto& velocities = std::get<MappedVelocities<Dim>>(step_->velocities);
    if (!soil.type->isMeshed()) touching.box.emplace(soil, scene.grid, c.place, points.weighsByHats());
    followStrain(scene, points, velocities, touching.nodes(), c);
    if (c.pushes() || !c.isClear) refuseCrossed(scene, points, c, shape_[c.shape], history);
    if (isSoft() && !c.pushes()) return false;

    const RigidState& rigid = states[c.body];
    const int index = points.index(c.place);
    const Vec3 n = c.normal;
    touching.arms = {points.armAlong(n, c.stretch), -points.exitAlong(n) * std::min(c.stretch, 1.0) * n};
    touching.at = points.position(c.place) + touching.arms.friction;
    touching.area = points.area(c.place, n) / c.cutTo;
    if (touching.box) touching.hats.emplace(soil, scene.grid, index, touching.arms.normal);
    const Vec3 against = frictionVelocity(velocities, soil, c, touching.arms, touching.atSurface());
    touching.carried = scene.dt * rigid.velocityAt(touching.at);
    Vec3 slid = Vec3::Zero();
    if (c.isOld())
        slid = movedSince(scene.dt, c, against) - touching.carried;
    else if (isSoft())
        slid = slidSinceTouch(scene.dt, soil, index, c, against, points.position(c.place), touching.carried);
    touching.opened = c.isOld() ? c.gap - c.gapBefore : 0;
    touching.along = slid - slid.dot(n) * n;
    c.slip += touching.along;
    if (isSoft()) return true;
    touching.site = addSite(scene, all, c, touching);
    return touching.site >= 0 || c.pushes();
}

template <int Dim>
int RigidContact::addSite(const Scene<Dim>& scene, const Points<Dim>& points, const RigidContactPoint& c,
                          const Touching<Dim>& touching) {
    const Body<Dim>& soil = *scene.bodies[c.soil];
    const RigidPair pair = pairOf(c.body, c.soil, int(scene.bodies.size()));
    RigidSite site;
    site.body = c.body;
    site.normal = c.normal;
    site.arm = touching.at - states[c.body].position;
    site.slip = c.slip;
    site.impulse = scene.dt * c.forceBefore.dot(c.normal) * c.normal;
    site.gap = c.gap;
    site.friction = pair.friction;
    site.borne = pair.adhesion * touching.area * scene.dt;
    return std::get<RigidImpulses<Dim>>(step_->impulses).add(site, soil.velocityField, [&](auto&& f) {
        forNodesOf(soil, scene.grid, points[c.soil].index(c.place), touching, f);
    });
}

// What slid begins to stick where it is.
template <int Dim>
void RigidContact::takeImpulse(const Scene<Dim>& scene, Touching<Dim>& touching, RigidContactPoint& c) {
    if (touching.site < 0) return;
    const RigidSite& site = std::get<RigidImpulses<Dim>>(step_->impulses)[touching.site];
    c.force = site.impulse / scene.dt;
    touching.pushed = c.force.dot(c.normal) * c.normal;
    touching.dragged = c.force - touching.pushed;
    if (!site.slides) return;
    frictionWork += touching.dragged.norm() * c.slip.norm();
    c.slip.setZero();
    ++sliding;
}

void RigidContact::moveOn(double dt) {
    for (int b = 0; b < bodies(); ++b) {
        for (int k = 0; k < 3; ++k) {
            impulses[b].force[k] += dt * forces.plane(k)[b];
            impulses[b].torque[k] += dt * torques.plane(k)[b];
        }
        if (const RigidMass& mass = step_->masses[b]; !isSoft() && mass.inverse > 0) {
            states[b].velocity += mass.inverse * dt * vectorAt<3>(forces, b);
            states[b].angularVelocity +=
                dt * mass.inverseInertiaAt(states[b].orientation) * vectorAt<3>(torques, b);
        }
        states[b].advance(dt);
    }
}

// The force of one contact, on the nodes and on the rigid body.
template <int Dim>
void RigidContact::push(Scene<Dim>& scene, const BodyPoints<Dim>& points, const Touching<Dim>& touching,
                        const RigidContactPoint& c, RigidBalance<Dim>& balance) {
    const Body<Dim>& soil = *scene.bodies[c.soil];
    const int index = points.index(c.place);
    const Vec3 &pushed = touching.pushed, &dragged = touching.dragged;
    const auto* box = touching.nodes();
    const auto* hats = touching.atSurface();
    addForce(soil, index, touching.arms, box, hats, pushed, dragged,
             scene.grid.fields[soil.velocityField].sum.data());
    if (checkBalance) balance.add(c.soil, c.body, index, touching.arms, box, hats, pushed, dragged);
    const Vec3 torque = (touching.at - states[c.body].position).cross(c.force);
    for (int k = 0; k < 3; ++k) {
        forces.plane(k)[c.body] -= c.force[k];
        torques.plane(k)[c.body] -= torque[k];
    }
    if (c.isOld()) {
        const Vec3 mean = 0.5 * (c.forceBefore + c.force);
        const double ofBody = mean.dot(touching.carried);
        const double ofSoil = ofBody + mean.dot(touching.opened * c.normal + touching.along);
        bodyWork += ofBody;
        soilWork += ofSoil;
        scene.energies.loads += ofSoil;
    }
    largestPenetration = std::max(largestPenetration, -c.gap);
    if (deep.body < 0 && -c.gap > deepShare * points.width(c.place, c.normal))
        deep = {c.body, c.soil, -c.gap, scene.step};
}

template void RigidContact::check<2>(Scene<2>&);
template void RigidContact::check<3>(Scene<3>&);
template void RigidContact::act<2>(Scene<2>&);
template void RigidContact::act<3>(Scene<3>&);
template void RigidContact::tie<2>(Scene<2>&);
template void RigidContact::tie<3>(Scene<3>&);
template std::vector<RigidContact::Overlap> RigidContact::overlaps(Scene<2>&);
template std::vector<RigidContact::Overlap> RigidContact::overlaps(Scene<3>&);
template std::vector<int> RigidContact::overlapping(Scene<2>&, int);
template std::vector<int> RigidContact::overlapping(Scene<3>&, int);

MPM_REGISTER(Engine, RigidContact);

} // namespace mpm
