// pavescape rerun: does everything a run's folder holds once more, elsewhere, and says where the two differ first.
#include "analysis/build.h"
#include "base/text.h"
#include "cli/commands.h"
#include "run/inputs.h"
#include "run/interrupt.h"
#include "run/message.h"

#include <algorithm>
#include <bit>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>

extern char** environ;

namespace explore::cli {
namespace {

using pave::counted;
using report::Json;

// A folder for the repetition, removed at the end.
class Scratch {
public:
    Scratch() {
        std::error_code none;
        std::string name = (std::filesystem::temp_directory_path(none) / "pavescape-rerun-XXXXXX").string();
        if (mkdtemp(name.data()) == nullptr) {
            throw pave::Error({.file = name}, "no folder for the repetition can be made", std::strerror(errno),
                              "a folder TMPDIR that can be written");
        }
        path_ = name;
    }
    ~Scratch() {
        std::error_code ignored;
        std::filesystem::remove_all(path_, ignored);
    }
    Scratch(const Scratch&) = delete;
    Scratch& operator=(const Scratch&) = delete;
    const std::string& path() const { return path_; }

private:
    std::string path_;
};

// The command line with another folder for the results.
std::vector<std::string> redirected(const std::vector<std::string>& arguments, const std::string& out) {
    std::vector<std::string> list;
    for (std::size_t i = 0; i < arguments.size(); ++i) {
        if (arguments[i] == "--out") {
            ++i;
        } else if (!arguments[i].starts_with("--out=")) {
            list.push_back(arguments[i]);
        }
    }
    list.insert(list.begin() + 1, {"--out", out}); // after the command: a "--" may follow
    return list;
}

// This program, started with other arguments in another folder; what it prints goes nowhere. Its exit status.
int start(const std::vector<std::string>& arguments, const std::string& directory) {
    std::vector<char*> argv;
    std::string name = "pavescape";
    std::vector<std::string> copies = arguments;
    argv.push_back(name.data());
    for (std::string& argument : copies) {
        argv.push_back(argument.data());
    }
    argv.push_back(nullptr);
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addchdir_np(&actions, directory.c_str());
    posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
    // A group of its own: Ctrl-C reaches this process alone, which throws away what the child has computed.
    posix_spawnattr_t attributes;
    posix_spawnattr_init(&attributes);
    posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
    pid_t child = 0;
    const int failed = posix_spawn(&child, "/proc/self/exe", &actions, &attributes, argv.data(), environ);
    posix_spawnattr_destroy(&attributes);
    posix_spawn_file_actions_destroy(&actions);
    if (failed != 0) {
        throw pave::Error({.file = directory}, "the run cannot be repeated from this folder", std::strerror(failed),
                          "the folder that the run was started in");
    }
    int status = 0;
    while (waitpid(child, &status, WNOHANG) == 0) {
        if (run::interrupted()) {
            kill(child, SIGKILL);
            waitpid(child, &status, 0);
            run::message("interrupted: the repetition is thrown away, the run itself is as it was\n");
            return was_interrupted;
        }
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    return WIFEXITED(status) ? WEXITSTATUS(status) : was_interrupted;
}

struct Comparison {
    std::size_t runs = 0;
    std::size_t evaluations = 0;
    std::string difference{}; // the first, in words; "": none
};

std::string place_of(const run::RunHeader& run, run::RunNumber n) {
    return n.start < 0 ? fmt::format("{}, point {}", run.key.command, n.number)
                       : fmt::format("{}, search {}, evaluation {}", run.key.command, n.start, n.number);
}

// The first list entry whose bits differ, in words.
std::string difference_of(std::string_view what, const std::vector<std::string>& names, const double* then,
                          const double* now, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) {
        if (std::bit_cast<std::uint64_t>(then[i]) != std::bit_cast<std::uint64_t>(now[i])) {
            const std::string name = i < names.size() ? names[i] : std::to_string(i + 1);
            return fmt::format("{} {}: {} then, {} now (SI)", what, name, then[i], now[i]);
        }
    }
    return {};
}

std::string difference_of(const run::RunHeader& run, const problem::Evaluation& then, const problem::Evaluation& now) {
    if (then.status != now.status) {
        return fmt::format("status: {} then, {} now", to_string(then.status), to_string(now.status));
    }
    if (then.parameters.size() != now.parameters.size() || then.responses.size() != now.responses.size() ||
        then.jacobian.rows() != now.jacobian.rows() || then.jacobian.cols() != now.jacobian.cols()) {
        return "another number of values";
    }
    std::string found = difference_of("parameter", run.parameters, then.parameters.data(), now.parameters.data(),
                                      now.parameters.size());
    if (found.empty()) {
        found =
            difference_of("response", run.responses, then.responses.data(), now.responses.data(), now.responses.size());
    }
    if (found.empty()) {
        found = difference_of("derivative", {}, then.jacobian.data(), now.jacobian.data(),
                              static_cast<std::size_t>(now.jacobian.size()));
    }
    return found;
}

Comparison compare(const run::Store& old_store, const run::Store& new_store) {
    Comparison c;
    const auto new_runs = new_store.runs();
    auto old_runs = old_store.runs();
    std::sort(old_runs.begin(), old_runs.end(), [](const auto& a, const auto& b) { return a.id < b.id; });
    for (const run::RunHeader& old_run : old_runs) {
        const auto same = std::find_if(new_runs.begin(), new_runs.end(),
                                       [&](const run::RunHeader& run) { return run.key == old_run.key; });
        if (same == new_runs.end()) {
            // One command may make many runs of one settings text: of other models of the study, or of other studies.
            const bool other_study = std::any_of(new_runs.begin(), new_runs.end(), [&](const run::RunHeader& run) {
                return run.key.command == old_run.key.command && run.key.settings == old_run.key.settings;
            });
            c.difference =
                other_study
                    ? fmt::format("{}: the study or its data have changed since", old_run.key.command)
                    : fmt::format("{} ({}): not among what was repeated", old_run.key.command, old_run.key.settings);
            return c;
        }
        std::map<run::RunNumber, problem::Evaluation> now;
        new_store.each(same->id, [&](run::RunNumber n, const problem::Evaluation& e) { now.emplace(n, e); });
        ++c.runs;
        old_store.each(old_run.id, [&](run::RunNumber n, const problem::Evaluation& then) {
            if (!c.difference.empty()) {
                return;
            }
            const auto found = now.find(n);
            const std::string words =
                found == now.end() ? "not computed now" : difference_of(old_run, then, found->second);
            c.difference = words.empty() ? "" : place_of(old_run, n) + ": " + words;
            ++c.evaluations;
            if (found != now.end()) {
                now.erase(found);
            }
        });
        if (c.difference.empty() && !now.empty()) {
            c.difference = place_of(old_run, now.begin()->first) + ": not computed then";
        }
        if (!c.difference.empty()) {
            return c;
        }
    }
    return c;
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
    std::vector<std::string> repeatable; // nothing else that a store may name is started
    for (const Command& command : commands()) {
        if (command.keeps_a_run) {
            repeatable.emplace_back(command.name);
        }
    }
    const Scratch scratch;
    const Scratch files;
    for (const run::Session& session : sessions) {
        const std::string command = session.arguments.empty() ? "" : session.arguments[0];
        if (std::find(repeatable.begin(), repeatable.end(), command) == repeatable.end()) {
            throw pave::Error({.file = folder, .key = "RUN"}, "the store names a command that is not repeated",
                              "\"" + command + "\"", pave::join(repeatable));
        }
        const run::Start again =
            run::laid_out({session.arguments, session.directory}, old_store.inputs(session.id), files.path());
        run::message("repeating: pavescape {}{}\n", fmt::join(session.arguments, " "),
                     again.changed ? " (a file has been changed since: from the texts that the run keeps)" : "");
        const int status = start(redirected(again.arguments, scratch.path()), again.directory);
        if (status != done && status != computation_failed) {
            return status;
        }
    }
    const Comparison c = compare(old_store, run::Store(scratch.path()));
    const std::string libraries = analysis::library_words();
    if (json) {
        Json then = Json::array();
        for (const run::Session& s : sessions) {
            then.push_back({{"arguments", s.arguments}, {"version", s.version}, {"libraries", s.libraries}});
        }
        fmt::print("{}\n", report::json_text({{"same", c.difference.empty()},
                                              {"runs", c.runs},
                                              {"evaluations", c.evaluations},
                                              {"first_difference", c.difference},
                                              {"then", std::move(then)},
                                              {"now", {{"version", analysis::version}, {"libraries", libraries}}}}));
        return c.difference.empty() ? done : computation_failed;
    }
    for (const run::Session& s : sessions) {
        if (s.version != analysis::version || s.libraries != libraries) {
            fmt::print("then: pavescape {}, {}\nnow:  pavescape {}, {}\n", s.version, s.libraries, analysis::version,
                       libraries);
            break;
        }
    }
    if (!c.difference.empty()) {
        fmt::print("The repetition differs; first: {}\n", c.difference);
        return computation_failed;
    }
    fmt::print("The same to the last bit: {} of {}.\n", counted(c.evaluations, "evaluation", "evaluations"),
               counted(c.runs, "run", "runs"));
    return done;
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
