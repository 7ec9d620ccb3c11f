// pavescape diagnose: the effect that the model lacks, the extended study, the gain.
#include "report/diagnose.h"
#include "cli/commands.h"
#include "run/files.h"

namespace explore::cli {
namespace {

struct DiagnoseArguments {
    CommonOptions common;
    analysis::DiagnoseOptions diagnose;
};

int diagnose(const DiagnoseArguments& options) {
    const study::Study study = study::load_study(options.common.study);
    const run::Budget budget(options.common.time_s);
    analysis::Session session(options.common.run(study));
    const auto result = analysis::diagnose(session, study, options.diagnose);
    if (!result) {
        return end_early(session, options.common, study, "diagnose", budget);
    }
    const report::Json json = report::diagnose_json(*result, session.options());
    if (result->failed()) {
        return hand_over_failure(options.common, json, result->diagnosis.failed);
    }
    if (result->is_extended()) {
        report::write_extended(*result, session.options());
    }
    run::write_file(session.folder(), "diagnose.txt", report::diagnosis_page(*result));
    return hand_over_answer(session, options.common, "diagnose", json,
                            report::diagnose_text(*result, session.options()));
}

} // namespace

void add_diagnose(CLI::App& app, Action& action) {
    auto* command =
        app.add_subcommand("diagnose", "finds the effect that the model lacks: cause, extended study, gain");
    auto options = std::make_shared<DiagnoseArguments>();
    add_common(*command, options->common);
    add_time(*command, options->common);
    add_depth(*command, options->common);
    add_model(*command, options->diagnose.model, false); // effects change what a reduced model is made for
    command
        ->add_option("--without", options->diagnose.without,
                     "NAME: an effect that is known not to be there (repeatable; `pavescape effects` lists them)")
        ->expected(1)
        ->take_all();
    command
        ->add_option("--explore", options->diagnose.settings.explore,
                     "points of the Sobol sample for the study's model")
        ->check(within(analysis::allowed::diagnose_explore))
        ->capture_default_str();
    command->add_option("--starts", options->diagnose.settings.starts, "local searches of the study's model")
        ->check(within(analysis::allowed::diagnose_starts))
        ->capture_default_str();
    command
        ->add_option("--bootstrap", options->diagnose.settings.bootstrap,
                     "simulated data sets to calibrate the evidence, at most")
        ->check(within(analysis::allowed::diagnose_bootstrap))
        ->capture_default_str();
    command->footer("Example: pavescape diagnose grids/captif-p1-fwd.toml");
    command->callback([=, &action] { action = [=] { return diagnose(*options); }; });
}

} // namespace explore::cli
