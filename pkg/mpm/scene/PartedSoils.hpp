// SPDX-License-Identifier: GPL-2.0-or-later
// Soil on both sides of a wall thinner than two cells. One velocity field cannot move the soil in front of the wall and
// leave that behind it: there are nodes that both sides reach. So the soil has two fields. They are one, their sums added,
// on all nodes but those where a wall stands between the two.
//
// A particle that reaches a node on which the soil is two has a side, by the middle plane of the wall, and keeps it for as
// long as it reaches one. It moves with the field of its side; all others move with the first field.
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

    // The walls that part soils, before a run. The second fields come after those of all groups.
    void find(Scene<Dim>& scene);
    bool isEmpty() const { return walls_.empty(); }
    const std::vector<Wall>& walls() const { return walls_; }

    // Of a field of soil: its other one, -1: it has none.
    int partnerOf(int field) const {
        const Soil* soil = soilOf(field);
        return soil ? soil->first + soil->second - field : -1;
    }
    // Whether it is no second field.
    bool isFirst(int field) const {
        const Soil* soil = soilOf(field);
        return !soil || soil->first == field;
    }
    // Whether the fields of a soil are one on a node.
    bool isBonded(int field, int node) const {
        const Soil* soil = soilOf(field);
        return soil && !soil->parts[node];
    }
    // How facets of a body that a soil does not see look, times their cosine with this; zero: it sees them all.
    Vec<Dim> hiddenFrom(int field, int body) const {
        for (const Wall& wall : walls_)
            if (wall.body == body && soilOf(field) == soilOf(wall.soil))
                return field == wall.front ? Vec<Dim>(-wall.normal) : wall.normal;
        return Vec<Dim>::Zero();
    }
    // The cells of the second side, for F-bar.
    SecondCells secondCells(const Body<Dim>& body) const {
        const Soil* soil = soilOf(body.velocityField);
        if (!soil || body.domains->boxes()->seconds().empty()) return {};
        return {body.domains->boxes()->seconds().data(), soil->isParted.data()};
    }

    // All on one thread. Once the particles are located: which nodes part, and which particles move with the second field.
    // mayDecide: whether particles keep the sides that are found; in a step they do.
    void divide(Scene<Dim>& scene, bool mayDecide);
    // What part of the grid the second fields touch, then.
    void markExtents(Scene<Dim>& scene) const;
    // Once the nodes have all that the particles and loads give: the first field takes the sums.
    void bond(Scene<Dim>& scene);
    // f(first field, second field, node) for the nodes where it has taken some.
    template <class F> void forBonded(F&& f) const {
        for (const Soil& soil : soils_)
            for (int node : soil.nodes) f(soil.first, soil.second, node);
    }
    // The second field moves with it.
    void tellMotion(Scene<Dim>& scene) const;
    // The same for momenta made anew, and for the velocities that follow from them.
    void bondMomenta(Scene<Dim>& scene) const;
    void tellVelocity(Scene<Dim>& scene) const;

  private:
    struct Soil {
        int first, second;          // fields
        std::vector<int> nodes;     // that the first field has taken the sums of
        std::vector<int> parting;   // nodes with a wall between the fields,
        std::vector<char> parts;    // each node;
        std::vector<char> isParted; // each cell, whether it has a corner on one of these
        std::vector<int> near;      // lowest nodes of supports that reach one,
        std::vector<short> wallAt;  // and each node: number + 1 of its wall; 0: it is none
    };
    std::vector<Wall> walls_;
    std::vector<Soil> soils_;

    const Soil* soilOf(int field) const {
        for (const Soil& soil : soils_)
            if (field == soil.first || field == soil.second) return &soil;
        return nullptr;
    }
    void place(const Scene<Dim>& scene, Wall& wall) const;
    bool isWall(const Scene<Dim>& scene, const Wall& wall) const;
    void findOf(Scene<Dim>& scene, int soil);
    void findParting(const Scene<Dim>& scene, Soil& soil) const;
    void addParting(const Grid<Dim>& grid, Soil& soil, int wall, int node) const;
};

} // namespace mpm
