// Every command: what registers it. A new one is a file of its own, a line here and a line in commands.cpp.
#pragma once

#include "cli/common.h"

namespace explore::cli {

void add_new(CLI::App& app, Action& action);
void add_check(CLI::App& app, Action& action);
void add_forward(CLI::App& app, Action& action);
void add_map(CLI::App& app, Action& action);
void add_fit(CLI::App& app, Action& action);
void add_sensitivity(CLI::App& app, Action& action);
void add_unique(CLI::App& app, Action& action);
void add_sample(CLI::App& app, Action& action);
void add_design(CLI::App& app, Action& action);
void add_diagnose(CLI::App& app, Action& action);
void add_compare(CLI::App& app, Action& action);
void add_twin(CLI::App& app, Action& action);
void add_effects(CLI::App& app, Action& action);
void add_slab(CLI::App& app, Action& action);
void add_survey(CLI::App& app, Action& action);
void add_noise(CLI::App& app, Action& action);
void add_road(CLI::App& app, Action& action);
void add_report(CLI::App& app, Action& action);
void add_plot(CLI::App& app, Action& action);
void add_explore(CLI::App& app, Action& action);
void add_serve(CLI::App& app, Action& action);
void add_export(CLI::App& app, Action& action);
void add_rerun(CLI::App& app, Action& action);
void add_merge(CLI::App& app, Action& action);

} // namespace explore::cli
