// pavescape map: the misfit landscape over a grid or a space-filling design.
#include "report/map.h"
#include "cli/commands.h"

#include <fmt/format.h>

namespace explore::cli {
namespace {

struct MapArguments {
    CommonOptions common;
    analysis::MapOptions map;
};

int map(const MapArguments& options) {
    if (const int points = options.map.points;
        options.map.design == analysis::MapDesign::adaptive && points > 0 && points < landscape::least_adaptive) {
        throw pave::Error({.key = "--points"}, "too few points for an adaptive map", fmt::format("{}", points),
                          fmt::format("at least {}", landscape::least_adaptive));
    }
    const study::Study study = study::load_study(options.common.study);
    const run::Budget budget(options.common.time_s);
    analysis::Session session(options.common.run(study));
    const auto result = analysis::map(session, study, options.map);
    if (!result) {
        return end_early(session, options.common, study, "map", budget);
    }
    const int status =
        hand_over_answer(session, options.common, "map", report::map_json(*result, session.options()),
                         report::map_answer(*result, session.options()), report::map_text(*result, session.options()));
    if (result->failed()) {
        complain(result->reason());
    }
    return result->failed() ? computation_failed : status;
}

} // namespace

void add_map(CLI::App& app, Action& action) {
    auto* command = app.add_subcommand("map", "the misfit landscape over a grid or a space-filling design");
    auto options = std::make_shared<MapArguments>();
    add_common(*command, options->common);
    add_time(*command, options->common);
    add_depth(*command, options->common);
    add_model(*command, options->map.model);
    command
        ->add_option_function<std::string>(
            "--design",
            [options](const std::string& word) {
                options->map.design = word == "grid"    ? analysis::MapDesign::grid
                                      : word == "sobol" ? analysis::MapDesign::sobol
                                                        : analysis::MapDesign::adaptive;
            },
            "grid, sobol, or adaptive: more points where the landscape bends and is low, and an estimate of how much "
            "of the box is explored (default: grid when the study states the points, else sobol)")
        ->check(CLI::IsMember({"grid", "sobol", "adaptive"}));
    command
        ->add_option("--points", options->map.points, "sobol, adaptive: points in all; grid: points of each parameter")
        ->check(within(analysis::allowed::map_points));
    command->footer("Example: pavescape map grids/captif-p1-fwd.toml");
    command->callback([=, &action] { action = [=] { return map(*options); }; });
}

} // namespace explore::cli
