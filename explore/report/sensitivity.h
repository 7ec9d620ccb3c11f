// Sensitivities as JSON and as a page of the terminal.
#pragma once

#include "analysis/sample/sensitivity.h"
#include "report/answer.h"

namespace explore::report {

// Of a result with an answer, or {"status", "reason"}.
Json sensitivity_json(const analysis::SensitivityResult& result, const analysis::RunOptions& run);
Answer sensitivity_answer(const analysis::SensitivityResult& result, const analysis::RunOptions& run);
std::string sensitivity_text(const analysis::SensitivityResult& result, const analysis::RunOptions& run);

} // namespace explore::report
