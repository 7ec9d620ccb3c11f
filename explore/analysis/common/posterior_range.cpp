#include "analysis/common/posterior_range.h"

#include "analysis/common/range_shape.h"
#include "base/text.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <functional>

namespace explore::analysis {
namespace {

using landscape::Range;

// Values of the draws on the scale that lengths are taken on, with their weights.
struct Spread {
    std::vector<double> places, weights;
};

std::string why_apart(const problem::Problem& problem, const landscape::Uniqueness& u, const Range& walked,
                      const Spread& spread) {
    if (u.acceptance->widened) {
        return "the data contradict the model, so the walk takes its noise as large as the residuals, the draws as "
               "stated";
    }
    const auto [least, most] = std::minmax_element(spread.places.begin(), spread.places.end());
    std::vector<double> units;
    units.reserve(spread.places.size());
    for (const double place : spread.places) {
        units.push_back(*most > *least ? (place - *least) / (*most - *least) : 0.5);
    }
    if (const std::size_t modes = modes_of(units, spread.weights).size(); modes > 1) {
        return fmt::format("the draws gather about {} separate values", modes);
    }
    if (std::string words = what_shapes(problem, u, walked); !words.empty()) {
        return words;
    }
    const auto at = [&](double share) { return landscape::weighted_quantile(spread.places, spread.weights, share); };
    const std::string skew = skew_words(at(0.5) - at(0.025), at(0.975) - at(0.5));
    return skew.empty() ? "a walk keeps the best of the other parameters, the draws weigh all of them" : skew;
}

// place: of a value, on the scale of the lengths.
PosteriorRange range_of(const problem::Problem& problem, const landscape::Uniqueness& u, const Range& walked,
                        const landscape::Marginal& marginal, const Spread& spread,
                        const std::function<double(double)>& place) {
    PosteriorRange range{.low = marginal.q025, .high = marginal.q975};
    const double off =
        std::max(std::abs(place(range.low) - place(walked.low)), std::abs(place(range.high) - place(walked.high)));
    if (off > range_matters * std::abs(place(walked.high) - place(walked.low))) {
        range.reason = why_apart(problem, u, walked, spread);
    }
    return range;
}

} // namespace

PosteriorRanges posterior_ranges(const problem::Problem& problem, const landscape::Uniqueness& u,
                                 const SampleResult& sampled) {
    PosteriorRanges ranges;
    if (!sampled.converged()) {
        ranges.missing = sampled.reason();
        return ranges;
    }
    const auto spread_of = [&](const auto& place_of, const auto& counts) {
        Spread spread;
        for (std::size_t i = 0; i < sampled.draws.size(); ++i) {
            if (counts(sampled.draws[i])) {
                spread.places.push_back(place_of(sampled.draws[i]));
                spread.weights.push_back(sampled.descent.weight[i]);
            }
        }
        return spread;
    };
    for (std::size_t k = 0; k < u.parameters.size(); ++k) {
        const problem::Axis& axis = problem.space.axes[k];
        ranges.parameters.push_back(range_of(
            problem, u, u.parameters[k], sampled.parameters[k],
            spread_of([&](const SampledDraw& d) { return d.unit[k]; }, [](const SampledDraw&) { return true; }),
            [&](double value) { return axis.unit(value); }));
    }
    for (std::size_t o = 0; o < u.outputs.size() && o < sampled.outputs.size(); ++o) {
        ranges.outputs.push_back(range_of(problem, u, u.outputs[o], sampled.outputs[o],
                                          spread_of([&](const SampledDraw& d) { return d.outputs[o]; },
                                                    [](const SampledDraw& d) { return !d.outputs.empty(); }),
                                          [](double value) { return value; }));
    }
    return ranges;
}

std::vector<std::string> posterior_words(const study::Study& study, const PosteriorRanges& ranges) {
    if (!ranges.missing.empty()) {
        return {"The posterior says nothing yet: " + ranges.missing + "."};
    }
    std::vector<std::string> words;
    for (std::size_t k = 0; k < ranges.parameters.size(); ++k) {
        if (const PosteriorRange& r = ranges.parameters[k]; !r.reason.empty()) {
            words.push_back(fmt::format("{} ({} to {}: {})", study.space.axes[k].name, pave::figure(r.low),
                                        pave::figure(r.high), r.reason));
        }
    }
    const auto outputs = study.outputs();
    for (std::size_t o = 0; o < ranges.outputs.size(); ++o) {
        if (const PosteriorRange& r = ranges.outputs[o]; !r.reason.empty()) {
            const data::Reading& output = study.readings[outputs[o]];
            words.push_back(fmt::format("{} ({} to {} {}: {})", output.output, pave::figure(output.in_unit(r.low)),
                                        pave::figure(output.in_unit(r.high)), output.unit.name, r.reason));
        }
    }
    if (words.empty()) {
        return {
            "The ranges that hold 95 % of the posterior agree with those that were walked, to a fifth of their width."};
    }
    return {"Where 95 % of the posterior lies differs by more than a fifth from the range that was walked: " +
            pave::join(words) + "."};
}

} // namespace explore::analysis
