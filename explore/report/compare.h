// A comparison of laws as JSON and as a page of the terminal.
#pragma once

#include "analysis/compare/compare.h"
#include "report/answer.h"

namespace explore::report {

// "status" and "reason" where no law has an answer.
Json compare_json(const analysis::CompareResult& result, const analysis::RunOptions& run);
Answer compare_answer(const analysis::CompareResult& result, const analysis::RunOptions& run);
std::string compare_text(const analysis::CompareResult& result, const analysis::RunOptions& run);

} // namespace explore::report
