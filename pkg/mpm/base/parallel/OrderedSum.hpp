// SPDX-License-Identifier: GPL-2.0-or-later
// Sums that do not depend on the number of threads.
#pragma once

#include "mpm/base/parallel/WorkPartition.hpp"

#include <numeric>

namespace mpm {

// A sum over chunks of particles: each chunk has its own term, and the terms are added in the order of the
// chunks.
class OrderedSum {
  public:
    void clear(int particles) { terms_.assign(chunksOf(particles), 0.0); }
    // The term of the chunk that begins with this particle.
    double& of(int begin) { return terms_[begin / chunkSize]; }
    double total() const { return std::accumulate(terms_.begin(), terms_.end(), 0.0); }

  private:
    std::vector<double> terms_;
};

} // namespace mpm
