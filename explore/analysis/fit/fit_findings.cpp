#include "analysis/common/data_faults.h"
#include "analysis/common/knowledge_words.h"
#include "analysis/common/layout.h"
#include "analysis/common/limit_words.h"
#include "analysis/common/option_ranges.h"
#include "analysis/common/repeated_rows.h"
#include "analysis/common/say.h"
#include "analysis/common/sought_noise.h"
#include "analysis/common/stress_steps.h"
#include "analysis/fit/fit.h"

#include "base/error.h"
#include "base/text.h"
#include "external/model.h"
#include "landscape/confirmation.h"
#include "landscape/readings_alone.h"

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <gsl/gsl_cdf.h>

namespace explore::analysis {
namespace {

using landscape::Minimum;
using pave::counted;
using pave::figure;
using pave::p_words;

// Minima whose misfit the noise of each reading cannot tell from the best one: within one noise level, or 5 % without
// degrees of freedom.
std::vector<const Minimum*> rivals(const std::vector<Minimum>& minima, const problem::Problem& problem,
                                   const landscape::LocalAnalysis& best) {
    const problem::Problem by_noise = problem.in_units_of_noise();
    const double f0 = by_noise.misfit(minima[0].evaluation);
    const double noise = best.noise_is_stated ? best.widening : best.noise;
    constexpr double rounding = 1e-6; // residuals of exact solutions differ by it
    const double margin = noise > 0.0 ? std::sqrt(f0 * f0 + noise * noise) : std::max(1.05 * f0, rounding);
    std::vector<const Minimum*> list;
    for (const Minimum& m : minima) {
        if (by_noise.misfit(m.evaluation) <= margin) {
            list.push_back(&m);
        }
    }
    return list;
}

std::string direction_words(const problem::ParameterSpace& space, const std::vector<double>& unit,
                            const std::vector<double>& direction) {
    std::string text;
    for (std::size_t k = 0; k < direction.size(); ++k) {
        if (std::abs(direction[k]) < 0.1) {
            continue;
        }
        const problem::Axis& axis = space.axes[k];
        const double moved = 0.1 * direction[k];
        text += text.empty() ? "" : " with ";
        text += axis.scale == problem::Scale::log
                    ? fmt::format("{} x {:.2f}", axis.name, std::pow(axis.high / axis.low, moved))
                    : fmt::format("{} {:+.2g}", axis.name, moved * axis.d_physical(unit[k]));
    }
    return text;
}

// Whether chi2 agrees with the noise, where that is stated.
std::string noise_words(const landscape::LocalAnalysis& local, bool is_student, bool alone) {
    const std::string dof =
        counted(static_cast<std::size_t>(local.degrees_of_freedom), "degree of freedom", "degrees of freedom");
    return fmt::format(
        "{}{}: {}, {}.{}", alone ? "Judged by the readings alone, without priors or constraints: " : "",
        local.p_value < landscape::contradicted
            ? (alone ? "the model does not fit these data within their stated noise"
                     : "The model does not fit these data within their stated noise")
            : (alone ? "the fit is consistent with the stated noise" : "The fit is consistent with the stated noise"),
        is_student ? fmt::format("-2 ln likelihood = {} above that of no residuals, where fits of such noise leave {} "
                                 "(simulated, {})",
                                 figure(local.chi2), figure(local.expected_chi2), dof)
                   : fmt::format("chi2 = {} with {}", figure(local.chi2), dof),
        p_words(local.p_value),
        !local.widened ? ""
        : is_student
            ? " The standard errors are those of a noise that much larger: leave out the readings named below, "
              "where it is they that are wrong."
            : " The standard errors are those of a noise that much larger; diagnose looks for the cause.");
}

// Whether there is a chi2 to speak of that the stated noise does not explain.
bool contradicts_noise(const landscape::LocalAnalysis& local) {
    return local.noise_is_stated && local.p_value < landscape::contradicted && local.degrees_of_freedom > 0;
}

// Parameters that the data do not determine: too few readings, errors as wide as the range.
void unknown_parameters(const FitResult& result, std::vector<std::string>& text) {
    const problem::ParameterSpace& space = result.problem.space;
    const std::size_t count = space.axes.size();
    if (result.problem.readings() < count) {
        text.push_back(fmt::format("{} for {}: whatever this fit says, other values fit these readings as well. Hold "
                                   "parameters at known values, state priors for them, or add readings.",
                                   counted(result.problem.readings(), "reading", "readings"),
                                   counted(count, "parameter", "parameters")));
    }
    std::vector<std::string> unseen;
    for (std::size_t k = 0; k < count; ++k) {
        if (result.leaves_unknown(k)) {
            unseen.push_back(space.axes[k].name);
        }
    }
    if (!unseen.empty() && (result.local.degrees_of_freedom > 0 || result.local.noise_is_stated)) {
        text.push_back(fmt::format("Not determined individually (the 95 % range spans half of the allowed range or "
                                   "more): {}. Other values fit these data as well, and what they predict elsewhere "
                                   "may differ: unique says how far.",
                                   pave::join(unseen)));
    }
}

// Parameters on bounds: what they mean for the rest is said before any of it.
void parameters_on_bounds(const FitResult& result, std::vector<std::string>& text) {
    const Minimum& best = result.best();
    if (!best.on_bound.empty()) {
        text.push_back(
            fmt::format("{}: the data ask for a value beyond the bound, or are not sensitive to it.{}{}",
                        pave::join(bound_words(result.problem.space, best.on_bound)),
                        result.local.degrees_of_freedom > 0
                            ? fmt::format(" The degrees of freedom count {} as known.",
                                          counted(best.on_bound.size(), "parameter", "parameters") + " on a bound")
                            : "",
                        contradicts_noise(result.local)
                            ? " What does not fit below may do so with the range opened: try that first."
                            : " Widen the range, hold the parameter at a known value, or state a prior."));
    }
}

// 95 % ranges that inequalities or bounds cut: no standard error tells them.
std::string held_words(const FitResult& result) {
    if (!result.held.any()) {
        return "";
    }
    std::vector<std::string> limits;
    for (const std::size_t i : result.held.limits) {
        limits.push_back(result.problem.limits[i]->text());
    }
    for (const landscape::BoundMet& bound : result.held.bounds) {
        limits.push_back(fmt::format("the {} bound of {}", bound.upper ? "upper" : "lower",
                                     result.problem.space.axes[bound.axis].name));
    }
    std::vector<std::string> ranges;
    for (std::size_t k = 0; k < result.problem.space.axes.size(); ++k) {
        if (const auto range = result.held.of(k)) {
            const problem::Axis& axis = result.problem.space.axes[k];
            ranges.push_back(fmt::format("{} {} to {}", axis.name, figure(axis.physical(range->low)),
                                         figure(axis.physical(range->high))));
        }
    }
    return fmt::format("Ranges of 95 % that end, on one side, at {}, to first order: {}.", pave::join(limits),
                       pave::join(ranges));
}

// The weights of readings under Student's noise.
std::string downweighted(const FitResult& result) {
    const std::vector<double> weights = reading_weights(result.problem, result.best().evaluation);
    std::vector<std::string> names;
    for (std::size_t i = 0; i < weights.size(); ++i) {
        if (weights[i] < 0.5) {
            names.push_back(fmt::format(
                "{} ({:.2g})", result.study.readings[result.problem.response_of(i)].label_with_unit(), weights[i]));
        }
    }
    const std::string noise =
        fmt::format("Noise of Student's t distribution with {:g} degrees of freedom", result.problem.noise_degrees());
    return names.empty()
               ? noise + ": no reading counts less than half of what it would with normal noise."
               : fmt::format("{}: {} {} less than half of what {} would with normal noise (1): {}. {}", noise,
                             counted(names.size(), "reading", "readings"), names.size() == 1 ? "counts" : "count",
                             names.size() == 1 ? "it" : "they", pave::join(names),
                             names.size() == 1 ? "It or the model is wrong there: check it."
                                               : "They or the model are wrong there: check them.");
}

// A reading whose residual noise does not explain: its studentised residual (Cook and Weisberg 1982), the largest of
// all at a family-wise level of 5 %. By the stated noise where it explains the residuals of the others; where it does
// not, or none is stated, by that, and then with too few of them nothing can be said. "": none.
std::string accused_reading(const FitResult& result) {
    // Where priors or constraints hold the answer, of the fit of the readings by themselves.
    const landscape::JudgedFit fit = landscape::judged_fit(result.problem.in_units_of_noise(), result.best());
    const problem::Problem& by_noise = fit.problem;
    const problem::Evaluation& answer = *fit.at;
    const Eigen::VectorXd r = by_noise.residuals(answer);
    const landscape::LocalAnalysis local =
        result.best().alone
            ? landscape::analyse({.evaluation = answer, .unit = by_noise.space.unit(answer.parameters)}, by_noise)
            : result.local;
    const auto n = static_cast<double>(by_noise.readings());
    // With correlated noise: of a shift of that reading alone, tested in the residuals of all.
    Eigen::MatrixXd followed; // what the parameters follow: orthonormal columns
    if (by_noise.noise_is_correlated()) {
        followed = landscape::followed_by(by_noise.residual_jacobian(answer),
                                          landscape::bounds_met(by_noise.space.unit(answer.parameters)));
    }
    const double dof = local.degrees_of_freedom - 1.0; // of the residuals of the other readings
    if (!(local.noise_is_stated && !local.widened) && dof < 1.0) {
        return "";
    }
    Eigen::Index worst = -1;
    double largest = 0.0;
    double least_p = 1.0;
    double worst_deviate = 0.0;
    bool by_others = false;
    for (Eigen::Index i = 0; i < static_cast<Eigen::Index>(by_noise.readings()); ++i) {
        double own = 1.0 - local.leverage[i];
        double pull = r[i];
        if (by_noise.noise_is_correlated()) {
            const Eigen::VectorXd shift = by_noise.change_by(static_cast<std::size_t>(i)).normalized();
            own = 1.0 - (followed.transpose() * shift).squaredNorm();
            pull = shift.dot(r);
        }
        constexpr double nothing = 1e-6; // the parameters follow it, whatever it reads
        if (own < nothing) {
            continue;
        }
        const double rest = std::max(0.0, r.squaredNorm() - pull * pull / own);
        const bool others_fit =
            local.noise_is_stated && (!local.widened || gsl_cdf_chisq_Q(rest, dof) >= landscape::contradicted);
        double deviate = std::min(std::abs(pull) / std::sqrt(own), r.norm()); // no more than all residuals
        if (!others_fit) {
            constexpr double rounding = 1e-9;
            deviate = rest > 0.0 && std::abs(pull) > rounding ? std::abs(pull) / std::sqrt(own * rest / dof) : 0.0;
        }
        const double chance = 2.0 * (others_fit ? gsl_cdf_ugaussian_Q(deviate) : gsl_cdf_tdist_Q(deviate, dof));
        if (chance < least_p || (chance == least_p && deviate > worst_deviate)) { // both may be too small a number
            least_p = chance;
            worst_deviate = deviate;
            worst = i;
            largest = pull;
            by_others = !others_fit;
        }
    }
    const double p = n * least_p;
    if (worst < 0 || p > 0.05) {
        return "";
    }
    const data::Reading& reading = result.study.readings[result.problem.response_of(static_cast<std::size_t>(worst))];
    const double model = answer.responses[result.problem.response_of(static_cast<std::size_t>(worst))];
    return fmt::format("One reading stands out{} ({:.0f} % of the sum of squares; p {} among {}): {}, measured {:g}, "
                       "model {}. Either it or {} is wrong there: check it, and fit without it (a # before its line in "
                       "the file).",
                       local.noise_is_stated && by_others ? " against the others" : "",
                       100.0 * largest * largest / r.squaredNorm(), p < 1e-15 ? "< 1e-15" : fmt::format("= {:.2g}", p),
                       counted(by_noise.readings(), "reading", "readings"), reading.label_with_unit(), reading.value,
                       figure(reading.in_unit(model)),
                       result.best().on_bound.empty() ? "the model" : "the model, its bounds included,");
}

// How the search of the best minimum ended: the second method's, where that went on.
std::string why_not_converged(const FitResult& result) {
    const Minimum& best = result.best();
    if (best.second && !best.second->agrees) {
        return std::string(best.second->method) + ": " + best.second->ended;
    }
    const auto& ends = result.searches.ends;
    return best.members.empty() ? "" : ends[static_cast<std::size_t>(best.members[0])].search.ended;
}

// Of searches that had not converged when they were ended; "": none.
std::string limited_words(const FitResult& result) {
    const int most = result.options.multistart.search.max_evaluations;
    const auto& ends = result.searches.ends;
    const auto limited = static_cast<std::size_t>(std::count_if(ends.begin(), ends.end(), [&](const auto& end) {
        return !end.search.converged && end.search.evaluations >= most;
    }));
    if (limited == 0) {
        return "";
    }
    const int more = static_cast<int>(std::min<long>(4L * most, allowed::fit_evaluations.high));
    return fmt::format("{} had not converged when {} ended after {}: the same fit with --evaluations {} goes on with "
                       "{}.",
                       counted(limited, "search", "searches"), limited == 1 ? "it was" : "they were",
                       counted(static_cast<std::size_t>(most), "evaluation", "evaluations"), more,
                       limited == 1 ? "it" : "them");
}

} // namespace

std::vector<std::string> findings(const FitResult& result) {
    std::vector<std::string> text;
    const study::Study& study = result.study;
    const problem::Problem& problem = result.problem;
    const landscape::LocalAnalysis& local = result.local;
    const std::vector<Minimum>& minima = result.searches.minima;
    const Minimum& best = result.best();
    const std::size_t starts = result.searches.ends.size();
    const auto close = rivals(minima, problem, local);
    // The most important comes first: what is not known, then where the searches ended.
    if (!best.converged) {
        text.push_back(
            fmt::format("The search that came lowest had not converged ({}): the misfit may fall further. "
                        "Neither the model nor a reading is judged by it, and its standard errors are of a "
                        "point that is none of the data's.{}",
                        why_not_converged(result),
                        limited_words(result).empty() ? " More --starts, or another --method, may end it." : ""));
    }
    if (best.converged && contradicts_noise(local) && best.on_bound.empty()) {
        text.push_back(noise_words(local, problem.noise_is_student(), best.alone.has_value()));
    }
    parameters_on_bounds(result, text);
    if (best.converged && contradicts_noise(local) && !best.on_bound.empty()) {
        text.push_back(noise_words(local, problem.noise_is_student(), best.alone.has_value()));
    }
    std::vector<WantedAlone> alone;
    for (const GroupFit& own : result.alone) {
        alone.push_back({own.fitted, own.minimum.unit, own.local.standard_error});
    }
    for (std::string& sentence : stress_steps(study, alone)) {
        text.push_back(std::move(sentence));
    }
    unknown_parameters(result, text);
    say(text, active_constraints(problem, best).words);
    say(text, held_words(result));
    say(text, repeated_rows_words(study));
    for (const std::string& words : fault_words(study)) {
        text.push_back(fmt::format("Before any model: {}.", words));
    }
    if (result.priors) {
        const auto sentences = prior_findings(problem, *result.priors);
        text.insert(text.end(), sentences.begin(), sentences.end());
    }
    const std::string unfinished = best.converged ? "" : ", whose search had not converged when it was ended";
    const auto early = static_cast<std::size_t>(
        std::count_if(result.searches.ends.begin(), result.searches.ends.end(), [&](const run::Endpoint& end) {
            return !end.search.unit.empty() && std::none_of(minima.begin(), minima.end(), [&](const Minimum& m) {
                return std::find(m.members.begin(), m.members.end(), end.start) != m.members.end();
            });
        }));
    if (starts == 1) {
        text.push_back(fmt::format("One search from one start{}: it says nothing about other minima; --starts 12 does.",
                                   unfinished));
    } else {
        text.push_back(
            fmt::format("{} of {} starts ended in the best minimum{}.", best.members.size(), starts, unfinished));
    }
    if (early > 0) {
        text.push_back(fmt::format("{} ended early, or beyond a constraint, and {} no minimum.",
                                   counted(early, "search", "searches"), early == 1 ? "is" : "are"));
    }
    say(text, limited_words(result));
    if (close.size() > 1) {
        text.push_back(fmt::format("{} minima fit these data equally well within their noise: the data do not single "
                                   "out one of them. unique compares what they predict.",
                                   close.size()));
    } else if (minima.size() > 1) {
        text.push_back(fmt::format("The next minimum has a misfit {:.2g} times as large: a search from a single start "
                                   "could have ended there.",
                                   minima[1].evaluation.misfit / best.evaluation.misfit));
    } else if (starts > 1 && early == 0) {
        text.push_back("No start ended anywhere else. That does not prove that there is no other minimum.");
    }
    say(text, landscape::confirmation_words(minima));
    // How far each parameter reaches over everything that fits as well.
    std::vector<std::string> loose;
    for (std::size_t k = 0; k < problem.space.axes.size(); ++k) {
        const problem::Axis& axis = problem.space.axes[k];
        double low = best.lowest[k];
        double high = best.highest[k];
        for (const Minimum* m : close) {
            low = std::min(low, m->lowest[k]);
            high = std::max(high, m->highest[k]);
        }
        if (axis.unit(high) - axis.unit(low) > 0.05) {
            loose.push_back(fmt::format("{} from {} to {}", axis.name, figure(low), figure(high)));
        }
    }
    if (!loose.empty()) {
        text.push_back("Searches that fit equally well ended with " + pave::join(loose) +
                       ": what fits as well reaches at least that far.");
    }
    if (const auto asked = static_cast<std::size_t>(result.options.multistart.starts); starts < asked) {
        text.push_back(fmt::format("{} of the {} starts requested were run: every other explored point with an answer "
                                   "lies nearer than {:g} (unit cube) to one of them. More explored points (--explore) "
                                   "give more starts.",
                                   starts, asked, result.options.multistart.start_distance));
    }
    const std::string change = direction_words(problem.space, best.unit, local.weakest);
    // In units of the noise of what it changes; the change is a tenth of the box.
    const Eigen::Map<const Eigen::VectorXd> weakest(local.weakest.data(),
                                                    static_cast<Eigen::Index>(local.weakest.size()));
    const double growth = local.root.cols() > 0 ? 0.1 * (local.root * weakest).norm() : INFINITY;
    if (growth < 3.0 && !change.empty()) {
        text.push_back(fmt::format("The data are hardly sensitive to this change: {}. It changes the residuals by {} "
                                   "times their noise.",
                                   change, figure(growth)));
    }
    if (problem.noise_is_student()) {
        text.push_back(downweighted(result));
    } else if (const std::string accused = best.converged ? accused_reading(result) : ""; !accused.empty()) {
        text.push_back(accused);
    }
    if (best.converged && local.noise_is_stated && !contradicts_noise(local) && local.degrees_of_freedom > 0) {
        text.push_back(noise_words(local, problem.noise_is_student(), best.alone.has_value()));
    }
    say(text, weights_words(study));
    say(text, noise_key_words(study));
    say(text, limit_words(study));
    say(text, misfit_words(study));
    if (local.degrees_of_freedom <= 0) {
        text.push_back(fmt::format("{} for {} free: the data cannot tell noise from a wrong model{}. Readings that are "
                                   "added, or a parameter that is held, let them.",
                                   counted(problem.readings(), "reading", "readings"),
                                   counted(problem.space.axes.size(), "parameter", "parameters"),
                                   local.noise_is_stated ? "" : ", and no error of the parameters can be given"));
    } else if (study.noise == study::NoiseSource::sought) {
        text.push_back(noise_scale_words(study, *result.noise_scale()));
    } else if (study.noise == study::NoiseSource::estimated) {
        if (study.data.misfit == problem::MisfitKind::weighted) {
            text.push_back("No reading states a standard deviation: each was weighted by its own size.");
        }
        text.push_back(fmt::format(
            "The data state no noise. Estimated from the residuals of the fit, with only {}, one "
            "residual has a standard deviation of {}. State it under [data.noise] to judge the model; `pavescape "
            "noise` "
            "finds it in repeated drops.",
            counted(static_cast<std::size_t>(local.degrees_of_freedom), "degree of freedom", "degrees of freedom"),
            figure(local.noise)));
    }
    if (result.without_floor) {
        say(text, floor_words(study, best, local, *result.without_floor));
    }
    say(text, drift_words(study, result.drifts));
    say(text, mesh_words(study, result.mesh));
    say(text, path_words(study, result.path));
    if (study.external && !study.external->derivative_words().empty()) {
        text.push_back(study.external->derivative_words());
    }
    return text;
}

} // namespace explore::analysis
