#include "report/road_run.h"

#include "analysis/explore/build.h"

namespace explore::report {

void add_run(Json& json, const analysis::RoadFiles& road, const analysis::RunOptions& run) {
    json["seed"] = run.seed;
    json["files"] = road.names;
    json["content"] = road.content;
    json["version"] = analysis::version;
    json["run"] = run.folder;
}

} // namespace explore::report
