#include "run/blas.h"

#include <dlfcn.h>

namespace explore::run {

bool prepare_blas() {
    if (auto* set_threads = reinterpret_cast<void (*)(int)>(dlsym(RTLD_DEFAULT, "openblas_set_num_threads"))) {
        set_threads(1);
    }
    auto* get_parallel = reinterpret_cast<int (*)()>(dlsym(RTLD_DEFAULT, "openblas_get_parallel"));
    return get_parallel == nullptr || get_parallel() != 0;
}

} // namespace explore::run
