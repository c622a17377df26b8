// SPDX-License-Identifier: GPL-2.0-or-later
#include "mpm/contact/rigid/findRigidContacts.hpp"

#include "mpm/particle/CutBoxes.hpp"

namespace mpm {

namespace {

// Overlap, in cells, up to which there is none: a body that touches flat ground gets no force from round-off.
constexpr double roundOff = 1e-12;
// Gap, in cells, up to which a face lies on the ground: round-off of coordinates.
constexpr double flush = 1e-9;
// Cosine between normals above which two contacts of a pair are one.
constexpr double sameSide = 0.5;
// Cosine between normals below which the rotation from one to the other is not known: they are opposite.
constexpr double opposite = -0.99;

// v, which is normal to `from`, under the smallest rotation that takes `from` to `to` (unit vectors).
Vec3 turned(const Vec3& v, const Vec3& from, const Vec3& to) {
    const double c = from.dot(to);
    return c > opposite ? Vec3(v - to.dot(v) / (1 + c) * (from + to)) : Vec3(v - to.dot(v) * to);
}

// From a particle to where it would be had it moved with the velocity that strains it. That one is mapped
// back from the particles (MUSL, USF), the one that moves them is not; under FLIP what lies between them adds
// up to dt (v_p - sum phi_i v_i).
template <int Dim>
Vec3 toStrainedPlace(const Scene<Dim>& scene, const Body<Dim>& soil, const RigidContactPoint& c) {
    Vec3 own = Vec3::Zero();
    if (soil.type->isMeshed() || !scene.scheme->remaps) return own;
    own.head<Dim>() = vectorAt<Dim>(soil.particles.velocity, c.place);
    return scene.dt * (c.motion.centre - own);
}

// A box that its region was cut through is thinner and not narrower: its spring counts the whole area of its
// face, but for boxes so thin that a node may have mass from them alone. Of that node phi is l/(4h) at most
// where their face meets a line of the grid, and the spring must not be stiffer for it than the time step
// allows. And the spring holds what the stress presses and shears the ground with.
template <int Dim>
void holdStress(const Scene<Dim>& scene, const Body<Dim>& soil, double half, const Softness& soft,
                RigidContactPoint& c) {
    const Particles<Dim>& particles = soil.particles;
    const Vec<Dim> l = soil.domains->boxes()->halfSize();
    const double volume = particles.initialVolume.plane()[c.place];
    const double left = std::min(1.0, std::max(volume / (2 * l).prod(), c.stretch));
    c.cutTo = std::max(left, l.minCoeff() / (4 * scene.grid.smallestCell().minCoeff()));
    Vec3 traction = Vec3::Zero(); // on the soil
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            traction[i] -= particles.stress.plane(3 * std::min(i, j) + std::max(i, j))[c.place] * c.normal[j];
    if (!(traction.dot(c.normal) > 0)) return;
    // from the centre to the ground it rises by the weight between
    traction.template head<Dim>() -=
        particles.mass.plane()[c.place] / volume * half * c.stretch * gravityOf(scene);
    const double pressure = traction.dot(c.normal), wanting = c.cutTo / left;
    c.slip = -soft.shear * wanting * (traction - pressure * c.normal);
    c.stretch += soft.normal * wanting * pressure / half;
}

// The boxes of a body that were cut in this step.
template <int Dim> const std::vector<CutBox<Dim>>& justCut(const Body<Dim>& soil) {
    static const std::vector<CutBox<Dim>> none;
    const auto* boxes = dynamic_cast<const CutBoxes<Dim>*>(soil.domains.get());
    return boxes ? boxes->justCut() : none;
}

} // namespace

template <int Dim>
void NearContacts::find(const Scene<Dim>& scene, const std::vector<BodyPoints<Dim>>& points,
                        const std::vector<RigidShape>& shapes, const std::vector<RigidState>& states,
                        std::vector<RigidContactPoint>& contacts) {
    const double near = BodyPoints<Dim>::mostShift * scene.grid.smallestCell().minCoeff();
    found_.clear();
    for (const RigidShape& shape : shapes) {
        const RigidState& at = states[shape.body];
        const Mat<3> R = at.orientation.toRotationMatrix();
        for (int soil = 0; soil < int(points.size()); ++soil) {
            const double reach = points[soil].mostReach(near);
            points[soil].near(shape, at, scene.grid, [&](int i) {
                const Vec3 x = points[soil].position(i);
                const Vec3 local = R.transpose() * (x - at.position);
                const Surface nearest = shape.nearest(local, reach);
                if (nearest.distance > reach) return;
                double gap = -std::numeric_limits<double>::max(), half = 0;
                Vec3 n;
                shape.directions(local, nearest, [&](const Surface& s) {
                    const Vec3 normal = R * s.normal;
                    const double along = points[soil].halfAlong(normal), clear = s.distance - along;
                    if (clear <= gap) return;
                    gap = clear;
                    half = along;
                    n = normal;
                });
                if (gap >= near + BodyPoints<Dim>::mostStretch * half) return;
                const int number = int(&shape - shapes.data());
                found_.push_back({{soil, points[soil].id(i), shape.body, gap, number, i},
                                  n,
                                  x,
                                  local - nearest.distance * nearest.normal});
            });
        }
    }
    keep(shapes, contacts);
}

void NearContacts::keep(const std::vector<RigidShape>& shapes, std::vector<RigidContactPoint>& contacts) {
    order_.clear();
    for (int i = 0; i < int(found_.size()); ++i) {
        const Key& key = found_[i].key;
        order_.push_back({uint64_t(key.soil) << 48 | uint64_t(key.id), i});
    }
    std::sort(order_.begin(), order_.end(), [this](const Place& a, const Place& b) {
        return a.point != b.point ? a.point < b.point : found_[a.found].key < found_[b.found].key;
    });
    contacts.clear();
    for (const Place& at : order_) {
        const Found& f = found_[at.found];
        const Key& key = f.key;
        bool isRepeat = false;
        for (size_t k = contacts.size(); k-- > 0;) {
            const RigidContactPoint& c = contacts[k];
            if (c.soil != key.soil || c.id != key.id || c.body != key.body) break;
            isRepeat |=
                c.normal.dot(f.normal) > sameSide || shapes[c.shape].nearest(f.edge).distance < -c.gap;
        }
        if (isRepeat) continue;
        RigidContactPoint& contact = contacts.emplace_back();
        contact.soil = key.soil;
        contact.body = key.body;
        contact.id = key.id;
        contact.gap = key.gap;
        contact.shape = key.shape;
        contact.place = key.place;
        contact.normal = f.normal;
        contact.point = f.point;
    }
}

void remember(std::vector<RigidContactPoint>& contacts, const std::vector<RigidContactPoint>& before) {
    auto old = before.begin();
    for (RigidContactPoint& c : contacts) {
        while (old != before.end() && old->pair() < c.pair()) ++old;
        double nearest = sameSide;
        for (auto same = old; same != before.end() && same->pair() == c.pair(); ++same) {
            if (same->normal.dot(c.normal) <= nearest) continue;
            nearest = same->normal.dot(c.normal);
            c.stretch = same->stretch;
            c.cutTo = same->cutTo;
            c.isKnown = true;
            c.bend = same->bend;
            if (!same->pushes()) continue;
            c.slip = turned(same->slip, same->normal, c.normal);
            c.pointBefore = same->point;
            c.forceBefore = same->force;
            c.gapBefore = same->gap;
        }
    }
}

template <int Dim>
void keepForces(const std::vector<BodyPoints<Dim>>& points, const std::vector<double>& softer,
                std::vector<RigidContactPoint>& contacts) {
    for (RigidContactPoint& c : contacts) {
        const double half = points[c.soil].halfAlong(c.normal);
        if (softer.empty() || softer[c.body] == 1 || !c.isOld() || half == 0) continue;
        c.stretch += (softer[c.body] - 1) * std::max(0.0, -c.gapBefore) / half;
        c.slip *= softer[c.body];
    }
}

template <int Dim>
void cutHistory(const Scene<Dim>& scene, const std::vector<BodyPoints<Dim>>& points,
                std::vector<RigidContactPoint>& history) {
    const auto give = [&](RigidContactPoint& half, const Vec<Dim>& offset) {
        half.point.template head<Dim>() += offset;
        const double off = half.normal.template head<Dim>().dot(offset);
        half.stretch = std::max(0.0, half.stretch + off / points[half.soil].halfAlong(half.normal));
        half.force *= 0.5;
    };
    const auto isBefore = [](auto& a, auto& b) { return a.pair() < b.pair(); };
    std::vector<RigidContactPoint> made;
    for (int s = 0; s < int(points.size()); ++s)
        for (const CutBox<Dim>& cut : justCut(*scene.bodies[s])) {
            const auto isBeforeBox = [&](const RigidContactPoint& c, int64_t id) {
                return c.soil != s ? c.soil < s : c.id < id;
            };
            auto c = std::lower_bound(history.begin(), history.end(), cut.kept, isBeforeBox);
            for (; c != history.end() && c->soil == s && c->id == cut.kept; ++c) {
                made.push_back(*c);
                made.back().id = cut.made;
                give(made.back(), -cut.offset);
                give(*c, cut.offset);
            }
        }
    if (made.empty()) return;
    std::stable_sort(made.begin(), made.end(), isBefore);
    const auto known = history.insert(history.end(), made.begin(), made.end());
    if (known != history.begin() && isBefore(*known, *std::prev(known))) // another body has larger ids
        std::inplace_merge(history.begin(), known, history.end(), isBefore);
}

template <int Dim>
void fitNewBoxes(const Scene<Dim>& scene, const std::vector<BodyPoints<Dim>>& points,
                 const std::vector<RigidShape>& shapes, const std::vector<int>& known,
                 const std::vector<Softness>& softness, std::vector<RigidContactPoint>& contacts) {
    const auto isHalf = [&](const RigidContactPoint& c) {
        const auto& cuts = justCut(*scene.bodies[c.soil]);
        return std::any_of(cuts.begin(), cuts.end(), [&](auto& cut) { return cut.kept == c.id; });
    };
    const double touches = flush * scene.grid.smallestCell().minCoeff();
    for (RigidContactPoint& c : contacts) {
        const double half = points[c.soil].halfAlong(c.normal);
        if (c.isKnown || c.gap >= touches || half == 0) continue;
        const bool isNewBody = c.soil >= int(known.size());
        const bool isOnSprings = std::abs(c.gap) < touches && softness[c.body].normal > 0;
        const bool isOnGround = shapes[c.shape].kind == RigidShape::HeightField || isOnSprings;
        const bool isNew = isNewBody ? isOnGround : c.id >= known[c.soil] || isHalf(c);
        if (!isNew) continue;
        c.stretch = std::max(0.0, 1 + c.gap / half);
        c.isKnown = true;
        if (isNewBody) holdStress(scene, *scene.bodies[c.soil], half, softness[c.body], c);
    }
}

template <int Dim>
void followStrain(const Scene<Dim>& scene, const BodyPoints<Dim>& points, MappedVelocities<Dim>& velocities,
                  const BoxNodes<Dim>* box, RigidContactPoint& c) {
    const double least = -roundOff * scene.grid.smallestCell().minCoeff();
    const Body<Dim>& soil = *scene.bodies[c.soil];
    if (box) c.motion = nodalMotionOf(velocities, soil, *box, c.place);
    const Vec3 shift = toStrainedPlace(scene, soil, c);
    c.point += shift;
    c.gap += c.normal.dot(shift);
    c.isClear = c.gap >= least;
    const double half = points.halfAlong(c.normal);
    if (c.isKnown && half > 0) {
        const Vec3 arm = points.armAlong(c.normal, c.stretch);
        const BoxHats<Dim> hats(soil, scene.grid, c.place, arm);
        const Vec3 against = strainVelocity(velocities, soil, c, hats, arm);
        const double thicker = -c.normal.dot(against) * scene.dt;
        c.stretch = std::clamp(c.stretch + thicker / half, 0.0, 1 + BodyPoints<Dim>::mostStretch);
    }
    c.gap -= half * (c.stretch - 1);
    if (c.gap >= least) c.gap = std::max(0.0, c.gap);
}

template void NearContacts::find(const Scene<2>&, const std::vector<BodyPoints<2>>&,
                                 const std::vector<RigidShape>&, const std::vector<RigidState>&,
                                 std::vector<RigidContactPoint>&);
template void NearContacts::find(const Scene<3>&, const std::vector<BodyPoints<3>>&,
                                 const std::vector<RigidShape>&, const std::vector<RigidState>&,
                                 std::vector<RigidContactPoint>&);
template void keepForces(const std::vector<BodyPoints<2>>&, const std::vector<double>&,
                         std::vector<RigidContactPoint>&);
template void keepForces(const std::vector<BodyPoints<3>>&, const std::vector<double>&,
                         std::vector<RigidContactPoint>&);
template void cutHistory(const Scene<2>&, const std::vector<BodyPoints<2>>&, std::vector<RigidContactPoint>&);
template void cutHistory(const Scene<3>&, const std::vector<BodyPoints<3>>&, std::vector<RigidContactPoint>&);
template void fitNewBoxes(const Scene<2>&, const std::vector<BodyPoints<2>>&, const std::vector<RigidShape>&,
                          const std::vector<int>&, const std::vector<Softness>&,
                          std::vector<RigidContactPoint>&);
template void fitNewBoxes(const Scene<3>&, const std::vector<BodyPoints<3>>&, const std::vector<RigidShape>&,
                          const std::vector<int>&, const std::vector<Softness>&,
                          std::vector<RigidContactPoint>&);
template void followStrain(const Scene<2>&, const BodyPoints<2>&, MappedVelocities<2>&, const BoxNodes<2>*,
                           RigidContactPoint&);
template void followStrain(const Scene<3>&, const BodyPoints<3>&, MappedVelocities<3>&, const BoxNodes<3>*,
                           RigidContactPoint&);

} // namespace mpm
