// What the commands share: options, the run folder, the first lines of every report.
#pragma once

#include "report/json.h"
#include "run/store.h"
#include "study/study.h"

#include <CLI/CLI.hpp>

namespace explore::cli {

// Points of a Sobol sample when nothing else is asked for.
inline constexpr int map_points = 1024;
inline constexpr int fit_points = 256;

enum ExitStatus { done = 0, computation_failed = 1, wrong_input = 2, was_interrupted = 130 };

struct CommonOptions {
    std::string study;
    std::string out; // empty: output/<study name>
    int threads = 0;
    std::uint64_t seed = 1;
    bool json = false;

    std::string folder(const study::Study& s) const { return out.empty() ? "output/" + s.stem() : out; }
};

// The value of an option lies between these; nan does not.
CLI::Validator within(double low, double high);

// Adds --out, --threads, --seed, --json. default_folder: where results go without --out, in words.
void add_run_options(CLI::App& app, CommonOptions& options, const std::string& default_folder);

// Adds STUDY, --out, --threads, --seed, --json.
void add_common(CLI::App& app, CommonOptions& options);

// A command registers itself and sets `action`, which is called after parsing and returns the exit status.
using Action = std::function<int()>;
void add_new(CLI::App& app, Action& action);
void add_check(CLI::App& app, Action& action);
void add_forward(CLI::App& app, Action& action);
void add_map(CLI::App& app, Action& action);
void add_fit(CLI::App& app, Action& action);
void add_sensitivity(CLI::App& app, Action& action);
void add_compare(CLI::App& app, Action& action);
void add_twin(CLI::App& app, Action& action);
void add_effects(CLI::App& app, Action& action);
void add_survey(CLI::App& app, Action& action);
void add_unique(CLI::App& app, Action& action);
void add_diagnose(CLI::App& app, Action& action);
void add_report(CLI::App& app, Action& action);
void add_export(CLI::App& app, Action& action);
void add_rerun(CLI::App& app, Action& action);

// What main was called with; kept for session().
void remember_command_line(int argc, const char* const* argv);
// The versions of the program and of the libraries that decide digits.
std::string build_words();
// This process, for the stores it writes to.
run::Session session(const CommonOptions& options);

// Header of a run of this study for the store.
run::RunHeader run_header(const study::Study& study, std::string command, std::string settings);

// Writes a file of a run's folder (created when missing) at once. Throws pave::Error.
void write_file(const std::string& folder, const std::string& name, const std::string& text);

// "asphalt 30 mm linear | base 277 mm uzan | ..." and what is varied.
std::string study_summary(const study::Study& study);

// What the header of every table of responses says.
inline constexpr std::string_view sign_convention =
    "deflection: positive down; strain and load-induced stress: positive in compression";

// Measured against modelled, one row a response, with the line that states the signs.
std::string response_table(const study::Study& study, const std::vector<double>& responses);

// Message on standard error for a run that was cut off.
int report_interrupt(const std::string& folder);

} // namespace explore::cli
