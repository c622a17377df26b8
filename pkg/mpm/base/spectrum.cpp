// SPDX-License-Identifier: GPL-2.0-or-later
#include "mpm/base/spectrum.hpp"

#include <Eigen/Eigenvalues>

namespace mpm {

// Of two rows is tridiagonal what compute() would make so first; scaled as there, to the same bits.
template <> Spectrum<2> spectrumOf(const Mat<2>& matrix) {
    const double largest =
        std::max(std::abs(matrix(1, 0)), std::max(std::abs(matrix(0, 0)), std::abs(matrix(1, 1))));
    const double scale = largest == 0 ? 1 : largest;
    const Vec<1> below(matrix(1, 0) / scale);
    Eigen::SelfAdjointEigenSolver<Mat<2>> solver;
    solver.computeFromTridiagonal(Vec<2>(matrix.diagonal() / scale), below);
    return {solver.eigenvalues() * scale, solver.eigenvectors()};
}

template <> Spectrum<3> spectrumOf(const Mat<3>& matrix) {
    const Eigen::SelfAdjointEigenSolver<Mat<3>> solver(matrix);
    return {solver.eigenvalues(), solver.eigenvectors()};
}

} // namespace mpm
