// pavescape report: one HTML file from a run.
#include "cli/commands.h"
#include "report/run_page.h"

#include <fmt/format.h>

namespace explore::cli {
namespace {

int make_report(const std::string& folder, const std::string& out) {
    const report::WrittenPage page = report::write_page_of(folder, keepers_of_runs(), out);
    fmt::print("{} ({:.1f} MB): open it in a browser\n", page.file, static_cast<double>(page.bytes) / 1e6);
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
