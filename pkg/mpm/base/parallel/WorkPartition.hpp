// SPDX-License-Identifier: GPL-2.0-or-later
// How pieces of work are divided among the threads.
#pragma once

#include <algorithm>
#include <vector>

namespace mpm {

// Particles per chunk where the order of chunks does not matter: few enough for the first-level cache.
constexpr int chunkSize = 128;

inline int chunksOf(int n) { return (n + chunkSize - 1) / chunkSize; }

// Divides a row of pieces so that each thread has consecutive ones of about the same total weight: the next
// loop over the same part of the grid then finds it in the thread's own cache. Who does a piece never changes
// a result.
class WorkPartition {
  public:
    // weight(i): what piece i costs, in any unit.
    template <class Weight> void set(int n, Weight&& weight) {
        middle_.resize(n);
        double sum = 0;
        for (int i = 0; i < n; ++i) {
            const double w = weight(i);
            middle_[i] = sum + 0.5 * w;
            sum += w;
        }
        for (double& m : middle_) m = sum > 0 ? m / sum : 0;
    }
    int count() const { return int(middle_.size()); }
    int owner(int piece, int threads) const { return std::min(int(middle_[piece] * threads), threads - 1); }

  private:
    std::vector<double>
        middle_; // of each piece in the running sum of the weights, as a fraction of the total
};

} // namespace mpm
