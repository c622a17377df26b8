// SPDX-License-Identifier: GPL-2.0-or-later
// Pore pressure on the cells: B and its transpose, the symmetry of the matrix, and its solution.
#include "mpm/step/PoreSystem.hpp"

#include <gtest/gtest.h>
#include <numeric>
#include <random>

using namespace mpm;

namespace {

std::mt19937 generator(1);
double number() { return std::uniform_real_distribution<double>(-1, 1)(generator); }

// Two thirds of the cells of a graded grid, with flow between them and out of the first.
template <int Dim> struct Sample {
    Grid<Dim> grid;
    PoreSystem<Dim> system;

    static typename Grid<Dim>::Lines lines() {
        typename Grid<Dim>::Lines all;
        for (auto& line : all) line = {0, 0.5, 1.2, 1.6, 2.5};
        return all;
    }
    Sample() : grid(lines()) {
        system.start(grid.count);
        for (int cell = 0; cell < grid.count; ++cell) {
            const Index<Dim> index = grid.indices(cell);
            bool isInside = cell % 3 != 0;
            for (int k = 0; k < Dim; ++k)
                isInside &= index[k] >= grid.ghost && index[k] < grid.ghost + grid.cells[k];
            if (!isInside) continue;
            auto& added = system.addCell(grid, cell);
            added.volume = (1.5 + 0.5 * number()) * grid.edges(cell).prod();
            added.storage = 1e-3 * (1.5 + number());
        }
        system.addNodes(grid);
        for (auto& node : system.nodes)
            for (int k = 0; k < Dim; ++k) node.step[k] = number() > 0 ? 0.1 * (1.5 + number()) : 0;
        for (int c = 0; c < int(system.cells.size()); ++c) {
            const int beside = system.cellAt(system.cells[c].number + 1);
            if (beside >= 0) system.faces.push_back({c, beside, 0.02 * (1.5 + number()), number()});
        }
        system.cells[0].flow += 0.1;
        system.finish();
    }
    std::vector<double> pressures() const {
        std::vector<double> u(system.cells.size());
        for (double& value : u) value = number();
        return u;
    }
};

double dot(const std::vector<double>& x, const std::vector<double>& y) {
    return std::inner_product(x.begin(), x.end(), y.begin(), 0.0);
}

template <int Dim> void expectTranspose() {
    Sample<Dim> sample;
    auto& system = sample.system;
    std::vector<Vec<Dim>> v(sample.grid.count);
    for (auto& one : v)
        for (int k = 0; k < Dim; ++k) one[k] = number();
    const auto u = sample.pressures();
    std::vector<double> flow(u.size());
    parallel(1, [&](ParallelRegion& region) {
        system.flowOut(region, [&](int node, int k) { return v[node][k]; }, flow);
    });
    double power = 0;
    for (const auto& node : system.nodes) power += system.force(node, u).dot(v[node.number]);
    EXPECT_NEAR(power, dot(flow, u), 1e-12 * system.cells.size());
    for (auto& one : v) one = Vec<Dim>::Ones(); // all move alike: nothing flows out
    parallel(1, [&](ParallelRegion& region) {
        system.flowOut(region, [&](int node, int k) { return v[node][k]; }, flow);
    });
    for (double each : flow) EXPECT_NEAR(each, 0, 1e-14);
}

template <int Dim>
std::vector<double> solved(Sample<Dim>& sample, const std::vector<double>& right, int threads) {
    std::vector<double> u(right.size(), 0.0), residual(right.size());
    parallel(threads, [&](ParallelRegion& region) {
        EXPECT_GT(sample.system.solve(region, right, 1e-12, 1000, u, residual), 3);
    });
    return u;
}

template <int Dim> void expectSolution() {
    Sample<Dim> sample;
    auto& system = sample.system;
    const auto x = sample.pressures(), y = sample.pressures();
    std::vector<double> ax(x.size()), ay(x.size());
    parallel(1, [&](ParallelRegion& region) {
        system.multiply(region, x, ax);
        system.multiply(region, y, ay);
    });
    EXPECT_NEAR(dot(ax, y), dot(ay, x), 1e-12 * x.size());
    EXPECT_GT(dot(ax, x), 0);
    const auto u = solved(sample, ax, 1);
    for (size_t c = 0; c < x.size(); ++c) EXPECT_NEAR(u[c], x[c], 1e-8);
    EXPECT_EQ(u, solved(sample, ax, 2));
}

TEST(PoreSystem, flowIsTheTransposeOfForce) {
    expectTranspose<2>();
    expectTranspose<3>();
}

TEST(PoreSystem, isSymmetricAndSolvedAlikeOnAnyNumberOfThreads) {
    expectSolution<2>();
    expectSolution<3>();
}

} // namespace
