#include "analysis/common/output_ranges.h"

#include "analysis/common/mesh_error.h"
#include "analysis/common/output_slopes.h"
#include "base/error.h"
#include "base/text.h"
#include "diagnose/evidence.h"
#include "diagnose/model_average.h"
#include "diagnose/workbench.h"
#include "inference/quantiles.h"
#include "landscape/minima.h"
#include "pavement/effects/effect.h"
#include "run/parallel.h"
#include "study/corrections.h"
#include "study/variants.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <gsl/gsl_cdf.h>
#include <numbers>
#include <optional>
#include <set>
#include <span>

namespace explore::analysis {
namespace {

using diagnose::Said;
using diagnose::Slopes;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Standard deviations of ln(factor); of sizes of effects, of the way to a typical one.
constexpr double strengths_of_corrections[] = {0.05, 0.1, 0.2, 0.4, 0.8};
constexpr double strengths_of_effects[] = {0.25, 0.5, 1.0, 2.0, 4.0};

// Possible errors of the model, a correction or an effect: coordinates, where they change nothing, and how far they
// may be from there: `reach` times a strength times standard normal numbers.
struct Hypothesis {
    std::string name;
    std::vector<pave::pavement::Correction> corrections; // one, or
    std::vector<study::Variant> effects;                 // one
    VectorXd none;
    MatrixXd reach;
    std::span<const double> strengths;
    bool is_of_readings = false; // an output is what is there, not what a sensor says
};

std::vector<Hypothesis> hypotheses_of(const study::Study& study) {
    std::vector<Hypothesis> list;
    for (const auto& correction : study::correction_channels(study)) {
        const auto size = static_cast<Index>(correction.factors.size());
        const problem::Axis axis = study::with_free_corrections(study, {correction}).space.axes.back();
        const MatrixXd factor = diagnose::prior_correlation(correction.factors.size()).llt().matrixL();
        list.push_back({.name = correction.name(),
                        .corrections = {correction},
                        .effects = {},
                        .none = VectorXd::Constant(size, diagnose::no_correction),
                        .reach = factor / std::log(axis.high / axis.low),
                        .strengths = strengths_of_corrections,
                        .is_of_readings = !pave::pavement::info(correction.channel).of_layer});
    }
    const bool is_plane = std::all_of(study.model.loads.begin(), study.model.loads.end(),
                                      [](const auto& load) { return load.is_axisymmetric(); });
    if (!is_plane) { // too long in three dimensions
        return list;
    }
    for (const study::Variant& variant : study::variants(study, {})) {
        const problem::Axis axis = study::size_axis(*variant.applied.effect);
        const double none = axis.unit(variant.applied.effect->null);
        list.push_back({.name = std::string(variant.applied.effect->name) +
                                (variant.on.empty() ? "" : fmt::format(" ({})", variant.on)),
                        .corrections = {},
                        .effects = {variant},
                        .none = VectorXd::Constant(1, none),
                        .reach = MatrixXd::Constant(1, 1, axis.unit(variant.applied.effect->typical) - none),
                        .strengths = strengths_of_effects});
    }
    return list;
}

using Batch = std::vector<std::size_t>; // of hypotheses, rising

// With all of them free; their coordinates follow the parameters in this order, for corrections come first.
problem::Problem problem_with(const study::Study& study, const std::vector<Hypothesis>& hypotheses, const Batch& batch,
                              study::Scope scope = study::Scope::everything) {
    std::vector<pave::pavement::Correction> corrections;
    std::vector<study::Variant> effects;
    for (const std::size_t c : batch) {
        corrections.insert(corrections.end(), hypotheses[c].corrections.begin(), hypotheses[c].corrections.end());
        effects.insert(effects.end(), hypotheses[c].effects.begin(), hypotheses[c].effects.end());
    }
    return study::make_noise_problem(
        study::with_free_effects(study::with_free_corrections(study, corrections), effects), scope);
}

bool is_error_of_reading(const Hypothesis& hypothesis) {
    return !hypothesis.effects.empty() && hypothesis.effects[0].applied.effect->is_error_of_reading;
}

// Coordinates that one run can differentiate by: as many as a study may have parameters, an effect once. Those that
// are too many alone are in none, nor are errors of readings, which take no run.
std::vector<Batch> batches_of(const std::vector<Hypothesis>& hypotheses, Index parameters) {
    struct Open {
        Batch batch;
        Index size;
        std::set<const pave::pavement::Effect*> effects;
    };
    std::vector<Open> list;
    for (std::size_t c = 0; c < hypotheses.size(); ++c) {
        const Hypothesis& h = hypotheses[c];
        const auto* effect = h.effects.empty() ? nullptr : h.effects[0].applied.effect;
        const auto most = static_cast<Index>(study::most_parameters);
        if (parameters + h.none.size() > most || is_error_of_reading(h)) {
            continue;
        }
        auto at = std::find_if(list.begin(), list.end(), [&](const Open& open) {
            return open.size + h.none.size() <= most && !open.effects.contains(effect);
        });
        if (at == list.end()) {
            at = list.insert(at, {{}, parameters, {}});
        }
        at->batch.push_back(c);
        at->size += h.none.size();
        if (effect != nullptr) {
            at->effects.insert(effect);
        }
    }
    std::vector<Batch> batches;
    batches.reserve(list.size());
    for (Open& open : list) {
        batches.push_back(std::move(open.batch));
    }
    return batches;
}

// The mesh for slopes: the coarse one, or the study's own where that has no answer.
struct Sloped {
    const study::Study& study;
    diagnose::Shift shift; // to the responses of the study's own at the answer, where nothing is lacking
    const std::vector<std::size_t>& outputs;
    double noise;

    std::optional<Slopes> at(const problem::Problem& problem, const VectorXd& point,
                             problem::ForwardFunction::Workspace& workspace) const {
        problem::Evaluation e =
            problem.evaluate({point.data(), static_cast<std::size_t>(point.size())}, true, workspace);
        return slopes_of(problem, point, diagnose::shifted(problem, std::move(e), shift), outputs, noise);
    }
};

// Of every hypothesis of a batch, where nothing is lacking.
void differentiate(const Sloped& sloped, const VectorXd& answer, const std::vector<Hypothesis>& hypotheses,
                   const Batch& batch, std::vector<std::optional<Slopes>>& slopes) {
    const Index n = answer.size();
    Index size = n;
    for (const std::size_t c : batch) {
        size += hypotheses[c].none.size();
    }
    VectorXd at(size);
    at.head(n) = answer;
    Index column = n;
    for (const std::size_t c : batch) {
        at.segment(column, hypotheses[c].none.size()) = hypotheses[c].none;
        column += hypotheses[c].none.size();
    }
    const problem::Problem problem = problem_with(sloped.study, hypotheses, batch);
    const auto all = sloped.at(problem, at, *problem.function->make_workspace());
    column = n;
    for (const std::size_t c : batch) {
        const Index count = hypotheses[c].none.size();
        if (all) {
            const auto part = [&](const MatrixXd& matrix) {
                MatrixXd columns(matrix.rows(), n + count);
                columns << matrix.leftCols(n), matrix.middleCols(column, count);
                return columns;
            };
            slopes[c] = Slopes{.at = part(all->at.transpose()).transpose(),
                               .residuals = all->residuals,
                               .rows = part(all->rows),
                               .outputs = all->outputs,
                               .output_rows = part(all->output_rows)};
        } else if (batch.size() > 1) { // one of them may be to blame
            differentiate(sloped, answer, hypotheses, {c}, slopes);
        }
        column += count;
    }
}

// Of the errors of single readings: an output is what is there, whatever a sensor says. plain: of the study where
// nothing is lacking, `best` what it computes there.
void differentiate_errors(const problem::Problem& problem, const Slopes& plain, const problem::Evaluation& best,
                          double noise, const std::vector<Hypothesis>& hypotheses,
                          std::vector<std::optional<Slopes>>& slopes) {
    const Index n = plain.at.size();
    for (std::size_t c = 0; c < hypotheses.size(); ++c) {
        const Hypothesis& h = hypotheses[c];
        for (std::size_t i = 0; is_error_of_reading(h) && i < problem.readings(); ++i) {
            if (problem.response_of(i) == static_cast<std::size_t>(*h.effects[0].applied.reading)) {
                Slopes own = plain;
                own.at.conservativeResize(n + 1);
                own.at[n] = h.none[0];
                own.rows.conservativeResize(Eigen::NoChange, n + 1);
                own.rows.col(n) = problem.change_by_gain(i, best) *
                                  study::size_axis(*h.effects[0].applied.effect).d_physical(h.none[0]) / noise;
                own.output_rows.conservativeResize(Eigen::NoChange, n + 1);
                own.output_rows.col(n).setZero();
                slopes[c] = std::move(own);
            }
        }
    }
}

// From the answer to the hypothesis's own best point at the most probable strength, by Gauss and Newton's steps; the
// slopes there, of the outputs that `sloped` has.
Slopes slopes_at_best(const Sloped& sloped, const problem::Problem& problem, const Hypothesis& hypothesis,
                      Slopes slopes, Index parameters) {
    const auto workspace = problem.function->make_workspace();
    constexpr int steps = 4;
    constexpr int halvings = 3;
    const auto most_said = [&](const Slopes& there) {
        std::size_t most = 0;
        double evidence = -INFINITY;
        for (std::size_t s = 0; s < hypothesis.strengths.size(); ++s) {
            const double now =
                diagnose::say(there, parameters, hypothesis.none, hypothesis.strengths[s] * hypothesis.reach)
                    .log_evidence;
            if (now > evidence) {
                evidence = now;
                most = s;
            }
        }
        return most;
    };
    for (int step = 0; step < steps; ++step) {
        const MatrixXd reach = hypothesis.strengths[most_said(slopes)] * hypothesis.reach;
        const auto sum = [&](const Slopes& there) {
            const VectorXd own =
                reach.fullPivLu().solve(VectorXd(there.at.tail(hypothesis.none.size()) - hypothesis.none));
            return there.residuals.squaredNorm() + own.squaredNorm() +
                   (there.at.head(parameters).array() - 0.5).square().sum() / inference::box_variance;
        };
        const double before = sum(slopes);
        VectorXd move = diagnose::say(slopes, parameters, hypothesis.none, reach).best - slopes.at;
        double gained = 0.0;
        for (int halving = 0; halving < halvings && !(gained > 0.0); ++halving, move *= 0.5) {
            const VectorXd next = (slopes.at + move).cwiseMax(0.0).cwiseMin(1.0);
            auto there = sloped.at(problem, next, *workspace);
            if (const double now = there ? sum(*there) : INFINITY; now < before) {
                gained = before - now;
                slopes = std::move(*there);
            }
        }
        constexpr double enough = 0.5; // of chi2
        if (gained < enough) {
            break;
        }
    }
    return slopes;
}

} // namespace

std::vector<OutputUncertainty> output_ranges(const study::Study& study, const std::vector<double>& unit, double noise,
                                             int threads, const std::vector<std::vector<double>>& others) {
    std::vector<std::size_t> outputs = study.outputs();
    if (outputs.empty() || !(noise > 0.0) || study.has_own_model) {
        return {};
    }
    const auto n = static_cast<Index>(unit.size());
    const VectorXd answer = Eigen::Map<const VectorXd>(unit.data(), n);
    const problem::Problem plain = study::make_noise_problem(study, study::Scope::everything);
    const problem::Evaluation best = plain.evaluate(unit, true, *plain.function->make_workspace());
    if (!best.converged()) {
        return {};
    }
    std::erase_if(outputs, [&](std::size_t o) { return !(std::abs(best.responses[o]) > 0.0); });
    auto right_slopes = slopes_of(plain, answer, best, outputs, noise);
    if (!right_slopes || outputs.empty()) {
        return {};
    }
    const Slopes unbounded = *right_slopes;
    hold_bounds(*right_slopes, unit);
    const Said right = diagnose::say(*right_slopes, n, VectorXd(0), MatrixXd(0, 0));
    const study::Study coarse = on_coarser_mesh(study);
    const problem::Problem coarse_plain = study::make_noise_problem(coarse, study::Scope::everything);
    const problem::Evaluation on_coarse = coarse_plain.evaluate(unit, false, *coarse_plain.function->make_workspace());
    const bool has_coarse = on_coarse.converged();
    const Sloped sloped{has_coarse ? coarse : study, diagnose::shift_between(best, has_coarse ? on_coarse : best),
                        outputs, noise};
    const std::vector<Hypothesis> hypotheses = hypotheses_of(sloped.study);
    std::vector<std::optional<Slopes>> slopes(hypotheses.size());
    tbb::task_arena arena(run::concurrency(threads));
    differentiate_errors(plain, unbounded, best, noise, hypotheses, slopes);
    const std::vector<Batch> batches = batches_of(hypotheses, n);
    run::for_each_index(arena, batches.size(),
                        [&](std::size_t i) { differentiate(sloped, answer, hypotheses, batches[i], slopes); });
    const auto said_by = [&](std::size_t c, std::size_t s) {
        const Hypothesis& hypothesis = hypotheses[c];
        Slopes own = *slopes[c];
        if (hypothesis.is_of_readings) {
            own.output_rows.rightCols(hypothesis.none.size()).setZero();
        }
        return diagnose::say(own, n, hypothesis.none, hypothesis.strengths[s] * hypothesis.reach);
    };
    std::vector<std::pair<double, std::size_t>> order;
    for (std::size_t c = 0; c < hypotheses.size(); ++c) {
        double evidence = -INFINITY;
        for (std::size_t s = 0; slopes[c] && s < hypotheses[c].strengths.size(); ++s) {
            evidence = std::max(evidence, said_by(c, s).log_evidence);
        }
        order.emplace_back(evidence, c);
    }
    std::sort(order.rbegin(), order.rend());
    constexpr std::size_t leading = 8;
    constexpr double far = 3.0; // of ln(evidence): where nothing is told apart, the answer is near enough
    const double without = right.log_evidence;
    // Steps need the readings alone: where outputs are under other loads, these are run at the end.
    const std::vector<bool> computed = study::computed_loads(study);
    const bool apart = std::any_of(outputs.begin(), outputs.end(), [&](std::size_t o) {
        return !computed[static_cast<std::size_t>(study.model.sensors[o].load)];
    });
    const std::vector<std::size_t> no_outputs;
    const Sloped of_readings{sloped.study, sloped.shift, no_outputs, noise};
    run::for_each_index(arena, std::min(leading, order.size()), [&](std::size_t i) {
        const std::size_t c = order[i].second;
        if (!slopes[c] || !(order[0].first > without + far)) {
            return;
        }
        const problem::Problem problem = problem_with(sloped.study, hypotheses, {c});
        if (!apart) {
            slopes[c] = slopes_at_best(sloped, problem, hypotheses[c], std::move(*slopes[c]), n);
            return;
        }
        Slopes begin = *slopes[c];
        begin.outputs.resize(0);
        begin.output_rows.resize(0, Eigen::NoChange);
        const VectorXd end =
            slopes_at_best(of_readings, problem_with(sloped.study, hypotheses, {c}, study::Scope::fitted),
                           hypotheses[c], std::move(begin), n)
                .at;
        if (auto there =
                end == slopes[c]->at ? std::nullopt : sloped.at(problem, end, *problem.function->make_workspace())) {
            slopes[c] = std::move(there);
        }
    });
    std::vector<Said> all;
    std::vector<std::size_t> whose;
    double least = right.left;
    for (std::size_t c = 0; c < hypotheses.size(); ++c) {
        for (std::size_t s = 0; slopes[c] && s < hypotheses[c].strengths.size(); ++s) {
            all.push_back(said_by(c, s));
            whose.push_back(c);
            least = std::min(least, all.back().left);
        }
    }
    if (all.empty()) {
        return {};
    }
    // No hypothesis is exact: the variance of the noise counts twice, of the stated size or, where none leaves so
    // little, of that which the best of them leaves. So much holds the truth in 38 of 39 blind cases, as does
    // twice the deviation; once holds it in 36 (tools/trials/outputs --first 52001 --count 13).
    constexpr double inexact = std::numbers::sqrt2; // of the standard deviation
    const double free = static_cast<double>(right_slopes->residuals.size() - n);
    const double larger = inexact * (free > 0.0 ? std::sqrt(std::max(1.0, least / free)) : 1.0);
    const double most = std::max_element(all.begin(), all.end(), [](const Said& a, const Said& b) {
                            return a.log_evidence < b.log_evidence;
                        })->log_evidence;
    std::vector<double> weights;
    std::vector<double> shares(hypotheses.size(), 0.0);
    double sum = 0.0;
    for (const Said& said : all) {
        weights.push_back(std::exp((said.log_evidence - most) / (larger * larger)));
        sum += weights.back();
    }
    for (std::size_t i = 0; i < weights.size(); ++i) {
        weights[i] /= sum;
        shares[whose[i]] += weights[i];
    }
    const auto leads = static_cast<std::size_t>(std::max_element(shares.begin(), shares.end()) - shares.begin());
    const VectorXd of_mesh = mesh_errors(study, plain, *right_slopes, best, outputs, noise);
    const Right if_right = right_at(plain, right, best, others, outputs, noise);
    const RangeAtBound at_bound(plain, unbounded, best, noise);
    constexpr double tail = 0.025;
    std::vector<OutputUncertainty> ranges;
    for (std::size_t o = 0; o < outputs.size(); ++o) {
        const auto at = static_cast<Index>(o);
        std::vector<double> means;
        std::vector<double> deviations;
        // Linear theory reaches no farther: no more than a factor of e as one standard deviation.
        constexpr double farthest = 1.0;
        for (const Said& said : all) {
            means.push_back(std::clamp(said.mean[at] - right_slopes->outputs[at], -farthest, farthest));
            deviations.push_back(std::hypot(std::min(farthest, larger * said.deviation[at]), of_mesh[at]));
        }
        const double value = best.responses[outputs[o]];
        const auto [low, high] = range_if_right(if_right, at, std::abs(of_mesh[at]), tail);
        const double below = diagnose::mixture_quantile(weights, means, deviations, tail);
        const double above = diagnose::mixture_quantile(weights, means, deviations, 1.0 - tail);
        OutputUncertainty range{.reading = outputs[o],
                                .best = value,
                                .low = low,
                                .high = high,
                                .wide_low = value * std::exp(std::min(below, 0.0)),
                                .wide_high = value * std::exp(std::max(above, 0.0)),
                                .of_mesh = of_mesh[at],
                                .deviation = right.deviation[at],
                                .channel = hypotheses[leads].name,
                                .share = shares[leads],
                                .least_is_held = below > -farthest,
                                .most_is_held = above < farthest};
        if (value < 0.0) {
            std::swap(range.wide_low, range.wide_high);
        }
        if (const auto held = at_bound.of(at, value, std::abs(of_mesh[at]))) {
            // Linear theory reaches no farther than for a model that may lack something.
            range.low = std::min(low, std::max(held->first, range.wide_low));
            range.high = std::max(high, std::min(held->second, range.wide_high));
        }
        if (others.size() > 0) { // other minima are no less possible where the model lacks something
            range.wide_low = std::min(range.wide_low, range.low);
            range.wide_high = std::max(range.wide_high, range.high);
        }
        ranges.push_back(std::move(range));
    }
    return ranges;
}

void OutputUncertainty::take_back(double shown) {
    may_be_right = false;
    wide_low = std::min(wide_low, shown);
    wide_high = std::max(wide_high, shown);
    low = wide_low;
    high = wide_high;
}

std::pair<double, double> widened(std::pair<double, double> range, const std::vector<OutputUncertainty>& ranges,
                                  std::size_t reading) {
    for (const OutputUncertainty& r : ranges) {
        if (r.reading == reading) {
            return {std::min(range.first, r.wide_low), std::max(range.second, r.wide_high)};
        }
    }
    return range;
}

std::vector<std::string> output_words(const study::Study& study, const std::vector<OutputUncertainty>& ranges) {
    std::vector<std::string> words;
    for (const OutputUncertainty& r : ranges) {
        const data::Reading& output = study.readings[r.reading];
        words.push_back(fmt::format(
            "Allowing for an error of the model that these data would not reveal, {} lies between {} and {} {} (95 "
            "%{}{}).",
            output.output, pave::figure(output.in_unit(r.wide_low)), pave::figure(output.in_unit(r.wide_high)),
            output.unit.name,
            r.may_be_right ? fmt::format("; {} to {} if the model is right", pave::figure(output.in_unit(r.low)),
                                         pave::figure(output.in_unit(r.high)))
                           : "",
            r.share > 0.5 ? fmt::format("; chiefly an error of {}", r.channel) : ""));
    }
    return words;
}

} // namespace explore::analysis
