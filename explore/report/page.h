// The report of a run as one HTML page that needs nothing else: no network, no other file.
#pragma once

#include "report/json.h"

namespace explore::report {

// data: {"folder", "version", "results": {command: the JSON of the command}, "evaluations": {"command", "parameters",
// "statuses", "rows": [[status, misfit, parameter values...]], "left_out"} or null, "sessions": [what one
// process computed: {"began", "arguments", "version", "libraries", "threads", "evaluations", "seconds"}], "studies":
// [{"file", "text" or "note"}]}. What is in it is shown as text, whatever it holds.
std::string page(const Json& data);

// The page of `explore`, which asks the server that it came from (report/explore_server.h) for everything that it
// shows.
std::string explore_page();

} // namespace explore::report
