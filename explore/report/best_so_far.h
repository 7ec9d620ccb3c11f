// The answer of a command whose time was over before it was finished.
#pragma once

#include "analysis/common/best_so_far.h"
#include "report/json.h"

namespace explore::report {

// {"study", "complete": false, "reason", "time_s", "evaluations", "answered", "explored", "best": {"misfit",
// "parameters", "status", ("chi2", "dof")} or null}. seconds: the time that it had.
Json best_so_far_json(const study::Study& study, const analysis::BestSoFar& found, double seconds);
// The same on the terminal; command, folder: what goes on with it.
std::string best_so_far_text(const study::Study& study, const analysis::BestSoFar& found, double seconds,
                             std::string_view command, const std::string& folder);

} // namespace explore::report
