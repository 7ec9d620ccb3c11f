// pavescape fit: explore, then refine the best starts.
#include "report/fit.h"
#include "analysis/common/starts.h"
#include "cli/commands.h"

namespace explore::cli {
namespace {

struct FitArguments {
    CommonOptions common;
    analysis::FitOptions fit;
    std::vector<std::string> starts, from;
};

int fit(const FitArguments& options) {
    const study::Study study = study::load_study(options.common.study);
    analysis::FitOptions asked = options.fit;
    for (const std::string& values : options.starts) {
        asked.starts.push_back(analysis::start_of(study, values));
    }
    for (const std::string& place : options.from) {
        auto starts = analysis::starts_from(study, place, static_cast<std::size_t>(asked.multistart.starts));
        std::move(starts.begin(), starts.end(), std::back_inserter(asked.starts));
    }
    const run::Budget budget(options.common.time_s);
    analysis::Session session(options.common.run(study));
    const auto result = analysis::fit(session, study, asked);
    if (!result) {
        return end_early(session, options.common, study, "fit", budget);
    }
    const report::Json json = report::fit_json(*result, session.options());
    if (result->failed()) {
        return hand_over_failure(options.common, json, result->reason());
    }
    return hand_over_answer(session, options.common, "fit", json, report::fit_text(*result, session.options()));
}

} // namespace

void add_fit(CLI::App& app, Action& action) {
    auto* command = app.add_subcommand("fit", "explore, then refine the best starts: the main job");
    auto options = std::make_shared<FitArguments>();
    add_common(*command, options->common);
    add_time(*command, options->common);
    add_depth(*command, options->common);
    add_model(*command, options->fit.model);
    std::vector<std::string> names;
    for (const auto& method : optimise::methods()) {
        names.emplace_back(method.name);
    }
    add_choice(*command, "--scheme", options->fit.scheme, analysis::scheme_names,
               "multistart, or paper: a coarse full grid and one search from its smallest misfit");
    command->add_option("--explore", options->fit.explore, "points of the Sobol sample")
        ->check(within(analysis::allowed::fit_explore))
        ->capture_default_str();
    command->add_option("--starts", options->fit.multistart.starts, "local searches")
        ->check(within(analysis::allowed::fit_starts))
        ->capture_default_str();
    command
        ->add_option("--evaluations", options->fit.multistart.search.max_evaluations,
                     "evaluations of each local search, at most; with more, those that this limit ended go on")
        ->check(within(analysis::allowed::fit_evaluations))
        ->capture_default_str();
    command
        ->add_option("--method", options->fit.multistart.method,
                     "local search; another method confirms the minima that it ends in")
        ->check(CLI::IsMember(names))
        ->capture_default_str();
    command
        ->add_option(
            "--start", options->starts,
            "NAME=VALUE,...: a search from these values too, others than these at the study's own (repeatable)")
        ->type_name("NAME=VALUE,...")
        ->expected(1)
        ->take_all();
    command
        ->add_option("--from", options->from,
                     "searches from the lowest points of an earlier run too, at most as many as --starts; or from "
                     "those of a file with a header of names (repeatable)")
        ->type_name("RUN|FILE.csv")
        ->expected(1)
        ->take_all();
    command->add_flag("--joint-only", options->fit.joint_only,
                      "do not also fit each group of readings alone to see what it predicts for the others");
    command->footer("Example: pavescape fit grids/captif-p1-fwd.toml --starts 16");
    command->callback([=, &action] { action = [=] { return fit(*options); }; });
}

} // namespace explore::cli
