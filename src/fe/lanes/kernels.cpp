#include "fe/lanes/kernels.h"

#include <algorithm>
#include <span>
#include <vector>

namespace pave::fe::lanes {

namespace sse2 {
extern const Kernels table;
}
#ifdef PAVESCAPE_WIDE_LANES
namespace fma2 {
extern const Kernels table;
}
namespace avx2 {
extern const Kernels table;
}
namespace avx512vl {
extern const Kernels table;
}
namespace avx512 {
extern const Kernels table;
}
#endif

namespace {

// Whether a processor that has vectors of 512 bits computes them in two halves, as AMD's family 19h (Zen 4): four lanes
// then take as many operations, and half the memory.
bool has_halves() {
#ifdef PAVESCAPE_WIDE_LANES
    return __builtin_cpu_is("amdfam19h") != 0;
#else
    return false;
#endif
}

const std::vector<const Kernels*>& usable() {
    static const std::vector<const Kernels*> all = [] {
        std::vector<const Kernels*> list;
#ifdef PAVESCAPE_WIDE_LANES
        if (__builtin_cpu_supports("avx2") != 0 && __builtin_cpu_supports("fma") != 0) {
            const bool has_avx512 = __builtin_cpu_supports("avx512f") != 0;
            if (has_avx512) {
                list.push_back(&avx512::table);
            }
            if (has_avx512 && __builtin_cpu_supports("avx512vl") != 0) {
                list.push_back(&avx512vl::table);
            }
            list.push_back(&avx2::table);
            list.push_back(&fma2::table);
        }
#endif
        list.push_back(&sse2::table);
        return list;
    }();
    return all;
}

} // namespace

int usable_kernels(const Kernels** list, int most) {
    const auto count = std::min(usable().size(), static_cast<std::size_t>(most));
    std::copy_n(usable().begin(), count, list);
    return static_cast<int>(count);
}

const Kernels& kernels(int runs) {
    std::span<const Kernels* const> list = usable();
    if (list[0]->lanes == most_lanes && has_halves()) {
        list = list.subspan(1);
    }
    const Kernels* narrowest = list[0];
    for (const Kernels* own : list) {
        if (own->lanes >= runs && own->lanes < narrowest->lanes && own->rounds_once == narrowest->rounds_once) {
            narrowest = own;
        }
    }
    return *narrowest;
}

} // namespace pave::fe::lanes
