// SPDX-License-Identifier: GPL-2.0-or-later
// Deterministic threading. Work is cut into pieces that do not depend on the number of threads, one thread
// does a piece in a fixed order, and sums are added in the order of the pieces. Hence the same bits for any
// number of threads.
#pragma once

#include "mpm/base/parallel/ColouredPieces.hpp"
#include "mpm/base/parallel/ThreadPool.hpp"

#include <mutex>

namespace mpm {

// What the threads of one parallel region do together. Every thread calls the same functions in the same
// order; each function ends at a barrier unless its name says NoWait. An exception does not end the loop that
// it comes from: the one of the lowest piece is kept (so it does not depend on the threads either) and
// rethrown when the region ends.
class ParallelRegion {
  public:
    // Calls f(i) once for each piece i.
    template <class F> void forPieces(const WorkPartition& partition, F&& f) {
        forPiecesNoWait(partition, f);
        wait();
    }

    // Threads go on before all pieces are done: until wait(), no thread may read what others have written.
    template <class F> void forPiecesNoWait(const WorkPartition& partition, F&& f) {
        const int me = omp_get_thread_num(), threads = omp_get_num_threads();
        for (int i = 0; i < partition.count(); ++i)
            if (partition.owner(i, threads) == me) guard(i, [&] { f(i); });
    }

    // Calls f(begin, end) on each thread with the range of pieces that it owns, which may be empty.
    template <class F> void forOwnRange(const WorkPartition& partition, F&& f) {
        const int me = omp_get_thread_num(), threads = omp_get_num_threads();
        int begin = 0, end = 0;
        for (int i = 0; i < partition.count(); ++i) {
            begin += partition.owner(i, threads) < me;
            end += partition.owner(i, threads) <= me;
        }
        guard(begin, [&] { f(begin, end); });
        wait();
    }

    // Calls f(i) once for each piece, never before those that it has to wait for. A thread does the pieces
    // that would have to wait after all its others, since what they wait for may be the last piece of another
    // thread.
    template <class F> void forColoured(ColouredPieces& pieces, F&& f) {
        const int me = omp_get_thread_num(), threads = omp_get_num_threads();
        const auto& sequence = pieces.sequence_;
        std::vector<int> later;
        for (size_t i = 0; i < sequence.size() + later.size(); ++i) {
            const bool isLater = i >= sequence.size();
            const int piece = isLater ? later[i - sequence.size()] : sequence[i];
            if (pieces.partition.owner(piece, threads) != me) continue;
            if (!isLater && !pieces.mayBegin(piece)) {
                later.push_back(piece);
                continue;
            }
            pieces.await(piece);
            guard(piece, [&] { f(piece); });
            pieces.finished(piece);
        }
        wait();
    }

    // Calls f(begin, end) for the chunks of [0, n); the same thread always does the same chunk.
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

    // The same, with the chunks divided by their weight.
    template <class F> void chunks(int n, const WorkPartition& partition, F&& f) {
        chunksNoWait(n, partition, f);
        wait();
    }
    template <class F> void chunksNoWait(int n, const WorkPartition& partition, F&& f) {
        forPiecesNoWait(partition, [&](int c) { f(c * chunkSize, std::min(n, (c + 1) * chunkSize)); });
    }

    // Returns when all threads are here.
    void wait() {
        if (const int threads = omp_get_num_threads(); threads > 1)
            barrier_.wait(threads, areTooMany(threads));
    }

    // One thread calls f while the others wait.
    template <class F> void once(F&& f) {
#pragma omp single nowait
        {
            const ThreadClock::Adding time(&ThreadClock::alone);
            guard(0, f);
        }
        wait();
    }

    // Whether a piece has thrown. Ask it where all threads get the same answer: inside once(), or behind a
    // barrier after which nothing throws.
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
            if (error_ && piece >= lowest_) return;
            error_ = std::current_exception();
            lowest_ = piece;
        }
    }

    Barrier barrier_;
    std::mutex mutex_;
    std::exception_ptr error_;
    int lowest_ = 0; // piece that threw error_
};

// Runs body(region) on each of so many threads, and throws what one of them has thrown.
template <class F> void parallel(int threads, F&& body) {
    ParallelRegion region;
    ThreadPool::run(threads, [&] { body(region); });
    region.rethrow();
}

} // namespace mpm
