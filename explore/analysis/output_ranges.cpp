#include "analysis/output_ranges.h"

#include "analysis/mesh_error.h"
#include "base/error.h"
#include "base/text.h"
#include "diagnose/evidence.h"
#include "diagnose/model_average.h"
#include "diagnose/workbench.h"
#include "landscape/minima.h"
#include "pavement/effects/effect.h"
#include "run/parallel.h"
#include "study/corrections.h"
#include "study/variants.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <gsl/gsl_cdf.h>
#include <optional>
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

// What the model may lack: further coordinates, where they change nothing, and how far they may be from there: `reach`
// times a strength times standard normal numbers. Its problem is made when it is needed: there are some sixty, with
// meshes and eliminated stiffnesses of their own.
struct Hypothesis {
    std::string name;
    study::Study study;
    VectorXd none;
    MatrixXd reach;
    std::span<const double> strengths;
    bool is_of_readings = false; // an output is what is there, not what a sensor says
};

std::vector<Hypothesis> hypotheses_of(const study::Study& study) {
    std::vector<Hypothesis> list;
    for (const auto& correction : study::correction_channels(study)) {
        const auto size = static_cast<Index>(correction.factors.size());
        study::Study corrected = study::with_free_corrections(study, {correction});
        const problem::Axis axis = corrected.space.axes.back();
        const MatrixXd factor = diagnose::prior_correlation(correction.factors.size()).llt().matrixL();
        list.push_back({.name = correction.name(),
                        .study = std::move(corrected),
                        .none = VectorXd::Constant(size, diagnose::no_correction),
                        .reach = factor / std::log(axis.high / axis.low),
                        .strengths = strengths_of_corrections,
                        .is_of_readings = !pave::pavement::info(correction.channel).of_layer});
    }
    const bool is_plane = std::all_of(study.model.loads.begin(), study.model.loads.end(),
                                      [](const auto& load) { return load.is_axisymmetric(); });
    if (!is_plane) { // a run each: too long in three dimensions
        return list;
    }
    for (const study::Variant& variant : study::variants(study, {})) {
        const problem::Axis axis = study::size_axis(*variant.applied.effect);
        const double none = axis.unit(variant.applied.effect->null);
        list.push_back({.name = std::string(variant.applied.effect->name) +
                                (variant.on.empty() ? "" : fmt::format(" ({})", variant.on)),
                        .study = study::with_free_effects(study, {variant}),
                        .none = VectorXd::Constant(1, none),
                        .reach = MatrixXd::Constant(1, 1, axis.unit(variant.applied.effect->typical) - none),
                        .strengths = strengths_of_effects});
    }
    return list;
}

// e: of the problem at that point, with jacobian.
std::optional<Slopes> slopes_of(const problem::Problem& problem, const VectorXd& at, const problem::Evaluation& e,
                                const std::vector<std::size_t>& outputs, double noise) {
    if (!e.converged()) {
        return std::nullopt;
    }
    Slopes slopes{.at = at,
                  .residuals = problem.residuals(e) / noise,
                  .rows = problem.residual_jacobian(e) / noise,
                  .outputs = VectorXd(static_cast<Index>(outputs.size())),
                  .output_rows = MatrixXd(static_cast<Index>(outputs.size()), at.size())};
    for (Index o = 0; o < slopes.outputs.size(); ++o) {
        const std::size_t row = outputs[static_cast<std::size_t>(o)];
        slopes.outputs[o] = std::log(std::abs(e.responses[row]));
        for (Index k = 0; k < at.size(); ++k) {
            const auto axis = static_cast<std::size_t>(k);
            slopes.output_rows(o, k) =
                e.jacobian(static_cast<Index>(row), k) * problem.space.axes[axis].d_physical(at[k]) / e.responses[row];
        }
    }
    const bool is_finite = slopes.residuals.allFinite() && slopes.rows.allFinite() && slopes.outputs.allFinite() &&
                           slopes.output_rows.allFinite();
    return is_finite ? std::optional(std::move(slopes)) : std::nullopt;
}

std::optional<Slopes> slopes_at(const problem::Problem& problem, const VectorXd& at,
                                const std::vector<std::size_t>& outputs, double noise,
                                problem::ForwardFunction::Workspace& workspace) {
    const problem::Evaluation e = problem.evaluate({at.data(), static_cast<std::size_t>(at.size())}, true, workspace);
    return slopes_of(problem, at, e, outputs, noise);
}

// Of the hypotheses that are corrections, which come first; how many they are. At no correction one run has the
// derivatives of several, as many as a study may have parameters.
std::size_t slopes_of_corrections(const study::Study& study, const VectorXd& answer,
                                  const std::vector<Hypothesis>& hypotheses, const std::vector<std::size_t>& outputs,
                                  double noise, std::vector<std::optional<Slopes>>& slopes) {
    const auto channels = study::correction_channels(study);
    const Index n = answer.size();
    for (std::size_t c = 0; c < channels.size();) {
        const std::size_t first = c;
        Index size = n;
        do {
            size += hypotheses[c].none.size();
            ++c;
        } while (c < channels.size() && size + hypotheses[c].none.size() <= static_cast<Index>(study::most_parameters));
        if (size > static_cast<Index>(study::most_parameters)) {
            continue; // this one alone is too many
        }
        VectorXd at = VectorXd::Constant(size, diagnose::no_correction);
        at.head(n) = answer;
        const problem::Problem problem = study::make_noise_problem(
            study::with_free_corrections(study, {channels.begin() + static_cast<std::ptrdiff_t>(first),
                                                 channels.begin() + static_cast<std::ptrdiff_t>(c)}),
            study::Scope::everything);
        const auto all = slopes_at(problem, at, outputs, noise, *problem.function->make_workspace());
        Index column = n;
        for (std::size_t own = first; all && own < c; ++own) {
            const Index count = hypotheses[own].none.size();
            const auto part = [&](const MatrixXd& matrix) {
                MatrixXd columns(matrix.rows(), n + count);
                columns << matrix.leftCols(n), matrix.middleCols(column, count);
                return columns;
            };
            slopes[own] = Slopes{.at = part(all->at.transpose()).transpose(),
                                 .residuals = all->residuals,
                                 .rows = part(all->rows),
                                 .outputs = all->outputs,
                                 .output_rows = part(all->output_rows)};
            column += count;
        }
    }
    return channels.size();
}

// From the answer to the hypothesis's own best point at the strength that says most, by Gauss and Newton's steps; the
// slopes there.
Slopes slopes_at_best(const Hypothesis& hypothesis, Slopes slopes, Index parameters,
                      const std::vector<std::size_t>& outputs, double noise) {
    const problem::Problem problem = study::make_noise_problem(hypothesis.study, study::Scope::everything);
    const auto workspace = problem.function->make_workspace();
    constexpr int steps = 4;
    constexpr int halvings = 3;
    const auto most_said = [&](const Slopes& there) {
        std::size_t best = 0;
        double evidence = -INFINITY;
        for (std::size_t s = 0; s < hypothesis.strengths.size(); ++s) {
            const double now =
                diagnose::say(there, parameters, hypothesis.none, hypothesis.strengths[s] * hypothesis.reach)
                    .log_evidence;
            if (now > evidence) {
                evidence = now;
                best = s;
            }
        }
        return best;
    };
    for (int step = 0; step < steps; ++step) {
        const MatrixXd reach = hypothesis.strengths[most_said(slopes)] * hypothesis.reach;
        const auto sum = [&](const Slopes& there) {
            const VectorXd own = reach.fullPivLu().solve(there.at.tail(hypothesis.none.size()) - hypothesis.none);
            return there.residuals.squaredNorm() + own.squaredNorm() +
                   (there.at.head(parameters).array() - 0.5).square().sum() / diagnose::box_variance;
        };
        const double before = sum(slopes);
        VectorXd move = diagnose::say(slopes, parameters, hypothesis.none, reach).best - slopes.at;
        double gained = 0.0;
        for (int halving = 0; halving < halvings && !(gained > 0.0); ++halving, move *= 0.5) {
            const VectorXd next = (slopes.at + move).cwiseMax(0.0).cwiseMin(1.0);
            auto there = slopes_at(problem, next, outputs, noise, *workspace);
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

// By how much the mesh is off in ln|output|, by Richardson's extrapolation from a finer one (second order); 0 where
// there is none.
VectorXd mesh_errors(const study::Study& study, const problem::Evaluation& best,
                     const std::vector<std::size_t>& outputs) {
    VectorXd errors = VectorXd::Zero(static_cast<Index>(outputs.size()));
    const auto refined = on_finer_mesh(study);
    if (!refined) {
        return errors;
    }
    try {
        const problem::Problem finer = study::make_problem(*refined, study::Scope::everything);
        const auto outcome = finer.function->evaluate(best.parameters, false, *finer.function->make_workspace());
        const double ratio = refined->model.settings.refine / study.model.settings.refine;
        for (Index o = 0; outcome && o < errors.size(); ++o) {
            const std::size_t row = outputs[static_cast<std::size_t>(o)];
            const double change = std::log(std::abs(outcome->responses[row] / best.responses[row]));
            errors[o] = std::isfinite(change) ? change / (1.0 - 1.0 / (ratio * ratio)) : 0.0;
        }
    } catch (const pave::Error&) { // too large
    }
    return errors;
}

} // namespace

std::vector<OutputUncertainty> output_ranges(const study::Study& study, const std::vector<double>& unit, double noise,
                                             int threads) {
    std::vector<std::size_t> outputs = study.outputs();
    if (outputs.empty() || !(noise > 0.0)) {
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
    for (const landscape::BoundMet& bound : landscape::bounds_met(unit)) { // the model as it is gives way no further
        right_slopes->rows.col(static_cast<Index>(bound.axis)).setZero();
        right_slopes->output_rows.col(static_cast<Index>(bound.axis)).setZero();
    }
    const Said right = diagnose::say(*right_slopes, n, VectorXd(0), MatrixXd(0, 0));
    const std::vector<Hypothesis> hypotheses = hypotheses_of(study);
    std::vector<std::optional<Slopes>> slopes(hypotheses.size());
    tbb::task_arena arena(run::concurrency(threads));
    const std::size_t corrections = slopes_of_corrections(study, answer, hypotheses, outputs, noise, slopes);
    run::for_each_index(arena, hypotheses.size() - corrections, [&](std::size_t i) {
        const std::size_t c = corrections + i;
        const Hypothesis& hypothesis = hypotheses[c];
        if (n + hypothesis.none.size() > static_cast<Index>(study::most_parameters)) {
            return;
        }
        VectorXd at(n + hypothesis.none.size());
        at << answer, hypothesis.none;
        const problem::Problem problem = study::make_noise_problem(hypothesis.study, study::Scope::everything);
        slopes[c] = slopes_at(problem, at, outputs, noise, *problem.function->make_workspace());
    });
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
    run::for_each_index(arena, std::min(leading, order.size()), [&](std::size_t i) {
        const std::size_t c = order[i].second;
        if (slopes[c] && order[0].first > without + far) {
            slopes[c] = slopes_at_best(hypotheses[c], std::move(*slopes[c]), n, outputs, noise);
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
    // No hypothesis is exact: the noise counts twice, of the stated size or, where none leaves so little, of that which
    // the best of them leaves. So much holds the truth in nine of ten blind cases (tools/output-trials).
    constexpr double inexact = 2.0;
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
    const VectorXd of_mesh = mesh_errors(study, best, outputs);
    constexpr double tail = 0.025;
    const double reach = gsl_cdf_ugaussian_Pinv(1.0 - tail);
    std::vector<OutputUncertainty> ranges;
    for (std::size_t o = 0; o < outputs.size(); ++o) {
        const auto at = static_cast<Index>(o);
        std::vector<double> means;
        std::vector<double> deviations;
        for (const Said& said : all) {
            means.push_back(said.mean[at] - right_slopes->outputs[at]);
            deviations.push_back(std::hypot(larger * said.deviation[at], of_mesh[at]));
        }
        const double value = best.responses[outputs[o]];
        const double half = reach * right.deviation[at];
        const double below = diagnose::mixture_quantile(weights, means, deviations, tail);
        const double above = diagnose::mixture_quantile(weights, means, deviations, 1.0 - tail);
        OutputUncertainty range{.reading = outputs[o],
                                .best = value,
                                .low = value * std::exp(-half),
                                .high = value * std::exp(half),
                                .wide_low = value * std::exp(below),
                                .wide_high = value * std::exp(above),
                                .channel = hypotheses[leads].name,
                                .share = shares[leads]};
        if (value < 0.0) {
            std::swap(range.low, range.high);
            std::swap(range.wide_low, range.wide_high);
        }
        ranges.push_back(std::move(range));
    }
    return ranges;
}

std::vector<std::string> output_words(const study::Study& study, const std::vector<OutputUncertainty>& ranges) {
    std::vector<std::string> words;
    for (const OutputUncertainty& r : ranges) {
        const data::Reading& output = study.readings[r.reading];
        words.push_back(fmt::format(
            "If the model may lack something, {} lies between {} and {} {} (95 %; {} to {} if it is right): what these "
            "data allow of a smooth error in one layer or kind of reading, or of an effect of the catalogue{}.",
            output.output, pave::figure(output.in_unit(r.wide_low)), pave::figure(output.in_unit(r.wide_high)),
            output.unit.name, pave::figure(output.in_unit(r.low)), pave::figure(output.in_unit(r.high)),
            r.share > 0.5 ? fmt::format(", chiefly {}", r.channel) : ""));
    }
    return words;
}

} // namespace explore::analysis
