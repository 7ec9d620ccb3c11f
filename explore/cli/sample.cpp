// pavescape sample: the posterior of the parameters and the outputs.
#include "report/sample.h"
#include "cli/commands.h"
#include "report/predictive.h"
#include "run/files.h"

namespace explore::cli {
namespace {

struct SampleArguments {
    CommonOptions common;
    analysis::SampleOptions sample;
    bool prior = false;
};

int check_prior(const SampleArguments& options, const study::Study& study) {
    const run::Budget budget(options.common.time_s);
    analysis::Session session(options.common.run(study));
    const auto check = analysis::prior_check(session, study, options.sample.samples);
    if (!check) {
        return end_early(session, options.common, study, "sample-prior", budget);
    }
    const report::Json json = report::prior_check_json(*check, session.options());
    if (check->failed()) {
        return hand_over_failure(options.common, json, check->reason());
    }
    return hand_over_answer(session, options.common, "sample-prior", json,
                            report::prior_check_answer(*check, session.options()), report::prior_check_text(*check));
}

int sample(const SampleArguments& options) {
    const study::Study study = study::load_study(options.common.study);
    if (options.prior) {
        return check_prior(options, study);
    }
    const run::Budget budget(options.common.time_s);
    analysis::Session session(options.common.run(study));
    const auto result = analysis::sample(session, study, options.sample);
    if (!result) {
        return end_early(session, options.common, study, "sample", budget);
    }
    const report::Json json = report::sample_json(*result, session.options());
    if (result->failed()) {
        return hand_over_failure(options.common, json, result->reason());
    }
    run::write_file(session.folder(), "samples.csv", report::samples_csv(*result));
    const int status =
        hand_over_answer(session, options.common, "sample", json, report::sample_text(*result, session.options()));
    if (!result->converged()) {
        complain(result->reason());
        return computation_failed;
    }
    return status;
}

} // namespace

void add_sample(CLI::App& app, Action& action) {
    auto* command = app.add_subcommand("sample", "the posterior: what the data leave of every parameter and output");
    auto options = std::make_shared<SampleArguments>();
    add_common(*command, options->common);
    add_time(*command, options->common);
    add_depth(*command, options->common);
    add_model(*command, options->sample.model);
    auto* model = command->get_option("--model")->default_str("auto where the study has a reduced model, else full");
    command->add_option("--samples", options->sample.samples, "draws, of four independent populations")
        ->check(within(analysis::allowed::sample_draws))
        ->capture_default_str();
    command
        ->add_option(
            "--confirm", options->sample.confirm,
            "draws at which the full model corrects the reduced one, and at most those at which it computes outputs "
            "under loads that no reading has")
        ->check(within(analysis::allowed::sample_confirm))
        ->capture_default_str();
    command->add_flag(
        "--prior", options->prior,
        "no posterior: what the prior predicts of each reading, at as many points as --samples, and which "
        "readings it does not reach");
    command->footer("Example: pavescape sample grids/captif-p1-unique-fwd.toml");
    command->callback([=, &action] {
        options->sample.any_model = model->count() == 0;
        action = [=] { return sample(*options); };
    });
}

} // namespace explore::cli
