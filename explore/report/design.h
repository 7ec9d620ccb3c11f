// Lives and overlay as JSON and as a page of the terminal.
#pragma once

#include "analysis/design/design.h"
#include "report/answer.h"

namespace explore::report {

// Of a result with an answer, or {"status", "reason"}. `low` and `high` of a criterion are of its remaining_years.
Json design_json(const analysis::DesignResult& result, const analysis::RunOptions& run);
Answer design_answer(const analysis::DesignResult& result, const analysis::RunOptions& run);
std::string design_text(const analysis::DesignResult& result, const analysis::RunOptions& run);

} // namespace explore::report
