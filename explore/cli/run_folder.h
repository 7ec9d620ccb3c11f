// What a run's folder holds, for the commands that show it.
#pragma once

#include "report/json.h"

#include <filesystem>

namespace explore::cli {

// The bytes of a file. Throws pave::Error.
std::string contents(const std::filesystem::path& path);

struct RunFolder {
    report::Json results = report::Json::object(); // {command: what it left when it was done}
    report::Json evaluations; // the points that show the landscape best, lowest misfit first (report/page.h); or null
};
// Throws pave::Error for a folder that holds no run, or a file of it that is not the result of one.
RunFolder read_run_folder(const std::string& folder);

} // namespace explore::cli
