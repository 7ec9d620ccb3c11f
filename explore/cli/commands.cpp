#include "cli/commands.h"

namespace explore::cli {

std::span<const Command> commands() {
    static constexpr Command all[] = {
        {"new", add_new},
        {"check", add_check},
        {"forward", add_forward},
        {"map", add_map, true},
        {"fit", add_fit, true},
        {"sensitivity", add_sensitivity, true},
        {"unique", add_unique, true},
        {"sample", add_sample, true},
        {"design", add_design, true},
        {"diagnose", add_diagnose, true},
        {"compare", add_compare, true},
        {"twin", add_twin},
        {"effects", add_effects},
        {"survey", add_survey, true},
        {"noise", add_noise},
        {"slab", add_slab},
        {"road", add_road, true},
        {"report", add_report},
        {"plot", add_plot},
        {"explore", add_explore},
        {"serve", add_serve},
        {"export", add_export},
        {"rerun", add_rerun},
        {"merge", add_merge},
    };
    return all;
}

std::vector<std::string> keepers_of_runs() {
    std::vector<std::string> names;
    for (const Command& command : commands()) {
        if (command.keeps_a_run) {
            names.emplace_back(command.name);
        }
    }
    return names;
}

} // namespace explore::cli
