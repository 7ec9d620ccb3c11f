#include "report/map.h"

#include "analysis/explore/build.h"
#include "base/text.h"
#include "report/text.h"
#include "run/program.h"
#include "run/progress.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <map>

namespace explore::report {
namespace {

using analysis::MapResult;
using pave::figure;

// The lowest misfit for every value of every axis of a grid.
std::string axis_profiles(const MapResult& map) {
    const study::Study& study = map.study;
    Table table({"parameter", "from", "to", "lowest misfit at each value", "best at"});
    for (std::size_t k = 0; k < study.space.axes.size(); ++k) {
        std::map<double, double> lowest;
        for (const auto& e : map.evaluations) {
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
        table.add({study.space.axes[k].name, figure(lowest.begin()->first), figure(lowest.rbegin()->first),
                   sparkline(values), figure(best_at)});
    }
    return table.text();
}

double runs_per_second(const run::Tally& tally) {
    return tally.seconds > 0.0 ? static_cast<double>(tally.computed) / tally.seconds : 0.0;
}

std::ptrdiff_t by_full_model(const MapResult& map) {
    return std::count_if(map.evaluations.begin(), map.evaluations.end(),
                         [](const problem::Evaluation& e) { return e.in_place_of_reduced; });
}

} // namespace

Json map_json(const MapResult& map, const analysis::RunOptions& run) {
    Json json = {{"design", map.design.name},
                 {"model", map.options.model.name()},
                 {"points", map.design.points.size()},
                 {"computed", map.tally.computed},
                 {"kept", map.tally.kept},
                 {"runs_per_second", runs_per_second(map.tally)},
                 {"statuses", status_counts(map.evaluations)},
                 {"parameters", space_json(map.study.space)},
                 {"study", study_json(map.study)},
                 {"version", analysis::version},
                 {"run", run.folder}};
    if (map.reduced) {
        json["reduced_model"] = reduced_json(*map.reduced);
        json["reduced_model"]["built"] = map.reduced->built;
        json["by_full_model"] = by_full_model(map);
    }
    if (map.explored) {
        json["explored"] = {{"checks", map.explored->checks},
                            {"predicted", map.explored->predicted},
                            {"tolerance", landscape::Explored::tolerance},
                            {"share_low", map.explored->low},
                            {"share_high", map.explored->high},
                            {"median_error", map.explored->median_error}};
    }
    json["findings"] = findings(map);
    json["lowest"] = Json::array();
    for (const auto& low : map.lowest) {
        json["lowest"].push_back({{"number", low.number},
                                  {"misfit", low.evaluation.misfit},
                                  {"parameters", parameters_json(map.study.space, low.evaluation.parameters)}});
        Json& entry = json["lowest"].back();
        if (map.options.model.confirmed()) {
            entry["misfit_of_reduced_model"] = map.evaluations[low.number].misfit;
        }
        for (const std::size_t i : map.study.outputs()) {
            const data::Reading& output = map.study.readings[i];
            const double value =
                low.evaluation.converged() ? low.evaluation.responses[i] : std::numeric_limits<double>::quiet_NaN();
            entry["outputs"].push_back(
                {{"name", output.output}, {"value", output.in_unit(value)}, {"unit", output.unit.name}});
        }
    }
    if (map.failed()) {
        json["status"] = "failed";
        json["reason"] = map.reason();
    }
    return json;
}

Answer map_answer(const MapResult& map, const analysis::RunOptions& run) {
    Answer answer;
    if (map.failed()) {
        answer.verdict =
            fmt::format("None of {} has an answer.", pave::counted(map.evaluations.size(), "point", "points"));
        answer.next = "pavescape forward " + run::shell_word(map.study.file);
        return answer;
    }
    answer.verdict_and_notes(findings(map));
    if (map.options.model.alone()) {
        answer.verdict += " By the reduced model alone: --model auto refines it with the full one.";
    }
    answer.heading = "The lowest points";
    answer.header = with_axes({"point", "misfit"}, map.study.space);
    for (const auto& low : map.lowest) {
        std::vector<std::string> row{fmt::format("{}", low.number), figure(low.evaluation.misfit)};
        std::transform(low.evaluation.parameters.begin(), low.evaluation.parameters.end(), std::back_inserter(row),
                       [](double value) { return figure(value); });
        answer.rows.push_back(std::move(row));
    }
    const auto without = static_cast<std::size_t>(
        std::count_if(map.evaluations.begin(), map.evaluations.end(), [](const auto& e) { return !e.converged(); }));
    if (without > 0) {
        answer.notes.push_back(fmt::format("{} of {} have no answer (--verbose counts the reasons).", without,
                                           pave::counted(map.evaluations.size(), "point", "points")));
    }
    if (map.explored) {
        answer.notes.push_back(fmt::format("The map predicts the misfit within {:g} % in {:.0f} to {:.0f} % of the box "
                                           "(95 %).",
                                           100.0 * landscape::Explored::tolerance, 100.0 * map.explored->low,
                                           100.0 * map.explored->high));
    }
    const std::string folder = run::shell_word(run.folder);
    answer.next =
        fmt::format("pavescape fit {} --from {}\nPicture: pavescape plot {} landscape\nAll points: pavescape export "
                    "{} --command map",
                    run::shell_word(map.study.file), folder, folder, folder);
    return answer;
}

std::string map_text(const MapResult& map, const analysis::RunOptions& run) {
    std::string text =
        fmt::format("{}\n  {}: {} computed in {} ({:.1f} runs/s), {} kept from before\n", study_summary(map.study),
                    map.design.name, pave::counted(static_cast<std::size_t>(map.tally.computed), "point", "points"),
                    run::duration_words(map.tally.seconds), runs_per_second(map.tally), map.tally.kept);
    if (map.reduced) {
        text += fmt::format(
            "{}  {} of the points by the full model, where the reduced one estimates an error above {:g} %\n{}",
            reduced_words(*map.reduced), by_full_model(map), map.options.model.limit_percent,
            map.options.model.alone() ? "  misfits below are those of the reduced model\n"
                                      : "  the lowest below are computed again by the full model\n");
    }
    const Json statuses = status_counts(map.evaluations);
    for (const auto& [status, count] : statuses.items()) {
        text += fmt::format("    {:<19} {}\n", status, count.get<std::int64_t>());
    }
    if (map.explored) {
        text += fmt::format(
            "  explored: from the map the misfit of a point drawn at random is predicted within {:g} % in {} of {} "
            "draws,\n    so in {:.0f} to {:.0f} % of the box (95 %); median error {:.2g} %\n",
            100.0 * landscape::Explored::tolerance, map.explored->predicted, map.explored->checks,
            100.0 * map.explored->low, 100.0 * map.explored->high, 100.0 * map.explored->median_error);
    }
    if (map.failed()) {
        return text;
    }
    text += "\n" + sentences(findings(map));
    if (map.is_grid) {
        text += "\n" + axis_profiles(map);
    }
    std::vector<std::string> columns = with_axes({"lowest", "misfit"}, map.study.space);
    for (const std::size_t i : map.study.outputs()) {
        columns.push_back(fmt::format("{} ({})", map.study.readings[i].output, map.study.readings[i].unit.name));
    }
    Table table(columns);
    for (const auto& low : map.lowest) {
        std::vector<std::string> row{fmt::format("{}", low.number), figure(low.evaluation.misfit)};
        for (const double value : low.evaluation.parameters) {
            row.push_back(figure(value));
        }
        for (const std::size_t i : map.study.outputs()) {
            const data::Reading& output = map.study.readings[i];
            const double value =
                low.evaluation.converged() ? output.in_unit(low.evaluation.responses[i]) : std::nan("");
            row.push_back(std::isfinite(value) ? figure(value) : "-");
        }
        table.add(std::move(row));
    }
    return text + fmt::format("\n{}\n  all points: pavescape export {} --command map\n", table.text(),
                              run::shell_word(run.folder));
}

} // namespace explore::report
