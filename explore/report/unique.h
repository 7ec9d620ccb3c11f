// The answer to the question of uniqueness as JSON and as a page of the terminal.
#pragma once

#include "analysis/unique/unique.h"
#include "report/json.h"

namespace explore::report {

// Of a result with an answer, or {"status", "reason", "statuses"}; without what depends on the machine.
Json unique_json(const analysis::UniqueResult& result, const analysis::RunOptions& run);
std::string unique_text(const analysis::UniqueResult& result, const analysis::RunOptions& run);

} // namespace explore::report
