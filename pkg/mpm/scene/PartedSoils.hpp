// SPDX-License-Identifier: GPL-2.0-or-later
// Soil on both sides of a wall thinner than two cells. One velocity field cannot move the soil in front of the wall and
// leave that behind it: there are nodes that both sides reach. So the bodies on either side get a field each. The fields
// are one, their sums added, on all nodes but those where a wall stands between them.
//
// The bodies tell the sides: each of them lies on one side of the middle plane of each wall.
#pragma once

#include "mpm/scene/Body.hpp"

#include <string>
#include <vector>

namespace mpm {

template <int Dim> class Scene;

template <int Dim> class PartedSoils {
  public:
    struct Wall {
        int body, soil; // its number in the scene; the group that it parts
        int front;      // field of the soil that the normal points to
        Vec<Dim> normal, middle;
        int across = 0;        // axis of the grid that the normal is nearest to
        Vec<Dim> lower, upper; // between which it parts the soil now
    };

    // The walls that part soils, before a run. Bodies have the numbers of their groups for velocity fields, and those in
    // front of an odd number of walls get a field of their own.
    void find(Scene<Dim>& scene);
    bool isEmpty() const { return walls_.empty(); }
    const std::vector<Wall>& walls() const { return walls_; }

    // Of a field of soil: its other one, -1: it has none.
    int partnerOf(int field) const {
        for (const Soil& soil : soils_)
            if (field == soil.first || field == soil.second) return soil.first + soil.second - field;
        return -1;
    }
    // Whether the fields of a soil are one on a node.
    bool isBonded(int field, int node) const {
        for (const Soil& soil : soils_)
            if (field == soil.first || field == soil.second) return soil.isBonded[node];
        return false;
    }
    // How facets of a body that a soil does not see look, times their cosine with this; zero: it sees them all.
    Vec<Dim> hiddenFrom(int field, int body) const {
        for (const Wall& wall : walls_)
            if (wall.body == body && partnerOf(field) >= 0 &&
                (field == wall.front || partnerOf(field) == wall.front))
                return field == wall.front ? Vec<Dim>(-wall.normal) : wall.normal;
        return Vec<Dim>::Zero();
    }

    // All on one thread. Once the nodes have all that the particles and loads give: the first field takes the sums.
    void bond(Scene<Dim>& scene);
    // The second field moves with it.
    void tellMotion(Scene<Dim>& scene) const;
    // The same for momenta made anew, and for the velocities that follow from them.
    void bondMomenta(Scene<Dim>& scene) const;
    void tellVelocity(Scene<Dim>& scene) const;

  private:
    struct Soil {
        int first, second;      // fields
        std::vector<int> nodes; // that are bonded,
        std::vector<char> isBonded;
    };
    std::vector<Wall> walls_;
    std::vector<Soil> soils_;

    void place(const Scene<Dim>& scene, Wall& wall) const;
    bool isWall(const Scene<Dim>& scene, const Wall& wall) const;
    bool findOf(Scene<Dim>& scene, int soil);
    bool parts(const Scene<Dim>& scene, const Soil& soil, int node) const;
};

} // namespace mpm
