// SPDX-License-Identifier: GPL-2.0-or-later
// Velocities that impulses give to an implicit body, and the bound on its answers, against the dense inverse.
#include "mpm/step/ImpulseResponse.hpp"

#include <Eigen/Dense>
#include <Eigen/LU>

#include <cmath>
#include <gtest/gtest.h>

namespace mpm {

TEST(ImpulseResponse, isThatOfTheDenseInverseAndBounded) {
    constexpr int count = 30, n = 2 * count, band = 5;
    BandMatrix factor;
    Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(n, n);
    factor.reset(n, band);
    for (int j = 0; j < n; ++j)
        for (int i = j; i < std::min(n, j + band + 1); ++i)
            dense(i, j) = dense(j, i) = factor.at(i, j) =
                i == j ? 2.0 * band + 1 : std::sin(1.0 + 3 * i + 7 * j);
    ASSERT_TRUE(factor.factorise());
    const Eigen::MatrixXd inverse = dense.inverse();

    ImpulseResponse<2> response;
    response.bodies.resize(1);
    response.bodies[0].factor = &factor;
    response.bodies[0].first = 20;
    for (int node = 10; node < count; node += 2) response.nodes.push_back({0, node, 0, 2 * node});
    Eigen::VectorXd impulses = Eigen::VectorXd::Zero(n), shares = impulses;
    response.clearImpulses();
    for (size_t i = 0; i < response.nodes.size(); ++i)
        for (int k = 0; k < 2; ++k) {
            const int unknown = response.nodes[i].unknown + k;
            impulses[unknown] = std::cos(5.0 * unknown);
            shares[unknown] = 1 + 0.1 * i;
            response.push(int(i), k, impulses[unknown]);
        }
    response.solve();
    std::vector<Vec<2>> bounds;
    const Eigen::VectorXd v = inverse * impulses, sums = inverse.cwiseAbs() * shares;
    for (size_t i = 0; i < response.nodes.size(); ++i)
        EXPECT_NEAR((response.velocity(int(i)) - v.segment<2>(response.nodes[i].unknown)).norm(), 0, 1e-14);
    response.bound([&](size_t i, int k) { return shares[response.nodes[i].unknown + k]; }, bounds);
    // The largest eigenvalue of the answers over their bounds is what the iterations rely on.
    Eigen::MatrixXd scaled = Eigen::MatrixXd::Zero(n, n);
    for (size_t i = 0; i < bounds.size(); ++i)
        for (int k = 0; k < 2; ++k) {
            const int unknown = response.nodes[i].unknown + k;
            scaled(unknown, unknown) = std::sqrt(shares[unknown] / bounds[i][k]);
            EXPECT_LE(bounds[i][k], 1.001 * sums[unknown]); // no larger than it need be
        }
    const Eigen::MatrixXd over = scaled * inverse * scaled;
    EXPECT_LE(Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(over).eigenvalues().maxCoeff(), 1 + 1e-3);
}

} // namespace mpm
