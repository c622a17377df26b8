// SPDX-License-Identifier: GPL-2.0-or-later
// Which part of a cell lies on which side of a wall that parts soil (PartedSoils), for SharedCells. A cell with a node on
// which the soil is two counts for each of its fields, by a number of its own: those of the second field begin at
// Grid::count, as in ParticleCells. For a field all that lies beyond the wall is a part of the wall, and goes with it.
#pragma once

#include "mpm/scene/Scene.hpp"

#include <map>

namespace mpm {

template <int Dim> class SidesOfCells {
  public:
    // The cells as walls part a soil now; soil: its first field, -1: none is parted.
    void find(const Scene<Dim>& scene, int soil);

    int inGrid(int number) const { return number < count_ ? number : number - count_; }
    // The field that a number is of; -1: of all that is in the cell.
    int fieldOf(int number) const {
        return !isParted_ || !isParted_[inGrid(number)] ? -1 : number < count_ ? first_ : second_;
    }
    // The place of a node or cell in arrays that have room for both fields.
    int place(int field, int node) const { return isParted_ && field == second_ ? node + count_ : node; }
    bool areAny() const { return isParted_; }
    int first() const { return first_; }
    int second() const { return second_; }
    // Whether the soil is one on a node.
    bool isOne(int node) const { return !isParted_ || parted_->isBonded(first_, node); }
    // f(number) for those of a cell.
    template <class F> void forNumbers(int cell, F&& f) const {
        f(cell);
        if (isParted_ && isParted_[cell]) f(cell + count_);
    }
    // f(number, along how many axes it is beside, part) for the cells beside one in which its field goes on; part: of the
    // volume of that cell, on the side of the field.
    template <class F> void forBeside(const Grid<Dim>& grid, int number, F&& f) const {
        const int field = fieldOf(number);
        forAround(grid, inGrid(number), [&](int cell, int axes) {
            if (axes == 0) return;
            if (field < 0) return forNumbers(cell, [&](int other) { f(other, axes, 1.0); });
            if (isParted_[cell]) return f(place(field, cell), axes, 1.0);
            if (const double its = part(grid, field, cell); its > 0) f(cell, axes, its);
        });
    }

    // The part of a cell that lies on the side of a field, up to the middle of the wall.
    double part(const Grid<Dim>& grid, int field, int cell) const;
    // The part of the wall in a cell that lies on the side of a field, up to its middle.
    double solids(const Grid<Dim>& grid, int field, int cell) const;
    // The part that lies before the near face of the wall, by the hat functions of the corners: smooth as the wall moves.
    double open(const Grid<Dim>& grid, int field, int cell) const;
    // The part of the integral of a node's hat function that lies beyond the far face of the wall.
    double beyond(const Grid<Dim>& grid, int field, int node) const;

  private:
    struct Plane {
        int front = 0, across = 0;
        double half = 0; // of the thickness, m
        Vec<Dim> normal, middle, lower, upper;
        std::map<int, double> along; // middle of the wall along the normal, m, by row of cells across it
    };
    void add(const Scene<Dim>& scene, const typename PartedSoils<Dim>::Wall& wall);
    static int rowOf(const Grid<Dim>& grid, const Vec<Dim>& x, int across);
    const Plane& planeAt(const Grid<Dim>& grid, const Vec<Dim>& x) const;
    static double middleAt(const Grid<Dim>& grid, const Plane& plane, const Vec<Dim>& x);
    // How far a place lies before the middle of the wall on the side of a field, and half the wall, in cells along the
    // normal.
    struct Depth {
        double before, half;
    };
    Depth depth(const Grid<Dim>& grid, int field, const Vec<Dim>& x) const;

    const PartedSoils<Dim>* parted_ = nullptr;
    const char* isParted_ = nullptr; // each cell, see SecondCells; nullptr: none is
    int count_ = 0, first_ = -1, second_ = -1;
    std::vector<Plane> planes_;
};

} // namespace mpm
