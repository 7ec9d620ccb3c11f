#include "report/json.h"

#include "base/units.h"

#include <cmath>

namespace explore::report {

std::string json_text(const Json& json, int indent) {
    return json.dump(indent, ' ', false, Json::error_handler_t::replace);
}

Json optional_json(const std::optional<double>& value) {
    return value ? Json(*value) : Json(nullptr);
}

Json parameters_json(const problem::ParameterSpace& space, const std::vector<double>& values) {
    Json json = Json::object();
    for (std::size_t k = 0; k < values.size(); ++k) {
        json[space.axes[k].name] = values[k];
    }
    return json;
}

Json space_json(const problem::ParameterSpace& space) {
    Json json = Json::array();
    for (const problem::Axis& axis : space.axes) {
        json.push_back({{"name", axis.name},
                        {"min", axis.low},
                        {"max", axis.high},
                        {"scale", axis.scale == problem::Scale::log ? "log" : "linear"}});
    }
    return json;
}

Json place_json(const study::Study& study, std::size_t i) {
    const auto& s = study.model.sensors[i];
    const std::string& load = study.model.loads[static_cast<std::size_t>(s.load)].name;
    if (i < study.measurements.size()) { // not metres turned back
        const auto& m = study.measurements[i];
        return {{"load", load},   {"quantity", m.quantity}, {"x_mm", m.x_mm},
                {"y_mm", m.y_mm}, {"depth_mm", m.depth_mm}, {"gauge_mm", m.gauge_mm}};
    }
    // To the picometre: what the study states, without the rounding of metres.
    const auto mm = [](double metres) { return std::round(metres / pave::unit::mm * 1e9) / 1e9; };
    return {{"load", load},
            {"quantity", std::string(info(s.quantity).name)},
            {"x_mm", mm(s.x)},
            {"y_mm", mm(s.y)},
            {"depth_mm", mm(s.depth)},
            {"gauge_mm", mm(s.gauge)}};
}

Json responses_json(const study::Study& study, const std::vector<double>& responses) {
    Json json = Json::array();
    for (std::size_t i = 0; i < responses.size(); ++i) {
        Json row = place_json(study, i);
        row["value"] = responses[i] / study.response_to_si(i);
        row["unit"] = std::string(study.response_unit(i));
        if (i < study.measurements.size()) {
            row["measured"] = study.measurements[i].value;
        } else {
            row["name"] = study.outputs[i - study.measurements.size()].name;
        }
        json.push_back(std::move(row));
    }
    return json;
}

Json status_counts(const std::vector<problem::Evaluation>& evaluations) {
    Json json = Json::object();
    for (const pave::Status status : pave::all_statuses) {
        json[std::string(to_string(status))] = std::count_if(
            evaluations.begin(), evaluations.end(), [&](const problem::Evaluation& e) { return e.status == status; });
    }
    return json;
}

Json minimum_json(const problem::Problem& problem, const landscape::Minimum& minimum) {
    const landscape::LocalAnalysis analysis = landscape::analyse(minimum, problem);
    Json errors = Json::object();
    for (std::size_t k = 0; k < minimum.unit.size(); ++k) {
        const problem::Axis& axis = problem.space.axes[k];
        const double error = analysis.standard_error[k] * axis.d_physical(minimum.unit[k]);
        errors[axis.name] = std::isfinite(error) ? Json(error) : Json(nullptr);
    }
    return {{"misfit", minimum.evaluation.misfit},
            {"parameters", parameters_json(problem.space, minimum.evaluation.parameters)},
            {"standard_errors", std::move(errors)},
            {"starts", minimum.members},
            {"converged", minimum.converged},
            {"on_bound", minimum.on_bound},
            {"lowest", parameters_json(problem.space, minimum.lowest)},
            {"highest", parameters_json(problem.space, minimum.highest)}};
}

} // namespace explore::report
