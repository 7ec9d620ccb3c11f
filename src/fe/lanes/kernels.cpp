#include "fe/lanes/kernels.h"

#include <algorithm>
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
    const Kernels* narrowest = usable()[0];
    for (const Kernels* own : usable()) {
        if (own->lanes >= runs && own->lanes < narrowest->lanes && own->rounds_once == narrowest->rounds_once) {
            narrowest = own;
        }
    }
    return *narrowest;
}

} // namespace pave::fe::lanes
