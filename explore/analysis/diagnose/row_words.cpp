#include "analysis/diagnose/diagnose_verdict.h"

#include "base/text.h"

#include <fmt/format.h>

namespace explore::analysis {

using pave::figure;

namespace {

std::string readings_words(const diagnose::Row& row) {
    std::vector<std::string> list;
    for (const auto& term : row.hypothesis.terms) {
        list.push_back(term.on);
    }
    return pave::join(list, " and ");
}

} // namespace

std::string row_words(const diagnose::Row& row) {
    using hypotheses::Kind;
    const auto size = [&] { return row.sizes.empty() ? 0.0 : row.sizes[0].value; };
    if (row.hypothesis.kind == Kind::noise && !row.sizes.empty()) {
        const std::string& of = row.sizes[0].name;
        if (of == "noise_factor") {
            return fmt::format("the noise is some {} times as large as stated (95 %: {} to {})", figure(size(), 2),
                               figure(row.sizes[0].low, 2), figure(row.sizes[0].high, 2));
        }
        if (of == "common_relative") {
            return row.ends
                       ? fmt::format("errors of {} or more that the readings of a load share (common_relative)",
                                     percent(row.sizes[0].low))
                       : fmt::format("errors of some {} that the readings of a load share (common_relative; 95 %: {} "
                                     "to {})",
                                     percent(size()), percent(row.sizes[0].low), percent(row.sizes[0].high));
        }
        if (of == "correlation_m") {
            return fmt::format("errors that neighbouring readings share, over some {} mm (correlation_mm)",
                               figure(1e3 * size(), 1));
        }
        return row.hypothesis.name;
    }
    if (row.hypothesis.kind == Kind::readings) {
        return (row.hypothesis.terms.size() > 1 ? "wrong readings: " : "a wrong reading: ") + readings_words(row);
    }
    if (row.hypothesis.kind == Kind::correction) {
        return fmt::format("a smooth correction ({})", row.hypothesis.name);
    }
    return row.hypothesis.name;
}

} // namespace explore::analysis
