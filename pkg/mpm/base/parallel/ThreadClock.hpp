// SPDX-License-Identifier: GPL-2.0-or-later
// Where the threads of a pool spend their time.
#pragma once

#include <chrono>

namespace mpm {

// Seconds that one thread of a pool spends in parallel regions. A thread that is in none has no clock, and nothing
// is measured.
struct ThreadClock {
    double waiting = 0; // for other threads
    double alone = 0;   // at work that the others wait for
    inline static thread_local ThreadClock* mine = nullptr;

    // Adds the time until it is destroyed to one of these numbers.
    class Adding {
      public:
        explicit Adding(double ThreadClock::* to) : sum_(mine ? &(mine->*to) : nullptr) {
            if (sum_) begin_ = Clock::now();
        }
        ~Adding() {
            if (sum_) *sum_ += since(begin_);
        }
        Adding(const Adding&) = delete;

      private:
        double* sum_;
        std::chrono::steady_clock::time_point begin_;
    };

    using Clock = std::chrono::steady_clock;
    static double since(Clock::time_point begin) {
        return std::chrono::duration<double>(Clock::now() - begin).count();
    }
};

// What threads do for one purpose, in seconds.
struct ThreadUse {
    double alone = 0;              // wall time in which one thread works
    double busy = 0;               // of all threads, at work that they share
    double waiting = 0;            // of all threads, while others are at work that they share
    double total = 0, regions = 0; // wall time, and that of parallel regions
};

} // namespace mpm
