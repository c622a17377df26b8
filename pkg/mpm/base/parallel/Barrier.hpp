// SPDX-License-Identifier: GPL-2.0-or-later
// Where the threads of a region wait for each other. OpenMP's own barrier makes a system call each time to
// wake sleepers, even if nobody sleeps: 0.86 us for two threads. This one takes 0.21 us, and a step has some
// twenty.
#pragma once

#include <atomic>
#include <condition_variable>
#include <mutex>
#include <thread>

namespace mpm {

class Barrier {
  public:
    // Returns when all threads have called it. A waiting thread first polls, then sleeps. With more threads
    // than processors each poll gives the processor to another thread.
    void wait(int threads, bool areTooMany) {
        const long mine = round_.load(std::memory_order_relaxed);
        if (arrived_.fetch_add(1, std::memory_order_acq_rel) == threads - 1) return open(mine);
        for (int polls = areTooMany ? pollsWhenYielding : pollsWhenSpinning; polls > 0; --polls) {
            if (round_.load(std::memory_order_acquire) != mine) return;
            areTooMany ? std::this_thread::yield() : pause();
        }
        sleep(mine);
    }

  private:
    // Tens of microseconds: longer than the threads of one stage differ, too short to disturb other jobs.
    static constexpr int pollsWhenSpinning = 2000;
    // Few: where another job wants the processor, a thread that yields gets it back only after milliseconds.
    static constexpr int pollsWhenYielding = 100;
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
