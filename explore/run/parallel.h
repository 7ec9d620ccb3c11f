// Work on indices in parallel, that Ctrl-C and the first exception end.
#pragma once

#include "run/interrupt.h"

#include <atomic>
#include <cstdint>
#include <exception>
#include <mutex>
#include <oneapi/tbb.h>

namespace explore::run {

// How many threads to use when so many are asked for (0: as many as the machine has). One, with a warning on standard
// error, where the BLAS of the machine allows no more. Throws where memory has no room for them.
int usable_threads(int asked);
// How many evaluations to have under way: as many as that, and those that other processes of the job have room for.
int concurrency(int asked);

// Processor time of this thread.
std::int64_t thread_cpu_ns();

// Calls body(i) for i in [0, n) in parallel, each on its own. The first exception of a body comes out here, after all
// tasks have ended; indices not begun when it is thrown, or when the program is interrupted, are left out.
template <class Body>
void for_each_index(tbb::task_arena& arena, std::size_t n, const Body& body) {
    std::exception_ptr failure;
    std::mutex mutex;
    std::atomic<bool> failed{false};
    arena.execute([&] {
        tbb::parallel_for(
            tbb::blocked_range<std::size_t>(0, n, 1),
            [&](const tbb::blocked_range<std::size_t>& range) {
                for (std::size_t i = range.begin(); i < range.end() && !failed && !interrupted(); ++i) {
                    try {
                        body(i);
                    } catch (...) {
                        const std::scoped_lock lock(mutex);
                        failed = true;
                        failure = failure ? failure : std::current_exception();
                    }
                }
            },
            tbb::simple_partitioner());
    });
    if (failure) {
        std::rethrow_exception(failure);
    }
}

} // namespace explore::run
