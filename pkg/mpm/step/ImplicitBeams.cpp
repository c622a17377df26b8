// SPDX-License-Identifier: GPL-2.0-or-later
// Beams in the stiffness of implicit bodies: sum_r k_r row_r row_r^T, see StrainedNodes::BeamRows.
#include "mpm/step/ImplicitSystem.hpp"

namespace mpm {

template <int Dim>
void ImplicitSystem<Dim>::addBeam(double square, const StrainedNodes<Dim>& strained,
                                  const Strained& particle) {
    const auto rowsOf = [&](size_t at) -> const auto& {
        return strained.beamRows[order_[at] - strained.entries.data()].row;
    };
    for (size_t a = 0; a < order_.size(); ++a) {
        double below[Dim][Mesh<Dim>::mostRows];
        for (int i = 0; i < Dim; ++i)
            for (int r = 0; r < particle.rows; ++r)
                below[i][r] = square * particle.rowStiffness[r] * rowsOf(a)[r][i];
        for (size_t b = 0; b <= a; ++b) {
            const auto& right = rowsOf(b);
            for (int j = 0; j < Dim; ++j) {
                double* column = &factor_.at(order_[a]->unknown, order_[b]->unknown + j);
                for (int i = a == b ? j : 0; i < Dim; ++i)
                    for (int r = 0; r < particle.rows; ++r) column[i] += below[i][r] * right[r][j];
            }
        }
    }
}

template <int Dim>
void ImplicitSystem<Dim>::addBeamForce(const StrainedNodes<Dim>& strained, const Strained& particle,
                                       const double* x, double* force) const {
    for (int r = 0; r < particle.rows; ++r) {
        double strain = 0;
        for (int e = particle.begin; e < particle.end; ++e)
            for (int i = 0; i < Dim; ++i)
                strain += strained.beamRows[e].row[r][i] * x[strained.entries[e].unknown + i];
        for (int e = particle.begin; e < particle.end; ++e)
            for (int i = 0; i < Dim; ++i)
                force[strained.entries[e].unknown + i] +=
                    particle.rowStiffness[r] * strain * strained.beamRows[e].row[r][i];
    }
}

template void ImplicitSystem<2>::addBeam(double, const StrainedNodes<2>&, const Strained&);
template void ImplicitSystem<3>::addBeam(double, const StrainedNodes<3>&, const Strained&);
template void ImplicitSystem<2>::addBeamForce(const StrainedNodes<2>&, const Strained&, const double*,
                                              double*) const;
template void ImplicitSystem<3>::addBeamForce(const StrainedNodes<3>&, const Strained&, const double*,
                                              double*) const;

} // namespace mpm
