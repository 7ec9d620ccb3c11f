// pavescape rerun: does everything a run's folder holds once more, elsewhere, and says where the two differ first.
#include "analysis/explore/build.h"
#include "base/text.h"
#include "cli/commands.h"
#include "run/files.h"
#include "run/inputs.h"
#include "run/message.h"
#include "run/program.h"
#include "run/store_difference.h"

#include <algorithm>
#include <fmt/format.h>

namespace explore::cli {
namespace {

using pave::counted;
using report::Json;

// The command line with another folder for the results, and as much time as it takes.
std::vector<std::string> redirected(const std::vector<std::string>& arguments, const std::string& out) {
    std::vector<std::string> list;
    for (std::size_t i = 0; i < arguments.size(); ++i) {
        if (arguments[i] == "--out" || arguments[i] == "--time") {
            ++i;
        } else if (!arguments[i].starts_with("--out=") && !arguments[i].starts_with("--time=")) {
            list.push_back(arguments[i]);
        }
    }
    list.insert(list.begin() + 1, {"--out", out}); // after the command: a "--" may follow
    return list;
}

std::optional<int> start(const std::vector<std::string>& arguments, const std::string& directory) {
    try {
        return run::run_this_program(arguments, directory);
    } catch (const std::runtime_error& error) {
        throw pave::Error({.file = directory}, "the run cannot be repeated from this folder", error.what(),
                          "the folder that the run was started in");
    }
}

int rerun(const std::string& folder, bool json) {
    const run::Store old_store(folder);
    std::vector<run::Session> sessions; // each command line once
    for (run::Session& session : old_store.sessions()) {
        const bool known = std::any_of(sessions.begin(), sessions.end(), [&](const run::Session& other) {
            return other.arguments == session.arguments && other.directory == session.directory;
        });
        if (!known) {
            sessions.push_back(std::move(session));
        }
    }
    const std::vector<std::string> repeatable = keepers_of_runs(); // nothing else that a store may name is started
    const run::TemporaryFolder scratch;
    const run::TemporaryFolder files;
    for (const run::Session& session : sessions) {
        const std::string command = session.arguments.empty() ? "" : session.arguments[0];
        if (std::find(repeatable.begin(), repeatable.end(), command) == repeatable.end()) {
            throw pave::Error({.file = folder, .key = "RUN"}, "the store names a command that is not repeated",
                              "\"" + command + "\"", pave::join(repeatable));
        }
        const run::Start again =
            run::laid_out({session.arguments, session.directory}, old_store.inputs(session.id), files.path());
        std::vector<std::string> words;
        std::transform(session.arguments.begin(), session.arguments.end(), std::back_inserter(words), run::shell_word);
        run::message("repeating: pavescape {}{}\n", fmt::join(words, " "),
                     again.changed ? " (a file has been changed since: from the texts that the run keeps)" : "");
        const auto status = start(redirected(again.arguments, scratch.path()), again.directory);
        if (!status) {
            run::message("interrupted: the repetition is thrown away, the run itself is as it was\n");
            return was_interrupted;
        }
        if (*status != done && *status != computation_failed) {
            return *status;
        }
    }
    const run::StoreDifference difference = run::difference_of(old_store, run::Store(scratch.path()));
    const bool same = difference.first.empty();
    const std::string libraries = analysis::library_words();
    if (json) {
        Json then = Json::array();
        for (const run::Session& s : sessions) {
            then.push_back({{"arguments", s.arguments}, {"version", s.version}, {"libraries", s.libraries}});
        }
        fmt::print("{}\n", report::json_text({{"same", same},
                                              {"runs", difference.runs},
                                              {"evaluations", difference.evaluations},
                                              {"first_difference", difference.first},
                                              {"then", std::move(then)},
                                              {"now", {{"version", analysis::version}, {"libraries", libraries}}}}));
        return same ? done : computation_failed;
    }
    report::Answer answer;
    answer.verdict = same ? fmt::format("The same to the last bit: {} of {}.",
                                        counted(difference.evaluations, "evaluation", "evaluations"),
                                        counted(difference.runs, "run", "runs"))
                          : fmt::format("The repetition differs; first: {}", difference.first);
    const auto other = std::find_if(sessions.begin(), sessions.end(), [&](const run::Session& s) {
        return s.version != analysis::version || s.libraries != libraries;
    });
    if (other != sessions.end()) {
        answer.notes = {fmt::format("Then: pavescape {}, {}", other->version, other->libraries),
                        fmt::format("Now: pavescape {}, {}", analysis::version, libraries)};
    }
    fmt::print("{}", shown_answer({}, answer, ""));
    return same ? done : computation_failed;
}

} // namespace

void add_rerun(CLI::App& app, Action& action) {
    auto* command = app.add_subcommand("rerun", "repeats a run in another folder and reports the first difference");
    auto folder = std::make_shared<std::string>();
    auto json = std::make_shared<bool>(false);
    command->add_option("RUN", *folder, "folder of the run")->required();
    command->add_flag("--json", *json, "print one JSON object and nothing else");
    command->footer("Example: pavescape rerun output/captif-p1-fwd");
    command->callback([=, &action] { action = [=] { return rerun(*folder, *json); }; });
}

} // namespace explore::cli
