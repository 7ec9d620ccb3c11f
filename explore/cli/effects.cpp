// pavescape effects: the catalogue of effects that a study may lack.
#include "report/effects.h"
#include "cli/commands.h"

#include <fmt/format.h>

namespace explore::cli {

void add_effects(CLI::App& app, Action& action) {
    auto* command = app.add_subcommand("effects", "the physical effects that a study may add to its model");
    auto options = std::make_shared<CommonOptions>();
    command->add_flag("--json", options->json, "print one JSON array and nothing else");
    add_depth(*command, *options);
    command->footer("Example: pavescape effects");
    command->callback([=, &action] {
        action = [=] {
            fmt::print("{}", options->json ? report::json_text(report::effects_json()) + "\n"
                                           : shown_answer(*options, report::effects_answer(), report::effects_text()));
            return static_cast<int>(done);
        };
    });
}

} // namespace explore::cli
