// SPDX-License-Identifier: GPL-2.0-or-later
// Points grouped by blocks of the grid.
#include "mpm/state/BlockOrder.hpp"

#include <gtest/gtest.h>
#include <random>
#include <set>

using namespace mpm;

namespace {

template <int Dim> struct Grouped {
    Grid<Dim> grid{Vec<Dim>::Zero(), Vec<Dim>::Constant(20), Vec<Dim>::Constant(1)};
    std::vector<int> cell;
    BlockOrder<Dim> order;

    explicit Grouped(int points, bool byCell = true) {
        std::mt19937 generator(3);
        std::uniform_int_distribution<int> anyCell(4, 15);
        for (int p = 0; p < points; ++p) {
            int c = 0;
            for (int k = 0; k < Dim; ++k) c += anyCell(generator) * grid.strides[k];
            cell.push_back(c);
        }
        order.group(grid, cell, byCell);
        order.prepare(grid, 3);
    }
    int blockOf(int point) const { return grid.blockAt(grid.indices(cell[point])); }
    void inspect() {
        for (int b = 0; b < order.blocks(); ++b) order.inspect(b, grid, cell);
    }
};

template <class T> class BlockOrderOf : public testing::Test {};
using Dims = testing::Types<std::integral_constant<int, 2>, std::integral_constant<int, 3>>;

} // namespace

TYPED_TEST_SUITE(BlockOrderOf, Dims);

TYPED_TEST(BlockOrderOf, every_point_is_in_its_block_once) {
    const Grouped<TypeParam::value> g(500);
    EXPECT_TRUE(g.order.isOf(g.grid));
    std::set<int> seen;
    for (int b = 0; b < g.order.blocks(); ++b)
        for (int i = g.order.start[b]; i < g.order.start[b + 1]; ++i) {
            EXPECT_EQ(g.blockOf(g.order.at(i)), b);
            seen.insert(g.order.at(i));
        }
    EXPECT_EQ(seen.size(), 500u);
}

TYPED_TEST(BlockOrderOf, points_of_a_block_stand_by_cell_and_then_by_number) {
    for (bool byCell : {true, false}) {
        const Grouped<TypeParam::value> g(500, byCell);
        for (int b = 0; b < g.order.blocks(); ++b)
            for (int i = g.order.start[b] + 1; i < g.order.start[b + 1]; ++i) {
                const int before = g.order.at(i - 1), here = g.order.at(i);
                if (byCell && g.cell[before] != g.cell[here])
                    EXPECT_LT(g.cell[before], g.cell[here]);
                else
                    EXPECT_LT(before, here);
            }
    }
}

TYPED_TEST(BlockOrderOf, a_point_may_wander_so_far_and_no_further) {
    constexpr int Dim = TypeParam::value;
    Grouped<Dim> g(1);
    g.inspect();
    EXPECT_FALSE(g.order.broken(g.grid));
    const Index<Dim> begin = g.grid.blockBegin(g.blockOf(0));
    const int block = g.blockOf(0), last = Dim - 1;
    for (int beyond : {0, 1}) {
        Index<Dim> index = g.grid.indices(g.cell[0]);
        index[last] = begin[last] + g.grid.blockWidth - 1 + g.grid.wander + beyond;
        g.cell[0] = 0;
        for (int k = 0; k < Dim; ++k) g.cell[0] += index[k] * g.grid.strides[k];
        EXPECT_FALSE(g.order.covers(block, g.grid, g.cell[0]));
        g.order.extend(block, g.grid, g.cell[0]);
        EXPECT_TRUE(g.order.covers(block, g.grid, g.cell[0]));
        EXPECT_EQ(g.order.broken(g.grid), beyond == 1);
    }
}

TYPED_TEST(BlockOrderOf, runs_of_equal_cells_are_counted) {
    Grouped<TypeParam::value> g(500);
    g.inspect();
    EXPECT_EQ(g.order.runs(), int(std::set<int>(g.cell.begin(), g.cell.end()).size()));
    EXPECT_TRUE(g.order.isKnown(0));
}

TYPED_TEST(BlockOrderOf, blocks_that_may_share_nodes_are_neighbours) {
    constexpr int Dim = TypeParam::value;
    const Grouped<Dim> g(1);
    for (int b = 0; b < g.order.blocks(); ++b) {
        std::set<int> beside;
        g.grid.blocksBeside(b, [&](int other) { beside.insert(other); });
        EXPECT_EQ(beside.count(b), 0u);
        for (int other = 0; other < g.order.blocks(); ++other) {
            if (other == b) continue;
            // Nodes of a block's points: its own, those they wander to, and the support of three behind.
            bool meet = true;
            const Index<Dim> mine = g.grid.blockBegin(b), theirs = g.grid.blockBegin(other);
            for (int k = 1; k < Dim; ++k) {
                meet &= std::abs(mine[k] - theirs[k]) < g.grid.blockWidth + 2 * g.grid.wander + 2;
                meet &= mine[k] < g.grid.nodes[k] && theirs[k] < g.grid.nodes[k]; // or it has no node
            }
            EXPECT_TRUE(!meet || beside.count(other)) << b << " and " << other;
        }
    }
}
