// SPDX-License-Identifier: GPL-2.0-or-later
// Sums that do not depend on the number of threads.
#pragma once

#include "mpm/base/parallel/WorkPartition.hpp"

#include <numeric>

namespace mpm {

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
