// pavescape sensitivity: how much each parameter moves each response, near the study's own values and over the box.
#include "report/sensitivity.h"
#include "cli/commands.h"

namespace explore::cli {
namespace {

struct SensitivityArguments {
    CommonOptions common;
    analysis::SensitivityOptions sensitivity;
};

int sensitivity(const SensitivityArguments& options) {
    const study::Study study = study::load_study(options.common.study);
    analysis::Session session(options.common.run(study));
    const auto result = analysis::sensitivity(session, study, options.sensitivity);
    if (!result) {
        return report_interrupt(session.folder());
    }
    const report::Json json = report::sensitivity_json(*result, session.options());
    if (result->failed()) {
        return hand_over_failure(options.common, json,
                                 std::string(to_string(result->own.status)) + ": " + result->reason());
    }
    const int status = hand_over_answer(session, options.common, "sensitivity", json,
                                        report::sensitivity_answer(*result, session.options()),
                                        report::sensitivity_text(*result, session.options()));
    if (options.sensitivity.samples > 0 && result->global.complete < 2) {
        complain("too few points of the box have an answer for global indices");
        return computation_failed;
    }
    return status;
}

} // namespace

void add_sensitivity(CLI::App& app, Action& action) {
    auto* command = app.add_subcommand("sensitivity", "how much each parameter moves each response");
    auto options = std::make_shared<SensitivityArguments>();
    add_common(*command, options->common);
    add_depth(*command, options->common);
    command
        ->add_option("--parameter", options->sensitivity.parameters,
                     "a parameter to change (repeatable; default: all of the study); the others stay at "
                     "their own values")
        ->allow_extra_args(false);
    command->add_option("--range", options->sensitivity.range, "the curves go this many percent to either side")
        ->check(within(analysis::allowed::sensitivity_range))
        ->capture_default_str();
    command->add_option("--points", options->sensitivity.points, "points of a curve")
        ->check(within(analysis::allowed::sensitivity_points))
        ->capture_default_str();
    command
        ->add_option("--samples", options->sensitivity.samples,
                     "rows of the sample for global indices, best a power of 2, each as many runs as parameters "
                     "and two more; 0: none")
        ->check(within(analysis::allowed::sensitivity_samples))
        ->capture_default_str();
    command->footer("Example: pavescape sensitivity grids/captif-p1-fwd.toml --range 50 --samples 256");
    command->callback([=, &action] { action = [=] { return sensitivity(*options); }; });
}

} // namespace explore::cli
