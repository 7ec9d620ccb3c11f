// Work on indices in parallel, that Ctrl-C and the first exception end.
#pragma once

#include "run/interrupt.h"

#include <atomic>
#include <cstdint>
#include <exception>
#include <mutex>
#include <oneapi/tbb.h>
#ifdef PAVESCAPE_THREAD_SANITIZER
#include <sanitizer/tsan_interface.h>
#endif

namespace explore::run {

// How many threads to use when so many are requested (0: as many as the machine has). One, with a warning on standard
// error, where the BLAS of the machine allows no more. Throws where memory has no room for them.
int usable_threads(int asked);
// How many evaluations to have under way: as many as that, and those that other processes of the job have room for.
int concurrency(int asked);

// Processor time of this thread.
std::int64_t thread_cpu_ns();

// Writes before released(x) on one thread are seen by what follows acquired(x) on another. TBB orders its
// tasks; but its library is not built for the thread sanitizer, which does not see that and has to be told.
#ifdef PAVESCAPE_THREAD_SANITIZER
inline void released(void* x) {
    __tsan_release(x);
}
inline void acquired(void* x) {
    __tsan_acquire(x);
}
// Of what reads the objects of a task before it can say acquired().
#define EXPLORE_BEFORE_ACQUIRED __attribute__((no_sanitize("thread")))
#else
inline void released(void*) {}
inline void acquired(void*) {}
#define EXPLORE_BEFORE_ACQUIRED
#endif

// A body and how its calls end.
template <class Body>
class Loop {
public:
    explicit Loop(const Body& body) : body_(body) {}

    void run(tbb::task_arena& arena, std::size_t n) {
        released(&begun_);
        arena.execute([this, n]() EXPLORE_BEFORE_ACQUIRED { tasks(n); });
        acquired(&ended_);
        if (failure_) {
            std::rethrow_exception(failure_);
        }
    }

private:
    void tasks(std::size_t n) {
        acquired(&begun_);
        tbb::parallel_for(
            tbb::blocked_range<std::size_t>(0, n, 1),
            [this](const tbb::blocked_range<std::size_t>& range)
                EXPLORE_BEFORE_ACQUIRED { calls(range.begin(), range.end()); },
            tbb::simple_partitioner());
        released(&ended_);
    }

    void calls(std::size_t begin, std::size_t end) {
        acquired(&begun_);
        for (std::size_t i = begin; i < end && !failed_ && !interrupted(); ++i) {
            try {
                body_(i);
            } catch (...) {
                const std::scoped_lock lock(mutex_);
                failed_ = true;
                failure_ = failure_ ? failure_ : std::current_exception();
            }
        }
        released(&ended_);
    }

    const Body& body_;
    std::exception_ptr failure_;
    std::mutex mutex_;
    std::atomic<bool> failed_{false};
    char begun_ = 0, ended_ = 0; // by their addresses
};

// Calls body(i) for i in [0, n) in parallel, each on its own. The first exception of a body comes out here, after all
// tasks have ended; indices not begun when it is thrown, or when the program is interrupted, are left out.
template <class Body>
void for_each_index(tbb::task_arena& arena, std::size_t n, const Body& body) {
    Loop<Body>(body).run(arena, n);
}

} // namespace explore::run
