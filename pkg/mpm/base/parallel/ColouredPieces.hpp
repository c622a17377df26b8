// SPDX-License-Identifier: GPL-2.0-or-later
// Pieces of work that share memory, coloured so that every number of threads sums in the same order.
#pragma once

#include "mpm/base/parallel/WorkPartition.hpp"

#include <atomic>
#include <memory>
#include <thread>

namespace mpm {

// Pieces of work some of which touch the same memory: whichever threads do them, these take turns in a fixed order. The
// pieces are coloured so that those of one colour have nothing in common, and a piece waits for the ones of lower colours
// that it has something in common with, not for the whole colour.
class ColouredPieces {
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
    WorkPartition partition; // to be set anew when the weights of the pieces have changed

  private:
    friend class ParallelRegion;
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

} // namespace mpm
