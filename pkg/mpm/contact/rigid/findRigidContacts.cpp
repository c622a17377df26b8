// SPDX-License-Identifier: GPL-2.0-or-later
#include "mpm/contact/rigid/findRigidContacts.hpp"

namespace mpm {

namespace {

// Overlap, in cells, up to which there is none: a body that touches flat ground gets no force from round-off.
constexpr double roundOff = 1e-12;
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
template <int Dim> Vec3 toStrainedPlace(const Scene<Dim>& scene, const Body<Dim>& soil, int p) {
    using NF = NodalField<Dim>;
    Vec3 straining = Vec3::Zero(), own = Vec3::Zero();
    if (soil.type->isMeshed() || !scene.scheme->remaps) return own;
    const auto& field = scene.grid.fields[soil.velocityField];
    const double least = scene.leastMass();
    soil.domains->weights(p, [&](int node, double phi, const Vec<Dim>&) {
        const auto& sum = field.sum[node];
        if (sum[NF::mass] <= least) return;
        for (int k = 0; k < Dim; ++k) {
            const double v = NF::velocityAtStart(sum, k);
            const int c = field.holder[node][k];
            straining[k] += phi * (c < 0 ? v : scene.heldAtStart(c, k, v));
        }
    });
    for (int k = 0; k < Dim; ++k) own[k] = soil.particles.velocity.plane(k)[p];
    return scene.dt * (straining - own);
}

} // namespace

template <int Dim>
std::vector<RigidContactPoint>
findNearContacts(const Scene<Dim>& scene, const std::vector<BodyPoints<Dim>>& points,
                 const std::vector<RigidShape>& shapes, const std::vector<RigidState>& states) {
    const double near = BodyPoints<Dim>::mostShift * scene.grid.smallestCell().minCoeff();
    std::vector<RigidContactPoint> contacts;
    for (const RigidShape& shape : shapes) {
        const RigidState& at = states[shape.body];
        const Mat<3> R = at.orientation.toRotationMatrix();
        for (int soil = 0; soil < int(points.size()); ++soil)
            points[soil].near(shape, at, scene.grid, [&](int i) {
                const Vec3 x = points[soil].position(i);
                const Vec3 local = R.transpose() * (x - at.position);
                double gap = -std::numeric_limits<double>::max();
                Vec3 n;
                shape.directions(local, [&](const Surface& s) {
                    const Vec3 normal = R * s.normal;
                    const double clear = s.distance - points[soil].halfAlong(normal);
                    if (clear <= gap) return;
                    gap = clear;
                    n = normal;
                });
                const double half = points[soil].halfAlong(n);
                if (gap >= near + BodyPoints<Dim>::mostStretch * half) return;
                gap -= half * (points[soil].stretch(i, n).factor - 1);
                if (gap >= near) return;
                const Surface s = shape.nearest(local);
                RigidContactPoint contact;
                contact.soil = soil;
                contact.body = shape.body;
                contact.id = points[soil].id(i);
                contact.normal = n;
                contact.point = x;
                contact.gap = gap;
                contact.place = i;
                contact.shape = int(&shape - shapes.data());
                contact.edge = local - s.distance * s.normal;
                contacts.push_back(contact);
            });
    }
    return contacts;
}

template <int Dim>
void moveToStrainedPlaces(const Scene<Dim>& scene, std::vector<RigidContactPoint>& contacts) {
    const double least = roundOff * scene.grid.smallestCell().minCoeff();
    for (RigidContactPoint& c : contacts) {
        const Vec3 shift = toStrainedPlace(scene, *scene.bodies[c.soil], c.place);
        c.point += shift;
        c.gap += c.normal.dot(shift);
    }
    const auto isOpen = [&](const RigidContactPoint& c) { return c.gap >= -least; };
    contacts.erase(std::remove_if(contacts.begin(), contacts.end(), isOpen), contacts.end());
}

void dropRepeats(std::vector<RigidContactPoint>& contacts, const std::vector<RigidShape>& shapes) {
    std::vector<const RigidContactPoint*> sorted; // a contact is too large to be sorted itself
    for (const RigidContactPoint& c : contacts) sorted.push_back(&c);
    std::sort(sorted.begin(), sorted.end(), [](const RigidContactPoint* a, const RigidContactPoint* b) {
        const auto key = [](const RigidContactPoint* c) {
            return std::tuple_cat(c->pair(), std::tie(c->gap, c->shape));
        };
        return key(a) < key(b);
    });
    std::vector<RigidContactPoint> kept;
    kept.reserve(contacts.size());
    for (const RigidContactPoint* c : sorted) {
        bool isRepeat = false;
        for (size_t k = kept.size(); k-- > 0 && kept[k].pair() == c->pair();)
            isRepeat |= kept[k].normal.dot(c->normal) > sameSide ||
                        shapes[kept[k].shape].nearest(c->edge).distance < -kept[k].gap;
        if (!isRepeat) kept.push_back(*c);
    }
    contacts.swap(kept);
}

void remember(std::vector<RigidContactPoint>& contacts, const std::vector<RigidContactPoint>& before) {
    auto old = before.begin();
    for (RigidContactPoint& c : contacts) {
        while (old != before.end() && old->pair() < c.pair()) ++old;
        double nearest = sameSide;
        for (auto same = old; same != before.end() && same->pair() == c.pair(); ++same) {
            if (same->normal.dot(c.normal) <= nearest) continue;
            nearest = same->normal.dot(c.normal);
            c.slip = turned(same->slip, same->normal, c.normal);
            c.pointBefore = same->point;
            c.forceBefore = same->force;
            c.gapBefore = same->gap;
        }
    }
}

template std::vector<RigidContactPoint> findNearContacts(const Scene<2>&, const std::vector<BodyPoints<2>>&,
                                                         const std::vector<RigidShape>&,
                                                         const std::vector<RigidState>&);
template std::vector<RigidContactPoint> findNearContacts(const Scene<3>&, const std::vector<BodyPoints<3>>&,
                                                         const std::vector<RigidShape>&,
                                                         const std::vector<RigidState>&);
template void moveToStrainedPlaces(const Scene<2>&, std::vector<RigidContactPoint>&);
template void moveToStrainedPlaces(const Scene<3>&, std::vector<RigidContactPoint>&);

} // namespace mpm
