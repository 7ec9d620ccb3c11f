// pavescape report: one HTML file from a run.
#include "analysis/build.h"
#include "cli/commands.h"
#include "report/page.h"
#include "report/run_folder.h"
#include "run/files.h"

#include <filesystem>
#include <fmt/format.h>

namespace explore::cli {
namespace {

using report::Json;

int make_report(const std::string& folder, const std::string& out) {
    report::RunFolder read = report::read_run_folder(folder, keepers_of_runs());
    std::optional<run::Store> store;
    if (std::filesystem::exists(std::filesystem::path(folder) / "run.sqlite")) {
        store.emplace(folder);
    }
    Json sessions = store ? report::sessions_json(*store) : Json::array();
    Json studies = report::studies_json(read.results, store ? &*store : nullptr);
    const std::string text = report::page({{"folder", std::filesystem::canonical(folder).filename().string()},
                                           {"version", analysis::version},
                                           {"results", std::move(read.results)},
                                           {"evaluations", std::move(read.evaluations)},
                                           {"sessions", std::move(sessions)},
                                           {"studies", std::move(studies)}});
    const std::filesystem::path path =
        out.empty() ? std::filesystem::path(folder) / "report.html" : std::filesystem::path(out);
    const std::string parent = path.parent_path().string();
    run::write_file(parent.empty() ? "." : parent, path.filename().string(), text);
    fmt::print("{} ({:.1f} MB): open it in a browser\n", path.string(), static_cast<double>(text.size()) / 1e6);
    return done;
}

} // namespace

void add_report(CLI::App& app, Action& action) {
    auto* command = app.add_subcommand("report", "one HTML file from a run, to read in a browser or on paper");
    auto folder = std::make_shared<std::string>();
    auto out = std::make_shared<std::string>();
    command->add_option("RUN", *folder, "folder of the run")->required();
    command->add_option("--out", *out, "the file (default: RUN/report.html)")->type_name("FILE");
    command->footer("Example: pavescape report output/captif-p1-fwd");
    command->callback([=, &action] { action = [=] { return make_report(*folder, *out); }; });
}

} // namespace explore::cli
