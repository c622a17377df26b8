// SPDX-License-Identifier: GPL-2.0-or-later
// What tells the inside of a body from its surface: the material in the cells around one.
#pragma once

#include "mpm/state/Grid.hpp"

#include <algorithm>
#include <vector>

namespace mpm {

// f(cell, along how many axes it is beside) for a cell and those of the grid round it.
template <int Dim, class F> void forAround(const Grid<Dim>& grid, int number, F&& f) {
    const Index<Dim> index = grid.indices(number);
    for (int n = 0; n < (Dim == 2 ? 9 : 27); ++n) {
        int other = number, axes = 0;
        bool isInGrid = true;
        for (int k = 0, rest = n; k < Dim; ++k, rest /= 3) {
            const int step = rest % 3 - 1, at = index[k] + step - grid.ghost;
            isInGrid &= at >= 0 && at < grid.cells[k];
            other += step * grid.strides[k];
            axes += step != 0;
        }
        if (isInGrid) f(other, axes);
    }
}

// From the number of a cell to those of it and of the cells round it.
template <int Dim> std::vector<int> stepsAround(const Grid<Dim>& grid) {
    std::vector<int> steps{0};
    for (int stride : grid.strides)
        for (size_t i = 0, n = steps.size(); i < n; ++i) {
            steps.push_back(steps[i] - stride);
            steps.push_back(steps[i] + stride);
        }
    return steps;
}

// The node at a corner of a cell.
template <int Dim> int cornerOf(const Grid<Dim>& grid, int cell, int corner) {
    for (int k = 0; k < Dim; ++k) cell += cornerSign(corner, k) > 0 ? grid.strides[k] : 0;
    return cell;
}

// From 0 at the surface of a body to 1 inside of it, by the least cover of the rows of cells before and beyond a
// cell along each axis, the cells across weighted with 1/4, 1/2, 1/4. About one inside the material, a half where
// one neighbour is empty, zero at a flat surface, and what the next row has below that. What is outside of the
// grid, behind its walls, does not count. coverOf(cell): the volume of the material in it over its own. surface,
// inside: least covers that give 0 and 1.
constexpr double insideFrom = 0.5;
template <int Dim, class Cover>
double insideBy(const Grid<Dim>& grid, int number, Cover&& coverOf, double surface = 0.25,
                double inside = insideFrom) {
    constexpr int rows = Dim == 2 ? 3 : 9, order[3] = {0, -1, 1}; // the cell itself first
    const Index<Dim> index = grid.indices(number);
    const auto isInGrid = [&](int k, int step) {
        const int at = index[k] + step - grid.ghost;
        return at >= 0 && at < grid.cells[k];
    };
    double least = inside;
    for (int axis = 0; axis < Dim; ++axis)
        for (int side : {-1, 1}) {
            if (!isInGrid(axis, side)) continue;
            double sum = 0, weights = 0;
            for (int n = 0; n < rows && sum < inside; ++n) { // most cells need one or two of a row
                int other = number + side * grid.strides[axis];
                double weight = 1;
                for (int k = 0, rest = n; k < Dim; ++k) {
                    if (k == axis) continue;
                    const int step = order[rest % 3];
                    rest /= 3;
                    other += step * grid.strides[k];
                    weight *= !isInGrid(k, step) ? 0 : step == 0 ? 0.5 : 0.25;
                }
                weights += weight;
                if (weight > 0) sum += weight * coverOf(other);
            }
            if (sum < inside) least = std::min(least, sum / weights);
        }
    return std::clamp((least - surface) / (inside - surface), 0.0, 1.0);
}

} // namespace mpm
