#include "report/explore.h"

#include "analysis/explore/build.h"
#include "report/curves.h"
#include "report/figure.h"
#include "report/json.h"

#include <cmath>
#include <fmt/format.h>

namespace explore::report {
namespace {

using analysis::Explorer;

Json numbers(const std::vector<double>& values) {
    Json list = Json::array();
    for (const double value : values) {
        list.push_back(finite_json(value));
    }
    return list;
}

std::string model_words(const Explorer& explorer) {
    if (!explorer.reduced()) {
        return fmt::format("The full model answers ({}).", explorer.why_full());
    }
    std::string words = "A reduced model answers;";
    for (const auto& load : explorer.reduced()->loads) {
        words += fmt::format(" under {} 95 % of its readings lie within {:.2g} % of the full model's;", load.name,
                             100.0 * load.report.error_95);
    }
    return words + " where it is not sure, the full model runs.";
}

Json minimum_of(const Explorer& explorer, const analysis::FoundMinimum& found) {
    Json json = minimum_json(explorer.space(), found.minimum, found.local);
    json["at"] = found.minimum.evaluation.parameters;
    json["chi2"] = explorer.chi2(found.minimum.evaluation);
    json["p_value"] =
        found.acceptance && found.acceptance->noise_is_stated ? Json(found.acceptance->p_value) : Json(nullptr);
    return json;
}

} // namespace

Json explore_state_json(const Explorer& explorer) {
    const study::Study& study = explorer.study();
    const analysis::FoundMinimum& best = explorer.minima().front();
    Json parameters = space_json(explorer.space());
    for (std::size_t k = 0; k < parameters.size(); ++k) {
        parameters[k]["words"] = parameter_words(study.space.axes[k].name);
        parameters[k]["start"] = study.space.axes[k].start;
    }
    Json readings = Json::array();
    for (const data::Reading& r : study.measured()) {
        Json row = place_json(r);
        row["measured"] = r.value;
        row["unit"] = std::string(r.unit.name);
        row["to_si"] = r.unit.to_si;
        row["unit_words"] = unit_words(std::string(r.unit.name));
        row["quantity_words"] = quantity_words(r.quantity);
        row["words"] = r.place_words();
        row["sigma"] = r.noise.is_stated() ? Json(r.in_unit(r.noise.deviation(r.measured()))) : Json(nullptr);
        row["fitted"] = true;
        readings.push_back(std::move(row));
    }
    for (const study::Group& group : study.groups) {
        for (const std::size_t i : group.rows) {
            readings[i]["fitted"] = !group.held_out;
        }
    }
    Json outputs = Json::array();
    for (const std::size_t i : study.outputs()) {
        const data::Reading& r = study.readings[i];
        outputs.push_back({{"name", r.output}, {"unit", unit_words(std::string(r.unit.name))}});
    }
    Json minima = Json::array();
    for (const auto& found : explorer.minima()) {
        minima.push_back(minimum_of(explorer, found));
    }
    const auto& acceptance = best.acceptance;
    return {{"study", study_json(study)},
            {"version", analysis::version},
            {"model", explorer.reduced() ? "reduced" : "full"},
            {"model_words", model_words(explorer)},
            {"seconds_a_point", explorer.seconds_a_point()},
            {"parameters", std::move(parameters)},
            {"readings", std::move(readings)},
            {"outputs", std::move(outputs)},
            {"noise",
             {{"source", study.noise_name()},
              {"widened", acceptance && acceptance->widened},
              {"stated", acceptance && acceptance->noise_is_stated}}},
            {"degrees_of_freedom", best.local.degrees_of_freedom},
            {"limit", explorer.limit() ? Json(*explorer.limit()) : Json(nullptr)},
            {"minima", std::move(minima)},
            {"curves", curves_json(explorer.curves_of_minimum())}};
}

Json explore_point_json(Explorer& explorer, const problem::Evaluation& evaluation,
                        const analysis::ChangedReadings& changes) {
    const study::Study& study = explorer.study();
    Json json = {{"status", std::string(to_string(evaluation.status))}, {"at", evaluation.parameters}};
    if (!evaluation.converged()) {
        json["reason"] = evaluation.reason;
        return json;
    }
    json["chi2"] = finite_json(explorer.chi2(evaluation));
    const std::size_t measured = study.measured().size();
    Json values = Json::array();
    for (std::size_t i = 0; i < measured; ++i) {
        values.push_back(finite_json(study.readings[i].in_unit(evaluation.responses[i])));
    }
    json["values"] = std::move(values);
    json["residuals"] = numbers(explorer.residuals(evaluation, changes));
    json["outputs"] = Json::array();
    for (const std::size_t i : study.outputs()) {
        json["outputs"].push_back(finite_json(study.readings[i].in_unit(evaluation.responses[i])));
    }
    json["full"] = !explorer.reduced() || evaluation.in_place_of_reduced;
    json["warnings"] = evaluation.warnings;
    return json;
}

Json explore_fit_json(Explorer& explorer, const std::optional<analysis::FoundMinimum>& found,
                      const analysis::ChangedReadings& changes) {
    if (!found) {
        return {{"status", "no answer"}};
    }
    return {{"status", "converged"},
            {"minimum", minimum_of(explorer, *found)},
            {"point", explore_point_json(explorer, found->minimum.evaluation, changes)}};
}

Json explore_landscape_json(const Explorer& explorer, const std::optional<analysis::PairGrid>& grid) {
    if (!grid) {
        return {{"status", "given up"}};
    }
    Json rows = Json::array();
    const std::size_t width = grid->x_values.size();
    for (std::size_t j = 0; j < grid->y_values.size(); ++j) {
        Json row = Json::array();
        for (std::size_t i = 0; i < width; ++i) {
            row.push_back(finite_json(grid->chi2[j * width + i]));
        }
        rows.push_back(std::move(row));
    }
    return {{"status", "computed"},
            {"x", explorer.space().axes[grid->x].name},
            {"y", explorer.space().axes[grid->y].name},
            {"x_values", grid->x_values},
            {"y_values", grid->y_values},
            {"chi2", std::move(rows)},
            {"lowest", finite_json(grid->lowest)},
            {"fitted", grid->fitted}};
}

Json explore_confirm_json(Explorer& explorer, const analysis::ConfirmedPoint& point,
                          const analysis::ChangedReadings& changes) {
    Json json = explore_point_json(explorer, point.evaluation, changes);
    json["full"] = true;
    json["curves"] = curves_json(point.curves);
    json["seconds"] = point.seconds;
    return json;
}

} // namespace explore::report
