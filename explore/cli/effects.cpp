// pavescape effects: the catalogue of effects that a study may lack.
#include "report/effects.h"
#include "cli/commands.h"

#include <fmt/format.h>

namespace explore::cli {

void add_effects(CLI::App& app, Action& action) {
    auto* command = app.add_subcommand("effects", "the physical effects that a study may add to its model");
    auto json = std::make_shared<bool>(false);
    command->add_flag("--json", *json, "print one JSON array and nothing else");
    command->footer("Example: pavescape effects");
    command->callback([=, &action] {
        action = [=] {
            fmt::print("{}", *json ? report::json_text(report::effects_json()) + "\n" : report::effects_text());
            return static_cast<int>(done);
        };
    });
}

} // namespace explore::cli
