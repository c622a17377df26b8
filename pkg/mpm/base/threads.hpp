// SPDX-License-Identifier: GPL-2.0-or-later
// Deterministic threading in one place. Work is cut into pieces that do not depend on the number of
// threads; a piece is done by one thread in a fixed order, and sums are added up in the order of the
// pieces. Hence the same bits for any number of threads.
#pragma once

#include "mpm/base/Crew.hpp"

#include <algorithm>
#include <atomic>
#include <exception>
#include <limits>
#include <memory>
#include <mutex>
#include <numeric>
#include <omp.h>
#include <thread>
#include <vector>

namespace mpm {

// A number that other threads look at while it changes: the clock of a run in the background.
template <class T> T watched(const T& x) {
    T value;
    __atomic_load(&x, &value, __ATOMIC_RELAXED);
    return value;
}
template <class T> void setWatched(T& x, T value) { __atomic_store(&x, &value, __ATOMIC_RELAXED); }

constexpr int chunkSize =
    128; // particles per piece where the order of pieces does not matter: few enough for the first cache

inline int chunksOf(int n) { return (n + chunkSize - 1) / chunkSize; }

// Pieces of work in a row, shared out so that each thread has a stretch of about the same weight: the next loop over the same
// part of the grid then finds it in the thread's own cache.
class Shares {
  public:
    template <class Weight> void set(int n, Weight&& weight) {
        middle_.resize(n);
        double sum = 0;
        for (int i = 0; i < n; ++i) {
            const double w = weight(i);
            middle_[i] = sum + 0.5 * w, sum += w;
        }
        for (double& m : middle_) m = sum > 0 ? m / sum : 0;
    }
    int count() const { return int(middle_.size()); }
    int owner(int piece, int threads) const { return std::min(int(middle_[piece] * threads), threads - 1); }

  private:
    std::vector<double> middle_; // of a piece, in the running sum of the weights over the total
};

// Pieces of work some of which touch the same memory: whichever threads do them, these take turns in a fixed order. The
// pieces are coloured so that those of one colour have nothing in common, and a piece waits for the ones of lower colours
// that it has something in common with, not for the whole colour.
class Turns {
  public:
    // neighbours[i]: the pieces that piece i shares memory with. Returns the number of colours.
    int graph(const std::vector<std::vector<int>>& neighbours) {
        const int n = int(neighbours.size());
        std::vector<int> colour(n, -1);
        int colours = 0;
        for (int i = 0; i < n; ++i) {
            std::vector<char> taken(colours + 1, 0);
            for (int other : neighbours[i])
                if (colour[other] >= 0) taken[colour[other]] = 1;
            colour[i] = int(std::find(taken.begin(), taken.end(), 0) - taken.begin());
            colours = std::max(colours, colour[i] + 1);
        }
        before_.assign(n, {});
        for (int i = 0; i < n; ++i)
            for (int other : neighbours[i])
                if (colour[other] < colour[i]) before_[i].push_back(other);
        sequence_.clear();
        std::vector<char> isIn(n, 0);
        for (int i = 0; i < n; ++i) append(i, isIn);
        done_ = std::make_unique<std::atomic<long>[]>(n);
        for (int i = 0; i < n; ++i) done_[i] = 0;
        return colours;
    }

    int count() const { return int(sequence_.size()); }
    Shares shares; // to be set anew when the weights of the pieces have changed

  private:
    friend class Team;
    std::vector<int> sequence_;                 // pieces in the order in which a thread takes its own
    std::vector<std::vector<int>> before_;      // pieces that piece i waits for
    std::unique_ptr<std::atomic<long>[]> done_; // how many times each piece has been done

    // A piece, right behind those that it waits for: what it has in common with them is still in the cache then.
    void append(int piece, std::vector<char>& isIn) {
        if (isIn[piece]) return;
        for (int other : before_[piece]) append(other, isIn);
        sequence_.push_back(piece), isIn[piece] = 1;
    }

    bool mayBegin(int piece) const {
        const long round = done_[piece].load(std::memory_order_relaxed);
        return std::all_of(before_[piece].begin(), before_[piece].end(),
                           [&](int other) { return done_[other].load(std::memory_order_acquire) > round; });
    }
    void await(int piece) const {
        for (int spins = 0; !mayBegin(piece); ++spins)
            if (spins > 1000) std::this_thread::yield(); // more threads than cores
    }
    void finished(int piece) { done_[piece].fetch_add(1, std::memory_order_release); }
};

// All threads of one parallel region. Every thread calls the same functions in the same order; each
// of them ends at a barrier, unless it says otherwise. An exception is kept (that of the lowest piece, so it does not depend on
// the threads either) and rethrown when the region ends.
class Team {
  public:
    // Calls f(i) once for each piece i.
    template <class F> void inShares(const Shares& shares, F&& f) {
        inSharesNoWait(shares, f);
        wait();
    }

    // Threads go on before all pieces are done: until wait(), nobody may read what others have written.
    template <class F> void inSharesNoWait(const Shares& shares, F&& f) {
        const int me = omp_get_thread_num(), threads = omp_get_num_threads();
        for (int i = 0; i < shares.count(); ++i)
            if (shares.owner(i, threads) == me) guard(i, [&] { f(i); });
    }

    // Calls f(begin, end) with the stretch of pieces that this thread has.
    template <class F> void inStretches(const Shares& shares, F&& f) {
        const int me = omp_get_thread_num(), threads = omp_get_num_threads();
        int begin = 0, end = 0;
        for (int i = 0; i < shares.count(); ++i)
            begin += shares.owner(i, threads) < me, end += shares.owner(i, threads) <= me;
        guard(begin, [&] { f(begin, end); });
        wait();
    }

    // Calls f(i) once for each piece of `turns`. A piece that has to wait comes after all others of the thread: what it waits for may be the
    // last that another thread does.
    template <class F> void inTurns(Turns& turns, F&& f) {
        const int me = omp_get_thread_num(), threads = omp_get_num_threads();
        const auto& sequence = turns.sequence_;
        std::vector<int> later;
        for (size_t i = 0; i < sequence.size() + later.size(); ++i) {
            const bool isLater = i >= sequence.size();
            const int piece = isLater ? later[i - sequence.size()] : sequence[i];
            if (turns.shares.owner(piece, threads) != me) continue;
            if (!isLater && !turns.mayBegin(piece)) {
                later.push_back(piece);
                continue;
            }
            turns.await(piece);
            guard(piece, [&] { f(piece); });
            turns.finished(piece);
        }
        wait();
    }

    // Calls f(begin, end) for chunks of [0, n); always the same thread for the same chunk.
    template <class F> void chunks(int n, F&& f) {
        chunksNoWait(n, f);
        wait();
    }

    template <class F> void chunksNoWait(int n, F&& f) {
        const int pieces = chunksOf(n);
#pragma omp for schedule(static) nowait
        for (int c = 0; c < pieces; ++c)
            guard(c, [&] { f(c * chunkSize, std::min(n, (c + 1) * chunkSize)); });
    }

    // Chunks of [0, n), shared out by their weight.
    template <class F> void chunksNoWait(int n, const Shares& shares, F&& f) {
        inSharesNoWait(shares, [&](int c) { f(c * chunkSize, std::min(n, (c + 1) * chunkSize)); });
    }

    // Until all threads are here.
    void wait() {
        if (const int threads = omp_get_num_threads(); threads > 1)
            barrier_.wait(threads, areTooMany(threads));
    }

    // One thread calls f while the others wait.
    template <class F> void once(F&& f) {
#pragma omp single nowait
        guard(0, f);
        wait();
    }

    // Whether a piece has thrown. To be asked where all threads get the same answer: inside once(), or behind a barrier that
    // nothing which throws can follow.
    bool failed() const { return bool(error_); }

    void rethrow() {
        if (error_) std::rethrow_exception(error_);
    }

  private:
    template <class F> void guard(int piece, F&& f) {
        try {
            f();
        } catch (...) {
            std::lock_guard<std::mutex> lock(mutex_);
            if (!error_ || piece < where_) error_ = std::current_exception(), where_ = piece;
        }
    }

    Barrier barrier_;
    std::mutex mutex_;
    std::exception_ptr error_;
    int where_ = std::numeric_limits<int>::max();
};

// body(team) runs on every thread.
template <class F> void parallel(int threads, F&& body) {
    Team team;
    Crew::call(threads, [&] { body(team); });
    team.rethrow();
}

// Sums over chunks of particles: each chunk has its own term, and they are added up in the order of the chunks.
class OrderedSum {
  public:
    void clear(int n) { terms_.assign(chunksOf(n), 0.0); }
    double& of(int begin) { return terms_[begin / chunkSize]; }
    double total() const { return std::accumulate(terms_.begin(), terms_.end(), 0.0); }

  private:
    std::vector<double> terms_;
};

} // namespace mpm
