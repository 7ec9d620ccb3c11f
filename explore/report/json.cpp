#include "report/json.h"

#include "base/units.h"
#include "problem/censored.h"
#include "report/model_words.h"

#include <algorithm>
#include <cmath>

namespace explore::report {

std::string json_text(const Json& json, int indent) {
    return json.dump(indent, ' ', false, Json::error_handler_t::replace);
}

Json finite_json(double value) {
    return std::isfinite(value) ? Json(value) : Json(nullptr);
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

Json place_json(const data::Reading& r) {
    Json json = {{"load", r.load}, {"quantity", r.quantity}, {"x_mm", r.x_mm},
                 {"y_mm", r.y_mm}, {"depth_mm", r.depth_mm}, {"gauge_mm", r.gauge_mm}};
    if (r.time_ms) {
        json["time_ms"] = *r.time_ms;
    }
    if (!r.name.empty()) {
        json["name"] = r.name;
    }
    return json;
}

Json responses_json(const study::Study& study, const std::vector<double>& responses) {
    Json json = Json::array();
    for (std::size_t i = 0; i < responses.size(); ++i) {
        const data::Reading& reading = study.readings[i];
        Json row = place_json(reading);
        row["value"] = reading.in_unit(responses[i]);
        row["unit"] = std::string(reading.unit.name);
        if (reading.is_measured()) {
            row["measured"] = reading.value;
            if (reading.censored != data::Censored::no) {
                row["limit"] = data::sign_of(reading.censored);
            }
        } else {
            row["name"] = reading.output;
        }
        json.push_back(std::move(row));
    }
    return json;
}

void add_residuals(Json& responses, const study::Study& study, const problem::Problem& problem,
                   const problem::Evaluation& evaluation, double noise) {
    for (const auto& group : study.groups) {
        for (const std::size_t i : group.rows) {
            if (group.held_out) {
                responses[i]["held_out"] = true;
            }
            const data::Reading& reading = study.readings[i];
            if (study.noise == study::NoiseSource::stated && std::isfinite(evaluation.responses[i])) {
                const double z = reading.noise.residual(evaluation.responses[i], reading.measured());
                const bool is_limit = reading.censored != data::Censored::no;
                responses[i]["residual"] = is_limit ? problem::censored_row(z, reading.censored) : z;
                responses[i]["sigma"] = reading.in_unit(reading.noise.deviation(reading.measured()));
            }
        }
    }
    if (study.noise != study::NoiseSource::stated && noise > 0.0) {
        const Eigen::VectorXd residuals = problem.single_residuals(evaluation);
        for (std::size_t i = 0; i < problem.readings(); ++i) {
            responses[problem.response_of(i)]["residual"] = residuals[static_cast<Eigen::Index>(i)] / noise;
        }
    }
}

Json noise_scale_json(const problem::NoiseScale& scale) {
    return {{"estimate", scale.estimate}, {"low", scale.low}, {"high", scale.high}};
}

Json study_json(const study::Study& study) {
    Json layers = Json::array(); // top down; the last without a thickness where it goes on for ever
    for (std::size_t i = 0; i < study.model.layers.size() && !study.has_own_model; ++i) {
        const bool is_endless = study.model.half_space && i + 1 == study.model.layers.size();
        const auto& layer = study.model.layers[i];
        layers.push_back({{"name", layer.name},
                          {"thickness_mm", is_endless ? Json(nullptr) : Json(layer.thickness / pave::unit::mm)}});
    }
    return {{"file", study.file},
            {"title", study.title},
            {"hash", study.hash},
            {"model_words", model_words(study)},
            {"layers", std::move(layers)}};
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
    return minimum_json(problem.space, minimum, landscape::analyse(minimum, problem));
}

Json minimum_json(const problem::ParameterSpace& space, const landscape::Minimum& minimum,
                  const landscape::LocalAnalysis& analysis) {
    Json errors = Json::object();
    for (std::size_t k = 0; k < minimum.unit.size(); ++k) {
        const problem::Axis& axis = space.axes[k];
        const double error = analysis.standard_error[k] * axis.d_physical(minimum.unit[k]);
        errors[axis.name] = finite_json(error);
    }
    Json at_bounds = Json::array();
    for (const auto& bound : minimum.on_bound) {
        at_bounds.push_back(space.axes[bound.axis].name);
    }
    Json not_determined = Json::array();
    for (std::size_t k = 0; k < minimum.unit.size(); ++k) {
        if (!landscape::is_at_bound(minimum.unit[k]) && !analysis.determines(k)) {
            not_determined.push_back(space.axes[k].name);
        }
    }
    Json json = {{"misfit", minimum.evaluation.misfit},
                 {"parameters", parameters_json(space, minimum.evaluation.parameters)},
                 {"standard_errors", std::move(errors)},
                 {"starts", minimum.members},
                 {"converged", minimum.converged},
                 {"on_bound", bound_words(space, minimum.on_bound)},
                 {"at_bounds", std::move(at_bounds)},
                 {"not_determined", std::move(not_determined)},
                 {"lowest", parameters_json(space, minimum.lowest)},
                 {"highest", parameters_json(space, minimum.highest)}};
    if (minimum.second) {
        json["confirmed"] = {
            {"method", minimum.second->method},           {"agrees", minimum.second->agrees},
            {"has_ended", minimum.second->has_ended},     {"misfit_before", minimum.second->misfit_before},
            {"evaluations", minimum.second->evaluations}, {"ended", minimum.second->ended}};
    }
    return json;
}

Json warnings_json(const problem::Evaluation& evaluation) {
    Json json = evaluation.warnings;
    if (evaluation.in_place_of_reduced) {
        json.push_back("computed by the full model: the reduced one is not sure enough here");
    }
    return json;
}

Json contrast_json(const analysis::LocatedCorrection& found) {
    if (!found.contrast) {
        return nullptr;
    }
    return {{"at", found.places[found.contrast->place].at},
            {"beside", found.places[found.contrast->beside].at},
            {"value", found.contrast->value},
            {"low", found.contrast->low},
            {"high", found.contrast->high}};
}

Json output_range_json(const data::Reading& output, const analysis::OutputUncertainty& range) {
    return {{"low", output.in_unit(range.low)},
            {"high", output.in_unit(range.high)},
            {"if_wrong",
             {{"low", output.in_unit(range.wide_low)},
              {"high", output.in_unit(range.wide_high)},
              {"channel", range.channel},
              {"share", range.share}}}};
}

void add_model_errors(Json& json, const study::Study& study, const std::optional<analysis::MeshError>& mesh,
                      const std::optional<analysis::PathError>& path) {
    if (mesh) {
        Json moved = Json::array();
        for (const auto& [parameter, standard_errors] : mesh->moved) {
            moved.push_back({{"parameter", parameter}, {"standard_errors", standard_errors}});
        }
        Json outputs = Json::array();
        for (const auto& output : mesh->outputs) {
            outputs.push_back({{"output", study.readings[output.reading].output},
                               {"change", output.change},
                               {"standard_deviations", output.deviations}});
        }
        json["mesh"] = {{"finer_refine", mesh->refine},
                        {"beyond_parameters", mesh->beyond},
                        {"chi2", mesh->chi2},
                        {"chi2_finer", mesh->chi2_finer},
                        {"moved", moved},
                        {"reading", study.readings[mesh->reading].label()},
                        {"change", mesh->change},
                        {"outputs", outputs},
                        {"shows", mesh->shows()}};
    }
    if (path) {
        json["path"] = {{"load_steps", path->steps},
                        {"reading", study.readings[path->reading].label()},
                        {"change", path->change},
                        {"share_of_noise", path->share},
                        {"shows", path->shows()}};
    }
}

Json reduced_json(const analysis::ReducedProblem& reduced) {
    Json json = {{"loads", Json::array()}};
    for (const auto& load : reduced.loads) {
        json["loads"].push_back({{"load", load.name},
                                 {"modes", load.report.modes},
                                 {"points", load.report.points},
                                 {"full_runs", load.report.full_runs},
                                 {"error_95", load.report.error_95}});
    }
    return json;
}

Json constraints_json(const problem::Problem& problem, const problem::Evaluation& answer) {
    const auto active = problem.active_limits(answer);
    Json list = Json::array();
    for (std::size_t i = 0; i < problem.limits.size(); ++i) {
        list.push_back({{"that", problem.limits[i]->text()},
                        {"active", std::find(active.begin(), active.end(), i) != active.end()}});
    }
    return list;
}

Json priors_json(const problem::Problem& problem, const std::vector<double>& values,
                 const landscape::PriorInfluence& influence) {
    Json parameters = Json::array();
    for (std::size_t k = 0; k < problem.space.axes.size(); ++k) {
        const problem::Axis& axis = problem.space.axes[k];
        Json parameter = {
            {"name", axis.name}, {"share", influence.share[k]}, {"readings_want", influence.readings_want[k]}};
        if (axis.prior) {
            parameter["mean"] = axis.prior->mean;
            parameter["sd"] = axis.prior->sd;
            parameter["pull"] = axis.pull(values[k]);
        }
        parameters.push_back(std::move(parameter));
    }
    return {{"parameters", parameters},
            {"statistic", influence.statistic},
            {"degrees_of_freedom", influence.degrees_of_freedom},
            {"p_value", influence.p_value}};
}

} // namespace explore::report
