// pavescape fit: explore, then refine the best starts.
#include "report/fit.h"
#include "cli/commands.h"

namespace explore::cli {
namespace {

struct Options {
    CommonOptions common;
    analysis::FitOptions fit;
};

int fit(const Options& options) {
    const study::Study study = study::load_study(options.common.study);
    analysis::Session session(options.common.run(study));
    const auto result = analysis::fit(session, study, options.fit);
    if (!result) {
        return report_interrupt(session.folder());
    }
    const report::Json json = report::fit_json(*result, session.options());
    if (result->failed()) {
        return hand_over_failure(options.common, json, result->reason());
    }
    return hand_over(session, options.common, "fit", json,
                     [&] { return report::fit_text(*result, session.options()); });
}

} // namespace

void add_fit(CLI::App& app, Action& action) {
    auto* command = app.add_subcommand("fit", "explore, then refine the best starts: the main job");
    auto options = std::make_shared<Options>();
    add_common(*command, options->common);
    add_model(*command, options->fit.model);
    std::vector<std::string> names;
    for (const auto& method : optimise::methods()) {
        names.emplace_back(method.name);
    }
    add_choice(*command, "--scheme", options->fit.scheme, analysis::scheme_names,
               "multistart, or paper: a coarse full grid and one search from its smallest misfit");
    command->add_option("--explore", options->fit.explore, "points of the Sobol sample")
        ->check(CLI::Range(1, 1'000'000))
        ->capture_default_str();
    command->add_option("--starts", options->fit.multistart.starts, "local searches")
        ->check(CLI::Range(1, 10'000))
        ->capture_default_str();
    command
        ->add_option("--method", options->fit.multistart.method,
                     "local search: " + pave::join(names) + "; another method confirms its minima")
        ->check(CLI::IsMember(names))
        ->capture_default_str();
    command->add_flag("--joint-only", options->fit.joint_only,
                      "do not also fit each group of readings alone to see what it predicts for the others");
    command->footer("Example: pavescape fit grids/captif-p1-fwd.toml --starts 16");
    command->callback([=, &action] { action = [=] { return fit(*options); }; });
}

} // namespace explore::cli
