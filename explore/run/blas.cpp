#include "run/blas.h"

#include <cstddef>
#include <dlfcn.h>
#include <sys/mman.h>

namespace explore::run {

bool prepare_blas() {
    if (auto* set_threads = reinterpret_cast<void (*)(int)>(dlsym(RTLD_DEFAULT, "openblas_set_num_threads"))) {
        set_threads(1);
    }
    auto* get_parallel = reinterpret_cast<int (*)()>(dlsym(RTLD_DEFAULT, "openblas_get_parallel"));
    return get_parallel == nullptr || get_parallel() != 0;
}

bool blas_has_room(int threads) {
    constexpr std::size_t buffer = std::size_t{160} << 20; // of a thread: 128 MB in Debian's build, and some to spare
    const std::size_t size = buffer * static_cast<std::size_t>(threads);
    void* const room = mmap(nullptr, size, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    if (room == MAP_FAILED) {
        return false;
    }
    munmap(room, size);
    return true;
}

} // namespace explore::run
