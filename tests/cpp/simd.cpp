// SPDX-License-Identifier: GPL-2.0-or-later
// Vectors: whatever the number of entries, loops by vectors do what a plain loop does.
#include "mpm/base/simd/Lanes.hpp"
#include "mpm/base/simd/forEachSimd.hpp"
#include "mpm/base/simd/forEachSimdPair.hpp"
#include "mpm/base/simd/largePages.hpp"
#include "mpm/base/simd/transpose.hpp"

#include <gtest/gtest.h>
#include <numeric>
#include <vector>

using namespace mpm;

namespace {

constexpr int most = 40; // entries: some vectors of every width, and every rest
constexpr double untouched = -77;

std::vector<double> numbers(int n, double first = 1) {
    std::vector<double> all(n);
    std::iota(all.begin(), all.end(), first);
    return all;
}

// In units of the last digit of `right`.
double lastDigits(double value, double right) {
    return std::abs(value - right) / (std::nextafter(std::abs(right), 1e300) - std::abs(right));
}

Quad quad(double first) { return Quad{first, first + 1, first + 2, first + 3}; }

void expectLanes(const Quad& q, const std::array<double, 4>& right) {
    for (int lane = 0; lane < 4; ++lane) EXPECT_EQ(q[lane], right[lane]) << "lane " << lane;
}

// Pack<8> {1 ... 8}
template <int W> Pack<W> counted(double first = 1) {
    Pack<W> p;
    for (int lane = 0; lane < W; ++lane) p.set(lane, first + lane);
    return p;
}

} // namespace

TEST(Quad, computes_lane_by_lane) {
    expectLanes(quad(1) + quad(10), {11, 13, 15, 17});
    expectLanes(quad(1) * quad(10), {10, 22, 36, 52});
    expectLanes(2.0 * quad(1), {2, 4, 6, 8});
    Quad q = quad(1);
    q += quad(10);
    q -= quad(1);
    expectLanes(q, {10, 11, 12, 13});
    q[2] = 5;
    expectLanes(q, {10, 11, 5, 13});
}

TEST(Quad, even_and_odd_lanes) {
    expectLanes(alternating(1, 2), {1, 2, 1, 2});
    expectLanes(evenLanes(quad(0), quad(10)), {0, 2, 10, 12});
}

template <class T> class PackOf : public testing::Test {};
using Widths = testing::Types<Pack<4>, Pack<8>, Pack<16>>;
TYPED_TEST_SUITE(PackOf, Widths);

TYPED_TEST(PackOf, lanes_are_computed_alike) {
    constexpr int width = sizeof(TypeParam) / sizeof(double);
    const Pack<width> a = counted<width>(), b = counted<width>(100);
    Pack<width> sum = a, weighted = a, copy = Pack<width>::zero();
    sum += b;
    weighted.add(2.0, b);
    copy = b;
    const Pack<width> product = 3.0 * b, zero = Pack<width>::zero();
    for (int lane = 0; lane < width; ++lane) {
        EXPECT_EQ(sum[lane], 101 + 2 * lane);
        EXPECT_EQ(weighted[lane], 201 + 3 * lane);
        EXPECT_EQ(product[lane], 300 + 3 * lane);
        EXPECT_EQ(copy[lane], 100 + lane);
        EXPECT_EQ(zero[lane], 0);
    }
    EXPECT_EQ(reinterpret_cast<std::uintptr_t>(&sum) % alignof(Pack<width>), 0u);
}

TEST(transpose, makes_columns_of_rows) {
    Quad a = quad(0), b = quad(10), c = quad(20), d = quad(30);
    transpose(a, b, c, d);
    expectLanes(a, {0, 10, 20, 30});
    expectLanes(b, {1, 11, 21, 31});
    expectLanes(c, {2, 12, 22, 32});
    expectLanes(d, {3, 13, 23, 33});
}

TEST(transpose, planes_to_lanes_and_back_for_any_count) {
    const auto w = numbers(most, 1), x = numbers(most, 100), y = numbers(most, 200), z = numbers(most, 300);
    for (int stride : {1, 2, 4})
        for (int count = 0; count <= most; ++count) {
            std::vector<Quad> lanes(stride * most + 1, Quad{untouched, untouched, untouched, untouched});
            interleave({w.data(), x.data(), y.data(), z.data()}, count, lanes.data(), stride);
            for (int i = 0; i <= stride * most; ++i) {
                const bool isWritten = i % stride == 0 && i / stride < count;
                const int p = i / stride;
                if (isWritten)
                    expectLanes(lanes[i], {w[p], x[p], y[p], z[p]});
                else
                    EXPECT_EQ(lanes[i][0], untouched);
            }
            std::vector<double> first(most, untouched), second = first, third = first;
            separate(lanes.data(), stride, count,
                     std::array<double*, 3>{first.data(), second.data(), third.data()});
            for (int p = 0; p < most; ++p) {
                EXPECT_EQ(first[p], p < count ? w[p] : untouched);
                EXPECT_EQ(second[p], p < count ? x[p] : untouched);
                EXPECT_EQ(third[p], p < count ? y[p] : untouched);
            }
        }
}

// Arrays are a vector longer than count, as those of a batch are; what lies behind must stay.
TEST(forEachSimd, does_what_a_plain_loop_does_for_any_count) {
    for (int count = 0; count <= most; ++count) {
        const std::vector<double> in = numbers(most + 8);
        std::vector<double> out(most + 8, untouched), plain = out;
        const double* from = in.data();
        double* to = out.data();
        forEachSimd(count,
                    [&](int p) MPM_INLINE_LAMBDA { to[p] = from[p] > 7 ? 3 * from[p] + 1 : -from[p]; });
        for (int p = 0; p < count; ++p) plain[p] = in[p] > 7 ? 3 * in[p] + 1 : -in[p];
        EXPECT_EQ(out, plain) << count << " entries";
    }
}

TEST(forEachSimdPair, does_what_a_plain_loop_does_for_any_count) {
    for (int count = 0; count <= most; ++count) {
        const std::vector<double> in = numbers(most);
        std::vector<double> out(most, untouched), plain = out;
        const double* from = in.data();
        double* to = out.data();
        forEachSimdPair(count, [&](auto at) MPM_INLINE_LAMBDA {
            const auto x = at(from);
            at.set(to, whereGreater(x, 7, 3 * x + 1, -x) - x / 2);
        });
        for (int p = 0; p < count; ++p) plain[p] = (in[p] > 7 ? 3 * in[p] + 1 : -in[p]) - in[p] / 2;
        EXPECT_EQ(out, plain) << count << " entries";
    }
}

// Where there is no AVX-512 these are the machine's own, and exact.
TEST(forEachSimdPair, roots_and_inverses_are_right_to_the_last_digits) {
    std::vector<double> in{1,     2,       3,         0.1,       1e-12, 1e12,      1e-100,
                           1e100, 7.0 / 3, 1 - 1e-16, 1 + 1e-15, 4,     123456.789};
    const int count = int(in.size());
    std::vector<double> roots(count), inverses(count);
    const double* from = in.data();
    double *root_ = roots.data(), *inverse_ = inverses.data();
    forEachSimdPair(count, [&](auto at) MPM_INLINE_LAMBDA {
        at.set(root_, root(at(from)));
        at.set(inverse_, inverse(at(from)));
    });
    for (int p = 0; p < count; ++p) {
        EXPECT_LE(lastDigits(roots[p], std::sqrt(in[p])), 2) << "root of " << in[p];
        EXPECT_LE(lastDigits(inverses[p], 1 / in[p]), 2) << "1 / " << in[p];
    }
}

TEST(forEachSimdPair, the_root_of_zero_is_nothing) {
    const double zero[1] = {0};
    double result[1] = {untouched};
    forEachSimdPair(1, [&](auto at) MPM_INLINE_LAMBDA { at.set(result, root(at(zero))); });
    EXPECT_GE(result[0], 0);
    EXPECT_LE(result[0], 1e-149);
}

// A node takes phi times the values, and B grad phi, whose component k is the sum of two lanes in 2D.
TEST(Lanes, give_values_and_products_with_the_gradient_in_2D) {
    const Lanes<2>::Set B{Quad{1, 2, 3, 4}};
    const Across<2> across{0.5, {0.25}};
    const Lanes<2>::Row row(quad(10), B, across);
    Pack<8> sum = Pack<8>::zero(), node = counted<8>();
    const double S = 2, G = -3;
    row.add(sum, S, G);
    Lanes<2>::finish(sum, node);
    const double phi = S * 0.5, dx = G * 0.5, dy = S * 0.25;
    for (int lane = 0; lane < 4; ++lane) EXPECT_EQ(node[lane], 1 + lane + phi * (10 + lane));
    EXPECT_EQ(node[4] + node[5], 5 + 6 + 1 * dx + 2 * dy);
    EXPECT_EQ(node[6] + node[7], 7 + 8 + 3 * dx + 4 * dy);
}

TEST(Lanes, give_values_and_products_with_the_gradient_in_3D) {
    const Lanes<3>::Set B{Quad{1, 2, 3, 0}, Quad{4, 5, 6, 0}, Quad{7, 8, 9, 0}, Quad{0, 0, 0, 11}};
    const Across<3> across{0.5, {0.25, 0.125}};
    const Lanes<3>::Row row(quad(10), B, across);
    Pack<8> sum = Pack<8>::zero(), node = Pack<8>::zero();
    const double S = 2, G = -3;
    row.add(sum, S, G);
    Lanes<3>::finish(sum, node);
    const double phi = S * 0.5, dx = G * 0.5, dy = S * 0.25, dz = S * 0.125;
    for (int lane = 0; lane < 4; ++lane) EXPECT_EQ(node[lane], phi * (10 + lane));
    for (int k = 0; k < 3; ++k) EXPECT_EQ(node[4 + k], (1 + k) * dx + (4 + k) * dy + (7 + k) * dz);
    EXPECT_EQ(node[7], 11 * phi);
}

TEST(largePages, arrays_begin_where_they_should_and_hold_zeros) {
    for (size_t bytes :
         {size_t(1), size_t(64), size_t(100000), largePage / 2, largePage + 1, 3 * largePage}) {
        const auto memory = zeroes(bytes);
        EXPECT_EQ(reinterpret_cast<std::uintptr_t>(memory.get()) % alignmentFor(bytes), 0u);
        const char* begin = static_cast<const char*>(memory.get());
        EXPECT_EQ(std::count(begin, begin + bytes, 0), long(bytes));
        std::vector<double, OnLargePages<double>> numbers(bytes / 8 + 1, 1.5);
        EXPECT_EQ(reinterpret_cast<std::uintptr_t>(numbers.data()) % alignmentFor(numbers.size() * 8), 0u);
    }
    EXPECT_EQ(alignmentFor(largePage / 2), largePage);
    EXPECT_EQ(alignmentFor(largePage / 2 - 1), cacheLine);
}
