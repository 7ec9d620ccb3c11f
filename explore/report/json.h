// Numbers of runs as JSON.
#pragma once

#include "analysis/common/load_steps.h"
#include "analysis/common/mesh_error.h"
#include "analysis/common/output_ranges.h"
#include "analysis/common/session.h"
#include "analysis/diagnose/located.h"
#include "landscape/minima.h"
#include "landscape/prior_influence.h"
#include "problem/noise_scale.h"

#include <nlohmann/json.hpp>
#include <optional>

namespace explore::report {

using Json = nlohmann::ordered_json;

// As text, indented by so many blanks (-1: in one line). Bytes that are not UTF-8, as names of folders may hold, are
// replaced.
std::string json_text(const Json& json, int indent = 2);

// The number, or null where it is none.
Json finite_json(double value);
// The number, or null.
Json optional_json(const std::optional<double>& value);

// {name: value}
Json parameters_json(const problem::ParameterSpace& space, const std::vector<double>& values);

// [{"name", "min", "max", "scale"}]
Json space_json(const problem::ParameterSpace& space);

// Where and what it reads: {"load", "quantity", "x_mm", "y_mm", "depth_mm", "gauge_mm", ("time_ms")}, as its file
// states them.
Json place_json(const data::Reading& reading);

// [{"load", "quantity", "x_mm", "y_mm", "depth_mm", "gauge_mm", "value", "unit", ("measured"), ("limit"), ("name")}],
// value in unit; limit: "<" or ">", where what was measured is one.
Json responses_json(const study::Study& study, const std::vector<double>& responses);

// Adds to rows of responses_json what is known of each reading's error: "residual", of the evaluation in standard
// deviations, by the stated noise or, where none is stated, `noise` (of a residual of the problem; 0: not known); where
// it is stated "sigma", one standard deviation in unit; and "held_out" where the study holds it out.
void add_residuals(Json& responses, const study::Study& study, const problem::Problem& problem,
                   const problem::Evaluation& evaluation, double noise);

// {"estimate", "low", "high"}: factor of the noise that is stated, with its 95 % range.
Json noise_scale_json(const problem::NoiseScale& scale);

// {"file", "title", "hash", "model_words"}
Json study_json(const study::Study& study);

// The warnings of a run, in sentences.
Json warnings_json(const problem::Evaluation& evaluation);

// Of an output, in its unit: `low`, `high` if the model is right, `if_wrong` if it may lack something.
Json output_range_json(const data::Reading& output, const analysis::OutputUncertainty& range);

// {"at", "beside", "value", "low", "high"}: the factor at one place over that at the other; null: no two are told
// apart.
Json contrast_json(const analysis::LocatedCorrection& found);

// Adds "mesh", what a finer one would do to an answer of the study, and "path", what the steps of the load path leave
// of error there.
void add_model_errors(Json& json, const study::Study& study, const std::optional<analysis::MeshError>& mesh,
                      const std::optional<analysis::PathError>& path);

// The inputs of a reduced model, the same whether now or before.
Json reduced_json(const analysis::ReducedProblem& reduced);

// {"converged": 240, "invalid-parameters": 16, ...}, every status named.
Json status_counts(const std::vector<problem::Evaluation>& evaluations);

// One minimum with its starts, spread and local analysis.
Json minimum_json(const problem::Problem& problem, const landscape::Minimum& minimum);
Json minimum_json(const problem::ParameterSpace& space, const landscape::Minimum& minimum,
                  const landscape::LocalAnalysis& analysis);

// [{"that", "active"}]: the study's constraints, and whether each holds the answer back.
Json constraints_json(const problem::Problem& problem, const problem::Evaluation& answer);

// {"parameters": [{"name", "share", "readings_want", ("mean", "sd", "pull")}], "statistic", "degrees_of_freedom",
// "p_value"}: share of the information on each that comes from priors, what the readings alone call for, and the test
// of the priors against the readings. values: the answer's.
Json priors_json(const problem::Problem& problem, const std::vector<double>& values,
                 const landscape::PriorInfluence& influence);

} // namespace explore::report
