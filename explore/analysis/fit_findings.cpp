#include "analysis/fit.h"

#include "base/error.h"
#include "base/text.h"

#include <cmath>
#include <fmt/format.h>

namespace explore::analysis {
namespace {

using landscape::Minimum;
using pave::counted;
using pave::figure;

// Minima whose misfit the noise cannot tell from the best one: within one noise level, or 5 % without degrees of
// freedom.
std::vector<const Minimum*> rivals(const std::vector<Minimum>& minima, const landscape::LocalAnalysis& best) {
    const double f0 = minima[0].evaluation.misfit;
    const double margin = best.noise > 0.0 ? std::sqrt(f0 * f0 + best.noise * best.noise) : 1.05 * f0;
    std::vector<const Minimum*> list;
    for (const Minimum& m : minima) {
        if (m.evaluation.misfit <= margin) {
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

} // namespace

std::vector<std::string> findings(const FitResult& result) {
    std::vector<std::string> text;
    const study::Study& study = result.study;
    const problem::Problem& problem = result.problem;
    const landscape::LocalAnalysis& local = result.local;
    const std::vector<Minimum>& minima = result.searches.minima;
    const bool weighted_by_noise =
        study.data.misfit == problem::MisfitKind::weighted && study.noise == study::NoiseSource::stated;
    const Minimum& best = result.best();
    const std::size_t starts = result.searches.ends.size();
    const auto close = rivals(minima, local);
    const std::string unfinished = best.converged ? "" : ", whose search had not converged when it was ended";
    if (starts == 1) {
        text.push_back(fmt::format("One search from one start{}: it says nothing about other minima.", unfinished));
    } else {
        text.push_back(
            fmt::format("{} of {} starts ended in the best minimum{}.", best.members.size(), starts, unfinished));
    }
    if (close.size() > 1) {
        text.push_back(fmt::format("{} minima fit these data equally well within their noise: the data do not single "
                                   "out one of them.",
                                   close.size()));
    } else if (minima.size() > 1) {
        text.push_back(fmt::format("The next minimum has a misfit {:.2g} times as large: a search from a single start "
                                   "could have ended there.",
                                   minima[1].evaluation.misfit / best.evaluation.misfit));
    } else if (starts > 1) {
        text.push_back("No start ended anywhere else. That does not prove that there is no other minimum.");
    }
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
    // A standard error that spans half of what the study allows says nothing about the parameter.
    std::vector<std::string> unseen;
    for (std::size_t k = 0; k < problem.space.axes.size(); ++k) {
        const bool at_bound = best.unit[k] <= 0.0 || best.unit[k] >= 1.0;
        if (!at_bound && local.standard_error[k] > 0.5) {
            unseen.push_back(problem.space.axes[k].name);
        }
    }
    if (!unseen.empty() && local.degrees_of_freedom > 0) {
        text.push_back(fmt::format("Not determined individually (the standard error spans half of the allowed range or "
                                   "more): {}. Other values fit these data as well, and what they predict elsewhere "
                                   "may differ.",
                                   pave::join(unseen)));
    }
    if (!best.on_bound.empty()) {
        text.push_back(pave::join(bound_words(problem.space, best.on_bound)) +
                       ": the data call for a value beyond the bound, or are not sensitive to it.");
    }
    if (local.noise > 0.0 && local.weakest_growth < 3.0 * local.noise) {
        text.push_back(fmt::format("The data are hardly sensitive to this change: {}. It changes the residuals by {}, "
                                   "where their noise is {}.",
                                   direction_words(problem.space, best.unit, local.weakest),
                                   figure(local.weakest_growth), figure(local.noise)));
    }
    const Eigen::VectorXd residuals = problem.residuals(best.evaluation);
    Eigen::Index worst = 0;
    const double largest = residuals.cwiseAbs().maxCoeff(&worst);
    // Residuals in units of stated noise are only news when they are large.
    const bool within_noise = weighted_by_noise && largest < 3.0;
    if (residuals.size() > 2 && !within_noise && largest * largest > 0.5 * residuals.squaredNorm()) {
        const std::size_t i = problem.response_of(static_cast<std::size_t>(worst));
        const data::Reading& reading = study.readings[i];
        text.push_back(
            fmt::format("One reading contributes {:.0f} % of the sum of squares: {}, measured {:g}, model {}. Either "
                        "it or the model is wrong there.",
                        100.0 * largest * largest / residuals.squaredNorm(), reading.label_with_unit(), reading.value,
                        figure(reading.in_unit(best.evaluation.responses[i]))));
    }
    if (local.noise_is_stated && local.degrees_of_freedom > 0) {
        text.push_back(fmt::format(
            "{}: chi2 = {} with {}, p = {:.2g}.{}",
            local.p_value < 0.05 ? "The model does not fit these data within their stated noise"
                                 : "The fit is consistent with the stated noise",
            figure(local.chi2),
            counted(static_cast<std::size_t>(local.degrees_of_freedom), "degree of freedom", "degrees of freedom"),
            local.p_value,
            local.widened ? " The standard errors are those of a noise that much larger; diagnose looks for the cause."
                          : ""));
    }
    if (local.degrees_of_freedom <= 0) {
        text.push_back(fmt::format("{} for {} free: the data cannot tell noise from a wrong model{}.",
                                   counted(problem.readings(), "reading", "readings"),
                                   counted(problem.space.axes.size(), "parameter", "parameters"),
                                   local.noise_is_stated ? "" : ", and no error of the parameters can be given"));
    } else if (study.noise == study::NoiseSource::estimated) {
        if (study.data.misfit == problem::MisfitKind::weighted) {
            text.push_back("No reading states a standard deviation: each was weighted by its own size.");
        }
        text.push_back(fmt::format(
            "The data state no noise. Estimated from the residuals of the fit, with only {}, one "
            "residual has a standard deviation of {}.",
            counted(static_cast<std::size_t>(local.degrees_of_freedom), "degree of freedom", "degrees of freedom"),
            figure(local.noise)));
    }
    return text;
}

} // namespace explore::analysis
