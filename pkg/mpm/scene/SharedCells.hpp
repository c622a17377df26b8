// SPDX-License-Identifier: GPL-2.0-or-later
// Cells of the grid that soil (boxes with F-bar, and meshes bonded to them) shares with a body that has a velocity of its own (a mesh in another
// group). Together they fill these cells, so whatever they slip, what flows through the faces is
//     div u = 0,   u_i = sum_g V_ig v_ig / sum_g V_ig,   V_ig: volume of group g at node i,
// but for what soil and body give way. The flux of u out of a shared cell, less what the body in it takes, is taken by
// the cells with soil in it and beside it, its takers; the pressure of the takers acts on the nodes of both groups by the
// conjugate. So a pressure that is the same everywhere, in the body, too, exerts no force. Particles of soil alone would
// not feel what a moving surface pushes into their cell (doc/theory/volumes.md).
//
// A taker is closed while its soil and the body fill the space and press on each other, else open: a gap, or a free
// surface near the body. An open one goes as if there were no other group. One that was closed knows its gap while that
// is small, and closes when it is used up; any one where surfaces meet and the cell is full.
//
// Where a wall parts the soil (SidesOfCells) a cell counts for each of its fields. For the soil of one side what lies
// beyond the wall is a part of the wall: with v_w the velocity of the solids and the part c of the cell on that side of
// the middle of the wall, its corners move by
//     u_i = l_i (v_i - v_w) + c v_w,   l_i = V_i / sum_g V_ig,
// on nodes where the soil is two, by c u_i where it is one, and the solids before that middle count. Both sides add up to
// the flux of all; soil of one side feels the pressure of that side, and the wall the difference.
#pragma once

#include "mpm/scene/Body.hpp"
#include "mpm/scene/SidesOfCells.hpp"

#include <map>

namespace mpm {

template <int Dim> class Scene;

template <int Dim> class SharedCells {
  public:
    bool isWanted = false; // by the engine for contact

    // Shared cells as the particles lie now, where they are not known in this step: when the nodes have the masses of
    // all bodies but those that act by cells (`actsByCells`), and the cells of these their mean stresses.
    void find(const Scene<Dim>& scene);
    // When the nodes have the masses of these, too.
    void takeVolumes(const Scene<Dim>& scene);
    // What the critical step of the soil and the bodies by themselves is to be multiplied with: the pressure of the
    // soil, with its stiffness, acts on the nodes of bodies that may be lighter.
    double stepFactor(const Scene<Dim>& scene);
    // Forgets all but which takers were closed and open.
    void clear();

    // Mean stress times volume that a closed taker bears for a body.
    void act(int taker, double stressVolume) { takers_.at(taker).acting += stressVolume; }
    // Adds the forces of what the takers bear to the nodes. One thread.
    void addForces(Scene<Dim>& scene);
    // Rate of volume change of a soil in an open taker, 1/s, where it would be `own` without the other group, and
    // `closed` if the taker were closed: a known gap opens by the difference, and what is left of it in a step is all
    // that the soil may take. volume: of the taker, what is this soil's.
    double openRate(int taker, double volume, double dt, double own, double closed) {
        Gap& gap = gaps_.at(taker);
        if (gap.is != Gap::Is::open) return own; // not known, or surfaces have met in this step
        const double part = volume / takers_.at(taker).volume;
        const double opened = gap.width + part * dt * (closed - own);
        if (opened <= Gap::usedUp) own = closed + gap.width / (part * dt);
        gap = Gap::after(opened);
        return own;
    }
    // What flows out of the cells in a step. velocityOf(group, node): m/s, while the step strains the bodies. One thread.
    template <class VelocityOf> void takeFluxes(const Scene<Dim>& scene, VelocityOf&& velocityOf);
    // Rate of volume change of the soil in a taker if it is closed, 1/s.
    double rate(int taker) const {
        const Taker& its = takers_.at(taker);
        double sum = 0;
        for (const Part& from : its.from) sum += from.part * givers_[giverAt_[from.cell]].flux;
        return sum / its.volume;
    }

    // Forces that the cells have put on a solid at a node, kN.
    struct Force {
        int soil, solid, node; // groups of the two
        Vec<Dim> force;
    };
    const std::vector<Force>& forces() const { return forces_; }
    // The same, as the sum of each cell: `node` is its number.
    const std::vector<Force>& forcesOfCells() const { return ofCells_; }

    // For the water in the pores of the soil, which flows as its volume changes. The takers of what flows out of a cell,
    // with the part of each; nullptr: it keeps all. Whether a cell takes and is closed; whether a giver is empty and open
    // to the air. The volume of a group at the corners of givers, m3.
    struct Part {
        int cell;
        double part;
    };
    const std::vector<Part>* takersOf(int cell) const {
        return givers_.empty() || giverAt_[cell] < 0 ? nullptr : &givers_[giverAt_[cell]].to;
    }
    bool isClosed(int cell) const {
        const auto found = takers_.find(cell);
        return found != takers_.end() && found->second.isClosed;
    }
    bool isAir(int giver) const { return isAir_[giver]; }
    template <class F> void forVolumes(F&& f) const { // f(node, group, volume)
        for (int node : nodes_)
            for (size_t g = 0; g < volumes_.size(); ++g) f(node, int(g), volumeOf(int(g), node));
    }

    // Takes note that the groups of two fields press on each other at a node. closeTouched() then lets takers close, from
    // the next step on.
    void touch(const int (&fields)[2], int node) {
        const bool isOfSecond = sides_.areAny() && std::max(fields[0], fields[1]) == sides_.second();
        const auto mark = [&](int place) {
            isTouched_[place] = 1;
            touched_.push_back(place);
        };
        if (!isOfSecond) mark(node);
        if (isOfSecond || (sides_.areAny() && sides_.isOne(node))) mark(sides_.place(sides_.second(), node));
    }
    void closeTouched(const Grid<Dim>& grid);

    // The cells of the takers and the gap of each as a number, see Gap::number().
    void store(std::vector<double>& cells, std::vector<double>& gaps) const;
    void restore(const std::vector<double>& cells, const std::vector<double>& gaps);

  private:
    struct Taker {
        std::vector<Part> from; // what it takes of the flux of which cells
        double volume = 0;      // that is open to its soil in these, m3
        double acting = 0;      // mean stress times volume that acts by the cells, kN m
        // How full its corners are, where it is open and pressed: about 1 inside, 0.75 at a flat free surface.
        double filled = 0;
        bool isClosed = false;
    };
    // Between the soil of a taker and the other group, over the volume of the taker: what it opened since it was closed.
    struct Gap {
        // open: by `width`. placed, unknown: nobody knows how far, of takers that were there when the first came, and of
        // later ones or such that opened by more than is kept.
        enum class Is { closed, open, placed, unknown };
        // Less than usedUp is no gap: the soil closes where it is pressed. What opened by more than `kept` is not followed.
        static constexpr double usedUp = 1e-12, kept = 3e-2;
        Is is = Is::unknown;
        double width = 0;

        static Gap after(double opened) {
            return opened > kept ? Gap() : Gap{Is::open, std::max(usedUp, opened)};
        }
        bool isKnown() const { return is == Is::closed || is == Is::open; }
        bool isUsedUp() const { return is == Is::closed || (is == Is::open && width <= usedUp); }
        // In checkpoints and for users: how far it is open, 0: closed, -1: placed, -2: unknown.
        double number() const { return is == Is::placed ? -1 : is == Is::unknown ? -2 : width; }
        static Gap of(double number) {
            if (number > 0) return {Is::open, number};
            return {number == 0 ? Is::closed : number == -1 ? Is::placed : Is::unknown};
        }
    };
    // What the volume of the solids in a cell gains as a node of theirs moves, m2.
    struct Growth {
        int group, node;
        Vec<Dim> slope;
    };
    struct Giver {
        int cell; // its number, see SidesOfCells
        std::vector<Part> to;
        std::vector<Growth> solids;
        double ofSolids = 0; // their volume in the cell, m3
        double flux = 0;     // to its takers in this step, m3/s
        int field = -1;      // of the soil on its side of a wall; -1: it counts as a whole
        double part = 1;     // of its volume, on that side

        void grow(int group, int node, const Vec<Dim>& slope) {
            for (Growth& solid : solids)
                if (solid.node == node && solid.group == group) {
                    solid.slope += slope;
                    return;
                }
            solids.push_back({group, node, slope});
        }
    };

    void findGroups(const Scene<Dim>& scene);
    void findSides(const Scene<Dim>& scene);
    void setVolume(int group, int node, double volume);
    double volumeOf(int group, int node) const { return volumes_[group].empty() ? 0 : volumes_[group][node]; }
    double volumeAt(int node) const; // of all groups
    void findSolids(const Scene<Dim>& scene);
    double openPart(const Grid<Dim>& grid, int number) const;
    void findGivers(const Scene<Dim>& scene);
    void give(const Scene<Dim>& scene, int number);
    double partOf(const Giver& giver, int group, int node) const;
    template <class VelocityOf> Vec<Dim> motion(const Giver& giver, int node, VelocityOf&& velocityOf) const;
    void findGrowths(const Scene<Dim>& scene);
    void addGrowth(const Scene<Dim>& scene, Body<Dim>& body);
    bool isBesideClosed(const Grid<Dim>& grid, int number, const std::map<int, Gap>& gaps) const;
    std::map<int, double> fillings(const Scene<Dim>& scene, const std::vector<int>& numbers);
    void addBoxes(const Scene<Dim>& scene, const std::vector<int>& reach, std::vector<int>& touched);
    void decide(const Scene<Dim>& scene);
    double meanStressIn(const Scene<Dim>& scene, int number) const;
    double coverOfSoils(const Scene<Dim>& scene, int number) const;
    double coverOfAll(const Scene<Dim>& scene, int cell) const;
    void findAir(const Scene<Dim>& scene);
    double fullAround(const Scene<Dim>& scene, int cell, int field);
    double insideOfAll(const Scene<Dim>& scene, int number);
    void tell(const Scene<Dim>& scene, int number, const Taker& taker);
    // What the volume of a cell gains as its corner moves, m2.
    Vec<Dim> slopeOf(const Grid<Dim>& grid, int cell, int corner) const {
        const Vec<Dim> slopes = grid.volumeSlopes(cell, cornerOf(grid, cell, corner), half_),
                       edges = grid.edges(cell);
        Vec<Dim> slope;
        for (int k = 0; k < Dim; ++k)
            slope[k] = grid.volume(cell) / (corners<Dim> / 2 * edges[k]) * cornerSign(corner, k) * slopes[k];
        return slope;
    }

    long step_ = -1, fluxStep_ = -1;
    double half_ = 0;                    // of the edge of the boxes of the first soil along the first axis, m
    double lightness_ = 1;               // of the lightest body, its density over that of the soil; at most 1
    std::vector<char> isSoil_, isSolid_; // of groups
    std::vector<std::vector<double>> volumes_; // of each group at the nodes, m3
    std::vector<int> nodes_;                   // that have any
    std::vector<double> hat_;                  // integrals of the hat functions over the grid, m3
    std::vector<double> scratch_;              // zero
    std::vector<int> near_;                    // cells with a node of a solid
    std::vector<int> touched_;    // places of nodes where groups press on each other in this step
    std::vector<char> isTouched_; // of each place, see SidesOfCells, whether it is one of these
    std::vector<char> isReached_; // of each cell, while fillings are found
    std::vector<int> air_;        // cells near solids that are empty and have a way out through empty ones
    std::vector<char> isAir_;     // of each cell, whether it is one of those
    std::vector<char> isNear_;    // of each cell, whether it is near a solid,
    std::vector<double> solid_;   // and what part of it solids fill, by its corners: smooth as they move
    std::vector<Giver> givers_;
    std::vector<int> giverAt_; // of each number of a cell, -1: none
    SidesOfCells<Dim> sides_;
    std::map<int, Taker> takers_;
    std::map<std::pair<int, int>, double> fullness_; // of cells that were asked for, for a field
    std::map<int, Gap> gaps_;                        // of the takers
    std::vector<Force> forces_, ofCells_;
};

// The velocity u_i of a corner of a giver, m/s.
template <int Dim>
template <class VelocityOf>
Vec<Dim> SharedCells<Dim>::motion(const Giver& giver, int node, VelocityOf&& velocityOf) const {
    Vec<Dim> u = Vec<Dim>::Zero();
    double volume = 0;
    for (size_t g = 0; g < volumes_.size(); ++g) {
        const double V = giver.field < 0 ? volumeOf(int(g), node) : partOf(giver, int(g), node);
        if (V == 0) continue;
        u += V * velocityOf(int(g), node);
        volume += V;
    }
    return giver.field < 0 && volume > 0 ? Vec<Dim>(u / volume) : u;
}

template <int Dim>
template <class VelocityOf>
void SharedCells<Dim>::takeFluxes(const Scene<Dim>& scene, VelocityOf&& velocityOf) {
    if (fluxStep_ == scene.step) return;
    fluxStep_ = scene.step;
    const Grid<Dim>& grid = scene.grid;
    for (Giver& giver : givers_) {
        const int cell = sides_.inGrid(giver.cell);
        const Vec<Dim> edges = grid.edges(cell);
        CornerNumbers<Dim> x; // where the corners go in the step, in cells
        for (int a = 0; a < corners<Dim>; ++a) {
            const Vec<Dim> u = motion(giver, cornerOf(grid, cell, a), velocityOf);
            for (int k = 0; k < Dim; ++k) x[k][a] = 0.5 * cornerSign(a, k) + scene.dt * u[k] / edges[k];
        }
        giver.flux = (CellAverage<Dim>::grown(grid, cell, x, half_) - 1) * grid.volume(cell) / scene.dt;
        if (giver.ofSolids == 0) continue;
        Mat<Dim> L = Mat<Dim>::Zero();
        for (const Growth& solid : giver.solids)
            L += velocityOf(solid.group, solid.node) * solid.slope.transpose() / giver.ofSolids;
        giver.flux -= giver.ofSolids * ((Mat<Dim>::Identity() + scene.dt * L).determinant() - 1) / scene.dt;
    }
}

} // namespace mpm
