// The run of a survey in its JSON.
#pragma once

#include "analysis/common/session.h"
#include "analysis/road/road_files.h"
#include "report/json.h"

namespace explore::report {

// Adds "seed", "files" (names), "content" (a hash of what they hold), "version" and "run" (its folder).
void add_run(Json& json, const analysis::RoadFiles& road, const analysis::RunOptions& run);

} // namespace explore::report
