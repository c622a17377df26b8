// SPDX-License-Identifier: GPL-2.0-or-later
// Threads: every piece of work is done once, in an order that does not depend on their number, and errors come out.
#include "mpm/base/parallel/OrderedSum.hpp"
#include "mpm/base/parallel/ParallelRegion.hpp"
#include "mpm/base/parallel/relaxed.hpp"

#include <gtest/gtest.h>
#include <random>

using namespace mpm;

namespace {

const std::vector<int> threadNumbers{1, 2, 3, 8}; // more than the processors of most machines that run this

WorkPartition equalPieces(int n) {
    WorkPartition partition;
    partition.set(n, [](int) { return 1; });
    return partition;
}

std::vector<std::atomic<int>> counters(int n) {
    std::vector<std::atomic<int>> all(n);
    for (auto& c : all) c = 0;
    return all;
}

// Each piece and the next one share memory.
std::vector<std::vector<int>> chain(int n) {
    std::vector<std::vector<int>> neighbours(n);
    for (int i = 0; i + 1 < n; ++i) {
        neighbours[i].push_back(i + 1);
        neighbours[i + 1].push_back(i);
    }
    return neighbours;
}

std::vector<double> randomNumbers(int n) {
    std::mt19937 generator(7);
    std::uniform_real_distribution<double> between(-1, 1);
    std::vector<double> all(n);
    for (double& x : all) x = between(generator);
    return all;
}

} // namespace

TEST(ThreadPool, calls_every_thread_once_and_the_same_ones_again) {
    for (int threads : threadNumbers)
        ThreadPool::during(threads, {}, [&] {
            for (int call = 0; call < 50; ++call) {
                auto calls = counters(threads);
                ThreadPool::run(threads, [&] { ++calls[omp_get_thread_num()]; });
                for (auto& c : calls) EXPECT_EQ(c, 1);
            }
        });
}

// OpenMP may give fewer threads inside of a pool; the work is divided among those that there are.
TEST(ThreadPool, does_all_work_where_another_number_of_threads_is_wanted) {
    ThreadPool::during(2, {}, [&] {
        for (int threads : threadNumbers) {
            auto done = counters(100);
            parallel(threads, [&](ParallelRegion& region) {
                region.forPieces(equalPieces(100), [&](int i) { ++done[i]; });
            });
            for (auto& d : done) EXPECT_EQ(d, 1);
        }
    });
}

TEST(ThreadPool, inside_of_another_uses_that_one) {
    std::atomic<int> calls{0};
    ThreadPool::during(2, {}, [&] {
        ThreadPool::during(3, {}, [&] { ThreadPool::run(2, [&] { ++calls; }); });
        ThreadPool::run(2, [&] { ++calls; });
    });
    EXPECT_EQ(calls, 4);
}

TEST(ThreadPool, lets_an_error_out_and_ends_its_threads) {
    for (int threads : threadNumbers) {
        EXPECT_THROW(ThreadPool::during(threads, {}, [] { throw std::runtime_error("wanted"); }),
                     std::runtime_error);
        std::atomic<int> calls{0};
        ThreadPool::run(threads, [&] { ++calls; }); // no pool is left behind
        EXPECT_EQ(calls, threads);
    }
}

// Two threads: the first works for 40 ms, the other waits; then one of them works for 30 ms while the other waits in
// once(); then the first works for 20 ms outside of all regions.
TEST(ThreadPool, counts_the_time_of_its_threads_for_each_purpose) {
    ThreadUse unused, use, other;
    const auto sleep = [](int ms) { std::this_thread::sleep_for(std::chrono::milliseconds(ms)); };
    const auto begin = ThreadClock::Clock::now();
    ThreadPool::during(2, {&unused, &use, &other}, [&] {
        ThreadPool::countFor(1);
        parallel(2, [&](ParallelRegion& region) {
            if (omp_get_thread_num() == 0) sleep(40);
            region.wait();
            region.once([&] { sleep(30); });
        });
        sleep(20);
        ThreadPool::countFor(2);
        sleep(10);
    });
    const double all = ThreadClock::since(begin);
    EXPECT_LT(unused.alone, all); // what passes before the first purpose
    EXPECT_EQ(unused.busy + unused.waiting + other.busy + other.waiting, 0);
    EXPECT_GE(other.alone, 0.010);
    EXPECT_GE(use.alone, 0.050);
    EXPECT_GE(use.busy, 0.040);
    EXPECT_GE(use.waiting, 0.035); // the second thread may begin later than the first
    EXPECT_LE(use.alone + (use.busy + use.waiting) / 2 + unused.alone + other.alone, all + 1e-9);
    EXPECT_GE(use.alone + (use.busy + use.waiting) / 2, 0.090);
}

TEST(ThreadPool, of_one_thread_counts_nothing) {
    ThreadUse use;
    ThreadPool::during(1, {&use}, [] { ThreadPool::countFor(0); });
    EXPECT_EQ(use.alone + use.busy + use.waiting, 0);
}

TEST(Barrier, nobody_goes_on_before_all_are_there) {
    const int rounds = 50;
    for (int threads : threadNumbers) {
        std::atomic<int> arrived{0};
        std::atomic<bool> isEarly{false};
        parallel(threads, [&](ParallelRegion& region) {
            for (int round = 1; round <= rounds; ++round) {
                ++arrived;
                region.wait();
                if (arrived < threads * round) isEarly = true;
                region.wait();
            }
        });
        EXPECT_FALSE(isEarly);
        EXPECT_EQ(arrived, rounds * threads);
    }
}

TEST(ParallelRegion, does_each_piece_chunk_and_range_once) {
    const int n = 1000;
    const WorkPartition partition = equalPieces(n);
    for (int threads : threadNumbers) {
        auto pieces = counters(n), particles = counters(n), ranges = counters(n), weighted = counters(n);
        std::atomic<int> alone{0};
        const WorkPartition chunks = equalPieces(chunksOf(n));
        parallel(threads, [&](ParallelRegion& region) {
            region.forPieces(partition, [&](int i) { ++pieces[i]; });
            region.chunks(n, [&](int begin, int end) {
                EXPECT_LE(end - begin, chunkSize);
                for (int p = begin; p < end; ++p) ++particles[p];
            });
            region.chunksNoWait(n, chunks, [&](int begin, int end) {
                for (int p = begin; p < end; ++p) ++weighted[p];
            });
            region.forOwnRange(partition, [&](int begin, int end) {
                for (int i = begin; i < end; ++i) ++ranges[i];
            });
            region.once([&] { ++alone; });
            EXPECT_EQ(alone, 1); // on every thread: once() ends at a barrier
        });
        for (int i = 0; i < n; ++i)
            EXPECT_TRUE(pieces[i] == 1 && particles[i] == 1 && ranges[i] == 1 && weighted[i] == 1) << i;
    }
}

TEST(ParallelRegion, does_nothing_where_there_is_nothing) {
    WorkPartition nothing;
    nothing.set(0, [](int) { return 1; });
    for (int threads : threadNumbers)
        parallel(threads, [&](ParallelRegion& region) {
            region.forPieces(nothing, [](int) { FAIL(); });
            region.chunks(0, [](int, int) { FAIL(); });
            region.forOwnRange(nothing, [](int begin, int end) { EXPECT_EQ(begin, end); });
        });
}

TEST(ParallelRegion, throws_the_error_of_the_lowest_piece_and_does_the_others) {
    const int n = 500;
    const WorkPartition partition = equalPieces(n);
    for (int threads : threadNumbers) {
        auto done = counters(n);
        const auto work = [&](ParallelRegion& region) {
            region.forPieces(partition, [&](int i) {
                ++done[i];
                if (i % 100 == 77) throw std::runtime_error("piece " + std::to_string(i));
            });
            region.once([&] { EXPECT_TRUE(region.failed()); });
        };
        try {
            parallel(threads, work);
            ADD_FAILURE() << "nothing was thrown";
        } catch (const std::runtime_error& error) {
            EXPECT_STREQ(error.what(), "piece 77");
        }
        for (auto& d : done) EXPECT_EQ(d, 1);
    }
}

TEST(ParallelRegion, throws_a_later_error_of_a_lower_piece) {
    const WorkPartition partition = equalPieces(10);
    for (int threads : threadNumbers) {
        const auto work = [&](ParallelRegion& region) {
            region.forPieces(partition, [](int i) {
                if (i == 5) throw std::runtime_error("5");
            });
            region.forPieces(partition, [](int i) {
                if (i == 2) throw std::logic_error("2");
            });
        };
        EXPECT_THROW(parallel(threads, work), std::logic_error);
    }
}

// The sum of numbers of very different size into few places shows the order of the additions in its last digits.
TEST(ColouredPieces, sum_in_the_same_order_on_any_number_of_threads) {
    const int n = 300, rounds = 20;
    const std::vector<double> given = randomNumbers(n);
    const auto sums = [&](int threads, bool isColoured) {
        ColouredPieces pieces;
        pieces.graph(isColoured ? chain(n) : std::vector<std::vector<int>>(n));
        pieces.partition.set(n, [](int) { return 1; });
        std::vector<std::vector<int>> order(n + 1); // which pieces wrote to a place, in their order
        std::vector<double> sum(n + 1, 0.0);
        std::mutex mutex;
        parallel(threads, [&](ParallelRegion& region) {
            for (int round = 0; round < rounds; ++round)
                region.forColoured(pieces, [&](int i) {
                    const std::lock_guard<std::mutex> lock(mutex); // only so that the control is no race
                    for (int place : {i, i + 1}) {
                        sum[place] = 1.1 * sum[place] + given[i];
                        order[place].push_back(i);
                    }
                });
        });
        for (auto& writers : order) EXPECT_EQ(writers.size() % rounds, 0u);
        return sum;
    };
    const std::vector<double> alone = sums(1, true);
    for (int threads : threadNumbers) EXPECT_EQ(sums(threads, true), alone) << threads << " threads";
    // The control: pieces that are not told of their neighbours are done in the order of their numbers.
    EXPECT_NE(sums(1, false), alone);
}

TEST(ColouredPieces, have_as_many_colours_as_needed) {
    ColouredPieces pieces;
    EXPECT_EQ(pieces.graph(chain(7)), 2);
    EXPECT_EQ(pieces.count(), 7);
    EXPECT_EQ(pieces.graph({{1, 2}, {0, 2}, {0, 1}}), 3);
    EXPECT_EQ(pieces.graph(std::vector<std::vector<int>>(5)), 1);
    EXPECT_EQ(pieces.graph({}), 0);
}

TEST(ColouredPieces, neighbours_never_work_at_the_same_time) {
    const int n = 24;
    for (int threads : threadNumbers) {
        ColouredPieces pieces;
        pieces.graph(chain(n));
        pieces.partition.set(n, [](int i) { return i % 5; });
        auto busy = counters(n);
        std::atomic<bool> met{false};
        parallel(threads, [&](ParallelRegion& region) {
            for (int round = 0; round < 5; ++round)
                region.forColoured(pieces, [&](int i) {
                    ++busy[i];
                    if ((i > 0 && busy[i - 1]) || (i + 1 < n && busy[i + 1])) met = true;
                    std::this_thread::yield();
                    --busy[i];
                });
        });
        EXPECT_FALSE(met);
    }
}

TEST(ColouredPieces, go_on_after_an_error) {
    ColouredPieces pieces;
    pieces.graph(chain(20));
    pieces.partition.set(20, [](int) { return 1; });
    for (int threads : threadNumbers) {
        auto done = counters(20);
        const auto work = [&](ParallelRegion& region) {
            region.forColoured(pieces, [&](int i) {
                ++done[i];
                if (i % 2) throw std::runtime_error(std::to_string(i));
            });
        };
        try {
            parallel(threads, work);
            ADD_FAILURE() << "nothing was thrown";
        } catch (const std::runtime_error& error) {
            EXPECT_STREQ(error.what(), "1");
        }
        for (auto& d : done) EXPECT_EQ(d, 1);
    }
}

TEST(WorkPartition, gives_each_thread_a_range_of_about_its_weight) {
    WorkPartition partition;
    const int n = 1000;
    partition.set(n, [](int i) { return i < 500 ? 3.0 : 1.0; });
    for (int threads : threadNumbers) {
        std::vector<double> weight(threads, 0.0);
        for (int i = 0; i < n; ++i) {
            const int owner = partition.owner(i, threads);
            ASSERT_TRUE(owner >= 0 && owner < threads);
            EXPECT_GE(owner, partition.owner(std::max(i - 1, 0), threads));
            weight[owner] += i < 500 ? 3 : 1;
        }
        for (double w : weight) EXPECT_NEAR(w, 2000.0 / threads, 3);
    }
}

TEST(WorkPartition, takes_pieces_without_weight) {
    WorkPartition partition;
    partition.set(4, [](int) { return 0; });
    for (int i = 0; i < 4; ++i) EXPECT_EQ(partition.owner(i, 3), 0);
}

TEST(OrderedSum, is_the_same_for_any_number_of_threads) {
    const int n = 10000;
    const std::vector<double> given = randomNumbers(n);
    const auto sumOn = [&](int threads) {
        OrderedSum sum;
        sum.clear(n);
        parallel(threads, [&](ParallelRegion& region) {
            region.chunks(n, [&](int begin, int end) {
                for (int p = begin; p < end; ++p) sum.of(begin) += given[p];
            });
        });
        return sum.total();
    };
    for (int threads : threadNumbers) EXPECT_EQ(sumOn(threads), sumOn(1));
    // The control: in another order the last digits differ.
    EXPECT_NE(std::accumulate(given.rbegin(), given.rend(), 0.0), sumOn(1));
}

TEST(OrderedSum, has_a_term_for_each_chunk_and_forgets_them) {
    OrderedSum sum;
    sum.clear(2 * chunkSize + 1);
    for (int begin : {0, chunkSize, 2 * chunkSize}) sum.of(begin) += 1 + begin;
    EXPECT_EQ(sum.total(), 3 + 3 * chunkSize);
    sum.clear(1);
    EXPECT_EQ(sum.total(), 0);
}

TEST(relaxed, reads_what_was_written) {
    double clock = 1;
    storeRelaxed(clock, 2.5);
    EXPECT_EQ(loadRelaxed(clock), 2.5);
}
