// pavescape map: the misfit landscape over a grid or a space-filling design.
#include "cli/model.h"
#include "landscape/adaptive_map.h"
#include "report/table.h"
#include "run/engine.h"
#include "run/message.h"
#include "run/progress.h"
#include "study/reduced_function.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <map>

namespace explore::cli {
namespace {

struct MapOptions {
    CommonOptions common;
    ModelOptions model;
    std::string design; // empty: grid when every parameter states its points, else sobol
    int points = 0;     // grid: an axis; others: in all
};

constexpr std::int64_t most_points = 10'000'000;

search::Design make_design(const MapOptions& options, const study::Study& study) {
    const auto grid_size = search::full_grid_size(study.space, options.points);
    const bool grid = options.design.empty() ? search::full_grid_size(study.space) > 0 : options.design == "grid";
    if (!grid) {
        return search::sobol(study.space, options.points > 0 ? options.points : map_points, options.common.seed);
    }
    if (grid_size <= 0 || grid_size > most_points) {
        throw pave::Error(
            {.file = study.file, .key = "parameters"}, "a full grid needs the number of points of each parameter",
            grid_size <= 0 ? "a parameter without points" : "too many points",
            fmt::format("points = ... in every [[parameters]], or --points; at most {} in all", most_points));
    }
    return search::full_grid(study.space, options.points);
}

// The lowest misfit for every value of every axis of a grid.
std::string axis_profiles(const study::Study& study, const std::vector<problem::Evaluation>& evaluations) {
    report::Table table({"parameter", "from", "to", "lowest misfit at each value", "best at"});
    for (std::size_t k = 0; k < study.space.axes.size(); ++k) {
        std::map<double, double> lowest;
        for (const auto& e : evaluations) {
            double& value = lowest.try_emplace(e.parameters[k], std::numeric_limits<double>::quiet_NaN()).first->second;
            if (e.converged() && !(value <= e.misfit)) {
                value = e.misfit;
            }
        }
        std::vector<double> values;
        double best_at = 0.0;
        double best = std::numeric_limits<double>::infinity();
        for (const auto& [at, misfit] : lowest) {
            values.push_back(misfit);
            if (misfit < best) {
                best = misfit;
                best_at = at;
            }
        }
        table.add({study.space.axes[k].name, report::figure(lowest.begin()->first),
                   report::figure(lowest.rbegin()->first), report::sparkline(values), report::figure(best_at)});
    }
    return table.text();
}

// The full model at the points where the reduced one found the lowest misfits.
std::optional<std::vector<problem::Evaluation>> confirm(const study::Study& study, const search::Design& design,
                                                        const std::vector<std::size_t>& lowest, run::Store& store,
                                                        const MapOptions& options, const std::string& settings) {
    search::Design again{design.name, {}};
    for (const std::size_t i : lowest) {
        again.points.push_back(design.points[i]);
    }
    const problem::Problem full = study::make_problem(study);
    const int id = store.begin(run_header(study, "map", settings + ", its lowest by the full model"));
    run::Engine engine(full, &store, id, {.threads = options.common.threads, .show_progress = false});
    return engine.evaluate(again);
}

int map(const MapOptions& options) {
    const bool adaptive = options.design == "adaptive";
    const int points = options.points > 0 ? options.points : map_points;
    if (adaptive && points < landscape::least_adaptive) {
        throw pave::Error({.key = "--points"}, "too few points for an adaptive map", fmt::format("{}", points),
                          fmt::format("at least {}", landscape::least_adaptive));
    }
    const study::Study study = study::load_study(options.common.study);
    const std::string folder = options.common.folder(study);
    std::optional<ReducedProblem> reduced;
    if (options.model.reduced()) {
        reduced = reduced_problem(study::make_problem(study, study::Scope::fitted), study, options.model, folder,
                                  options.common.threads);
        if (!reduced) {
            return report_interrupt(folder);
        }
    }
    const problem::Problem problem = reduced ? reduced->problem : study::make_problem(study);
    search::Design design = adaptive ? search::Design{landscape::adaptive_name(points, options.common.seed), {}}
                                     : make_design(options, study);
    const std::string settings = design.name + (reduced ? reduced->settings : "");
    run::Store store(folder, session(options.common));
    const int id = store.begin(run_header(study, "map", settings));
    run::Engine engine(problem, &store, id, {.threads = options.common.threads, .show_progress = true});
    std::optional<std::vector<problem::Evaluation>> evaluations;
    std::optional<landscape::Explored> explored;
    if (adaptive) {
        if (auto map = landscape::adaptive_map(engine, problem, points, options.common.seed, options.common.threads)) {
            design = std::move(map->design);
            evaluations = std::move(map->evaluations);
            explored = map->explored;
        }
    } else {
        evaluations = engine.evaluate(design);
    }
    if (!evaluations) {
        return report_interrupt(folder);
    }
    const run::Tally& tally = engine.tally();
    const double rate = tally.seconds > 0.0 ? static_cast<double>(tally.computed) / tally.seconds : 0.0;
    auto lowest = run::distinct_starts(design, *evaluations, 10, 0.0);
    std::vector<problem::Evaluation> reported;
    reported.reserve(lowest.size());
    for (const std::size_t i : lowest) {
        reported.push_back((*evaluations)[i]);
    }
    if (options.model.confirmed()) {
        auto confirmed = confirm(study, design, lowest, store, options, settings);
        if (!confirmed) {
            return report_interrupt(folder);
        }
        std::vector<std::pair<std::size_t, problem::Evaluation>> sorted;
        for (std::size_t k = 0; k < lowest.size(); ++k) {
            sorted.emplace_back(lowest[k], std::move((*confirmed)[k]));
        }
        std::stable_sort(sorted.begin(), sorted.end(), [](const auto& a, const auto& b) {
            return a.second.converged() && !(a.second.misfit >= b.second.misfit); // the others have no misfit
        });
        for (std::size_t k = 0; k < lowest.size(); ++k) {
            lowest[k] = sorted[k].first;
            reported[k] = std::move(sorted[k].second);
        }
        store.begin(run_header(study, "map", settings)); // the map is the run used last
    }

    report::Json json = {{"design", design.name},
                         {"model", options.model.model},
                         {"points", design.points.size()},
                         {"computed", tally.computed},
                         {"kept", tally.kept},
                         {"runs_per_second", rate},
                         {"statuses", report::status_counts(*evaluations)},
                         {"parameters", report::space_json(study.space)},
                         {"study", {{"file", study.file}, {"title", study.title}, {"hash", study.hash}}},
                         {"version", PAVESCAPE_VERSION},
                         {"run", folder}};
    if (reduced) {
        json["reduced_model"] = reduced->json;
        json["reduced_model"]["built"] = reduced->built;
        json["by_full_model"] = std::count_if(evaluations->begin(), evaluations->end(), study::is_by_full_model);
    }
    if (explored) {
        json["explored"] = {{"checks", explored->checks},
                            {"foretold", explored->foretold},
                            {"tolerance", landscape::Explored::tolerance},
                            {"share_low", explored->low},
                            {"share_high", explored->high},
                            {"median_error", explored->median_error}};
    }
    json["lowest"] = report::Json::array();
    for (std::size_t k = 0; k < lowest.size(); ++k) {
        const auto& e = reported[k];
        json["lowest"].push_back({{"number", lowest[k]},
                                  {"misfit", e.misfit},
                                  {"parameters", report::parameters_json(study.space, e.parameters)}});
        if (options.model.confirmed()) {
            json["lowest"].back()["misfit_of_reduced_model"] = (*evaluations)[lowest[k]].misfit;
        }
    }
    const std::string without_answer =
        lowest.empty() ? "not one point of the map has an answer; the first says: " + evaluations->front().reason : "";
    if (lowest.empty()) {
        json["status"] = "failed";
        json["reason"] = without_answer;
    }
    store.put_result(id, report::json_text(json, -1));
    write_file(folder, "map.json", report::json_text(json) + "\n");
    if (options.common.json) {
        fmt::print("{}\n", report::json_text(json));
        if (lowest.empty()) {
            run::message("pavescape: {}\n", without_answer);
        }
        return lowest.empty() ? computation_failed : done;
    }
    fmt::print("{}\n  {}: {} computed in {} ({:.1f} runs/s), {} kept from before\n", study_summary(study), design.name,
               report::counted(static_cast<std::size_t>(tally.computed), "point", "points"),
               run::duration_words(tally.seconds), rate, tally.kept);
    if (reduced) {
        fmt::print("{}  {} of the points by the full model, where the reduced one estimates an error above {:g} %\n{}",
                   reduced->words, json["by_full_model"].get<std::int64_t>(), options.model.limit_percent,
                   options.model.alone() ? "  misfits below are those of the reduced model\n"
                                         : "  the lowest below are computed again by the full model\n");
    }
    for (const auto& [status, count] : json["statuses"].items()) {
        fmt::print("    {:<19} {}\n", status, count.get<std::int64_t>());
    }
    if (explored) {
        fmt::print(
            "  explored: from the map the misfit of a point drawn at random is foretold within {:g} % in {} of {} "
            "draws,\n    so in {:.0f} to {:.0f} % of the box (95 %); median error {:.2g} %\n",
            100.0 * landscape::Explored::tolerance, explored->foretold, explored->checks, 100.0 * explored->low,
            100.0 * explored->high, 100.0 * explored->median_error);
    }
    if (lowest.empty()) {
        run::message("pavescape: {}\n", without_answer);
        return computation_failed;
    }
    if (design.name.starts_with("grid")) {
        fmt::print("\n{}", axis_profiles(study, *evaluations));
    }
    std::vector<std::string> header{"lowest", "misfit"};
    for (const auto& axis : study.space.axes) {
        header.push_back(axis.name);
    }
    report::Table table(header);
    for (std::size_t k = 0; k < lowest.size(); ++k) {
        std::vector<std::string> row{fmt::format("{}", lowest[k]), report::figure(reported[k].misfit)};
        for (const double value : reported[k].parameters) {
            row.push_back(report::figure(value));
        }
        table.add(std::move(row));
    }
    fmt::print("\n{}\n  all points: pavescape export {} --command map\n", table.text(), folder);
    return done;
}

} // namespace

void add_map(CLI::App& app, Action& action) {
    auto* command = app.add_subcommand("map", "the misfit landscape over a grid or a space-filling design");
    auto options = std::make_shared<MapOptions>();
    add_common(*command, options->common);
    add_model(*command, options->model);
    command
        ->add_option(
            "--design", options->design,
            "grid, sobol, or adaptive: more points where the landscape bends and is low, and a word on how much of the "
            "box is explored (default: grid when the study states the points, else sobol)")
        ->check(CLI::IsMember({"grid", "sobol", "adaptive"}));
    command->add_option("--points", options->points, "sobol, adaptive: points in all; grid: points of each parameter")
        ->check(CLI::Range(1, 10'000'000));
    command->footer("Example: pavescape map grids/captif-p1-fwd.toml");
    command->callback([=, &action] { action = [=] { return map(*options); }; });
}

} // namespace explore::cli
