#include "analysis/unique/map.h"

#include "base/error.h"
#include "base/text.h"
#include "study/problems.h"

#include <algorithm>
#include <fmt/format.h>

namespace explore::analysis {
namespace {

constexpr std::int64_t most_points = 10'000'000;

bool is_grid(const MapOptions& options, const study::Study& study) {
    return options.design == MapDesign::automatic ? search::full_grid_size(study.space) > 0
                                                  : options.design == MapDesign::grid;
}

search::Design make_design(const MapOptions& options, const study::Study& study, std::uint64_t seed) {
    const auto grid_size = search::full_grid_size(study.space, options.points);
    if (!is_grid(options, study)) {
        return search::sobol(study.space, options.points > 0 ? options.points : map_points, seed);
    }
    if (grid_size <= 0 || grid_size > most_points) {
        throw pave::Error(
            {.file = study.file, .key = "parameters"}, "a full grid needs the number of points of each parameter",
            grid_size <= 0 ? "a parameter without points" : "too many points",
            fmt::format("points = ... in every [[parameters]], or --points; at most {} in all", most_points));
    }
    return search::full_grid(study.space, options.points);
}

// The full model with every response at the lowest points. False: interrupted.
bool complete(Session& session, MapResult& map, const std::string& settings) {
    search::Design again{map.design.name, {}};
    for (const auto& low : map.lowest) {
        again.points.push_back(map.design.points[low.number]);
    }
    const problem::Problem full = study::make_problem(map.study);
    run::Engine engine(full, session.store(),
                       session.begin(map.study, "map", settings + ", its lowest by the full model"),
                       {.threads = session.options().threads, .show_progress = false});
    auto computed = engine.evaluate(again);
    if (!computed) {
        return false;
    }
    for (std::size_t k = 0; k < map.lowest.size(); ++k) {
        if (!map.options.model.confirmed() && !(*computed)[k].converged()) {
            // The map stands; what it did not compute has no answer there.
            map.lowest[k].evaluation.warnings.push_back("not all loads have an answer here: " + (*computed)[k].reason);
            continue;
        }
        map.lowest[k].evaluation = std::move((*computed)[k]);
    }
    std::stable_sort(map.lowest.begin(), map.lowest.end(), [](const auto& a, const auto& b) {
        return a.evaluation.converged() && !(a.evaluation.misfit >= b.evaluation.misfit); // the others have no misfit
    });
    session.begin(map.study, "map", settings); // the map is the run used last
    return true;
}

} // namespace

bool has_more_to_predict(const study::Study& study) {
    const std::vector<bool> fitted = study::fitted_loads(study);
    return std::any_of(study.model.sensors.begin(), study.model.sensors.end(),
                       [&](const auto& sensor) { return !fitted[static_cast<std::size_t>(sensor.load)]; });
}

std::vector<std::string> findings(const MapResult& result) {
    if (result.failed()) {
        return {};
    }
    const problem::Evaluation& lowest = result.lowest[0].evaluation;
    std::vector<std::string> at;
    for (std::size_t k = 0; k < lowest.parameters.size(); ++k) {
        at.push_back(fmt::format("{} = {}", result.study.space.axes[k].name, pave::figure(lowest.parameters[k])));
    }
    return {fmt::format("The lowest misfit of {} is {}, at {}. It may be lower between them: fit searches for that.",
                        pave::counted(result.evaluations.size(), "point", "points"), pave::figure(lowest.misfit),
                        pave::join(at))};
}

std::optional<MapResult> map(Session& session, const study::Study& study, const MapOptions& options) {
    const bool adaptive = options.design == MapDesign::adaptive;
    const int points = options.points > 0 ? options.points : map_points;
    const auto [threads, seed] = std::pair(session.options().threads, session.options().seed);
    std::optional<ReducedProblem> reduced;
    if (options.model.reduced()) {
        reduced = session.reduced(study::make_problem(study, study::Scope::fitted), study, options.model);
        if (!reduced) {
            return std::nullopt;
        }
    }
    MapResult result{.study = study,
                     .options = options,
                     .design = adaptive ? search::Design{landscape::adaptive_name(points, seed), {}}
                                        : make_design(options, study, seed),
                     .is_grid = is_grid(options, study),
                     .evaluations = {},
                     .lowest = {},
                     .explored = {},
                     .reduced = std::move(reduced),
                     .tally = {}};
    const problem::Problem problem =
        result.reduced ? result.reduced->problem : study::make_problem(study, study::Scope::fitted);
    const std::string settings = result.design.run_name() + (result.reduced ? result.reduced->settings : "");
    auto engine = session.engine(problem, session.begin(study, "map", settings));
    std::optional<std::vector<problem::Evaluation>> evaluations;
    if (adaptive) {
        if (auto map = landscape::adaptive_map(engine, problem, points, seed, threads)) {
            result.design = std::move(map->design);
            evaluations = std::move(map->evaluations);
            result.explored = map->explored;
        }
    } else {
        evaluations = engine.evaluate(result.design);
    }
    if (!evaluations) {
        return std::nullopt;
    }
    result.evaluations = std::move(*evaluations);
    result.tally = engine.tally();
    for (const std::size_t i : run::distinct_starts(result.design, result.evaluations, map_lowest, 0.0)) {
        result.lowest.push_back({i, result.evaluations[i]});
    }
    const bool to_complete = options.model.confirmed() || (!options.model.alone() && has_more_to_predict(study));
    if (!result.failed() && to_complete && !complete(session, result, settings)) {
        return std::nullopt;
    }
    return result;
}

} // namespace explore::analysis
