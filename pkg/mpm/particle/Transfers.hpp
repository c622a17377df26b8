// SPDX-License-Identifier: GPL-2.0-or-later
// What particle types share: making of particles, where points are in the grid, volumes. A type supplies the
// loops and the weights; what one particle gives and takes is in ParticlePlanes.hpp.
#pragma once

#include "mpm/particle/NodeLanes.hpp"
#include "mpm/particle/ParticlePlanes.hpp"

namespace mpm {

template <int Dim> class Transfers : public Domains<Dim> {
  public:
    using Base = Domains<Dim>;
    using NF = typename Base::NF;
    using L = Lanes<Dim>;
    using Planes = ParticlePlanes<Dim>;
    using Base::Base;
    using Base::particles;

  protected:
    static void addTo(int node, double quantity, double* nodal, std::vector<int>& touched) {
        if (quantity == 0) return;
        if (nodal[node] == 0) touched.push_back(node);
        nodal[node] += quantity;
    }

    // Creates n particles with the given centres and volumes, numbered in order.
    void create(const std::vector<Vec<Dim>>& positions, const std::vector<double>& volumes) {
        particles.resize(int(positions.size()));
        for (int p = 0; p < particles.size(); ++p) {
            particles.id.integers()[p] = p;
            for (int k = 0; k < Dim; ++k)
                particles.position.plane(k)[p] = particles.reference.plane(k)[p] = positions[p][k];
            particles.volume.plane()[p] = particles.initialVolume.plane()[p] = volumes[p];
            for (int i = 0; i < 3; ++i) particles.deformationGradient.plane(4 * i)[p] = 1;
        }
    }

    // V = J V0 of particles [begin, end).
    void volumesFromGradient(int begin, int end) {
        const double* F[9];
        for (int i = 0; i < 9; ++i) F[i] = particles.deformationGradient.plane(i);
        double* V = particles.volume.plane();
        const double* V0 = particles.initialVolume.plane();
#pragma omp simd
        for (int p = begin; p < end; ++p) {
            if (Dim == 2)
                V[p] = V0[p] * (F[0][p] * F[4][p] - F[1][p] * F[3][p]) * F[8][p];
            else
                V[p] = V0[p] * (F[0][p] * (F[4][p] * F[8][p] - F[5][p] * F[7][p]) -
                                F[1][p] * (F[3][p] * F[8][p] - F[5][p] * F[6][p]) +
                                F[2][p] * (F[3][p] * F[7][p] - F[4][p] * F[6][p]));
        }
    }

    [[noreturn]] void outside(const char* what, int64_t number, const Vec<Dim>& x) const {
        throw RunError(
            message("step ", Base::step, ": ", what, " ", number, " of '", Base::bodyName, "' at ", place(x),
                    x.allFinite() ? " is outside the grid " : " has no finite position; grid ",
                    place(Base::grid.lower), " to ", place(Base::grid.upper),
                    "; enlarge the grid, hold the body with boundary conditions, or lower dt (soil without "
                    "closing or F-bar falls apart)"));
    }

    // Lowest nodes of the supports of points [begin, end), which start at floor(c - offset) in each
    // direction, and the positions in them. Returns whether any of these nodes is another one than before.
    // Throws for the first point that is more than half a cell outside the grid or not a number.
    bool support(int begin, int end, double* const x[Dim], double offset, int* cell, double* const local[Dim],
                 const char* what, const int64_t* number) const {
        const auto& grid = Base::grid;
        if (grid.isGraded())
            return support(
                begin, end, x, [&](int k, double at) MPM_INLINE_LAMBDA { return grid.lines(k).inCells(at); },
                offset, cell, local, what, number);
        double origin[Dim], overCell[Dim];
        for (int k = 0; k < Dim; ++k) {
            origin[k] = grid.lower[k];
            overCell[k] = 1 / grid.smallestCell()[k];
        }
        const double ghost = grid.ghost;
        return support(
            begin, end, x,
            [=](int k, double at) MPM_INLINE_LAMBDA { return (at - origin[k]) * overCell[k] + ghost; },
            offset, cell, local, what, number);
    }

  private:
    // With inCells(axis, x), the position in cells from the lowest ghost node.
    template <class InCells>
    bool support(int begin, int end, double* const x[Dim], InCells&& inCells, double offset, int* cell,
                 double* const local[Dim], const char* what, const int64_t* number) const {
        const auto& grid = Base::grid;
        const double ghost = grid.ghost, lowest = ghost - 0.5;
        double *at[Dim], *inside[Dim], highest[Dim];
        int stride[Dim];
        for (int k = 0; k < Dim; ++k) {
            at[k] = x[k];
            inside[k] = local[k];
            stride[k] = grid.strides[k];
            highest[k] = ghost + grid.cells[k] + 0.5;
        }
        int wrong = 0, changed = 0;
#pragma omp simd reduction(| : wrong, changed)
        for (int p = begin; p < end; ++p) {
            int node = 0;
            MPM_UNROLL
            for (int k = 0; k < Dim; ++k) {
                const double c = inCells(k, at[k][p]);
                const bool isInside = c >= lowest && c <= highest[k];
                const double base =
                    isInside ? std::floor(c - offset) : 0; // nan and what is far away are no whole numbers
                inside[k][p] = c - base;
                node += stride[k] * int(base);
                wrong |= !isInside;
            }
            changed |= cell[p] != node;
            cell[p] = node;
        }
        if (wrong) throwOutside(begin, end, x, what, number);
        return changed;
    }

    [[noreturn]] void throwOutside(int begin, int end, double* const x[Dim], const char* what,
                                   const int64_t* number) const {
        const auto& grid = Base::grid;
        for (int p = begin;; ++p) {
            Vec<Dim> at;
            bool isInside = true;
            for (int k = 0; k < Dim; ++k) {
                at[k] = x[k][p];
                const double c = grid.inCells(at[k], k);
                isInside &= c >= grid.ghost - 0.5 && c <= grid.ghost + grid.cells[k] + 0.5;
            }
            if (!isInside || p == end - 1) outside(what, number ? number[p] : p, at);
        }
    }
};

} // namespace mpm
