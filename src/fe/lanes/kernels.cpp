#include "fe/lanes/kernels.h"

namespace pave::fe::lanes {

namespace sse2 {
extern const Kernels table;
}
#ifdef PAVESCAPE_WIDE_LANES
namespace avx2 {
extern const Kernels table;
}
namespace avx512 {
extern const Kernels table;
}
#endif

int usable_kernels(const Kernels** list, int most) {
    int count = 0;
    const auto add = [&](const Kernels& kernels) {
        if (count < most) {
            list[count++] = &kernels;
        }
    };
#ifdef PAVESCAPE_WIDE_LANES
    const bool has_avx2 = __builtin_cpu_supports("avx2") != 0 && __builtin_cpu_supports("fma") != 0;
    if (has_avx2 && __builtin_cpu_supports("avx512f") != 0) {
        add(avx512::table);
    }
    if (has_avx2) {
        add(avx2::table);
    }
#endif
    add(sse2::table);
    return count;
}

const Kernels& kernels() {
    static const Kernels* const widest = [] {
        const Kernels* first = nullptr;
        usable_kernels(&first, 1);
        return first;
    }();
    return *widest;
}

} // namespace pave::fe::lanes
