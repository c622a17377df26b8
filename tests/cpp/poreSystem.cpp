// SPDX-License-Identifier: GPL-2.0-or-later
// Pore pressure on the cells: B and its transpose, the symmetry of the matrix, and its solution.
#include "mpm/step/PoreMatrix.hpp"

#include <gtest/gtest.h>
#include <numeric>
#include <random>

using namespace mpm;

namespace {

std::mt19937 generator(1);
double number() { return std::uniform_real_distribution<double>(-1, 1)(generator); }

// Two thirds of the cells of a graded grid, with flow between them and out of the first. isCut: the first cells have
// parts of particles, and a cell without an unknown hands its flow to two of them.
template <int Dim> struct Sample {
    Grid<Dim> grid;
    PoreSystem<Dim> system;
    PoreMatrix<Dim> matrix;

    static typename Grid<Dim>::Lines lines() {
        typename Grid<Dim>::Lines all;
        for (auto& line : all) line = {0, 0.5, 1.2, 1.6, 2.5};
        return all;
    }
    explicit Sample(bool isCut = true) : grid(lines()) {
        int empty = -1;
        std::vector<int> numbers;
        for (int cell = 0; cell < grid.count; ++cell) {
            const Index<Dim> index = grid.indices(cell);
            bool isInside = true;
            for (int k = 0; k < Dim; ++k)
                isInside &= index[k] >= grid.ghost && index[k] < grid.ghost + grid.cells[k];
            if (isInside && cell % 3 == 0) empty = cell;
            if (!isInside || cell % 3 == 0) continue;
            numbers.push_back(cell);
        }
        system.start(grid, numbers);
        for (auto& cell : system.cells) {
            cell.volume = (1.5 + 0.5 * number()) * grid.edges(cell.number).prod();
            cell.storage = 1e-3 * (1.5 + number());
        }
        if (isCut) {
            for (int c = 0; c < 3; ++c)
                for (int a = 0; a < corners<Dim>; ++a)
                    system.parts.push_back(
                        {c, cornerOf(grid, system.cells[c].number, a), Vec<Dim>::Constant(number())});
            auto& handing = system.addHandingCell(grid, empty);
            handing.volume = 0.3;
            handing.own = 0;
            const int from = int(system.cells.size()) - 1;
            system.shares = {{from, 0, 0.6}, {from, 1, 0.4}};
        }
        system.addNodes(grid);
        for (auto& node : system.nodes)
            for (int k = 0; k < Dim; ++k) node.step[k] = number() > 0 ? 0.1 * (1.5 + number()) : 0;
        for (int c = 0; c < system.unknowns; ++c) {
            const int beside = system.cellAt(system.cells[c].number + 1);
            if (beside >= 0) system.faces.push_back({c, beside, 0.02 * (1.5 + number()), number(), 0, 1.0});
        }
        system.cells[0].flow += 0.1;
        system.finish();
        parallel(1, [&](ParallelRegion& region) { matrix.assemble(region, system, grid.strides); });
    }
    std::vector<double> pressures() const {
        std::vector<double> u(system.unknowns);
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
    std::vector<Vec<Dim>> v(system.nodes.size());
    for (auto& one : v)
        for (int k = 0; k < Dim; ++k) one[k] = number();
    const auto u = sample.pressures();
    std::vector<double> flow(u.size()), acting;
    parallel(1, [&](ParallelRegion& region) { system.flowOut(region, v, 0, flow); });
    system.findActing(u, acting);
    double power = 0;
    for (size_t i = 0; i < v.size(); ++i) power += system.force(system.nodes[i], acting).dot(v[i]);
    EXPECT_NEAR(power, dot(flow, u), 1e-12 * system.cells.size());
}

template <int Dim> void expectNoFlowWhereAllMovesAlike() {
    Sample<Dim> sample(false);
    std::vector<double> flow(sample.system.cells.size());
    const std::vector<Vec<Dim>> v(sample.system.nodes.size(), Vec<Dim>::Ones());
    parallel(1, [&](ParallelRegion& region) { sample.system.flowOut(region, v, 1e-3, flow); });
    for (double each : flow) EXPECT_NEAR(each, 0, 1e-14);
}

template <int Dim>
std::vector<double> solved(Sample<Dim>& sample, const std::vector<double>& right, int threads) {
    std::vector<double> u(right.size(), 0.0), residual(right.size());
    parallel(threads, [&](ParallelRegion& region) {
        EXPECT_GT(sample.matrix.solve(region, sample.system, right, 1e-12, 1000, u, residual), 3);
    });
    return u;
}

// A = C + H + B M^-1 B^T by its parts.
template <int Dim> void expectProduct(bool isCut) {
    Sample<Dim> sample(isCut);
    auto& system = sample.system;
    const auto x = sample.pressures();
    std::vector<double> y(x.size()), flow(x.size()), away, acting;
    system.flowAway(x, away);
    system.findActing(x, acting);
    std::vector<Vec<Dim>> v;
    for (auto& node : system.nodes) v.push_back(system.force(node, acting).cwiseProduct(node.step));
    parallel(2, [&](ParallelRegion& region) {
        system.flowOut(region, v, 0, flow);
        sample.matrix.multiply(region, system, x, y);
    });
    for (int c = 0; c < system.unknowns; ++c)
        EXPECT_NEAR(y[c], system.cells[c].storage * x[c] + away[c] + flow[c], 1e-13);
}

template <int Dim> void expectSolution() {
    Sample<Dim> sample;
    auto& system = sample.system;
    const auto x = sample.pressures(), y = sample.pressures();
    std::vector<double> ax(x.size()), ay(x.size());
    parallel(1, [&](ParallelRegion& region) {
        sample.matrix.multiply(region, system, x, ax);
        sample.matrix.multiply(region, system, y, ay);
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
    expectNoFlowWhereAllMovesAlike<2>();
    expectNoFlowWhereAllMovesAlike<3>();
}

TEST(PoreSystem, theStoredMatrixIsThatOfItsParts) {
    for (const bool isCut : {false, true}) {
        expectProduct<2>(isCut);
        expectProduct<3>(isCut);
    }
}

TEST(PoreSystem, isSymmetricAndSolvedAlikeOnAnyNumberOfThreads) {
    expectSolution<2>();
    expectSolution<3>();
}

} // namespace
