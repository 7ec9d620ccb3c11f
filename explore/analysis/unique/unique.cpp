#include "analysis/unique/unique.h"

#include "analysis/common/layout.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fmt/format.h>

namespace explore::analysis {

namespace {

// Nodes of all pairs together: of the full model, whose runs take some ten times as long.
constexpr int most_nodes_of_full_model = 2000;

// Around the minima that were found, by the problem of `engine`, which may be of a reduced model: then from its own
// minima. Nothing: interrupted.
std::optional<UniqueLandscape> landscape_around(run::Engine& engine, const problem::Problem& problem,
                                                const landscape::Uniqueness& answer, bool reduced) {
    std::vector<std::vector<double>> starts;
    for (const std::size_t m : answer.accepted) {
        starts.push_back(answer.minima[m].unit);
    }
    for (std::size_t m = 0; m < answer.minima.size(); ++m) {
        constexpr std::size_t most_rejected = 3; // other basins are seen where the data reject them, too
        const bool accepted = std::find(answer.accepted.begin(), answer.accepted.end(), m) != answer.accepted.end();
        if (!accepted && starts.size() < answer.accepted.size() + most_rejected) {
            starts.push_back(answer.minima[m].unit);
        }
    }
    const auto ends = engine.search(starts, *optimise::find_method("gauss-newton"), {});
    if (!ends) {
        return std::nullopt;
    }
    UniqueLandscape result{.profiled = {}, .by_reduced_model = reduced, .limit = answer.acceptance->threshold};
    std::vector<const run::Endpoint*> found;
    for (const run::Endpoint& end : *ends) {
        if (!end.search.unit.empty()) {
            found.push_back(&end);
        }
    }
    if (found.empty()) {
        return result;
    }
    std::stable_sort(found.begin(), found.end(),
                     [](const auto* a, const auto* b) { return a->evaluation.misfit < b->evaluation.misfit; });
    std::vector<std::vector<double>> minima;
    minima.reserve(found.size());
    for (const run::Endpoint* end : found) {
        minima.push_back(end->search.unit);
    }
    std::vector<landscape::Reach> reach;
    for (std::size_t k = 0; k < answer.parameters.size(); ++k) {
        const problem::Axis& axis = problem.space.axes[k];
        reach.push_back({axis.unit(answer.parameters[k].low), axis.unit(answer.parameters[k].high)});
    }
    landscape::PairProfileSettings settings;
    settings.first_start = static_cast<int>(starts.size());
    if (!reduced) {
        settings.most_nodes = most_nodes_of_full_model;
    }
    auto profiled = landscape::profiled_landscape(engine, problem, *answer.acceptance, minima,
                                                  found[0]->evaluation.misfit, reach, settings);
    if (!profiled) {
        return std::nullopt;
    }
    result.profiled = std::move(*profiled);
    result.runs = engine.tally().computed;
    return result;
}

} // namespace

std::string UniqueResult::reason() const {
    return run::why_no_minimum(problem, answer.explored);
}

std::optional<UniqueResult> unique(Session& session, const study::Study& given, const UniqueOptions& options) {
    const auto begin = std::chrono::steady_clock::now();
    const study::Study study = with_enough_load_steps(given, session);
    if (options.posterior) {
        check_noise_for_sample(study);
    }
    const problem::Problem full = study::make_noise_problem(study, study::Scope::fitted);
    const problem::Problem everything = study::make_noise_problem(study, study::Scope::everything);
    auto reduced = session.reduced(full, study, options.model);
    if (options.model.reduced() && !reduced) {
        return std::nullopt;
    }
    UniqueResult result{.study = study,
                        .options = options,
                        .problem = options.model.alone() ? reduced->problem : full,
                        .answer = {},
                        .next = {},
                        .landscape = {},
                        .mesh = {},
                        .path = {},
                        .outputs = {},
                        .posterior = {},
                        .reduced = std::move(reduced),
                        .curves = {}};
    const std::string settings = fmt::format("searches of {} evaluations, seed {}{}", options.settings.max_evaluations,
                                             session.options().seed, result.reduced ? result.reduced->settings : "");
    std::optional<run::Engine> explorer;
    if (options.model.confirmed()) { // a run of its own: its evaluations are not the full model's
        explorer.emplace(result.reduced->problem, session.store(), session.begin(study, "explore", settings),
                         session.engine_settings());
    }
    // A reduced model's is computed again sooner than it is read.
    const bool with_landscape = options.landscape || options.model.reduced();
    const int landscape_run =
        with_landscape && !result.reduced ? session.begin(study, "unique-landscape", settings) : 0;
    const int outputs_run = session.begin(study, "unique-outputs", settings);
    auto engine = session.engine(result.problem, session.begin(study, "unique", settings));
    auto everything_engine = session.engine(everything, outputs_run);
    auto task = uniqueness_task(study, result.problem, everything, engine, everything_engine, session.options().seed);
    task.explorer = explorer ? &*explorer : nullptr;
    if (options.model.alone()) {
        task.outputs.clear(); // of loads that it may not have
    }
    auto answer = landscape::uniqueness(task, options.settings);
    if (!answer) {
        return std::nullopt;
    }
    result.answer = std::move(*answer);
    if (!result.failed() && result.answer.acceptance) {
        result.next = next_reading(study, result.problem, result.answer);
    }
    if (with_landscape && result.answer.acceptance && !result.answer.parameters.empty()) {
        const problem::Problem& of = result.reduced ? result.reduced->problem : full;
        run::Engine own(of, result.reduced ? nullptr : session.store(), landscape_run, session.engine_settings());
        result.landscape = landscape_around(own, of, result.answer, result.reduced.has_value());
        if (!result.landscape) {
            return std::nullopt;
        }
        result.forward_cpu_seconds += own.tally().forward_cpu_seconds;
    }
    if (!result.failed() && !options.model.alone()) {
        result.curves = curves(study, result.best().evaluation.parameters);
        if (result.answer.acceptance) {
            const double noise = std::sqrt(result.answer.acceptance->variance);
            result.mesh = mesh_error(study, result.problem, result.best().evaluation, result.best().unit, noise);
            result.path = path_error(study, result.problem, result.best().evaluation, noise);
            result.outputs =
                output_ranges(study, result.best().unit,
                              result.answer.acceptance->noise_is_stated ? 1.0 : result.answer.acceptance->noise(),
                              session.options().threads);
            const std::vector<std::size_t> outputs = study.outputs();
            for (OutputUncertainty& range : result.outputs) { // walked along, where the other is to first order
                const auto o = static_cast<std::size_t>(std::find(outputs.begin(), outputs.end(), range.reading) -
                                                        outputs.begin());
                if (o < result.answer.outputs.size()) {
                    range.low = result.answer.outputs[o].low;
                    range.high = result.answer.outputs[o].high;
                }
            }
        }
    }
    result.computed = engine.tally().computed + everything_engine.tally().computed;
    result.kept = engine.tally().kept + everything_engine.tally().kept;
    result.forward_cpu_seconds += engine.tally().forward_cpu_seconds + everything_engine.tally().forward_cpu_seconds +
                                  result.next.forward_cpu_seconds;
    if (explorer) {
        result.computed_by_reduced_model = explorer->tally().computed;
        result.forward_cpu_seconds += explorer->tally().forward_cpu_seconds;
    }
    if (options.posterior && !result.answer.parameters.empty()) {
        const auto sampled = sample(session, study, {.model = options.model, .any_model = !options.model.reduced()});
        if (!sampled) {
            return std::nullopt;
        }
        session.begin(study, "unique", settings); // the run used last
        result.posterior = posterior_ranges(result.problem, result.answer, *sampled);
        result.computed += sampled->computed;
        result.kept += sampled->kept;
        result.computed_by_reduced_model += sampled->computed_by_reduced_model;
    }
    result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    return result;
}

} // namespace explore::analysis
