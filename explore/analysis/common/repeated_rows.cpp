#include "analysis/common/repeated_rows.h"

#include "base/error.h"
#include "base/text.h"

#include <fmt/format.h>
#include <map>
#include <tuple>

namespace explore::analysis {

std::string repeated_rows_words(const study::Study& study) {
    const auto cells = [](const data::Reading& r) {
        return std::tuple(r.name, r.load, r.quantity, r.x_mm, r.y_mm, r.depth_mm, r.gauge_mm, r.value, r.unit.name,
                          r.sigma, r.time_ms, r.censored);
    };
    std::map<decltype(cells(data::Reading())), const data::Reading*> first;
    std::vector<std::string> pairs;
    std::size_t count = 0;
    for (const data::Reading& reading : study.measured()) {
        const auto [known, is_new] = first.emplace(cells(reading), &reading);
        if (is_new) {
            continue;
        }
        ++count;
        constexpr std::size_t shown = 3;
        if (pairs.size() < shown) {
            pairs.push_back(fmt::format("{} ({}:{} and {}:{})", reading.label(), known->second->file,
                                        known->second->line, reading.file, reading.line));
        }
    }
    if (count == 0) {
        return "";
    }
    return fmt::format(
        "{} in every cell with one before: {}{}. Each counts as a reading of its own with an error of its "
        "own; where they are copies, every range is too narrow, and they have to be left out.",
        count == 1 ? "One reading agrees" : fmt::format("{} readings agree", count), pave::join(pairs),
        count > pairs.size() ? " and others" : "");
}

} // namespace explore::analysis
