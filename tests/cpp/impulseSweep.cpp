// SPDX-License-Identifier: GPL-2.0-or-later
// Velocities on the way along a body against the dense inverse, wherever impulses are given.
#include "mpm/step/ImpulseSweep.hpp"

#include <Eigen/LU>

#include <cmath>
#include <gtest/gtest.h>

namespace mpm {

namespace {

constexpr int first = 10, held = 23, span = 3;

class Ways : public testing::TestWithParam<std::pair<int, int>> {
  protected:
    int n = GetParam().first;
    BandMatrix factor;
    Eigen::MatrixXd inverse;
    Eigen::VectorXd impulses = Eigen::VectorXd::Zero(n);
    ImpulseSweep sweep;

    void SetUp() override {
        const int band = GetParam().second;
        factor.reset(n, band);
        for (int j = 0; j < n; ++j)
            for (int i = j; i < std::min(n, j + band + 1); ++i)
                factor.at(i, j) = i == j ? 1.2 * band + 1 : std::sin(1.0 + 3 * i + 7 * j);
        factor.decouple(held);
        Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(n, n);
        for (int j = 0; j < n; ++j)
            for (int i = j; i < std::min(n, j + band + 1); ++i) dense(i, j) = dense(j, i) = factor.at(i, j);
        ASSERT_TRUE(factor.factorise());
        inverse = dense.inverse();
        inverse(held, held) = 0;
        sweep.start(factor, first, span, [](int unknown) { return unknown == held; });
    }
    void push(int unknown) {
        const double impulse = std::cos(5.0 * unknown + impulses.norm());
        impulses[unknown] += impulse;
        sweep.push(unknown, impulse);
    }
    void expectAt(int lowest, int count) {
        const Eigen::VectorXd v = inverse * impulses;
        for (int i = lowest; i < std::min(n, lowest + count); ++i)
            EXPECT_NEAR(sweep.velocity(i), v[i], 1e-13 * v.norm()) << i << " at " << lowest;
    }
};

TEST_P(Ways, areRightWhereOneIs) {
    for (int round = 0; round < 3; ++round)
        for (int at = n - span; at >= first; at -= 1 + at % 4) {
            sweep.goTo(at);
            expectAt(at, span);
            push(at);
            push(at + span - 1);
            expectAt(at, span);
        }
    sweep.restart();
    expectAt(first, n);
}

TEST_P(Ways, mayGoBackAndForth) {
    for (int step = 0; step < 200; ++step) {
        const int at = first + 37 * step * step % (n - span - first);
        sweep.goTo(at);
        expectAt(at, span);
        push(at + step % span);
    }
}

TEST_P(Ways, countWhatWasGivenElsewhere) {
    sweep.goTo(n - span);
    push(n - 1);
    push(first);
    sweep.goTo(n / 2);
    expectAt(n / 2, span);
    push(n - 1);
    sweep.goTo(first);
    expectAt(first, span);
}

TEST_P(Ways, answerLikeTheInverse) {
    for (int i = first; i < n; ++i)
        for (int j = std::max(first, i - span + 1); j < std::min(n, i + span); ++j)
            EXPECT_NEAR(sweep.answer(i, j), inverse(i, j), 1e-14);
    push(held);
    impulses[held] = 0;
    sweep.restart();
    expectAt(first, n);
}

INSTANTIATE_TEST_SUITE_P(Bands, Ways,
                         testing::Values(std::pair(60, 1), std::pair(80, 7), std::pair(200, 25),
                                         std::pair(150, 70)));

} // namespace

} // namespace mpm
