// Numbers of runs as JSON.
#pragma once

#include "landscape/minima.h"
#include "study/study.h"

#include <nlohmann/json.hpp>
#include <optional>

namespace explore::report {

using Json = nlohmann::ordered_json;

// As text, indented by so many blanks (-1: in one line). Bytes that are not UTF-8, as names of folders may hold, are
// replaced.
std::string json_text(const Json& json, int indent = 2);

// The number, or null.
Json optional_json(const std::optional<double>& value);

// {name: value}
Json parameters_json(const problem::ParameterSpace& space, const std::vector<double>& values);

// [{"name", "min", "max", "scale"}]
Json space_json(const problem::ParameterSpace& space);

// Where and what response number i is: {"load", "quantity", "x_mm", "y_mm", "depth_mm", "gauge_mm"}; of a reading as
// its file states them.
Json place_json(const study::Study& study, std::size_t i);

// [{"load", "quantity", "x_mm", "y_mm", "depth_mm", "gauge_mm", "value", "unit", ("measured"), ("name")}], value in
// unit.
Json responses_json(const study::Study& study, const std::vector<double>& responses);

// {"converged": 240, "invalid-parameters": 16, ...}, every status named.
Json status_counts(const std::vector<problem::Evaluation>& evaluations);

// One minimum with its starts, spread and local analysis.
Json minimum_json(const problem::Problem& problem, const landscape::Minimum& minimum);

} // namespace explore::report
