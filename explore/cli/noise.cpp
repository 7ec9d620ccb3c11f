// pavescape noise: what repeated drops of an FWD tell of the noise of its readings.
#include "report/noise.h"
#include "cli/commands.h"

#include <fmt/format.h>

namespace explore::cli {
namespace {

struct NoiseArguments {
    std::vector<std::string> files;
    std::string columns;
    CommonOptions common; // how much is shown
};

int noise(const NoiseArguments& options) {
    const auto result = analysis::noise_of_drops(data::read_fwd_files(options.files, options.columns));
    fmt::print("{}", options.common.json
                         ? report::json_text(report::noise_json(result)) + "\n"
                         : shown_answer(options.common, report::noise_answer(result), report::noise_text(result)));
    return done;
}

} // namespace

void add_noise(CLI::App& app, Action& action) {
    auto* command = app.add_subcommand("noise", "the noise of FWD readings, from repeated drops");
    auto options = std::make_shared<NoiseArguments>();
    command->add_option("FILE", options->files, "measured FWD files")->required();
    add_columns(*command, options->columns);
    command->add_flag("--json", options->common.json, "print one JSON object and nothing else");
    add_depth(*command, options->common);
    command->footer("Example: pavescape noise grids/road-north.f25");
    command->callback([=, &action] { action = [=] { return noise(*options); }; });
}

} // namespace explore::cli
