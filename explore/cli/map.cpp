// pavescape map: the misfit landscape over a grid or a space-filling design.
#include "cli/common.h"
#include "report/table.h"
#include "run/engine.h"
#include "run/progress.h"

#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <map>

namespace explore::cli {
namespace {

struct MapOptions {
    CommonOptions common;
    std::string design; // empty: grid when every parameter states its points, else sobol
    int points = 0;     // grid: an axis; sobol: in all
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

int map(const MapOptions& options) {
    const study::Study study = study::load_study(options.common.study);
    const problem::Problem problem = study::make_problem(study);
    const search::Design design = make_design(options, study);
    const std::string folder = options.common.folder(study);
    run::Store store(folder, session(options.common));
    const int id = store.begin(run_header(study, "map", design.name));
    run::Engine engine(problem, &store, id, {.threads = options.common.threads, .show_progress = true});
    const auto evaluations = engine.evaluate(design);
    if (!evaluations) {
        return report_interrupt(folder);
    }
    const run::Tally& tally = engine.tally();
    const double rate = tally.seconds > 0.0 ? static_cast<double>(tally.computed) / tally.seconds : 0.0;
    const auto lowest = run::distinct_starts(design, *evaluations, 10, 0.0);

    report::Json json = {{"design", design.name},
                         {"points", design.points.size()},
                         {"computed", tally.computed},
                         {"kept", tally.kept},
                         {"runs_per_second", rate},
                         {"statuses", report::status_counts(*evaluations)},
                         {"parameters", report::space_json(study.space)},
                         {"study", {{"file", study.file}, {"title", study.title}, {"hash", study.hash}}},
                         {"version", PAVESCAPE_VERSION},
                         {"run", folder}};
    json["lowest"] = report::Json::array();
    for (const std::size_t i : lowest) {
        const auto& e = (*evaluations)[i];
        json["lowest"].push_back(
            {{"number", i}, {"misfit", e.misfit}, {"parameters", report::parameters_json(study.space, e.parameters)}});
    }
    store.put_result(id, json.dump());
    write_file(folder, "map.json", json.dump(2) + "\n");
    if (options.common.json) {
        fmt::print("{}\n", json.dump(2));
        return lowest.empty() ? computation_failed : done;
    }
    fmt::print("{}\n  {}: {} computed in {} ({:.1f} runs/s), {} kept from before\n", study_summary(study), design.name,
               report::counted(static_cast<std::size_t>(tally.computed), "point", "points"),
               run::duration_words(tally.seconds), rate, tally.kept);
    for (const auto& [status, count] : json["statuses"].items()) {
        fmt::print("    {:<19} {}\n", status, count.get<std::int64_t>());
    }
    if (lowest.empty()) {
        fmt::print(stderr, "pavescape: not one point of the map has an answer; the first says: {}\n",
                   evaluations->front().reason);
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
    for (const std::size_t i : lowest) {
        std::vector<std::string> row{fmt::format("{}", i), report::figure((*evaluations)[i].misfit)};
        for (const double value : (*evaluations)[i].parameters) {
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
    command->add_option("--design", options->design, "grid or sobol (default: grid when the study states the points)")
        ->check(CLI::IsMember({"grid", "sobol"}));
    command->add_option("--points", options->points, "sobol: points in all; grid: points of each parameter")
        ->check(CLI::Range(1, 10'000'000));
    command->footer("Example: pavescape map grids/captif-p1-fwd.toml");
    command->callback([=, &action] { action = [=] { return map(*options); }; });
}

} // namespace explore::cli
