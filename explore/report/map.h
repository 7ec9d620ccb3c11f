// A map of the landscape as JSON and as a page of the terminal.
#pragma once

#include "analysis/unique/map.h"
#include "report/answer.h"

namespace explore::report {

// "status" and "reason" where not one point has an answer.
Json map_json(const analysis::MapResult& map, const analysis::RunOptions& run);
Answer map_answer(const analysis::MapResult& map, const analysis::RunOptions& run);
std::string map_text(const analysis::MapResult& map, const analysis::RunOptions& run);

} // namespace explore::report
