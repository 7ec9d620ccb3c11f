// pavescape design: what is left of a pavement's life, and how thick an overlay.
#include "report/design.h"
#include "cli/commands.h"

namespace explore::cli {
namespace {

struct DesignArguments {
    CommonOptions common;
    analysis::DesignOptions design;
};

int design(const DesignArguments& options) {
    const study::Study study = study::load_study(options.common.study);
    analysis::Session session(options.common.run(study));
    const auto result = analysis::design(session, study, options.design);
    if (!result) {
        return report_interrupt(session.folder());
    }
    const report::Json json = report::design_json(*result, session.options());
    if (result->failed()) {
        return hand_over_failure(options.common, json, result->failure);
    }
    return hand_over_answer(session, options.common, "design", json, report::design_answer(*result, session.options()),
                            report::design_text(*result, session.options()));
}

} // namespace

void add_design(CLI::App& app, Action& action) {
    auto* command = app.add_subcommand("design", "remaining life and overlay, with ranges");
    auto options = std::make_shared<DesignArguments>();
    add_common(*command, options->common);
    add_model(*command, options->design.model, false);
    add_depth(*command, options->common);
    command
        ->add_option("--reliability", options->design.reliability_percent,
                     "that an overlay lasts, over what the data accept [%]")
        ->check(within(analysis::allowed::design_reliability))
        ->capture_default_str();
    command
        ->add_option("--years", options->design.years,
                     "of traffic that an overlay must last, where a criterion states no design_traffic")
        ->check(within(analysis::allowed::design_years))
        ->capture_default_str();
    command->add_option("--explore", options->design.settings.explore, "points of the Sobol sample, with derivatives")
        ->check(within(analysis::allowed::unique_explore))
        ->capture_default_str();
    command
        ->add_option("--verify", options->design.settings.verify,
                     "independent random starts in a row that must find no new minimum")
        ->check(within(analysis::allowed::unique_verify))
        ->capture_default_str();
    command->footer("Example: pavescape design grids/captif-p1-design.toml");
    command->callback([=, &action] { action = [=] { return design(*options); }; });
}

} // namespace explore::cli
