#include "run/parallel.h"

#include "run/blas.h"
#include "run/cluster.h"
#include "run/message.h"

#include <ctime>
#include <fmt/format.h>
#include <stdexcept>

namespace explore::run {

int usable_threads(int asked) {
    const Cluster* cluster = Cluster::current();
    const int threads = asked > 0            ? asked
                        : cluster != nullptr ? cluster->own_threads()
                                             : tbb::this_task_arena::max_concurrency();
    if (!prepare_blas() && threads > 1) {
        static std::once_flag said;
        std::call_once(said, [] {
            message("warning: the BLAS of this machine is a build of OpenBLAS without threads, which cannot be "
                    "used by two tasks at once; going on with one thread (package libopenblas0-pthread mends "
                    "this)\n");
        });
        return 1;
    }
    if (!blas_has_room(threads)) {
        throw std::runtime_error(fmt::format("there is not enough memory for {} thread{}; --threads asks for fewer",
                                             threads, threads == 1 ? "" : "s"));
    }
    return threads;
}

int concurrency(int asked) {
    const Cluster* cluster = Cluster::current();
    return usable_threads(asked) + (cluster != nullptr ? cluster->threads(asked) : 0);
}

std::int64_t thread_cpu_ns() {
    timespec t{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return std::int64_t{1'000'000'000} * t.tv_sec + t.tv_nsec;
}

} // namespace explore::run
