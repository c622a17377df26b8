// SPDX-License-Identifier: GPL-2.0-or-later
// Eigenvalues and eigenvectors beside Eigen's own solver, to the bit.
#include "mpm/base/spectrum.hpp"

#include <Eigen/Eigenvalues>

#include <gtest/gtest.h>
#include <random>

using namespace mpm;

namespace {

template <int Dim> void expectSame(const Mat<Dim>& matrix) {
    const Spectrum<Dim> found = spectrumOf<Dim>(matrix);
    const Eigen::SelfAdjointEigenSolver<Mat<Dim>> expected(matrix);
    EXPECT_EQ(found.values, expected.eigenvalues()) << matrix;
    EXPECT_EQ(found.vectors, expected.eigenvectors()) << matrix;
}

template <int Dim> void expectSameForMany() {
    std::mt19937 numbers(1);
    std::normal_distribution<double> normal;
    for (int n = 0; n < 2000; ++n) {
        Mat<Dim> F;
        for (int i = 0; i < Dim * Dim; ++i) F(i) = normal(numbers) * std::pow(10.0, n % 7 - 3);
        expectSame<Dim>(F.transpose() * F);
        expectSame<Dim>(F + F.transpose());
    }
    expectSame<Dim>(Mat<Dim>::Zero());
    expectSame<Dim>(Mat<Dim>::Identity());
    expectSame<Dim>(Mat<Dim>::Ones());
}

} // namespace

TEST(spectrumOf, has_the_bits_of_the_general_solver_in_2D) { expectSameForMany<2>(); }
TEST(spectrumOf, has_the_bits_of_the_general_solver_in_3D) { expectSameForMany<3>(); }
