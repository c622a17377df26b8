// SPDX-License-Identifier: GPL-2.0-or-later
// Threads that stay together from step to step.
#pragma once

#include "mpm/base/parallel/Barrier.hpp"

#include <exception>
#include <functional>
#include <omp.h>

namespace mpm {

inline bool areTooMany(int threads) {
    static const int processors = omp_get_num_procs(); // it asks the system
    return threads > processors;
}

// Threads at hand for many calls of parallel(): an OpenMP region for each would take 1.8 us, like this it is 0.5.
class ThreadPool {
  public:
    // Calls f() on this thread, while the others stand by.
    template <class F> static void during(int threads, F&& f) {
        if (threads == 1 || mine_) return f();
        ThreadPool pool(threads);
        std::exception_ptr error;
#pragma omp parallel num_threads(threads)
        if (omp_get_thread_num() > 0)
            pool.standBy();
        else {
            mine_ = &pool;
            try {
                f();
            } catch (...) {
                error = std::current_exception();
            }
            mine_ = nullptr;
            pool.all(nullptr);
        }
        if (error) std::rethrow_exception(error);
    }

    // Calls f() on all of so many threads, those of this thread's pool if it has as many.
    static void run(int threads, const std::function<void()>& f) {
        if (mine_ && mine_->threads_ == threads) return mine_->all(&f);
#pragma omp parallel num_threads(threads) if (threads > 1)
        f();
    }

  private:
    explicit ThreadPool(int threads) : threads_(threads) {}

    void all(const std::function<void()>* f) {
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

    inline static thread_local ThreadPool* mine_ = nullptr;
    const int threads_;
    const std::function<void()>* task_ = nullptr; // for all of them; none: the end
    Barrier barrier_;
};

} // namespace mpm
