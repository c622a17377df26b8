// SPDX-License-Identifier: GPL-2.0-or-later
// The nodes on which groups of bodies meet, and how their surfaces lie there: normal, gap, area. See Meeting.cpp.
#pragma once

#include "mpm/contact/NearBoxes.hpp"

namespace mpm {

// v over its size; zero where that is not above `least`.
template <int Dim> Vec<Dim> unit(const Vec<Dim>& v, double least) {
    const double size = v.norm();
    return size > least && size > 0 ? Vec<Dim>(v / size) : Vec<Dim>(Vec<Dim>::Zero());
}

// On the second group, kN s: all that the nodes take, and the part of it that only makes the velocities of the start agree.
template <int Dim> struct Impulses {
    Vec<Dim> all = Vec<Dim>::Zero(), agreeing = Vec<Dim>::Zero();
    bool sticks = false;
};

// Where surfaces of two groups face each other.
template <int Dim> struct Site {
    Vec<Dim> normal = Vec<Dim>::Zero();   // from the first group to the second; zero: not known
    double gap = 0, area = 0;             // m; m2, of the smaller surface along the normal
    double tolerated = 0;                 // m, overlap that does not count
    bool presses = false, sticks = false; // in this step
    Impulses<Dim> J;
};

// A node that two groups move.
template <int Dim> struct Meet : Site<Dim> {
    int node, field[2];
    Vec<Dim> position;
    FaceSeen<Dim> surface[2];
    int edgeOf = -1;                      // which of the two has an edge here that the normal is taken from
    double weight = 0;                    // m2, of the surface that normal and gap rest on
    bool hasTouches = false;              // which tell better how far the surfaces overlap
    bool acts = false, slides = false;    // with what it shares with touches
    Vec<Dim> impulse = Vec<Dim>::Zero();  // kN s, on the second group in this step,
    Vec<Dim> friction = Vec<Dim>::Zero(); // and what of it is friction
};

// A vertex of a mesh at the surface of the other group, between nodes that both move.
template <int Dim> struct Touch : Site<Dim>, NodesRound<Dim> {};

// Meets and touches of one pair of groups.
struct Stretch {
    size_t meet, lastMeet, touch, lastTouch;
};

// Where groups meet, found once per step.
template <int Dim> class Meeting {
  public:
    std::vector<Meet<Dim>> meets;
    std::vector<Touch<Dim>> touches;
    std::vector<Stretch> pairs;

    void prepare(const Scene<Dim>& scene);
    // normalsByMass: from the gradient of the nodal mass instead of the surfaces.
    void find(const Scene<Dim>& scene, bool normalsByMass);
    bool isFound(const Scene<Dim>& scene) const { return step_ == scene.step; }

  private:
    using Vertex = typename ExplicitSurface<Dim>::Vertex;
    long step_ = -1;
    Neighbourhood<Dim> neighbourhood_;           // of one pair of groups at a time, as what follows:
    NearBoxes<Dim> boxes_[2];                    // of either group
    std::vector<const Vertex*> skins_[2];        // vertices of either group at no edge, by their nearest node
    std::vector<ExplicitSurface<Dim>> surfaces_; // per body
    std::vector<bool> isExplicit_;               // groups whose surface is explicit altogether
    std::vector<bool> hasOutline_;               // groups with boxes that carry an outline

    // What groups a and b share, in this order; side: 0 for a, 1 for b; field: the number of that group; first: of their meets.
    bool findNodes(const Scene<Dim>& scene, int a, int b);
    void findSurfaces(const Scene<Dim>& scene, int side, int field, size_t first);
    void findNormals(const Grid<Dim>& grid, size_t first);
    void findNormalsByMass(const Grid<Dim>& grid, size_t first);
    void turnAtEdges(const Scene<Dim>& scene, int side, int field, size_t first);
    void straighten(const Grid<Dim>& grid, size_t first);
    void findFaces(const Scene<Dim>& scene, int side, int field);
    void findIntruders(const Grid<Dim>& grid, int side, int field, int other, size_t first);
    void findGaps(const Grid<Dim>& grid, size_t first);
    void borrow(const Grid<Dim>& grid, size_t first);
    void findTouches(const Scene<Dim>& scene, int a, int b);

    void addParts(const std::vector<Vertex>& vertices, int side);
    void findSkin(const Scene<Dim>& scene, int side, int field);
    double distanceOfBoxes(const Grid<Dim>& grid, const Vertex& own, int side) const;
    double distanceOfMesh(const Grid<Dim>& grid, const Vertex& own, int side, Vec<Dim>& normal) const;
    // f(body, surface) for those bodies of a group that have an explicit one, not for bodies that take what these convert.
    template <class F> void forSurfaces(const Scene<Dim>& scene, int field, F&& f) {
        for (size_t b = 0; b < scene.bodies.size(); ++b)
            if (Body<Dim>& body = *scene.bodies[b];
                body.velocityField == field && ExplicitSurface<Dim>::isOf(body))
                f(body, surfaces_[b]);
    }
};

} // namespace mpm
