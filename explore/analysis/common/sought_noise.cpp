#include "analysis/common/sought_noise.h"

#include "base/text.h"

#include <algorithm>
#include <fmt/format.h>

namespace explore::analysis {

std::string noise_scale_words(const study::Study& study, const problem::NoiseScale& scale) {
    using pave::figure;
    const auto measured = study.measured();
    const bool is_stated = study.data.states_noise() || std::any_of(measured.begin(), measured.end(),
                                                                    [](const auto& m) { return m.sigma.has_value(); });
    if (is_stated) {
        return fmt::format("The noise is {} times what is stated (95 %: {} to {}), as the readings themselves say.",
                           figure(scale.estimate, 3), figure(scale.low, 3), figure(scale.high, 3));
    }
    const double percent = 100.0 * measured[0].noise.relative;
    return fmt::format("The noise is {} % of each reading (95 %: {} to {} %), as the readings themselves say.",
                       figure(percent * scale.estimate, 3), figure(percent * scale.low, 3),
                       figure(percent * scale.high, 3));
}

} // namespace explore::analysis
