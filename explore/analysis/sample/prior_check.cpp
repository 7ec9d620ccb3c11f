#include "analysis/sample/prior_check.h"

#include "analysis/common/load_steps.h"
#include "analysis/sample/sample.h"
#include "base/error.h"
#include "base/text.h"
#include "landscape/marginals.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <gsl/gsl_cdf.h>
#include <numbers>

namespace explore::analysis {
namespace {

// The problem without its readings: priors and constraints.
problem::Problem known_beforehand(const problem::Problem& problem) {
    problem::Problem known(problem.space, nullptr, problem::Misfit(problem::MisfitKind::noise, {}));
    known.limits = problem.limits;
    return known;
}

// From uniform numbers, a point of each parameter's own prior within the box; adds the logarithm of its density over
// what is uniform in the box.
std::vector<double> by_priors(const problem::ParameterSpace& space, std::vector<double> unit, double& log_density) {
    for (std::size_t k = 0; k < space.axes.size(); ++k) {
        const problem::Axis& axis = space.axes[k];
        if (!axis.prior) {
            continue;
        }
        const double low = gsl_cdf_ugaussian_P(axis.pull(axis.low));
        const double high = gsl_cdf_ugaussian_P(axis.pull(axis.high));
        const double pull = gsl_cdf_ugaussian_Pinv(low + unit[k] * (high - low));
        if (std::isfinite(pull)) {
            unit[k] = std::clamp((pull - axis.pull(axis.low)) / (axis.pull(axis.high) - axis.pull(axis.low)), 0.0, 1.0);
        }
        const double there = axis.pull(axis.physical(unit[k]));
        log_density +=
            std::log(axis.d_pull() / (high - low)) - 0.5 * std::log(2.0 * std::numbers::pi) - 0.5 * there * there;
    }
    return unit;
}

} // namespace

std::vector<std::size_t> PriorCheck::unreached() const {
    std::vector<std::size_t> rows;
    constexpr double tail = 0.005;
    for (const PredictedReading& reading : readings) {
        if (reading.below < tail || reading.below > 1.0 - tail) {
            rows.push_back(reading.row);
        }
    }
    return rows;
}

std::optional<PriorCheck> prior_check(Session& session, const study::Study& given, int points) {
    check_noise_for_sample(given);
    study::Study study = with_enough_load_steps(given, session);
    for (data::Reading& reading : study.readings) {
        reading.noise.scale_is_sought = false;
    }
    const problem::Problem problem = study::make_noise_problem(study, study::Scope::fitted);
    const problem::Problem known = known_beforehand(problem);
    search::Design design = search::sobol(study.space, points, session.options().seed);
    std::vector<double> independent(design.points.size(), 0.0);
    for (std::size_t i = 0; i < design.points.size(); ++i) {
        design.points[i] = by_priors(study.space, std::move(design.points[i]), independent[i]);
    }
    auto engine = session.engine(problem, session.begin(study, "sample-prior", design.run_name()));
    const auto evaluations = engine.evaluate(design);
    if (!evaluations) {
        return std::nullopt;
    }
    PriorCheck check{.study = study, .points = design.points.size()};
    check.computed = engine.tally().computed;
    check.kept = engine.tally().kept;
    Predictions predictions;
    landscape::Descent weights;
    for (std::size_t i = 0; i < evaluations->size(); ++i) {
        const problem::Evaluation& e = (*evaluations)[i];
        if (!e.converged()) {
            continue;
        }
        ++check.answered;
        if (const double weight = std::exp(known.log_density(e) - independent[i]); weight > 0.0) {
            predictions.responses.push_back(e.responses);
            predictions.weight.push_back(weight);
        }
    }
    if (predictions.weight.empty()) {
        check.missing = check.answered == 0 ? "not one point of the prior has an answer"
                                            : "no point of the prior that was drawn meets the constraints";
        return check;
    }
    weights.weight = predictions.weight;
    check.effective = weights.effective_weights();
    check.readings = predicted(problem, study, predictions);
    return check;
}

std::vector<std::string> findings(const PriorCheck& check) {
    std::vector<std::string> names;
    const auto rows = check.unreached();
    for (const PredictedReading& reading : check.readings) {
        if (std::find(rows.begin(), rows.end(), reading.row) != rows.end()) {
            const data::Reading& r = check.study.readings[reading.row];
            names.push_back(fmt::format("{} (read {:g} {}, predicted {} to {})", r.words(), r.value, r.unit.name,
                                        pave::figure(r.in_unit(reading.low)), pave::figure(r.in_unit(reading.high))));
        }
    }
    std::vector<std::string> text;
    text.push_back(
        names.empty()
            ? fmt::format("The prior reaches {}.", check.readings.size() == 1
                                                       ? "the reading"
                                                       : fmt::format("all {} readings", check.readings.size()))
            : fmt::format(
                  "The prior does not reach {}: {}. A fit within this box and by these priors will hardly meet {}; "
                  "look at units, places, bounds and the section first.",
                  pave::counted(names.size(), "reading", "readings"), pave::join(names, "; "),
                  names.size() == 1 ? "it" : "them"));
    if (constexpr double few = 100.0; check.effective < few) {
        text.push_back(fmt::format("Only {:.0f} of {} points count, by constraints and answers: --samples for more.",
                                   check.effective, check.points));
    }
    return text;
}

} // namespace explore::analysis
