// SPDX-License-Identifier: GPL-2.0-or-later
// Pieces of work that share memory, coloured so that any number of threads sums in the same order.
#pragma once

#include "mpm/base/parallel/ThreadClock.hpp"
#include "mpm/base/parallel/WorkPartition.hpp"

#include <atomic>
#include <memory>
#include <thread>

namespace mpm {

// Pieces of work of which neighbours touch the same memory. Pieces of one colour have no memory in common. A
// piece waits for those neighbours that have a lower colour, not for all of that colour; so whichever threads
// do the pieces, each number in memory is written in a fixed order.
class ColouredPieces {
  public:
    // neighbours[i]: the pieces that piece i shares memory with, and the other way round. Returns the number
    // of colours.
    int graph(const std::vector<std::vector<int>>& neighbours) {
        const int n = int(neighbours.size());
        const std::vector<int> colour = coloursOf(neighbours);
        before_.assign(n, {});
        for (int i = 0; i < n; ++i)
            for (int other : neighbours[i])
                if (colour[other] < colour[i]) before_[i].push_back(other);
        sequence_.clear();
        std::vector<char> isIn(n, 0);
        for (int i = 0; i < n; ++i) append(i, isIn);
        timesDone_ = std::make_unique<std::atomic<long>[]>(n);
        for (int i = 0; i < n; ++i) timesDone_[i] = 0;
        return n == 0 ? 0 : *std::max_element(colour.begin(), colour.end()) + 1;
    }

    int count() const { return int(sequence_.size()); }
    WorkPartition partition; // to be set anew when the weights of the pieces have changed

  private:
    friend class ParallelRegion;
    static constexpr int pollsBeforeYielding = 1000; // then there may be more threads than processors

    std::vector<int> sequence_;                      // pieces in the order in which a thread does its own
    std::vector<std::vector<int>> before_;           // before_[i]: pieces that piece i waits for
    std::unique_ptr<std::atomic<long>[]> timesDone_; // how many times each piece has been done

    // Each piece takes the lowest colour that none of its neighbours has yet.
    static std::vector<int> coloursOf(const std::vector<std::vector<int>>& neighbours) {
        const int n = int(neighbours.size());
        std::vector<int> colour(n, -1);
        int colours = 0;
        for (int i = 0; i < n; ++i) {
            std::vector<char> isTaken(colours + 1, 0);
            for (int other : neighbours[i])
                if (colour[other] >= 0) isTaken[colour[other]] = 1;
            colour[i] = int(std::find(isTaken.begin(), isTaken.end(), 0) - isTaken.begin());
            colours = std::max(colours, colour[i] + 1);
        }
        return colour;
    }

    // A piece comes right behind those that it waits for: the memory that they share is still in the cache
    // then.
    void append(int piece, std::vector<char>& isIn) {
        if (isIn[piece]) return;
        for (int other : before_[piece]) append(other, isIn);
        sequence_.push_back(piece);
        isIn[piece] = 1;
    }

    bool mayBegin(int piece) const {
        const long round = timesDone_[piece].load(std::memory_order_relaxed);
        return std::all_of(before_[piece].begin(), before_[piece].end(), [&](int other) {
            return timesDone_[other].load(std::memory_order_acquire) > round;
        });
    }
    void await(int piece) const {
        if (mayBegin(piece)) return;
        const ThreadClock::Adding time(&ThreadClock::waiting);
        for (int polls = 0; !mayBegin(piece); ++polls)
            if (polls > pollsBeforeYielding) std::this_thread::yield();
    }
    void finished(int piece) { timesDone_[piece].fetch_add(1, std::memory_order_release); }
};

} // namespace mpm
