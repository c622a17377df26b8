// SPDX-License-Identifier: GPL-2.0-or-later
// Threads that stay together from step to step.
#pragma once

#include "mpm/base/parallel/Barrier.hpp"
#include "mpm/base/parallel/relaxed.hpp"
#include "mpm/base/public.hpp"

#include <exception>
#include <functional>
#include <omp.h>
#include <pthread.h>
#include <vector>

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
    // purposes: what the time of the threads is counted for, see countFor().
    template <class F> static void during(int threads, const std::vector<ThreadUse*>& purposes, F&& f) {
        if (threads == 1 || ofThisThread_ || isAlone_) return f();
        ThreadPool pool(threads, purposes.size());
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
        pool.tell(purposes);
        if (error) std::rethrow_exception(error);
    }

    // Calls f() on each of so many threads: those of this thread's pool if it has as many, or new ones.
    static void run(int threads, const std::function<void()>& f) {
        if (ofThisThread_ && ofThisThread_->threads_ == threads) return ofThisThread_->onAll(&f);
#pragma omp parallel num_threads(threads) if (threads > 1 && !isAlone_)
        f();
    }

    // What threads do from now on is for this purpose.
    static void countFor(int purpose) {
        if (ofThisThread_) ofThisThread_->change(purpose);
    }

    // To be called once. A process made by fork has none of the other threads, and GCC's OpenMP would wait for them
    // for ever: they end before the fork, and begin anew on both sides. Inside of a parallel region they cannot end, and
    // the child takes one thread from then on; the results are the same bits.
    static void surviveForks() {
        pthread_atfork([] { isForkedInside_ = omp_pause_resource_all(omp_pause_soft) != 0; }, nullptr,
                       [] {
                           ofThisThread_ = nullptr;
                           isAlone_ |= isForkedInside_;
                       });
    }

  private:
    using Clock = ThreadClock::Clock;
    using Uses = std::vector<ThreadUse>; // by purpose

    ThreadPool(int threads, size_t purposes) : threads_(threads), uses_(threads, Uses(purposes + 1)) {}

    void onAll(const std::function<void()>* f) {
        const auto begin = Clock::now();
        task_ = f;
        wait();
        if (!f) return;
        work(0);
        wait();
        uses_[0][purpose_].regions += ThreadClock::since(begin);
    }

    void standBy() {
        for (wait(); task_; wait()) {
            work(omp_get_thread_num());
            wait();
        }
    }

    void work(int thread) {
        const auto begin = Clock::now();
        ThreadClock clock;
        ThreadClock::mine = &clock;
        (*task_)();
        ThreadClock::mine = nullptr;
        ThreadUse& use = uses_[thread][purpose_];
        use.busy += ThreadClock::since(begin) - clock.waiting - clock.alone;
        use.alone += clock.alone;
    }

    void change(int purpose) {
        const auto now = Clock::now();
        uses_[0][purpose_].total += std::chrono::duration<double>(now - changed_).count();
        changed_ = now;
        purpose_ = purpose;
    }

    void tell(const std::vector<ThreadUse*>& purposes) {
        change(purpose_);
        for (size_t i = 0; i < purposes.size(); ++i) {
            double alone = 0, busy = 0; // in regions
            for (const Uses& uses : uses_) {
                alone += uses[i].alone;
                busy += uses[i].busy;
            }
            const double shared = uses_[0][i].regions - alone;
            const auto add = [](double& sum, double x) { storeRelaxed(sum, sum + x); };
            add(purposes[i]->alone, uses_[0][i].total - shared);
            add(purposes[i]->busy, busy);
            add(purposes[i]->waiting, threads_ * shared - busy);
        }
    }

    void wait() { barrier_.wait(omp_get_num_threads(), areTooMany(threads_)); }

    inline static thread_local ThreadPool* ofThisThread_ = nullptr;
    inline static thread_local bool isForkedInside_ = false; // of the fork that this thread makes
    inline static bool isAlone_ = false;                     // the other threads were lost in a fork
    const int threads_;
    std::vector<Uses> uses_; // of each thread
    int purpose_ = 0;
    Clock::time_point changed_ = Clock::now();
    const std::function<void()>* task_ = nullptr; // what all threads are to call; nullptr ends the pool
    Barrier barrier_;
};

} // namespace mpm
