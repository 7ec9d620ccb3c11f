// Shared by survey and road: the files of a road, which of their drops, and how a result is handed over.
#pragma once

#include "analysis/road/road_files.h"
#include "analysis/survey/survey.h"
#include "cli/commands.h"

namespace explore::cli {

struct RoadInput {
    CommonOptions common;
    std::vector<std::string> files;
    std::string columns;
    analysis::SurveyOptions options;
};

// Adds FILE..., --columns, --drops, --target-load and the options of a run.
void add_road_input(CLI::App& app, RoadInput& input);
// An option such as "40kN", "566 kPa".
void add_load(CLI::App& app, const std::string& name, const std::string& help,
              const std::function<void(const analysis::LoadLevel&)>& keep);

// The result of a command on a road.
struct RoadPages {
    report::Json json;
    std::string csv, text;
    std::optional<report::Json> map; // GeoJSON
    bool nothing = false;            // there is no result
};
// Reads the files, calls analyse (nothing: interrupted), keeps and prints what it makes: NAME.json, NAME.csv,
// NAME.geojson, NAME.kml; beside it what the files hold as NAME.ddx (NAME-1.ddx, ... where one cannot hold it). Returns
// the exit status. Throws pave::Error where the folder holds NAME.json of another road.
int run_road(const RoadInput& input, const std::string& name,
             const std::function<std::optional<RoadPages>(analysis::Session&, std::vector<data::FwdFile>)>& analyse);

} // namespace explore::cli
