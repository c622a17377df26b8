// SPDX-License-Identifier: GPL-2.0-or-later
// The band matrix against dense algebra, with narrow and wide bands.
#include "mpm/step/BandMatrix.hpp"

#include <Eigen/LU>

#include <gtest/gtest.h>

namespace mpm {

namespace {

struct Filled {
    BandMatrix band;
    Eigen::MatrixXd dense;

    Filled(int n, int width, double scale = 1) : dense(Eigen::MatrixXd::Zero(n, n)) {
        band.reset(n, width);
        for (int j = 0; j < n; ++j)
            for (int i = j; i < std::min(n, j + width + 1); ++i) {
                const double value = i == j ? 2.0 * width + 1 : std::sin(1.0 + 3 * i + 7 * j);
                band.at(i, j) = dense(i, j) = dense(j, i) = scale * value;
            }
    }
    std::vector<double> padded(const Eigen::VectorXd& x) const {
        std::vector<double> all(band.padded(), 0.0);
        std::copy(x.data(), x.data() + x.size(), all.begin());
        return all;
    }
};

class Bands : public testing::TestWithParam<std::pair<int, int>> {};

TEST_P(Bands, solveLikeDenseOnes) {
    const auto [n, width] = GetParam();
    Filled matrix(n, width);
    const Eigen::VectorXd x = Eigen::VectorXd::LinSpaced(n, -1, 2), b = matrix.dense * x;
    BandMatrix& factor = matrix.band;
    ASSERT_TRUE(factor.factorise());
    std::vector<double> solved = matrix.padded(b);
    factor.solve(solved.data());
    for (int i = 0; i < n; ++i) EXPECT_NEAR(solved[i], x[i], 2e-12);

    const int first = n / 2;
    const Eigen::MatrixXd inverse = matrix.dense.inverse();
    std::vector<double> upper(matrix.band.padded(), 0.0);
    upper[first + 1] = 3;
    factor.solve(upper.data(), first);
    for (int i = first; i < n; ++i) EXPECT_NEAR(upper[i], 3 * inverse(i, first + 1), 1e-13);

    const int reach = width + 4;
    std::vector<double> near;
    factor.invertNearDiagonal(first, reach, near);
    for (int i = first; i < n; ++i)
        for (int j = i; j < std::min(n, i + reach); ++j)
            EXPECT_NEAR(near[size_t(i - first) * reach + j - i], inverse(i, j), 1e-13);
}

TEST_P(Bands, tellWhenTheyAreNotPositive) {
    const auto [n, width] = GetParam();
    Filled matrix(n, width);
    matrix.band.at(n - 1, n - 1) = -1;
    EXPECT_FALSE(matrix.band.factorise());
}

TEST(Band, decoupledUnknownKeepsItsDiagonal) {
    Filled matrix(20, 5);
    matrix.band.at(7, 7) = 2;
    matrix.band.decouple(7);
    ASSERT_TRUE(matrix.band.factorise());
    std::vector<double> solved = matrix.padded(Eigen::VectorXd::Ones(20));
    matrix.band.solve(solved.data());
    EXPECT_NEAR(solved[7], 0.5, 1e-16);
}

// A solution in units that are so many times as large, by odd powers of two.
TEST_P(Bands, haveTheSameBitsInOtherUnits) {
    const auto [n, width] = GetParam();
    std::vector<double> solved[2], near[2];
    for (const double scale : {1.0, 8.0}) {
        const int i = scale > 1;
        Filled matrix(n, width, scale);
        ASSERT_TRUE(matrix.band.factorise());
        solved[i] = matrix.padded(Eigen::VectorXd::LinSpaced(n, -1, 2));
        matrix.band.solve(solved[i].data());
        matrix.band.invertNearDiagonal(n / 2, width + 4, near[i]);
        for (double& x : solved[i]) x *= scale;
        for (double& x : near[i]) x *= scale;
    }
    EXPECT_EQ(solved[0], solved[1]);
    EXPECT_EQ(near[0], near[1]);
}

INSTANTIATE_TEST_SUITE_P(Widths, Bands,
                         testing::Values(std::pair(9, 3), std::pair(200, 17), std::pair(100, 64),
                                         std::pair(300, 65), std::pair(333, 150), std::pair(80, 79)));

} // namespace

} // namespace mpm
