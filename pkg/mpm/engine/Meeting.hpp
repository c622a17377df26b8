// SPDX-License-Identifier: GPL-2.0-or-later
// The nodes on which groups of bodies meet, and how their surfaces lie there: normal, gap, area. See Meeting.cpp.
#pragma once

#include "mpm/engine/BoundaryFacets.hpp"
#include "mpm/scene/Scene.hpp"

namespace mpm {

// v over its size; zero where that is not above `least`.
template <int Dim> Vec<Dim> unit(const Vec<Dim>& v, double least) {
    const double size = v.norm();
    return size > least && size > 0 ? Vec<Dim>(v / size) : Vec<Dim>(Vec<Dim>::Zero());
}

// The surface of a group as one node sees it, weighted with the node's hat function phi; n points out, d runs from the node.
template <int Dim> struct FaceSeen {
    Vec<Dim> outward = Vec<Dim>::Zero(); // m2 (2D: m), int phi n dA
    Mat<Dim> moment = Mat<Dim>::Zero();  // m3, int phi d n^T dA
    double intruded = -1e300;            // m, reach of the boxes that have crossed into a mesh
    // Of meshes only:
    double extent = 0;                   // m2, int phi dA
    double nearest = 1e300, reach = 0;   // m2, m: squared distance from the normal of the nearest vertex, and its reach
};

// On the second group, kN s: all that the nodes take, and the part of it that only makes the velocities of the start agree.
template <int Dim> struct Impulses {
    Vec<Dim> all = Vec<Dim>::Zero(), agreeing = Vec<Dim>::Zero();
    bool sticks = false;
};

// Where surfaces of two groups face each other.
template <int Dim> struct Site {
    Vec<Dim> normal = Vec<Dim>::Zero(); // from the first group to the second; zero: not known
    double gap = 0, area = 0;           // m; m2, of the smaller surface along the normal
    double tolerated = 0;               // m, overlap that does not count
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

// The nodes round a point: their numbers among the meets, -1 where it is none, and their hat functions.
template <int Dim> struct NodesRound {
    static constexpr int size = 1 << Dim;
    int meet[size];
    double S[size];
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
    struct Vertex { // at the boundary of a mesh, near a meet; or the middle of a facet of an outline, or one of its corners
        int node;   // the nearest
        Vec<Dim> position, outward; // area vector of its share of the facets, from
        double size, extent;        // its size, and the area of the share
        NodesRound<Dim> round;
    };
    struct Boundary { // of a body with an explicit surface: a mesh, or boxes with an outline
        BoundaryFacets<Dim> facets;
        std::vector<int> vertices;
        std::vector<int> facetsAt, firstAt; // numbers of the facets at each vertex, one vertex after the other; where they begin
        std::vector<Vertex> near;           // of the vertices, or of the facets of the outline,
        std::vector<Vertex> parts;          // and the corners of these
        std::vector<int> place;             // of each vertex in `near`, -1: not there
        int particles = -1;                 // when it was found
        void find(Body<Dim>& body);
    };
    struct Boxes { // near meets, by their nearest node
        std::vector<double> centre[Dim], half[Dim], density; // m; cells; volume, m3, over that of the box in cells
        std::vector<int> start;                              // of the boxes of each near node
    };
    struct Box { // one of them
        Vec<Dim> centre, half;
        double density;
        int near; // number of the nearest node
    };
    long step_ = -1;
    std::vector<Boundary> boundaries_; // per body
    Boxes boxes_[2];                   // of either group
    std::vector<Box> found_;           // of one group, in the order of the particles
    std::vector<const Vertex*> skins_[2]; // vertices of either group at no edge, by their nearest node
    std::vector<bool> isExplicit_;     // groups whose surface is explicit altogether
    std::vector<bool> hasOutline_;     // groups with boxes that carry an outline
    std::vector<int> slot_;            // of each node in `meets`, -1: none; of one pair of groups at a time
    std::vector<int> near_;            // number of each node that is, or is next to, one of these; -1: it is not
    std::vector<int> nearNodes_;       // by their number, which grows with that of the node
    Vec<Dim> lower_, upper_;           // of a box that holds all that is near

    bool findNodes(const Scene<Dim>& scene, int a, int b);
    void findSurfaces(const Scene<Dim>& scene, int side, int field, size_t first);
    void findBoxes(const Scene<Dim>& scene, int side, int field);
    // f(begin, end) for the boxes whose nearest node is that of the meet, or next to it.
    template <class F> void forBoxes(const Grid<Dim>& grid, const Meet<Dim>& meet, const Boxes& boxes, F&& f) const;
    void addBoxes(const Grid<Dim>& grid, Meet<Dim>& meet, int side) const;
    void findVertices(Body<Dim>& body, Boundary& boundary, const Grid<Dim>& grid);
    void findFacets(const Body<Dim>& body, Boundary& boundary, const Grid<Dim>& grid);
    bool isNear(const Grid<Dim>& grid, const Vec<Dim>& x) const;
    void addFacets(const std::vector<Vertex>& vertices, int side);
    void findNormals(const Grid<Dim>& grid, size_t first);
    void findNormalsByMass(const Grid<Dim>& grid, size_t first);
    void straighten(const Grid<Dim>& grid, size_t first);
    void turnAtEdges(const Scene<Dim>& scene, int side, int field, size_t first);
    void findFaces(const Scene<Dim>& scene, int side, int field);
    void findIntruders(const Grid<Dim>& grid, int side, int field, int other, size_t first);
    void findGaps(const Grid<Dim>& grid, size_t first);
    void findTouches(const Scene<Dim>& scene, int a, int b);
    static bool isExplicit(const Body<Dim>& body) { return body.type->isMeshed() || body.domains->outline(); }
    // f(body, boundary) for those bodies of a group that have one, not for bodies that take what these convert.
    template <class F> void forBoundaries(const Scene<Dim>& scene, int field, F&& f) const {
        for (size_t b = 0; b < scene.bodies.size(); ++b)
            if (Body<Dim>& body = *scene.bodies[b]; body.velocityField == field && isExplicit(body)) f(body, boundaries_[b]);
    }
    // f(vertex, area vector of its share of a facet).
    template <class F> static void forShares(Body<Dim>& body, const Boundary& boundary, F&& f);
    NodesRound<Dim> nodesRound(const Grid<Dim>& grid, const Vec<Dim>& x) const;
    void findSkin(const Scene<Dim>& scene, int side, int field);
    double distanceOfBoxes(const Grid<Dim>& grid, const Vertex& own, int side) const;
    double distanceOfMesh(const Grid<Dim>& grid, const Vertex& own, int side, Vec<Dim>& normal) const;
    void borrow(const Grid<Dim>& grid, size_t first);
    void forget(size_t first);
};

} // namespace mpm
