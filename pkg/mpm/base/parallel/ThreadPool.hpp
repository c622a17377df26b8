// SPDX-License-Identifier: GPL-2.0-or-later
// Threads that stay together from step to step.
#pragma once

#include "mpm/base/parallel/Barrier.hpp"
#include "mpm/base/public.hpp"

#include <exception>
#include <functional>
#include <omp.h>

namespace mpm {

inline bool areTooMany(int threads) {
    static const int processors = omp_get_num_procs(); // a system call
    return threads > processors;
}

// Threads that wait for many calls of parallel(): entering one takes 0.5 us with them, and 1.8 us as an
// OpenMP region.
class MPM_PUBLIC ThreadPool {
  public:
    // Calls f() on this thread while the others of a new pool stand by for run(). Inside of another during()
    // of this thread, and for one thread, f() is all that happens.
    template <class F> static void during(int threads, F&& f) {
        if (threads == 1 || ofThisThread_) return f();
        ThreadPool pool(threads);
        std::exception_ptr error;
#pragma omp parallel num_threads(threads)
        if (omp_get_thread_num() > 0)
            pool.standBy();
        else {
            ofThisThread_ = &pool;
            try {
                f();
            } catch (...) {
                error = std::current_exception();
            }
            ofThisThread_ = nullptr;
            pool.onAll(nullptr);
        }
        if (error) std::rethrow_exception(error);
    }

    // Calls f() on each of so many threads: those of this thread's pool if it has as many, or new ones.
    static void run(int threads, const std::function<void()>& f) {
        if (ofThisThread_ && ofThisThread_->threads_ == threads) return ofThisThread_->onAll(&f);
#pragma omp parallel num_threads(threads) if (threads > 1)
        f();
    }

  private:
    explicit ThreadPool(int threads) : threads_(threads) {}

    void onAll(const std::function<void()>* f) {
        task_ = f;
        wait();
        if (!f) return;
        (*f)();
        wait();
    }

    void standBy() {
        for (wait(); task_; wait()) {
            (*task_)();
            wait();
        }
    }

    void wait() { barrier_.wait(omp_get_num_threads(), areTooMany(threads_)); }

    inline static thread_local ThreadPool* ofThisThread_ = nullptr;
    const int threads_;
    const std::function<void()>* task_ = nullptr; // what all threads are to call; nullptr ends the pool
    Barrier barrier_;
};

} // namespace mpm
