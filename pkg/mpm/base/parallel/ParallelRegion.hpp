// SPDX-License-Identifier: GPL-2.0-or-later
// Deterministic threading. Work is cut into pieces that do not depend on the number of
// threads; a piece is done by one thread in a fixed order, and sums are added up in the order of the
// pieces. Hence the same bits for any number of threads.
#pragma once

#include "mpm/base/parallel/ColouredPieces.hpp"
#include "mpm/base/parallel/ThreadPool.hpp"

#include <limits>

namespace mpm {

// All threads of one parallel region. Every thread calls the same functions in the same order; each
// of them ends at a barrier, unless it says otherwise. An exception is kept (that of the lowest piece, so it does not depend on
// the threads either) and rethrown when the region ends.
class ParallelRegion {
  public:
    // Calls f(i) once for each piece i.
    template <class F> void forPieces(const WorkPartition& partition, F&& f) {
        forPiecesNoWait(partition, f);
        wait();
    }

    // Threads go on before all pieces are done: until wait(), nobody may read what others have written.
    template <class F> void forPiecesNoWait(const WorkPartition& partition, F&& f) {
        const int me = omp_get_thread_num(), threads = omp_get_num_threads();
        for (int i = 0; i < partition.count(); ++i)
            if (partition.owner(i, threads) == me) guard(i, [&] { f(i); });
    }

    // Calls f(begin, end) with the stretch of pieces that this thread has.
    template <class F> void forOwnRange(const WorkPartition& partition, F&& f) {
        const int me = omp_get_thread_num(), threads = omp_get_num_threads();
        int begin = 0, end = 0;
        for (int i = 0; i < partition.count(); ++i)
            begin += partition.owner(i, threads) < me, end += partition.owner(i, threads) <= me;
        guard(begin, [&] { f(begin, end); });
        wait();
    }

    // Calls f(i) once for each piece of `turns`. A piece that has to wait comes after all others of the thread: what it waits for may be the
    // last that another thread does.
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
    template <class F> void chunksNoWait(int n, const WorkPartition& partition, F&& f) {
        forPiecesNoWait(partition, [&](int c) { f(c * chunkSize, std::min(n, (c + 1) * chunkSize)); });
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

// body(region) runs on every thread.
template <class F> void parallel(int threads, F&& body) {
    ParallelRegion region;
    ThreadPool::run(threads, [&] { body(region); });
    region.rethrow();
}

} // namespace mpm
