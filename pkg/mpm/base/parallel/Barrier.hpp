// SPDX-License-Identifier: GPL-2.0-or-later
// Where the threads of a region wait for each other. OpenMP's own barrier makes a system call each time to
// wake sleepers, even if nobody sleeps: 0.86 us for two threads. This one takes 0.21 us, and a step has some
// twenty.
#pragma once

#include "mpm/base/parallel/ThreadClock.hpp"

#include <atomic>
#include <condition_variable>
#include <mutex>
#include <thread>

namespace mpm {

class Barrier {
  public:
    // Returns when all threads have called it. A waiting thread first polls, then gives the processor to other
    // threads between its polls, then sleeps.
    void wait(int threads, bool areTooMany) {
        const long mine = round_.load(std::memory_order_relaxed);
        if (arrived_.fetch_add(1, std::memory_order_acq_rel) == threads - 1) return open(mine);
        const ThreadClock::Adding time(&ThreadClock::waiting);
        const auto poll = [&](int polls, auto&& between) {
            for (; polls > 0; --polls, between())
                if (round_.load(std::memory_order_acquire) != mine) return true;
            return false;
        };
        if (!areTooMany && poll(pollsWhenSpinning, pause)) return;
        if (poll(areTooMany ? pollsOfTooMany : pollsWhenYielding, std::this_thread::yield)) return;
        sleep(mine);
    }

  private:
    // A microsecond. Where threads share a processor, since another job has theirs, each wait costs as much: with 2000
    // the sheet pile on two threads takes two to three times as long there, and no less on free processors.
    static constexpr int pollsWhenSpinning = 50;
    // Longer than one thread alone is at work in a step, for contact and implicit bodies: to be woken takes 50 us, at
    // each of these parts. Two runs of two threads on two processors take half the time that they take with a thread
    // that sleeps at once, and a fifteenth of it with one that spins so long.
    static constexpr int pollsWhenYielding = 1000;
    // Few: where another job wants the processor, a thread that yields gets it back only after milliseconds.
    static constexpr int pollsOfTooMany = 100;
    static constexpr int cacheLine = 64; // bytes

    // Each on a cache line of its own, so that polling threads do not slow down those that arrive.
    alignas(cacheLine) std::atomic<int> arrived_{0};
    alignas(cacheLine) std::atomic<long> round_{0};
    alignas(cacheLine) std::atomic<int> asleep_{0};
    std::mutex mutex_;
    std::condition_variable wake_;

    void open(long mine) {
        arrived_.store(0, std::memory_order_relaxed);
        round_.store(mine + 1);
        if (asleep_.load() == 0) return; // a thread that goes to sleep after this sees the new round
        std::lock_guard<std::mutex> lock(mutex_);
        wake_.notify_all();
    }

    void sleep(long mine) {
        std::unique_lock<std::mutex> lock(mutex_);
        ++asleep_;
        wake_.wait(lock, [&] { return round_.load() != mine; });
        --asleep_;
    }

    static void pause() {
#ifdef __x86_64__
        __builtin_ia32_pause();
#endif
    }
};

} // namespace mpm
