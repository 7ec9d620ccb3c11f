#include "report/run_page.h"

#include "analysis/explore/build.h"
#include "report/page.h"
#include "report/run_folder.h"
#include "run/files.h"

#include <filesystem>

namespace explore::report {

WrittenPage write_page_of(const std::string& folder, const std::vector<std::string>& commands, const std::string& out) {
    RunFolder read = read_run_folder(folder, commands);
    std::optional<run::Store> store;
    if (std::filesystem::exists(std::filesystem::path(folder) / "run.sqlite")) {
        store.emplace(folder);
    }
    Json sessions = store ? sessions_json(*store) : Json::array();
    Json studies = studies_json(read.results, store ? &*store : nullptr);
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
