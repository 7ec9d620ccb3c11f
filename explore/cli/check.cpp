// pavescape check: reads a study to the end, says what would run and how long it would take.
#include "report/check.h"
#include "analysis/common/run_cost.h"
#include "cli/commands.h"
#include "run/parallel.h"
#include "run/progress.h"

#include <algorithm>
#include <cstdio>
#include <fmt/format.h>

namespace explore::cli {
namespace {

struct CheckArguments {
    CommonOptions common;
    bool time = false; // by runs
};

int check_study(const CheckArguments& chosen) {
    const CommonOptions& options = chosen.common;
    const study::Study study = study::load_study(options.study);
    const int threads = run::usable_threads(options.threads);
    // Said before it is known whether the study is sound: not on standard output.
    const auto& loads = study.model.loads;
    if (!std::all_of(loads.begin(), loads.end(), [](const auto& load) { return load.is_axisymmetric(); })) {
        fmt::print(stderr, "a mesh in three dimensions is made ...\n");
    }
    const auto cost = analysis::affordable_cost(study, threads);
    if (cost.memory > 0.0) {
        fmt::print(stderr, "it asks for some {} a thread and {} a run{}\n", run::memory_words(cost.memory),
                   run::duration_words(cost.seconds), chosen.time ? "; runs are timed ..." : "");
    } else if (chosen.time) {
        fmt::print(stderr, "runs are timed ...\n");
    }
    const auto list = analysis::check(study, threads, chosen.time ? analysis::Timing::runs : analysis::Timing::sizes);
    if (!list) {
        return hand_over_failure(options,
                                 {{"status", std::string(to_string(list.status()))}, {"reason", list.failure().reason}},
                                 fmt::format("the study can be read, but has no answer at its own values: {}: {}",
                                             to_string(list.status()), list.failure().reason));
    }
    const report::CheckedStudy checked{study, *list, threads, chosen.time, cost};
    fmt::print("{}", options.json ? report::json_text(report::check_json(checked)) + "\n"
                                  : shown_answer(options, report::check_answer(checked), report::check_text(checked)));
    return done;
}

} // namespace

void add_check(CLI::App& app, Action& action) {
    auto* command = app.add_subcommand("check", "checks a whole study, and says what each command would take");
    auto options = std::make_shared<CheckArguments>();
    command->add_option("STUDY", options->common.study, "study file (TOML)")->required();
    command
        ->add_option("--threads", options->common.threads,
                     "number of threads that the times are for (default: one a core)")
        ->check(CLI::Range(1, 4096));
    command->add_flag("--time", options->time, "run the model at the study's own values to time it");
    command->add_flag("--json", options->common.json, "print one JSON object and nothing else");
    add_depth(*command, options->common);
    command->footer("Example: pavescape check grids/captif-p1-fwd.toml");
    command->callback([=, &action] { action = [=] { return check_study(*options); }; });
}

} // namespace explore::cli
