// SPDX-License-Identifier: GPL-2.0-or-later
// Deterministic threading in one place. Work is cut into pieces that do not depend on the number of
// threads; a piece is done by one thread in a fixed order, and sums are added up in the order of the
// pieces. Hence the same bits for any number of threads.
#pragma once

#include <algorithm>
#include <atomic>
#include <exception>
#include <limits>
#include <mutex>
#include <vector>

namespace mpm {

constexpr int chunkSize = 512; // particles per piece where the order of pieces does not matter

inline int chunksOf(int n) { return (n + chunkSize - 1) / chunkSize; }

// All threads of one parallel region. Every thread calls the same functions in the same order; each
// of them ends at a barrier. An exception is kept (that of the lowest piece, so it does not depend on
// the threads either) and rethrown when the region ends.
class Team {
  public:
    // Calls f(i) once for each piece i in [0, n).
    template <class F> void forEach(int n, F&& f) {
#pragma omp for schedule(dynamic, 1)
        for (int i = 0; i < n; ++i) guard(i, [&] { f(i); });
    }

    // Calls f(begin, end) for chunks of [0, n).
    template <class F> void chunks(int n, F&& f) {
        const int pieces = chunksOf(n);
#pragma omp for schedule(static)
        for (int c = 0; c < pieces; ++c)
            guard(c, [&] { f(c * chunkSize, std::min(n, (c + 1) * chunkSize)); });
    }

    // Pieces of neighbouring colours may touch the same nodes, pieces of one colour never do.
    template <class F> void twoColours(int n, F&& f) {
        for (int colour = 0; colour < 2; ++colour) forEach((n - colour + 1) / 2, [&](int i) { f(2 * i + colour); });
    }

    // One thread calls f while the others wait.
    template <class F> void once(F&& f) {
#pragma omp single
        guard(0, f);
    }

    // Whether a piece has thrown; the same answer for every thread after a barrier.
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

    std::mutex mutex_;
    std::exception_ptr error_;
    int where_ = std::numeric_limits<int>::max();
};

// Opens one parallel region; body(team) runs on every thread.
template <class F> void parallel(int threads, F&& body) {
    Team team;
#pragma omp parallel num_threads(threads) if (threads > 1)
    body(team);
    team.rethrow();
}

// Adds f(begin, end) over chunks of [0, n), always in the same order.
class OrderedSum {
  public:
    template <class F> void add(Team& team, int n, F&& f) {
        team.once([&] { parts_.assign(chunksOf(n), 0.0); });
        team.chunks(n, [&](int begin, int end) { parts_[begin / chunkSize] = f(begin, end); });
    }
    double total() const {
        double sum = 0;
        for (double part : parts_) sum += part;
        return sum;
    }

  private:
    std::vector<double> parts_;
};

} // namespace mpm
