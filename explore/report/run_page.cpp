#include "report/run_page.h"

#include "analysis/explore/build.h"
#include "report/page.h"
#include "report/run_folder.h"
#include "run/files.h"

#include <cstdlib>
#include <filesystem>
#include <fmt/format.h>

namespace explore::report {
namespace {

// Eight digits: a page shows four, and what is rounded twice may end elsewhere. Places keep theirs.
void shorten(Json& json) {
    for (auto& [key, value] : json.items()) {
        if (value.is_structured()) {
            shorten(value);
        } else if (value.is_number_float() && key != "chainage_m" && key != "latitude" && key != "longitude") {
            value = std::strtod(fmt::format("{:.8g}", value.get<double>()).c_str(), nullptr);
        }
    }
}

// A page of hundreds of stations holds what it draws of them, not all that the result says.
void lighten(Json& results) {
    for (const char* command : {"survey", "road"}) {
        if (!results.contains(command) || !results[command].contains("stations")) {
            continue;
        }
        for (Json& station : results[command]["stations"]) {
            for (const char* key :
                 {"levels", "condition", "structural_number", "drops_disagree", "readings_left_out"}) {
                station.erase(key);
            }
            shorten(station);
        }
    }
}

} // namespace

WrittenPage write_page_of(const std::string& folder, const std::vector<std::string>& commands, const std::string& out) {
    RunFolder read = read_run_folder(folder, commands);
    std::optional<run::Store> store;
    if (std::filesystem::exists(std::filesystem::path(folder) / "run.sqlite")) {
        store.emplace(folder);
    }
    Json sessions = store ? sessions_json(*store) : Json::array();
    Json studies = studies_json(read.results, store ? &*store : nullptr);
    lighten(read.results);
    const std::string text = page({{"folder", std::filesystem::canonical(folder).filename().string()},
                                   {"version", analysis::version},
                                   {"results", std::move(read.results)},
                                   {"evaluations", std::move(read.evaluations)},
                                   {"sessions", std::move(sessions)},
                                   {"studies", std::move(studies)}});
    const std::filesystem::path path =
        out.empty() ? std::filesystem::path(folder) / "report.html" : std::filesystem::path(out);
    const std::string parent = path.parent_path().string();
    run::write_file(parent.empty() ? "." : parent, path.filename().string(), text);
    return {path.string(), text.size()};
}

} // namespace explore::report
