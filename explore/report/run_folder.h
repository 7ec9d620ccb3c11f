// The content of a run's folder, for the commands that show it.
#pragma once

#include "report/json.h"
#include "run/store.h"

#include <string>
#include <vector>

namespace explore::report {

struct RunFolder {
    Json results = Json::object(); // {command: what it left when it was done}
    Json evaluations; // the points that show the landscape best, lowest misfit first (report/page.h); or null
};
// commands: those that leave a result. Throws pave::Error for a folder that holds no run, or a file of it that is not
// the result of one.
RunFolder read_run_folder(const std::string& folder, const std::vector<std::string>& commands);

// The sessions: when each computed, and how fast.
Json sessions_json(const run::Store& store);

// The studies that the results came from, as they were run. store: may be nullptr.
Json studies_json(const Json& results, const run::Store* store);

} // namespace explore::report
