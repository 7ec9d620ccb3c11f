// The posterior as JSON, as a page of the terminal and as a table of draws.
#pragma once

#include "analysis/sample/sample.h"
#include "report/json.h"

namespace explore::report {

// Of any result; quantities that are not converged have no mean, deviation and quantiles.
Json sample_json(const analysis::SampleResult& result, const analysis::RunOptions& run);
std::string sample_text(const analysis::SampleResult& result, const analysis::RunOptions& run);

// A line a draw: population, weight (1 on average), log_likelihood, parameters, outputs in their units (empty where
// they were not computed).
std::string samples_csv(const analysis::SampleResult& result);

} // namespace explore::report
