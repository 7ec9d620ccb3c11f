#include "analysis/fit/fit.h"

#include "analysis/common/load_steps.h"
#include "base/error.h"
#include "base/text.h"
#include "landscape/confirmation.h"
#include "landscape/readings_alone.h"
#include "landscape/uniqueness.h"
#include "problem/student.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace explore::analysis {
namespace {

constexpr int first_confirming = landscape::first_start_of_others + 1000; // start of a chain

search::Design make_design(FitOptions& options, const study::Study& study, std::uint64_t seed) {
    if (options.scheme == Scheme::multistart) {
        return search::sobol(study.space, options.explore, seed);
    }
    options.multistart.starts = 1;
    constexpr int coarse = 4;
    if (search::full_grid_size(study.space, coarse) > 100'000) {
        throw pave::Error({.file = study.file, .key = "parameters"}, "too many parameters for the paper's full grid",
                          pave::counted(study.space.axes.size(), "parameter", "parameters"), "--scheme multistart");
    }
    problem::ParameterSpace space = study.space;
    for (auto& axis : space.axes) {
        axis.points = coarse; // an axis held in `map` is free here
    }
    return search::full_grid(space);
}

} // namespace

std::string FitResult::reason() const {
    return run::why_no_minimum(problem, searches.explored);
}

std::optional<problem::NoiseScale> FitResult::noise_scale() const {
    if (!problem.noise_scale_is_sought() || failed() || local.degrees_of_freedom < 1) {
        return std::nullopt;
    }
    return problem::noise_scale_of_fit(local.noise * local.noise * local.degrees_of_freedom, local.degrees_of_freedom);
}

bool FitResult::leaves_unknown(std::size_t parameter) const {
    const auto range = held.of(parameter);
    return !landscape::is_at_bound(best().unit[parameter]) &&
           (range ? range->high - range->low >= landscape::LocalAnalysis::undetermined : !local.determines(parameter));
}

std::optional<FitResult> fit(Session& session, const study::Study& given, const FitOptions& asked) {
    const study::Study study = with_enough_load_steps(given, session);
    const problem::Problem full = study::make_problem(study, study::Scope::fitted);
    auto reduced = session.reduced(full, study, asked.model);
    if (asked.model.reduced() && !reduced) {
        return std::nullopt;
    }
    FitOptions options = asked;
    search::Design design = make_design(options, study, session.options().seed);
    FitResult result{.study = study,
                     .options = options,
                     .problem = options.model.alone() ? reduced->problem : full,
                     .design = std::move(design),
                     .searches = {},
                     .local = {},
                     .joint = {},
                     .alone = {},
                     .reduced = std::move(reduced),
                     .without_floor = {},
                     .mesh = {},
                     .path = {},
                     .drifts = {},
                     .priors = {},
                     .curves = {},
                     .tally = {}};
    const auto& search = options.multistart.search;
    // Not how many evaluations a search may take: with more it goes on where it ended.
    const std::string settings = fmt::format(
        "{}; starts at distance {}; {}, tolerances {} {}{}{}", result.design.run_name(),
        options.multistart.start_distance, options.multistart.method, search.step_tolerance, search.misfit_tolerance,
        result.reduced ? result.reduced->settings : "", options.model.confirmed() ? " to explore" : "");
    std::optional<std::vector<problem::Evaluation>> explored;
    if (options.model.confirmed()) { // a run of its own: its evaluations are not the full model's
        auto engine = session.engine(result.reduced->problem, session.begin(study, "explore", settings));
        explored = engine.evaluate(result.design);
        if (!explored) {
            return std::nullopt;
        }
        result.seconds_by_reduced_model = engine.tally().seconds;
    }
    auto engine = session.engine(result.problem, session.begin(study, "fit", settings));
    if (!explored && !options.starts.empty()) {
        explored = engine.evaluate(result.design);
        if (!explored) {
            return std::nullopt;
        }
    }
    auto searches = explored ? landscape::refine(engine, result.problem, result.design, std::move(*explored),
                                                 options.starts, options.multistart)
                             : landscape::multistart(engine, result.problem, result.design, options.multistart);
    if (!searches) {
        return std::nullopt;
    }
    result.searches = std::move(*searches);
    if (result.failed()) {
        result.tally = engine.tally();
        return result;
    }
    const std::size_t searched =
        result.design.points.size() + static_cast<std::size_t>(landscape::search_evaluations(result.searches.ends));
    if (!landscape::confirm(engine, result.problem, landscape::confirming_method(options.multistart.method),
                            landscape::analyse(result.best(), result.problem).noise,
                            landscape::confirming_evaluations(searched), first_confirming, result.searches.minima)) {
        return std::nullopt;
    }
    const Predictor predictor(study);
    landscape::Minimum& best = result.searches.minima[0];
    if (!landscape::find_alone(engine, result.problem.in_units_of_noise(), best, landscape::first_start_of_others)) {
        return std::nullopt;
    }
    predictor.complete(best.evaluation);
    result.drifts = sensor_drifts(study, best.evaluation);
    result.joint = group_fit(study, predictor, "all", result.problem, best);
    result.local = result.joint->local;
    result.held = landscape::held_ranges(result.problem, best, result.local, result.local.bounds_count());
    if (!result.problem.priors().empty()) {
        const problem::Problem by_noise = result.problem.in_units_of_noise();
        if (const auto acceptance = landscape::acceptance_of(by_noise, best)) {
            result.priors = landscape::prior_influence(by_noise, *acceptance, best);
        }
    }
    if (!options.model.alone()) {
        result.without_floor = fit_without_floor(study, best.unit);
        const landscape::LocalAnalysis& local = result.local;
        const double noise = !local.noise_is_stated ? local.noise
                             : local.widened        ? std::sqrt(local.chi2 / local.degrees_of_freedom)
                                                    : 1.0;
        const problem::Problem by_noise = result.problem.in_units_of_noise();
        result.mesh = mesh_error(study, by_noise, best.evaluation, best.unit, noise);
        result.path = path_error(study, by_noise, best.evaluation, noise);
        result.curves = curves(study, best.evaluation.parameters);
    }
    if (!options.joint_only && !options.model.alone()) {
        auto alone = fit_alone(session, study, predictor, result.design, result.searches, settings, options.multistart);
        if (!alone) {
            return std::nullopt;
        }
        result.alone = std::move(*alone);
        session.begin(study, "fit", settings); // the run of this fit is the one used last
    }
    result.tally = engine.tally();
    return result;
}

std::vector<double> reading_weights(const problem::Problem& problem, const problem::Evaluation& evaluation) {
    std::vector<double> weights(problem.readings(), 1.0);
    if (problem.noise_is_student()) {
        const Eigen::VectorXd z = problem.standard_residuals(evaluation);
        std::transform(z.begin(), z.end(), weights.begin(),
                       [&](double value) { return problem::student_weight(value, problem.noise_degrees()); });
    }
    return weights;
}

} // namespace explore::analysis
