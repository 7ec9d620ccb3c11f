#include "analysis/sample/sample.h"

#include "analysis/common/candidate_readings.h"
#include "analysis/common/load_steps.h"
#include "base/error.h"
#include "landscape/readings_alone.h"
#include "landscape/smooth.h"
#include "study/problems.h"
#include "study/reduced_function.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <numeric>

namespace explore::analysis {
namespace {

constexpr int populations = 4;
constexpr int most_particles = 500; // of a population; more draws are further ones of the same particles

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Evenly spread over all draws, population after population.
std::vector<std::size_t> thinned(std::size_t all, std::size_t wanted) {
    std::vector<std::size_t> chosen;
    const std::size_t count = std::min(all, wanted);
    for (std::size_t k = 0; k < count; ++k) {
        chosen.push_back(k * all / count);
    }
    return chosen;
}

// In SI; not a number under a load that was not computed.
std::vector<double> outputs_of(const study::Study& study, const std::vector<double>& responses) {
    std::vector<double> values;
    for (const std::size_t i : study.outputs()) {
        values.push_back(responses[i]);
    }
    return values;
}

std::vector<double> readings_of(const study::Study& study, const std::vector<double>& responses) {
    const auto count = static_cast<std::ptrdiff_t>(study.measured().size());
    return {responses.begin(), responses.begin() + count};
}

// The full model at some of the draws. Nothing: interrupted.
std::optional<std::vector<problem::Evaluation>>
full_runs(run::Engine& engine, const std::vector<landscape::Draw>& draws, const std::vector<std::size_t>& chosen) {
    search::Design design{"draws", {}};
    for (const std::size_t i : chosen) {
        design.points.push_back(draws[i].unit);
    }
    return engine.evaluate(design);
}

constexpr double most_left = 0.1; // of the logarithm of a weight: draws are then worth 1 % less, by 1/(1 + left^2)

// The logarithms of the weights of all draws; `left`: see SampleCorrection. Empty: only those are known that were run.
VectorXd smooth_weights(const landscape::Posterior& posterior, const std::vector<std::size_t>& chosen,
                        const std::vector<double>& logarithm, double& left) {
    const auto d = static_cast<Index>(posterior.draws[0].unit.size());
    MatrixXd all(static_cast<Index>(posterior.draws.size()), d);
    for (Index i = 0; i < all.rows(); ++i) {
        all.row(i) = Eigen::Map<const Eigen::RowVectorXd>(posterior.draws[static_cast<std::size_t>(i)].unit.data(), d);
    }
    const VectorXd values = Eigen::Map<const VectorXd>(logarithm.data(), static_cast<Index>(logarithm.size()));
    const auto surface = values.allFinite() ? landscape::smooth(all(chosen, Eigen::all), values, all) : std::nullopt;
    if (!surface) {
        return {};
    }
    left = surface->left;
    return left < most_left ? surface->values : VectorXd{};
}

// Weighs draws of the reduced model by the ratio of the likelihoods.
void correct(SampleResult& result, const std::vector<std::size_t>& chosen,
             const std::vector<problem::Evaluation>& evaluations, const problem::Problem& full) {
    const auto& posterior = result.posterior;
    SampleCorrection correction{.runs = chosen.size(), .left = std::numeric_limits<double>::quiet_NaN()};
    constexpr double none = -std::numeric_limits<double>::infinity();
    std::vector<double> logarithm;
    for (std::size_t k = 0; k < chosen.size(); ++k) {
        logarithm.push_back(evaluations[k].converged()
                                ? full.log_density(evaluations[k]) - posterior.draws[chosen[k]].log_likelihood
                                : none);
        correction.without_answer += evaluations[k].converged() ? 0 : 1;
    }
    const double top = *std::max_element(logarithm.begin(), logarithm.end());
    const VectorXd smooth = smooth_weights(posterior, chosen, logarithm, correction.left);
    std::vector<double> mean(populations, 0.0);
    std::vector<double> count(populations, 0.0);
    std::size_t k = 0; // the next one chosen
    for (std::size_t i = 0; i < posterior.draws.size(); ++i) {
        const bool was_run = k < chosen.size() && chosen[k] == i;
        if (!was_run && smooth.size() == 0) {
            continue;
        }
        const double value = was_run ? logarithm[k] : smooth[static_cast<Index>(i)];
        const double weight = value == none ? 0.0 : std::exp(value - top);
        const auto p = static_cast<std::size_t>(posterior.descent.population[i]);
        mean[p] += weight;
        count[p] += 1.0;
        if (weight > 0.0) {
            SampledDraw draw;
            draw.unit = posterior.draws[i].unit;
            draw.log_likelihood = posterior.draws[i].log_likelihood + value;
            if (was_run) {
                draw.parameters = evaluations[k].parameters;
                draw.outputs = outputs_of(result.study, evaluations[k].responses);
                draw.readings = readings_of(result.study, evaluations[k].responses);
                draw.chi2 = std::pow(evaluations[k].misfit, 2);
            } else {
                draw.parameters = result.problem.space.physical(draw.unit);
                draw.chi2 = std::numeric_limits<double>::quiet_NaN();
            }
            result.draws.push_back(std::move(draw));
            result.descent.weight.push_back(weight);
            result.descent.population.push_back(posterior.descent.population[i]);
            result.descent.ancestor.push_back(posterior.descent.ancestor[i]);
        }
        k += was_run ? 1 : 0;
    }
    correction.weighed = result.draws.size();
    correction.effective = result.descent.effective_weights();
    if (smooth.size() > 0) {
        correction.effective /= 1.0 + correction.left * correction.left;
    }
    result.correction = correction;
    // The evidence of each population, times its mean weight.
    double sum = 0.0;
    std::vector<double> evidence;
    for (std::size_t p = 0; p < populations; ++p) {
        evidence.push_back(std::exp(posterior.log_evidences[p] - posterior.log_evidence) * mean[p] /
                           std::max(1.0, count[p]));
        sum += evidence.back() / populations;
    }
    double variance = 0.0;
    for (const double value : evidence) {
        variance += std::pow(value / sum - 1.0, 2) / (populations - 1.0);
    }
    result.log_evidence = posterior.log_evidence + top + std::log(sum);
    result.log_evidence_error = std::sqrt(variance / populations);
}

void take_all(SampleResult& result) {
    for (const auto& draw : result.posterior.draws) {
        problem::Evaluation e;
        e.parameters = result.problem.space.physical(draw.unit);
        e.responses = draw.responses;
        result.draws.push_back({draw.unit, e.parameters, outputs_of(result.study, draw.responses),
                                readings_of(result.study, draw.responses), draw.log_likelihood,
                                result.problem.residuals(e).squaredNorm()});
    }
    result.descent = result.posterior.descent;
    result.log_evidence = result.posterior.log_evidence;
    result.log_evidence_error = result.posterior.log_evidence_error;
}

// Outputs under loads that no reading has. False: interrupted.
bool add_outputs_besides(Session& session, SampleResult& result, const std::string& settings) {
    result.besides = outputs_besides(result.study);
    if (result.besides.empty()) {
        return true;
    }
    MatrixXd units(static_cast<Index>(result.draws.size()), static_cast<Index>(result.study.space.axes.size()));
    for (Index i = 0; i < units.rows(); ++i) {
        units.row(i) =
            Eigen::Map<const Eigen::RowVectorXd>(result.draws[static_cast<std::size_t>(i)].unit.data(), units.cols());
    }
    auto drawn = outputs_at_draws(session, result.study, units, result.descent.weight,
                                  static_cast<std::size_t>(std::max(1, result.options.confirm)), settings);
    if (!drawn) {
        return false;
    }
    const auto all = result.study.outputs();
    for (std::size_t i = 0; i < result.draws.size(); ++i) {
        auto& outputs = result.draws[i].outputs;
        outputs.resize(all.size(), std::numeric_limits<double>::quiet_NaN());
        for (std::size_t o = 0; o < drawn->rows.size(); ++o) {
            const auto at = std::find(all.begin(), all.end(), drawn->rows[o]) - all.begin();
            outputs[static_cast<std::size_t>(at)] = drawn->values(static_cast<Index>(i), static_cast<Index>(o));
        }
    }
    result.surface = std::move(drawn->surface);
    result.computed += drawn->computed;
    result.kept += drawn->kept;
    return true;
}

void summarise(SampleResult& result) {
    std::vector<double> values(result.draws.size());
    for (std::size_t k = 0; k < result.problem.space.axes.size(); ++k) {
        for (std::size_t i = 0; i < values.size(); ++i) {
            values[i] = result.draws[i].parameters[k];
        }
        result.parameters.push_back(landscape::marginal(values, result.descent));
    }
    landscape::Descent descent; // of draws with outputs
    std::vector<const SampledDraw*> with_outputs;
    for (std::size_t i = 0; i < result.draws.size(); ++i) {
        if (!result.draws[i].outputs.empty()) {
            with_outputs.push_back(&result.draws[i]);
            descent.weight.push_back(result.descent.weight[i]);
            descent.population.push_back(result.descent.population[i]);
            descent.ancestor.push_back(result.descent.ancestor[i]);
        }
    }
    for (std::size_t o = 0; o < result.study.outputs().size() && !with_outputs.empty(); ++o) {
        values.clear();
        for (const SampledDraw* draw : with_outputs) {
            values.push_back(draw->outputs[o]);
        }
        result.outputs.push_back(landscape::marginal(values, descent));
    }
}

// Of the draws whose residuals are known.
void take_noise_scale(SampleResult& result) {
    std::vector<double> sums;
    std::vector<double> weights;
    for (std::size_t i = 0; i < result.draws.size(); ++i) {
        if (std::isfinite(result.draws[i].chi2)) {
            sums.push_back(result.draws[i].chi2);
            weights.push_back(result.descent.weight[i]);
        }
    }
    result.noise_scale = problem::noise_scale_of_draws(sums, weights, result.problem.readings());
}

std::vector<PredictedReading> predicted_by_draws(const SampleResult& result) {
    Predictions predictions;
    for (std::size_t i = 0; i < result.draws.size(); ++i) {
        if (!result.draws[i].readings.empty()) {
            predictions.responses.push_back(result.draws[i].readings);
            predictions.weight.push_back(result.descent.weight[i]);
        }
    }
    return predicted(result.problem, result.study, predictions);
}

void judge(SampleResult& result) {
    const auto check = [&](const std::string& name, const landscape::Marginal& m) {
        if (m.rhat > landscape::most_rhat) {
            result.missing.push_back(fmt::format("the populations disagree on {} (R-hat {:.3f}, above {})", name,
                                                 m.rhat, landscape::most_rhat));
        } else if (m.ess < landscape::least_ess) {
            result.missing.push_back(
                fmt::format("{} has {:.0f} effective draws, fewer than {:.0f}", name, m.ess, landscape::least_ess));
        }
    };
    if (result.correction && result.correction->effective < landscape::least_ess) {
        // Few draws that are all worth one are too few; many that are worth little are of another posterior.
        const bool is_another = result.correction->effective < 0.5 * static_cast<double>(result.correction->runs);
        result.missing.push_back(fmt::format(
            "{}: {} of its draws were run by the full model and are worth {:.0f} of its own, fewer than {:.0f} "
            "(--confirm for more of them, --model full without the reduced model)",
            is_another ? "the reduced model differs too much from the full one"
                       : "too few draws of the reduced model were confirmed",
            result.correction->runs, result.correction->effective, landscape::least_ess));
    } else {
        for (std::size_t k = 0; k < result.parameters.size(); ++k) {
            check(result.problem.space.axes[k].name, result.parameters[k]);
        }
        const auto outputs = result.study.outputs();
        for (std::size_t o = 0; o < result.outputs.size(); ++o) {
            check(result.study.readings[outputs[o]].output, result.outputs[o]);
        }
    }
    result.status = result.missing.empty() ? SampleStatus::converged : SampleStatus::not_converged;
}

// At most 256 draws of equal weight: each stands for as much of the sum of the weights.
MatrixXd equal_draws(const SampleResult& result) {
    constexpr std::size_t most = 256;
    const auto& weight = result.descent.weight;
    const std::size_t n = std::min(most, result.draws.size());
    const double step = std::accumulate(weight.begin(), weight.end(), 0.0) / static_cast<double>(n);
    MatrixXd points(static_cast<Index>(n), static_cast<Index>(result.problem.space.axes.size()));
    double below = 0.0; // the weights of the draws before `draw`
    std::size_t draw = 0;
    for (std::size_t i = 0; i < n; ++i) {
        const double middle = (static_cast<double>(i) + 0.5) * step;
        while (draw + 1 < weight.size() && below + weight[draw] < middle) {
            below += weight[draw++];
        }
        points.row(static_cast<Index>(i)) =
            Eigen::Map<const Eigen::RowVectorXd>(result.draws[draw].unit.data(), points.cols());
    }
    return points;
}

// Judges the model as a fit does: by a search from the best draw and, where priors or constraints hold the answer, one
// by the readings alone. False: interrupted.
bool judge_readings(Session& session, const study::Study& study, const std::string& settings,
                    const std::vector<double>& best, SampleResult& result) {
    auto engine = session.engine(result.problem, session.begin(study, "sample-best", settings));
    auto ends = engine.search({best}, *optimise::find_method("gauss-newton"), {});
    if (!ends) {
        return false;
    }
    auto minima = landscape::distinct_minima(*ends, result.problem);
    const bool is_found = !minima.empty();
    if (is_found && !landscape::find_alone(engine, result.problem, minima[0], 1)) {
        return false;
    }
    result.computed += engine.tally().computed;
    result.kept += engine.tally().kept;
    session.begin(study, "sample", settings); // the sample is the run used last
    if (!is_found) {
        return true;
    }
    const landscape::JudgedFit fit = landscape::judged_fit(result.problem, minima[0]);
    result.chi2 = fit.sum;
    result.degrees_of_freedom = fit.degrees_of_freedom;
    result.p_value = landscape::goodness_of(fit.problem, *fit.at, fit.sum, fit.degrees_of_freedom).p_value;
    if (result.problem.priors().empty() && result.problem.limits.empty()) {
        return true;
    }
    result.held = std::move(minima[0]);
    if (const auto acceptance = landscape::acceptance_of(result.problem, *result.held)) {
        result.priors = landscape::prior_influence(result.problem, *acceptance, *result.held);
    }
    return true;
}

// Of a model whose constraints forbid a part of the box the prior is what they leave.
void relative_to_allowed(std::uint64_t seed, SampleResult& result) {
    if (result.problem.limits.empty()) {
        return;
    }
    result.allowed = landscape::allowed_share(result.problem, seed);
    if (!result.allowed) {
        result.allowed = result.posterior.allowed;
    }
    if (result.allowed) {
        result.log_evidence -= result.allowed->log;
        result.log_evidence_error = std::hypot(result.log_evidence_error, result.allowed->error);
    }
}

} // namespace

std::string SampleResult::reason() const {
    if (failed()) {
        return posterior.draws.empty() ? posterior.reason
                                       : "the full model has no answer at any draw of the reduced one";
    }
    std::string text;
    for (const std::string& sentence : missing) {
        text += (text.empty() ? "not converged: " : "; ") + sentence;
    }
    return text;
}

void check_noise_for_sample(const study::Study& study) {
    const problem::Problem problem = study::make_noise_problem(study, study::Scope::fitted);
    if (!problem.noise_is_stated() && !problem.noise_scale_is_sought()) {
        throw pave::Error({.file = study.file, .key = "data.noise"}, "a posterior needs the noise of every reading", {},
                          "sigma in the data, or [data.noise] with relative, absolute or scale = \"sought\"");
    }
}

std::optional<SampleResult> sample(Session& session, const study::Study& given, const SampleOptions& asked) {
    const auto begin = std::chrono::steady_clock::now();
    check_noise_for_sample(given);
    const study::Study study = with_enough_load_steps(given, session);
    const problem::Problem full = study::make_noise_problem(study, study::Scope::fitted);
    SampleOptions options = asked;
    if (options.any_model) {
        options.model.use = study::why_no_reduced_model(study).empty() ? ModelUse::automatic : ModelUse::full;
    }
    auto reduced = session.reduced(full, study, options.model);
    if (options.model.reduced() && !reduced) {
        return std::nullopt;
    }
    SampleResult result{.study = study,
                        .options = options,
                        .problem = options.model.alone() ? reduced->problem : full,
                        .posterior = {}};
    result.reduced = std::move(reduced);
    const int rounds = (options.samples + populations * most_particles - 1) / (populations * most_particles);
    const int pairs = 2 * populations * rounds;
    const int particles = 2 * ((options.samples + pairs - 1) / pairs); // even
    const std::string settings =
        fmt::format("{} populations of {}, {} rounds, seed {}{}", populations, particles, rounds,
                    session.options().seed, result.reduced ? result.reduced->settings : "");
    const bool confirmed = options.model.confirmed();
    const problem::Problem& sampled = confirmed ? result.reduced->problem : result.problem;
    std::pair<std::string, std::string> run_of_sample{confirmed ? "sample-reduced" : "sample", settings};
    const int run = session.begin(study, run_of_sample.first, run_of_sample.second);
    {
        run::Engine engine(sampled, session.store(), run,
                           {.threads = session.options().threads, .show_progress = false});
        auto posterior = landscape::posterior(engine, sampled,
                                              {.populations = populations,
                                               .particles = particles,
                                               .rounds = rounds,
                                               .show_progress = session.options().show_progress},
                                              session.options().seed);
        if (!posterior) {
            return std::nullopt;
        }
        result.posterior = std::move(*posterior);
        (confirmed ? result.computed_by_reduced_model : result.computed) = engine.tally().computed;
        result.kept = confirmed ? 0 : engine.tally().kept;
    }
    if (!result.posterior.draws.empty()) {
        if (!confirmed) {
            take_all(result);
        }
        if (confirmed) {
            const auto chosen =
                thinned(result.posterior.draws.size(), static_cast<std::size_t>(std::max(1, options.confirm)));
            run_of_sample = {"sample", fmt::format("{}, {} of the draws", settings, chosen.size())};
            auto engine = session.engine(full, session.begin(study, run_of_sample.first, run_of_sample.second));
            const auto evaluations = full_runs(engine, result.posterior.draws, chosen);
            if (!evaluations) {
                return std::nullopt;
            }
            result.computed += engine.tally().computed;
            result.kept += engine.tally().kept;
            correct(result, chosen, *evaluations, full);
        }
        if (!options.model.alone() && !result.draws.empty()) {
            if (!add_outputs_besides(session, result, run_of_sample.second)) {
                return std::nullopt;
            }
            session.begin(study, run_of_sample.first, run_of_sample.second); // the sample is the run used last
        }
        for (SampledDraw& draw : result.draws) {
            if (!std::all_of(draw.outputs.begin(), draw.outputs.end(), [](double v) { return std::isfinite(v); })) {
                draw.outputs.clear();
            }
        }
    }
    if (!result.draws.empty()) {
        summarise(result);
        result.predicted = predicted_by_draws(result);
        const auto best = std::min_element(result.draws.begin(), result.draws.end(), [](const auto& a, const auto& b) {
            return std::isfinite(a.chi2) && !(b.chi2 <= a.chi2);
        });
        result.chi2 = best->chi2;
        result.degrees_of_freedom = full.degrees_of_freedom(full.space.axes.size());
        if (full.noise_scale_is_sought()) { // which makes chi2 what it should be
            take_noise_scale(result);
        } else if (!judge_readings(session, study, settings, best->unit, result)) {
            return std::nullopt;
        }
        relative_to_allowed(session.options().seed, result);
        judge(result);
        if (result.converged() && !options.model.alone() && !full.noise_scale_is_sought()) {
            result.telling = telling_readings(result.study, equal_draws(result));
        }
    }
    result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    return result;
}

} // namespace explore::analysis
