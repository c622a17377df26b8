// SPDX-License-Identifier: GPL-2.0-or-later
// Where two groups of bodies are in contact: on nodes that both move, and at vertices of meshes between such
// nodes.
#pragma once

#include "mpm/contact/NearbyNodes.hpp"

namespace mpm {

// v over its size; zero where that is not above `least`.
template <int Dim> Vec<Dim> unit(const Vec<Dim>& v, double least) {
    const double size = v.norm();
    return size > least && size > 0 ? Vec<Dim>(v / size) : Vec<Dim>(Vec<Dim>::Zero());
}

// On the second group, kN s: all that the nodes take, and the part of it that only makes the velocities of
// the start agree.
template <int Dim> struct Impulses {
    Vec<Dim> all = Vec<Dim>::Zero(), agreeing = Vec<Dim>::Zero();
    bool sticks = false;
    bool parts = false; // surfaces do, though all that shared cells press them together with holds them

    void scale(double factor) {
        all *= factor;
        agreeing *= factor;
    }
};

// Where surfaces of two groups face each other.
template <int Dim> struct ContactSite {
    Vec<Dim> normal = Vec<Dim>::Zero();   // from the first group to the second; zero: not known
    double gap = 0, area = 0;             // m; m2, of the smaller surface along the normal
    double tolerated = 0;                 // m, overlap that does not count
    double carried = 0;                   // kN, force that shared cells press the surfaces together with
    bool presses = false, sticks = false; // in this step,
    bool parts = false;                   // see Impulses
    Impulses<Dim> J;
};

// A node that two groups move.
template <int Dim> struct ContactNode : ContactSite<Dim> {
    int node, field[2];
    Vec<Dim> position;
    NodalSurface<Dim> surface[2];
    NodalSurface<Dim> sides[2]; // what of it boxes on each side of a wall have where a soil is one
    int edgeOf = -1;            // which of the two has an edge here that the normal is taken from,
    double sharpness = 0;       // and how much of one, up to 1
    double shareOfBoxes = 0;    // of the normal, where the other group is a mesh
    double overlap = 0;         // m, of the surfaces, away from edges of meshes
    double weight = 0;          // m2, of the surface that normal and gap rest on
    double owned = 0;           // m2, of the surface of a mesh here, by contact points,
    double gapOfPoints = 0;     // m3, their gaps times what they own,
    double scaleOfOwned = 1;    // and what they have of the surface where they do all, over what they own
    double areaOfPoints = 0;    // m2, for which they stand here: their impulses are on it
    bool hasPoints = false;     // contact points, which tell better how far the surfaces overlap
    bool isLeftOut = false;     // contact points do all that it would
    int twin[2] = {-1, -1};     // number of the contact node on which a side meets another field; -1: none
    bool acts = false, slides = false, touches = false; // with what it shares with contact points
    // kN s, what the first group loses and the second gets in this step, and what of it is friction.
    Vec<Dim> impulse[2] = {Vec<Dim>::Zero(), Vec<Dim>::Zero()}, friction[2] = {impulse[0], impulse[1]};

    // Of the surface of a side, along the normal, m2.
    double areaOf(int side) const {
        return (side == 0 ? 1 : -1) * surface[side].outward.dot(ContactSite<Dim>::normal);
    }
};

// Numbers of contact nodes, and for each group the weights with which they move its surface at a site.
template <int Dim> struct SiteNodes {
    int count;
    const int* at;
    const double* S[2];
};

// A vertex of a mesh at the surface of the other group, between nodes that both move. Each group has the hat functions
// where its own surface is: nodes that a surface hardly reaches are light, and at the vertex they would take any
// velocity and nothing would be held.
template <int Dim> struct ContactPoint : ContactSite<Dim>, SurroundingNodes<Dim> {
    int side = 0, body = -1, vertex = -1; // the group whose mesh it belongs to, that body, and its vertex
    Vec<Dim> position = Vec<Dim>::Zero();
    double otherS[SurroundingNodes<Dim>::size]; // of the other group

    // Which of several at an edge it is: the axis that it looks most along, 1 to 3, or down it.
    int face() const {
        int axis;
        const Vec<Dim>& n = ContactSite<Dim>::normal;
        n.cwiseAbs().maxCoeff(&axis);
        return n[axis] > 0 ? axis + 1 : -axis - 1;
    }
    SiteNodes<Dim> sites() const {
        return {this->size, this->contact, {side == 0 ? this->S : otherS, side == 0 ? otherS : this->S}};
    }
};

// What is told of a contact node after a step.
struct ContactRecord {
    int first = 0, second = 0;  // numbers of the groups
    Vec3 node = Vec3::Zero();   // m
    Vec3 normal = Vec3::Zero(); // from the first to the second
    double gap = 0, area = 0;   // m; m2 (2D: m)
    Vec3 force = Vec3::Zero();  // kN, on the second group
    Vec3 slip = Vec3::Zero();   // m/s, rate of the first against the second

    template <class Self, class Visit> static void members(Self& row, Visit&& visit) {
        visit("first", "", row.first);
        visit("second", "", row.second);
        visit("node", "m", row.node);
        visit("normal", "-", row.normal);
        visit("gap", "m", row.gap);
        visit("area", "m2", row.area);
        visit("force", "kN", row.force);
        visit("slip", "m/s", row.slip);
    }
};

// Contact nodes and points of one pair of groups: from first to one before end.
template <int Dim> struct ContactPair {
    size_t firstNode, endNode, firstPoint, endPoint;
    bool ownsFacets; // see OwnedFacets
    int group[2];
    Vec<Dim> motionOfEdges[2]; // of one group against the other, m/s, in the mean over the nodes;
    bool hasEdges[2];          // whether there are any
    double negligible = 0;     // what a round may change beside an implicit body in velocities made anew, kJ
};

// Numbers of pairs of groups a < b that stay when there are more groups.
inline size_t pairOf(int a, int b) { return size_t(b) * (b - 1) / 2 + a; }

} // namespace mpm
