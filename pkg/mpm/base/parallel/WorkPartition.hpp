// SPDX-License-Identifier: GPL-2.0-or-later
// How pieces of work are divided among the threads.
#pragma once

#include <algorithm>
#include <vector>

namespace mpm {

constexpr int chunkSize =
    128; // particles per piece where the order of pieces does not matter: few enough for the first cache

inline int chunksOf(int n) { return (n + chunkSize - 1) / chunkSize; }

// Pieces of work in a row, shared out so that each thread has a stretch of about the same weight: the next loop over the same
// part of the grid then finds it in the thread's own cache.
class WorkPartition {
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

} // namespace mpm
