// Shared by the commands: options, how a result is handed over, the table of commands.
#pragma once

#include "analysis/common/option_ranges.h"
#include "analysis/common/session.h"
#include "report/answer.h"
#include "run/budget.h"

#include <CLI/CLI.hpp>
#include <functional>

namespace explore::cli {

enum ExitStatus { done = 0, computation_failed = 1, wrong_input = 2, was_interrupted = 130 };

// A command registers itself and sets `action`, which is called after parsing and returns the exit status.
using Action = std::function<int()>;

// A command is a file of its own and a line in commands().
struct Command {
    std::string_view name;
    void (*add)(CLI::App& app, Action& action);
    // Of its run, whose folder then holds NAME.json: the page of `report` shows it, `rerun` repeats it. An interrupt
    // lets it finish what is being computed; one of the others ends the program at once.
    bool keeps_a_run = false;
};
std::span<const Command> commands();
std::vector<std::string> keepers_of_runs(); // names of those that keep one

struct CommonOptions {
    std::string study;
    std::string out; // empty: output/<study name>
    int threads = 0;
    std::uint64_t seed = 1;
    double time_s = 0.0; // for the whole command; 0: as long as it takes
    bool json = false;
    bool verbose = false, quiet = false; // of an answer on the terminal

    std::string folder(const study::Study& s) const { return out.empty() ? "output/" + s.folder_name() : out; }
    analysis::RunOptions run(std::string folder) const;
    analysis::RunOptions run(const study::Study& s) const; // where a run takes long, says what it takes
};

// The value of an option lies between these; nan does not.
CLI::Validator within(double low, double high);
inline CLI::Validator within(const analysis::allowed::Real& range) {
    return within(range.low, range.high);
}
inline CLI::Validator within(const analysis::allowed::Whole& range) {
    return CLI::Range(range.low, range.high);
}

// One of these words, kept as its number.
template <class Enum, std::size_t N>
CLI::Option* add_choice(CLI::App& app, const std::string& name, Enum& value, const std::string_view (&words)[N],
                        const std::string& help) {
    std::map<std::string, Enum> choices;
    std::vector<std::string> list;
    for (std::size_t i = 0; i < N; ++i) {
        choices.emplace(words[i], static_cast<Enum>(i));
        list.emplace_back(words[i]);
    }
    return app
        .add_option_function<std::string>(
            name, [&value, choices](const std::string& word) { value = choices.at(word); }, help)
        ->check(CLI::IsMember(list))
        ->default_str(std::string(words[static_cast<std::size_t>(value)]));
}

// Adds --out, --threads, --seed, --json. default_folder: where results go without --out, in words.
void add_run_options(CLI::App& app, CommonOptions& options, const std::string& default_folder);
// Adds STUDY, --out, --threads, --seed, --json.
void add_common(CLI::App& app, CommonOptions& options);
// Adds --time, of a command that ends with end_early().
void add_time(CLI::App& app, CommonOptions& options);
// Adds --verbose and --quiet, of a command that has an answer (report/answer.h).
void add_depth(CLI::App& app, CommonOptions& options);
// Adds --model and --model-error. alone: whether the command can do with the reduced model alone.
void add_model(CLI::App& app, analysis::ModelOptions& options, bool alone = true);
// Adds --columns.
void add_columns(CLI::App& app, std::string& columns);

// The arguments of main; kept for the stores that this process writes to.
void remember_command_line(int argc, const char* const* argv);

// Keeps a result, and prints it as JSON or as the page.
int hand_over(analysis::Session& session, const CommonOptions& options, std::string_view name, const report::Json& json,
              const std::function<std::string()>& page);
// The same of a command that has an answer: its full page is kept too, as NAME.txt.
int hand_over_answer(analysis::Session& session, const CommonOptions& options, std::string_view name,
                     const report::Json& json, const report::Answer& answer, const std::string& page);
int hand_over_answer(analysis::Session& session, const CommonOptions& options, std::string_view name,
                     const report::Json& json, const std::string& page);
// The answer as standard output shows it, in the columns of the terminal.
std::string shown_answer(const CommonOptions& options, const report::Answer& answer, const std::string& page);
std::string shown_answer(const CommonOptions& options, std::string_view name, const report::Json& json,
                         const std::string& page);
// "pavescape: TEXT" on standard error: in the columns of a terminal, else in one line.
void complain(std::string_view text);
// A computation without an answer: JSON where it is requested, and the reason on standard error. Exit status 1.
int hand_over_failure(const CommonOptions& options, const report::Json& json, std::string_view reason);
// For a run that was cut off: a message on standard error. Exit status 130.
int report_interrupt(const std::string& folder);
// The same where its time may have been over: then the best answer so far is printed.
int end_early(analysis::Session& session, const CommonOptions& options, const study::Study& study,
              std::string_view name, const run::Budget& budget);

} // namespace explore::cli
