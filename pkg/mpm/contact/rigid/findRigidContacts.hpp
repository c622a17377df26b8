// SPDX-License-Identifier: GPL-2.0-or-later
// Which points of the scene overlap with rigid bodies, and what they were in the step before.
#pragma once

#include "mpm/contact/rigid/BodyPoints.hpp"
#include "mpm/contact/rigid/BoxSurface.hpp"
#include "mpm/contact/rigid/RigidContactPoint.hpp"

namespace mpm {

// Points that overlap or nearly do, sorted. Of the contacts of a pair that look the same way only the deepest
// counts (flush boxes of a clump, neighbouring facets), and none at an edge that is hidden in the surface of a
// shape which is touched more deeply.
class NearContacts {
  public:
    // points: of each body of the scene.
    template <int Dim>
    void find(const Scene<Dim>& scene, const std::vector<BodyPoints<Dim>>& points,
              const std::vector<RigidShape>& shapes, const std::vector<RigidState>& states,
              std::vector<RigidContactPoint>& contacts);

  private:
    // Sorted instead of contacts, which are ten times as large.
    struct Key {
        int soil;
        int64_t id;
        int body;
        double gap;
        int shape, place; // place: of the point in its body
        bool operator<(const Key& other) const {
            return std::tie(soil, id, body, gap, shape) <
                   std::tie(other.soil, other.id, other.body, other.gap, other.shape);
        }
    };
    struct Found {
        Key key;
        Vec3 normal, point, edge;
    };
    // A contact of found_, with the body and the id of its point in one number: most contacts differ in that.
    struct Place {
        uint64_t point;
        int found;
    };
    std::vector<Found> found_; // these two only keep their memory from step to step
    std::vector<Place> order_;

    void keep(const std::vector<RigidShape>& shapes, std::vector<RigidContactPoint>& contacts);
};

// Stretch, slip and last place of contacts that were there in the step before; the slip turns with the
// normal. Both are sorted.
void remember(std::vector<RigidContactPoint>& contacts, const std::vector<RigidContactPoint>& before);

// The halves of a box that was cut press as it did: with its slip, half of its force, and its surface in place.
template <int Dim>
void cutHistory(const Scene<Dim>& scene, const std::vector<BodyPoints<Dim>>& points,
                std::vector<RigidContactPoint>& history);

// Boxes keep the forces of their springs where these become softer by a factor, of each rigid body (none: 1),
// for what is lighter has come into the scene: what rests elsewhere would drop.
template <int Dim>
void keepForces(const std::vector<BodyPoints<Dim>>& points, const std::vector<double>& softer,
                std::vector<RigidContactPoint>& contacts);

// How much a spring gives way under 1 kPa: along the normal and across it. Zero: there are none.
struct Softness {
    double normal = 0, shear = 0; // m/kPa
};

// Boxes that are new are as thick as fits, so that they start without overlap: both halves of one that was cut
// before it was in touch, pieces of a mesh, and boxes of a new body on ground, which its region was cut to, or
// flush with any shape. The latter start with the overlap and the slip that hold the stress they were given:
// what lies in equilibrium does not drop. known: particles of each body in the step before. softness: of each
// rigid body.
template <int Dim>
void fitNewBoxes(const Scene<Dim>& scene, const std::vector<BodyPoints<Dim>>& points,
                 const std::vector<RigidShape>& shapes, const std::vector<int>& known,
                 const std::vector<Softness>& softness, std::vector<RigidContactPoint>& contacts);

// Whether the strain may have moved a point so far that it is in touch.
template <int Dim> bool mayTouch(const Scene<Dim>& scene, const RigidContactPoint& contact) {
    return contact.isKnown || contact.gap < BodyPoints<Dim>::mostShift * scene.grid.smallestCell().minCoeff();
}

// The gap where the strain has moved a point, and the surface of a box that is in touch (box: its nodes). The first
// thickness of a box comes back when it is clear with it.
template <int Dim>
void followStrain(const Scene<Dim>& scene, const BodyPoints<Dim>& points, MappedVelocities<Dim>& velocities,
                  const BoxNodes<Dim>* box, RigidContactPoint& contact);

} // namespace mpm
