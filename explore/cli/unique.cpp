// pavescape unique: is the answer unique, along what is it not, and what does that do to the outputs?
#include "report/unique.h"
#include "cli/commands.h"

namespace explore::cli {
namespace {

struct UniqueArguments {
    CommonOptions common;
    analysis::UniqueOptions unique;
};

int unique(const UniqueArguments& options) {
    const study::Study study = study::load_study(options.common.study);
    const run::Budget budget(options.common.time_s);
    analysis::Session session(options.common.run(study));
    const auto result = analysis::unique(session, study, options.unique);
    if (!result) {
        return end_early(session, options.common, study, "unique", budget);
    }
    const report::Json json = report::unique_json(*result, session.options());
    if (result->failed()) {
        return hand_over_failure(options.common, json, result->reason());
    }
    return hand_over_answer(session, options.common, "unique", json, report::unique_text(*result, session.options()));
}

} // namespace

void add_unique(CLI::App& app, Action& action) {
    auto* command =
        app.add_subcommand("unique", "is the answer unique? valleys, profiles, and what they do to the outputs");
    auto options = std::make_shared<UniqueArguments>();
    add_common(*command, options->common);
    add_time(*command, options->common);
    add_depth(*command, options->common);
    add_model(*command, options->unique.model);
    command->add_option("--explore", options->unique.settings.explore, "points of the Sobol sample, with derivatives")
        ->check(within(analysis::allowed::unique_explore))
        ->capture_default_str();
    command
        ->add_option(
            "--verify", options->unique.settings.verify,
            "independent random starts in a row that must find no new minimum (bound on what was missed: 3 / this)")
        ->check(within(analysis::allowed::unique_verify))
        ->capture_default_str();
    command->add_option("--searches", options->unique.settings.max_searches, "local searches at most")
        ->check(within(analysis::allowed::unique_searches))
        ->capture_default_str();
    command->add_flag("--landscape", options->unique.landscape,
                      "the misfit over every pair of parameters with the others fitted, by the full model, too (with "
                      "--model reduced and auto the reduced one computes it in any case)");
    command->add_flag(
        "--posterior", options->unique.posterior,
        "draw the posterior too, as sample does, and say where its ranges differ from those of the profiles");
    command->footer("Example: pavescape unique grids/captif-p1-fwd.toml");
    command->callback([=, &action] { action = [=] { return unique(*options); }; });
}

} // namespace explore::cli
