// SPDX-License-Identifier: GPL-2.0-or-later
// The forces of a body with F-bar that acts by cells: boxes, and meshes bonded to them. Where cells lie inside the
// material, share s, their mean stress p_c acts on the nodes by the cell and not by the particles in it:
//     f_i = - sum_p V_p (dev sigma_p + (1 - s_c) V_a/V_in p_c I) grad phi_ip - sum_c V_a s_c p_c grad phi_ic
// with grad phi_ic the mean of the gradient of the hat function over the cell, V_in the volume of the particles in
// it and V_a = s V_c + (1 - s) V_in. It is the work conjugate of the rate of volume change that CellAverage takes
// from cell and particles, so the elastic operator is symmetric. A mean stress that is the same everywhere then
// exerts no force inside, however the particles lie in the cells. What cells share with another group acts on both,
// see scene/SharedCells.hpp. (Slopes of the mean stress within a cell have no
// such conjugate: with their forces, noise in an uneven cover grew at any step.)
#pragma once

#include "mpm/scene/SharedCells.hpp"

namespace mpm {

class CellForces {
  public:
    // Finds the mean stress in each cell where it has changed since they were located; called by all threads, as what
    // follows.
    template <int Dim> static void findMeans(ParallelRegion& region, Body<Dim>& body, const Grid<Dim>& grid) {
        const MeanOfStress<Dim> mean(body.particles.stress, grid);
        body.cellAverage.template average<false>(
            region, body.particles.volume.plane(), mean,
            [](int, auto& cell, const auto& ofStress) { cell.take(ofStress); });
    }

    // Then what acts by the cells, and the stress that is left to the particles, for addSum().
    template <int Dim>
    ActingStress divide(ParallelRegion& region, Body<Dim>& body, const Grid<Dim>& grid,
                        SharedCells<Dim>& shared) {
        const int n = body.particles.size();
        auto& cells = body.cellAverage;
        region.once([&] { spherical_.resize(n); });
        const MeanOfStress<Dim> mean(body.particles.stress, grid);
        cells.forEach(region, [&](int c, auto& cell) {
            const bool isShared = cell.shared > 0 && !cell.isOpen;
            const double whole = isShared ? cell.shared : cell.share * cell.whole;
            const double outside = 1 - cell.inside;
            const double volume = cells.acting(cell, whole);
            const double acting = cell.inside * volume * cell.stress;
            if (isShared) shared.act(c, acting);
            cells.actByCell(c, (isShared ? 0 : acting) * cell.edges.cwiseInverse());
            const double byParticles = outside * volume / cell.weight * cell.stress;
            cells.give(c, spherical_.data(), [&](int, int p) { return byParticles - mean(p); });
        });
        cells.actByHoles(region, grid);
        region.chunks(n, [&](int begin, int end) { cells.collect(begin, end, spherical_.data()); });
        return ActingStress(body.particles.stress, spherical_.data());
    }

    // Adds what acts by the cells to the nodes.
    template <int Dim> static void add(ParallelRegion& region, const Body<Dim>& body, Grid<Dim>& grid) {
        region.wait();
        auto* sum = grid.fields[body.velocityField].sum.data();
        body.cellAverage.forForces(region, grid, [&](int node, const Vec<Dim>& force) {
            for (int k = 0; k < Dim; ++k) NodalField<Dim>::addForce(sum[node], k, force[k]);
        });
    }

  private:
    std::vector<double> spherical_; // of the particles, kPa, see ActingStress
};

} // namespace mpm
