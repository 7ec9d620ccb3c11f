// A fit as JSON and as a page of the terminal.
#pragma once

#include "analysis/fit/fit.h"
#include "report/json.h"

namespace explore::report {

// Of a fit with an answer, or {"status", "reason", "statuses"}. folder: of the run.
Json fit_json(const analysis::FitResult& result, const analysis::RunOptions& run);
std::string fit_text(const analysis::FitResult& result, const analysis::RunOptions& run);

} // namespace explore::report
