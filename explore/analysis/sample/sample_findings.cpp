#include "analysis/common/knowledge_words.h"
#include "analysis/common/limit_words.h"
#include "analysis/common/say.h"
#include "analysis/common/sought_noise.h"
#include "analysis/sample/sample.h"

#include "base/error.h"
#include "base/text.h"
#include "inference/quantiles.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <numeric>

namespace explore::analysis {
namespace {

using pave::figure;
using pave::p_words;

constexpr double strong = 0.9;        // correlation that is worth a sentence
constexpr std::size_t most_pairs = 3; // of them
constexpr double edge = 0.02;         // of a range,
constexpr double held = 0.1;          // and the share of the draws there that says the box ends the parameter
constexpr double uninformed = 0.9;    // deviation over that of the prior
constexpr double least_mode = 0.05;   // share of the draws
constexpr double valley = 0.5;        // density between two modes, of the lower one

std::vector<double> units_of(const SampleResult& result, std::size_t k) {
    std::vector<double> units;
    for (const SampledDraw& draw : result.draws) {
        units.push_back(draw.unit[k]);
    }
    return units;
}

std::string answer_words(const SampleResult& result) {
    constexpr double half = 0.5; // of what the study allows, on the parameter's scale
    std::vector<std::string> known;
    std::vector<std::string> held; // by their priors
    std::vector<std::string> apart;
    std::vector<std::string> open;
    const auto& axes = result.problem.space.axes;
    const auto& only = result.priors ? result.priors->only : std::vector<std::size_t>();
    for (std::size_t k = 0; k < axes.size(); ++k) {
        const landscape::Marginal& m = result.parameters[k];
        const bool is_narrow = axes[k].unit(m.q975) - axes[k].unit(m.q025) < half;
        const bool is_held = std::find(only.begin(), only.end(), k) != only.end();
        (is_held                                                           ? held
         : modes_of(units_of(result, k), result.descent.weight).size() > 1 ? apart
         : is_narrow                                                       ? known
                                                                           : open)
            .push_back(axes[k].name);
    }
    std::vector<std::string> parts;
    if (!known.empty()) {
        parts.push_back("The readings determine " + pave::join(known));
    } else {
        parts.emplace_back("The readings determine no parameter");
    }
    if (!apart.empty()) {
        parts.push_back(fmt::format("{} {} separate values that explain the data", pave::join(apart),
                                    apart.size() == 1 ? "has" : "have"));
    }
    if (!held.empty()) {
        parts.push_back(fmt::format("{} {} known only with {} prior", pave::join(held), held.size() == 1 ? "is" : "are",
                                    held.size() == 1 ? "its" : "the"));
    }
    if (!open.empty()) {
        parts.push_back(fmt::format("of {} half of what the study allows or more lies in the 95 % {}", pave::join(open),
                                    open.size() == 1 ? "range" : "ranges"));
    }
    if (parts.size() == 1 && !known.empty()) {
        parts[0] +=
            fmt::format(": {} 95 % {} less than half of what the study allows", known.size() == 1 ? "its" : "their",
                        known.size() == 1 ? "range covers" : "ranges cover");
    }
    return pave::join(parts, "; ") + ".";
}

void say_bounds(const SampleResult& result, std::vector<std::string>& text) {
    const auto& axes = result.problem.space.axes;
    const auto& weight = result.descent.weight;
    std::vector<std::string> silent;
    for (std::size_t k = 0; k < axes.size(); ++k) {
        const auto units = units_of(result, k);
        double total = 0.0;
        double ends[2] = {0.0, 0.0};
        for (std::size_t i = 0; i < units.size(); ++i) {
            total += weight[i];
            ends[0] += units[i] < edge ? weight[i] : 0.0;
            ends[1] += units[i] > 1.0 - edge ? weight[i] : 0.0;
        }
        for (const int upper : {0, 1}) {
            if (ends[upper] > held * total) {
                text.push_back(fmt::format(
                    "{} is cut off at its {} bound {}: {:.0f} % of the draws lie within "
                    "{:.0f} % of the range from it. "
                    "What is said of it rests on that bound: widen the range, or state what is known as a prior.",
                    axes[k].name, upper != 0 ? "upper" : "lower", figure(upper != 0 ? axes[k].high : axes[k].low),
                    100.0 * ends[upper] / total, 100.0 * edge));
            }
        }
        if (landscape::marginal(units, result.descent).sd / std::sqrt(inference::box_variance) > uninformed &&
            modes_of(units, weight).size() == 1) {
            silent.push_back(axes[k].name);
        }
    }
    if (!silent.empty()) {
        text.push_back(fmt::format("The data hardly constrain {} alone: the draws fill the whole range of the study.",
                                   pave::join(silent)));
    }
}

void say_modes(const SampleResult& result, std::vector<std::string>& text) {
    const auto& axes = result.problem.space.axes;
    for (std::size_t k = 0; k < axes.size(); ++k) {
        const auto modes = modes_of(units_of(result, k), result.descent.weight);
        if (modes.size() < 2) {
            continue;
        }
        std::vector<std::string> places;
        places.reserve(modes.size());
        for (const Mode& mode : modes) {
            places.push_back(
                fmt::format("{:.0f} % about {}", 100.0 * mode.share, figure(axes[k].physical(mode.centre))));
        }
        text.push_back(fmt::format("{} separate values of {} explain the data: {}. Its mean lies where none of them "
                                   "is: report each by itself; a further reading or a prior decides.",
                                   modes.size(), axes[k].name, pave::join(places)));
    }
}

void say_correlations(const SampleResult& result, std::vector<std::string>& text) {
    struct Pair {
        std::size_t a, b;
        double correlation;
    };
    const auto& axes = result.problem.space.axes;
    std::vector<Pair> pairs;
    for (std::size_t a = 0; a < axes.size(); ++a) {
        for (std::size_t b = a + 1; b < axes.size(); ++b) {
            const double c =
                landscape::weighted_correlation(units_of(result, a), units_of(result, b), result.descent.weight);
            if (std::abs(c) > strong) {
                pairs.push_back({a, b, c});
            }
        }
    }
    std::stable_sort(pairs.begin(), pairs.end(),
                     [](const Pair& a, const Pair& b) { return std::abs(a.correlation) > std::abs(b.correlation); });
    for (std::size_t i = 0; i < std::min(pairs.size(), most_pairs); ++i) {
        const auto& [a, b, c] = pairs[i];
        text.push_back(fmt::format("{} and {} hang together (correlation {:.2f} on their scales): the data know a "
                                   "combination of them, not each.",
                                   axes[a].name, axes[b].name, c));
    }
}

// The standard deviation of a normal distribution whose densest tenth is as narrow as that of the draws.
double spread_where_densest(std::span<const double> units, std::span<const double> weight, double total) {
    std::vector<std::size_t> order(units.size());
    std::iota(order.begin(), order.end(), 0);
    std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return units[a] < units[b]; });
    constexpr double share = 0.1;
    constexpr double of_normal = 0.2513; // width of the central tenth over the standard deviation
    double narrowest = INFINITY;
    double held_by = 0.0; // weight from `from` to `to`, both in it
    std::size_t from = 0;
    for (std::size_t to = 0; to < order.size(); ++to) {
        held_by += weight[order[to]];
        while (held_by - weight[order[from]] >= share * total) {
            held_by -= weight[order[from++]];
        }
        if (held_by >= share * total) {
            narrowest = std::min(narrowest, units[order[to]] - units[order[from]]);
        }
    }
    return narrowest / of_normal;
}

} // namespace

std::vector<Mode> modes_of(std::span<const double> units, std::span<const double> weight) {
    const double low = landscape::weighted_quantile(units, weight, 0.25);
    const double high = landscape::weighted_quantile(units, weight, 0.75);
    double sum = 0.0;
    double squares = 0.0;
    double total = 0.0;
    double weights = 0.0;
    for (std::size_t i = 0; i < units.size(); ++i) {
        sum += weight[i] * units[i];
        squares += weight[i] * units[i] * units[i];
        total += weight[i];
        weights += weight[i] * weight[i];
    }
    const double deviation = std::sqrt(std::max(0.0, squares / total - std::pow(sum / total, 2)));
    const double whole = high > low ? std::min(deviation, (high - low) / 1.34) : deviation;
    // Of many separate values the whole spread says nothing: of the densest of them.
    const double spread = std::min(whole, spread_where_densest(units, weight, total));
    // Silverman's rule (1986, Density Estimation, 3.31).
    const double width = std::max(0.9 * spread * std::pow(total * total / weights, -0.2), 1e-4);
    const auto [first, last] = std::minmax_element(units.begin(), units.end());
    const double from = *first - 2.0 * width;
    const double across = *last + 2.0 * width - from;
    constexpr double a_width = 4.0;
    const int cells = std::clamp(static_cast<int>(a_width * across / width), 200, 4000);
    const double step = across / cells;
    const auto place = [&](int c) { return from + (c + 0.5) * step; };
    std::vector<double> density(static_cast<std::size_t>(cells), 0.0);
    for (int c = 0; c < cells; ++c) {
        for (std::size_t i = 0; i < units.size(); ++i) {
            density[static_cast<std::size_t>(c)] +=
                weight[i] * std::exp(-0.5 * std::pow((place(c) - units[i]) / width, 2));
        }
    }
    // Cut at the lowest point between two peaks where it is deep enough.
    std::vector<double> cuts;
    double peak = 0.0;   // of what began at the cut before
    double lowest = 0.0; // since that peak
    double lowest_at = 0.0;
    for (int c = 0; c < cells; ++c) {
        const double d = density[static_cast<std::size_t>(c)];
        if (d > peak && lowest >= valley * peak) {
            peak = lowest = d;
            continue;
        }
        if (d < lowest) {
            lowest = d;
            lowest_at = place(c);
        } else if (lowest < valley * std::min(peak, d)) { // a second peak rises
            cuts.push_back(lowest_at);
            peak = lowest = d;
        }
    }
    cuts.push_back(INFINITY);
    std::vector<Mode> modes;
    double begin = -INFINITY;
    for (const double end : cuts) {
        std::vector<double> inside, of;
        double share = 0.0;
        for (std::size_t i = 0; i < units.size(); ++i) {
            if (units[i] >= begin && units[i] < end) {
                inside.push_back(units[i]);
                of.push_back(weight[i]);
                share += weight[i] / total;
            }
        }
        if (share >= least_mode) {
            modes.push_back({landscape::weighted_quantile(inside, of, 0.5), share});
        }
        begin = end;
    }
    return modes;
}

std::vector<std::string> findings(const SampleResult& result) {
    std::vector<std::string> text;
    if (!result.converged()) {
        text.push_back("NOT CONVERGED: no quantile is given. What is missing: " + pave::join(result.missing) +
                       ". More draws (--samples) may do.");
        return text;
    }
    if (result.p_value < 0.01) {
        text.push_back(fmt::format("The data contradict the model: chi2 is {} {}, {} degrees of freedom "
                                   "({}). A posterior "
                                   "takes model and stated noise for true, so its ranges are too narrow; diagnose says "
                                   "what the model may lack.",
                                   figure(result.chi2),
                                   result.held && result.held->alone ? "by the readings alone, without what is known "
                                                                       "besides"
                                                                     : "at the best draw",
                                   result.degrees_of_freedom, p_words(result.p_value)));
    }
    if (result.priors) {
        for (std::string& words : prior_findings(result.problem, *result.priors)) {
            text.push_back(std::move(words));
        }
    }
    if (result.held) {
        say(text, active_constraints(result.problem, *result.held).words);
    }
    if (!result.problem.limits.empty()) {
        text.push_back(
            result.allowed
                ? fmt::format("The constraints leave {:.3g} % of the prior; the evidence is relative to that.",
                              100.0 * std::exp(result.allowed->log))
                : "What the constraints leave of the prior is too little to be estimated from draws of it: the "
                  "evidence "
                  "counts all that they forbid as prior, and cannot be compared with that of another model.");
    }
    text.push_back(answer_words(result));
    say(text, limit_words(result.study));
    if (result.noise_scale) {
        text.push_back(noise_scale_words(result.study, *result.noise_scale));
    }
    say_modes(result, text);
    say_bounds(result, text);
    say_correlations(result, text);
    if (!result.telling.empty()) {
        const auto& [reading, bits] = result.telling.front();
        text.push_back(fmt::format("Best next measurement: {} (noise {} {} assumed): the ranges together "
                                   "would shrink to {:.0f} % of their volume ({:.1f} bits).",
                                   reading.words(), figure(reading.in_unit(reading.noise.absolute)), reading.unit.name,
                                   100.0 * std::exp2(-bits), bits));
    }
    const auto& posterior = result.posterior;
    if (posterior.answered < 0.999) {
        text.push_back(fmt::format("{:.1f} % of the box has no answer: the prior is uniform over the rest.",
                                   100.0 * (1.0 - posterior.answered)));
    }
    if (const auto& c = result.correction) {
        text.push_back(
            c->weighed > c->runs
                ? fmt::format(
                      "The reduced model drew; {} runs of the full model weigh its draws. A smooth surface gives "
                      "the logarithms of their weights to {:.1g}, so that the {} draws are worth {:.0f} of the full "
                      "model.",
                      c->runs, c->left, c->weighed, c->effective)
                : fmt::format("The reduced model drew; {} runs of the full model weigh its draws and are worth {:.0f} "
                              "draws of the full model.",
                              c->runs, c->effective));
    } else if (result.options.model.alone()) {
        text.push_back(
            fmt::format("All of this is the reduced model's, whose error is estimated below {} % of a reading "
                        "where it was used.",
                        figure(result.options.model.limit_percent)));
    }
    if (const auto& surface = result.surface) {
        std::vector<std::string> off;
        for (std::size_t o = 0; o < result.besides.size(); ++o) {
            const data::Reading& output = result.study.readings[result.besides[o]];
            off.push_back(fmt::format("{} by {} {}", output.output, figure(output.in_unit(surface->error[o]), 2),
                                      output.unit.name));
        }
        text.push_back(fmt::format(
            "Outputs under loads that no reading has come from a smooth surface through {} runs with derivatives; "
            "at {} other draws it is off, root mean square: {}.",
            surface->runs, surface->checks, pave::join(off)));
    }
    return text;
}

} // namespace explore::analysis
