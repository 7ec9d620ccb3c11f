#include "fe/lanes/kernels.h"

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
        add(fma2::table);
    }
#endif
    add(sse2::table);
    return count;
}

const Kernels& kernels(int runs) {
    struct Usable {
        const Kernels* list[4] = {};
        int count = 0;
    };
    static const Usable usable = [] {
        Usable all;
        all.count = usable_kernels(all.list, 4);
        return all;
    }();
    const Kernels* narrowest = usable.list[0];
    for (int i = 1; i < usable.count && usable.list[i]->lanes >= runs; ++i) {
        if (usable.list[i]->rounds_once == narrowest->rounds_once) {
            narrowest = usable.list[i];
        }
    }
    return *narrowest;
}

} // namespace pave::fe::lanes
