#include "analysis/common/range_shape.h"

#include "base/error.h"
#include "base/text.h"
#include "landscape/held_ranges.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace explore::analysis {
namespace {

using landscape::Range;
using landscape::Uniqueness;

std::string reason_for(const problem::Problem& problem, const Uniqueness& u, std::size_t k, double below,
                       double above) {
    std::string words = what_shapes(problem, u, u.parameters[k]);
    if (words.empty() && !u.minima[0].on_bound.empty()) {
        words = "held by " + pave::join(landscape::bound_words(problem.space, u.minima[0].on_bound));
    }
    if (words.empty()) {
        words = skew_words(below, above);
    }
    return words.empty() ? "chi2 is no parabola over a range so wide" : words;
}

} // namespace

std::string what_shapes(const problem::Problem& problem, const Uniqueness& u, const Range& range) {
    if (u.accepted.size() > 1) {
        return "the data accept more than one minimum";
    }
    std::vector<std::string> held;
    for (const auto& [bounds, limits] :
         {std::pair(&range.low_bounds, &range.low_limits), std::pair(&range.high_bounds, &range.high_limits)}) {
        for (std::string& words : landscape::bound_words(problem.space, *bounds)) {
            held.push_back(std::move(words));
        }
        for (const std::size_t i : *limits) {
            held.push_back("the constraint " + problem.limits[i]->text());
        }
    }
    std::sort(held.begin(), held.end());
    held.erase(std::unique(held.begin(), held.end()), held.end());
    return held.empty() ? "" : "held by " + pave::join(held);
}

std::string skew_words(double below, double above) {
    const double skewness = std::max(below, above) / std::max(1e-12, std::min(below, above));
    return skewness > 1.0 + range_matters
               ? fmt::format("skew: it reaches {:.1f} times as far {} as {}", std::min(skewness, 99.0),
                             above > below ? "up" : "down", above > below ? "down" : "up")
               : "";
}

std::vector<std::optional<RangeShape>> range_shapes(const problem::Problem& problem, const Uniqueness& u) {
    std::vector<std::optional<RangeShape>> shapes(problem.space.axes.size());
    if (!u.acceptance) {
        return shapes;
    }
    const landscape::Minimum& best = u.minima[0];
    const auto local = landscape::analyse(best, problem);
    const auto held = landscape::held_ranges(problem, best, local, local.bounds_count());
    for (std::size_t k = 0; k < u.parameters.size(); ++k) {
        const problem::Axis& axis = problem.space.axes[k];
        const double deviation = std::sqrt(u.acceptance->threshold) * local.standard_error[k];
        const double low = held.of(k) ? held.of(k)->low : std::max(0.0, best.unit[k] - deviation);
        const double high = held.of(k) ? held.of(k)->high : std::min(1.0, best.unit[k] + deviation);
        const double half = held.of(k) ? 0.5 * (high - low) : deviation;
        if (!std::isfinite(half) || half <= 0.0) {
            continue;
        }
        const double below = best.unit[k] - axis.unit(u.parameters[k].low);
        const double above = axis.unit(u.parameters[k].high) - best.unit[k];
        RangeShape shape{.gaussian_low = axis.physical(low),
                         .gaussian_high = axis.physical(high),
                         .ratio = (below + above) / (high - low)};
        // At either end: a range may be as wide as promised and lie elsewhere.
        const double off = std::max(std::abs(below - (best.unit[k] - low)), std::abs(above - (high - best.unit[k])));
        if (off > range_matters * half) {
            shape.reason = reason_for(problem, u, k, below, above);
        }
        shapes[k] = shape;
    }
    return shapes;
}

std::string shape_words(const problem::Problem& problem, const Uniqueness& u) {
    std::vector<std::string> words;
    const auto shapes = range_shapes(problem, u);
    for (std::size_t k = 0; k < shapes.size(); ++k) {
        if (shapes[k] && !shapes[k]->reason.empty()) {
            words.push_back(fmt::format("{} ({} to {} to first order: {})", problem.space.axes[k].name,
                                        pave::figure(shapes[k]->gaussian_low), pave::figure(shapes[k]->gaussian_high),
                                        shapes[k]->reason));
        }
    }
    return words.empty()
               ? ""
               : "The profile ranges differ from the standard-error ranges by more than a fifth: " + pave::join(words) +
                     ".";
}

} // namespace explore::analysis
