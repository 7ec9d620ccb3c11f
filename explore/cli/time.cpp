// How long a command may take, and what it says when its time is over.
#include "cli/common.h"
#include "report/best_so_far.h"

#include <fmt/format.h>

namespace explore::cli {

void add_time(CLI::App& app, CommonOptions& options) {
    app.add_option_function<std::string>(
           "--time", [&options](const std::string& text) { options.time_s = *run::budget_of(text); },
           "30s, 10min or 2h for the whole command: then the best answer so far, and the same command goes on")
        ->type_name("TIME")
        ->check(CLI::Validator(
            [](const std::string& text) {
                return run::budget_of(text) ? std::string()
                                            : fmt::format("\"{}\" is no time; allowed: {}", text, run::budget_words);
            },
            ""));
}

int end_early(analysis::Session& session, const CommonOptions& options, const study::Study& study,
              std::string_view name, const run::Budget& budget) {
    if (!budget.is_spent()) {
        return report_interrupt(session.folder());
    }
    const auto found = analysis::best_so_far(session, study, name);
    fmt::print("{}", options.json ? report::json_text(report::best_so_far_json(study, found, budget.seconds())) + "\n"
                                  : report::best_so_far_text(study, found, budget.seconds(), name, session.folder()));
    return was_interrupted;
}

} // namespace explore::cli
