#include "analysis/sample/sensitivity.h"

#include "base/error.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <numeric>

namespace explore::analysis {

std::vector<std::size_t> ranked(const landscape::SobolIndices& g) {
    std::vector<std::size_t> order(g.total.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return g.total[a].value > g.total[b].value; });
    return order;
}

std::vector<std::string> findings(const SensitivityResult& s) {
    const problem::ParameterSpace& space = s.study.space;
    constexpr double negligible = 0.05; // of the variance
    std::vector<std::string> words;
    std::vector<bool> matters(space.axes.size(), false);
    double widest = 0.0;
    bool beyond = false; // an estimate above all of the variance
    for (std::size_t i = 0; i < s.global.responses.size(); ++i) {
        const auto& g = s.global.responses[i];
        const std::string name = s.study.readings[s.responses[i]].label();
        if (!std::isfinite(g.total[0].value)) {
            words.push_back(name + " does not vary over the box.");
            continue;
        }
        const auto order = ranked(g);
        std::vector<std::string> parts;
        for (const std::size_t k : order) {
            widest = std::max(widest, (g.total[k].high - g.total[k].low) / 2.0);
            matters[k] = matters[k] || g.total[k].high >= negligible;
            if (parts.empty() || (parts.size() < 3 && g.total[k].value >= negligible)) {
                const double share = g.total[k].value;
                beyond = beyond || share > 1.0;
                parts.push_back(
                    fmt::format("{} ({}{})", space.axes[k].name,
                                share > 1.0 ? std::string("nearly all") : fmt::format("{:.0f} %", 100.0 * share),
                                parts.empty() ? " of its variance" : ""));
            }
        }
        std::string sentence = name + " is governed by " + pave::join(parts, ", then ");
        if (g.interactions.low >= negligible) {
            sentence += fmt::format("; {:.0f} % come from parameters acting together, counted here for each of them",
                                    100.0 * g.interactions.value);
        }
        if (order.size() > 1 && g.total[order[1]].high > g.total[order[0]].low) {
            sentence += fmt::format("; the sample does not settle which of {} and {} comes first",
                                    space.axes[order[0]].name, space.axes[order[1]].name);
        }
        words.push_back(sentence + ".");
    }
    std::vector<std::string> idle;
    for (std::size_t k = 0; k < space.axes.size(); ++k) {
        if (!matters[k]) {
            idle.push_back(space.axes[k].name);
        }
    }
    if (widest > 0.0 && !idle.empty()) {
        words.push_back(fmt::format("Within its bounds it hardly matters to any of these responses (total index below "
                                    "{}): {}. They will not determine it.",
                                    negligible, pave::join(idle)));
    }
    if (s.global.complete < s.global.rows) {
        words.push_back(fmt::format(
            "{} of {} rows of the sample ({:.1f} %) hold a point without an answer and were left out whole: the "
            "indices "
            "describe the part of the box that has answers, where the parameters are no longer independent.",
            s.global.rows - s.global.complete, s.global.rows,
            100.0 * static_cast<double>(s.global.rows - s.global.complete) / static_cast<double>(s.global.rows)));
    }
    if (beyond) {
        words.push_back(
            fmt::format("{} rows are too few for these shares: an estimate lies above 100 %, where no share "
                        "can be, and its interval is not to be relied on. More --samples mend it.",
                        s.global.complete));
    }
    if (s.global.complete < 2) {
        words.emplace_back("Too few rows are left for global indices.");
    } else if (widest > 0.1) {
        words.push_back(fmt::format("The widest of the 95 % intervals of a total index is +-{:.2f}: more --samples "
                                    "narrow it, and what is computed is kept.",
                                    widest));
    }
    return words;
}

} // namespace explore::analysis
