#include "analysis/common/run_cost.h"

#include "base/error.h"
#include "base/memory_limit.h"
#include "base/text.h"

#include <fmt/format.h>

namespace explore::analysis {

pave::pavement::ForwardModel::Cost affordable_cost(const study::Study& study, int threads) {
    if (study.has_own_model) { // not known
        return {};
    }
    constexpr double giga = 1e9;
    const auto cost = pave::pavement::ForwardModel(study.model).cost();
    const double limit = pave::memory_limit();
    if (threads * cost.memory > limit) {
        const auto fit = static_cast<int>(limit / cost.memory);
        throw pave::Error({.file = study.file, .key = "mesh.refine"},
                          fmt::format("runs on {} need more memory than there is",
                                      pave::counted(static_cast<std::size_t>(threads), "thread", "threads")),
                          fmt::format("some {:.1f} GB a thread", cost.memory / giga),
                          fmt::format("{:.1f} GB in all: {}a smaller refine or extent_m", limit / giga,
                                      fit > 0 ? fmt::format("--threads {} or ", fit) : ""));
    }
    return cost;
}

} // namespace explore::analysis
