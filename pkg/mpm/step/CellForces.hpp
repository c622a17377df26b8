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
    // Finds the mean stress in each cell; called by all threads, as what follows.
    template <int Dim> static void findMeans(ParallelRegion& region, Body<Dim>& body) {
        const double* stress[3];
        for (int k = 0; k < 3; ++k) stress[k] = body.particles.stress.plane(4 * k);
        region.chunks(body.particles.size(), [&](int begin, int end) {
            double* mean = body.cellAverage.values();
            for (int p = begin; p < end; ++p) mean[p] = (stress[0][p] + stress[1][p] + stress[2][p]) / 3;
        });
        body.cellAverage.template average<false>(region, body.particles.volume.plane(), [](int, auto&) {});
    }

    // Then takes the part that acts by cells out of what the particles of a body give in addSum().
    template <int Dim>
    void takeOut(ParallelRegion& region, Body<Dim>& body, const Grid<Dim>& grid, SharedCells<Dim>& shared) {
        const int n = body.particles.size();
        const int axes = grid.isAxisymmetric ? 3 : Dim; // that strain
        auto& cells = body.cellAverage;
        region.once([&] {
            for (int k = 0; k < axes; ++k) diagonal_[k].resize(n);
        });
        const double* stress[3];
        for (int k = 0; k < 3; ++k) stress[k] = body.particles.stress.plane(4 * k);
        cells.forEach(region, [&](int c, auto& cell) {
            const bool isShared = cell.shared > 0;
            const double whole = isShared ? cell.shared : cell.share * cell.whole;
            const double outside = 1 - cell.inside;
            const double volume = cells.acting(cell, whole);
            const double acting = cell.inside * volume * cell.mean;
            if (isShared) shared.act(c, acting);
            cells.actByCell(c, (isShared ? 0 : acting) * cell.edges.cwiseInverse());
            cell.byParticles = outside * volume / cell.weight * cell.mean;
        });
        cells.actByHoles(region, grid);
        region.chunks(n, [&](int begin, int end) {
            const double* mean = cells.values();
            for (int p = begin; p < end; ++p) {
                const double by =
                    cells.over(p, [](const auto& cell, int) { return cell.byParticles; }) - mean[p];
                for (int k = 0; k < axes; ++k) diagonal_[k][p] = stress[k][p] + by;
            }
        });
        region.once([&] {
            for (int k = 0; k < axes; ++k) body.domains->diagonal[k] = diagonal_[k].data();
        });
    }

    // Adds it to the nodes.
    template <int Dim> void add(ParallelRegion& region, Body<Dim>& body, Grid<Dim>& grid) {
        region.once([&] { body.domains->diagonal = {}; });
        auto* sum = grid.fields[body.velocityField].sum.data();
        body.cellAverage.forForces(region, grid, [&](int node, const Vec<Dim>& force) {
            for (int k = 0; k < Dim; ++k) NodalField<Dim>::addForce(sum[node], k, force[k]);
        });
    }

  private:
    std::vector<double> diagonal_[3]; // of the stress that acts by the particles, kPa
};

} // namespace mpm
