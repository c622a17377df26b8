// SPDX-License-Identifier: GPL-2.0-or-later
// Conjugate gradients of implicit bodies against dense algebra, with all that strains a particle.
#include "mpm/step/ImplicitIteration.hpp"

#include <Eigen/LU>

#include <gtest/gtest.h>

namespace mpm {

namespace {

double number(int i) { return std::sin(1.0 + 7.3 * i); } // from -1 to 1

// Particles on a few nodes each, and the matrix of their energy, sum by sum.
template <int Dim> struct Strains {
    static constexpr int nodes = 12;
    StrainedNodes<Dim> strained;
    Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(Dim * nodes, Dim* nodes);

    Strains(bool withControl, bool withHoop) {
        for (int p = 0; p < 20; ++p) {
            auto& particles = strained.particles;
            particles.push_back({int(strained.entries.size()), 0, 2.0 + number(p), 1.5 + number(p + 50), {}});
            for (double& control : particles.back().control) control = withControl ? 1.2 + number(p + 80) : 0;
            for (int n = 0; n < 5; ++n) addEntry(p, (p + 2 * n) % nodes, withHoop);
            particles.back().end = int(strained.entries.size());
            addEnergy(particles.back());
        }
    }
    void addEntry(int p, int node, bool withHoop) {
        typename StrainedNodes<Dim>::Entry entry{node, Dim * node, {}, {}, 0, {}, Vec<Dim>::Zero()};
        const int seed = 100 * p + 7 * node;
        for (int k = 0; k < Dim; ++k) entry.trace[k] = entry.g[k] = number(seed + k);
        for (double& gamma : entry.gamma) gamma = number(seed + 11);
        entry.hoop = withHoop ? 0.3 * number(seed + 17) : 0;
        entry.trace[0] += entry.hoop;
        strained.entries.push_back(entry);
    }
    template <class Part>
    void addSquare(double stiffness, const typename StrainedNodes<Dim>::Strained& of, Part&& part) {
        Eigen::VectorXd row = Eigen::VectorXd::Zero(Dim * nodes);
        for (int e = of.begin; e < of.end; ++e)
            for (int k = 0; k < Dim; ++k)
                row[strained.entries[e].unknown + k] += part(strained.entries[e], k);
        matrix += stiffness * row * row.transpose();
    }
    // lambda (tr e)^2 + 2 mu e : e, and the control.
    void addEnergy(const typename StrainedNodes<Dim>::Strained& of) {
        addSquare(of.lambda, of, [](auto& entry, int k) { return entry.trace[k]; });
        addSquare(2 * of.mu, of, [](auto& entry, int k) { return k == 0 ? entry.hoop : 0; });
        for (int i = 0; i < Dim; ++i)
            for (int j = 0; j < Dim; ++j)
                addSquare(2 * of.mu, of, [&](auto& entry, int k) {
                    return 0.5 * ((k == i) * entry.g[j] + (k == j) * entry.g[i]);
                });
        for (int m = 0; m < StrainedNodes<Dim>::patterns; ++m)
            for (int i = 0; i < Dim; ++i)
                addSquare(of.control[m], of, [&](auto& entry, int k) { return (k == i) * entry.gamma[m]; });
    }
};

template <int Dim> void solvesLikeDenseAlgebra(bool withControl, bool withHoop) {
    const Strains<Dim> strains(withControl, withHoop);
    constexpr int nodes = Strains<Dim>::nodes, all = Dim * nodes, held = Dim * 3 + 1;
    const double square = 0.7;
    Eigen::MatrixXd A = square * strains.matrix;
    Eigen::VectorXd b(all);
    ImplicitIteration<Dim> iteration(nodes, square);
    ASSERT_TRUE(iteration.look(strains.strained));
    iteration.add(strains.strained);
    EXPECT_EQ(iteration.sums() == Dim, !withControl && !withHoop);
    for (int n = 0; n < nodes; ++n) {
        const double mass = 0.1 + 0.02 * n;
        bool isHeld[Dim];
        Vec<Dim> right, guess = Vec<Dim>::Constant(0.5);
        for (int k = 0; k < Dim; ++k) {
            const int i = Dim * n + k;
            A(i, i) += mass;
            isHeld[k] = i == held;
            right[k] = b[i] = number(i + 900);
        }
        iteration.setNode(n, mass, isHeld, right, guess);
    }
    A.row(held).setZero();
    A.col(held).setZero();
    A(held, held) = 1;
    b[held] = 0;
    const Eigen::VectorXd v = A.lu().solve(b);
    EXPECT_FALSE(iteration.solve(2)); // control: not at once
    ASSERT_TRUE(iteration.solve(1000));
    for (int i = 0; i < all; ++i) EXPECT_NEAR(iteration.solution(i / Dim, i % Dim), v[i], 1e-9 * v.norm());
}

TEST(ImplicitIteration, solvesLikeDenseAlgebra) {
    for (bool withControl : {false, true}) {
        solvesLikeDenseAlgebra<3>(withControl, false);
        for (bool withHoop : {false, true}) solvesLikeDenseAlgebra<2>(withControl, withHoop);
    }
}

TEST(ImplicitIteration, leavesBeamsToTheFactor) {
    Strains<2> strains(false, false);
    strains.strained.particles.back().rows = 1;
    EXPECT_FALSE(ImplicitIteration<2>(Strains<2>::nodes, 1).look(strains.strained));
}

} // namespace

} // namespace mpm
