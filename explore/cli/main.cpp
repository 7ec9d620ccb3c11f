#include "analysis/explore/build.h"
#include "base/error.h"
#include "cli/commands.h"
#include "cli/help.h"
#include "cli/terminal.h"
#include "run/blas.h"
#include "run/cluster.h"
#include "run/interrupt.h"
#include "run/message.h"
#include "study/pavement_function.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <fmt/format.h>
#include <gsl/gsl_errno.h>
#include <malloc.h>
#include <new>
#include <unistd.h>

namespace {

// The exit status of a command, and its complaint on standard error.
int perform(const explore::cli::Action& action) {
    namespace cli = explore::cli;
    try {
        if (!explore::run::blas_has_room(1)) {
            throw std::bad_alloc();
        }
        const int status = action();
        if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0) {
            cli::complain("the output could not be written in full");
            return cli::computation_failed;
        }
        return status;
    } catch (const pave::Error& error) {
        cli::complain(error.what());
        return cli::wrong_input;
    } catch (const std::bad_alloc&) {
        explore::run::message("pavescape: the computation failed: memory has run out; what was finished is kept\n");
        return cli::computation_failed;
    } catch (const std::exception& error) {
        cli::complain(fmt::format("the computation failed: {}", error.what()));
        return cli::computation_failed;
    }
}

// As one process of a job of many: the first performs the command, the others compute what it asks for.
int perform_together(const explore::cli::Action& action) {
    namespace run = explore::run;
    const std::string build = explore::analysis::build_words();
    try {
        auto transport = run::join_mpi();
        if (transport->rank() == 0) {
            const int processes = transport->ranks();
            const run::Cluster cluster(std::move(transport), build);
            const int status = perform(action);
            const auto traffic = cluster.traffic();
            explore::run::message(
                "{} processes: {} evaluations by the others ({:.1f} s), {} kB out, {} kB in, {:.2f} s of post\n",
                processes, traffic.requests, traffic.cpu_seconds, traffic.bytes_out / 1000, traffic.bytes_in / 1000,
                traffic.post_cpu_seconds);
            return status;
        }
        run::serve(*transport, build, [](const std::string& d) { return explore::study::make_function(d); });
        return explore::cli::done;
    } catch (const std::exception& error) {
        if (run::is_first_of_job()) {
            explore::cli::complain(fmt::format("the processes cannot work together: {}", error.what()));
        }
        return explore::cli::computation_failed;
    }
}

// The message on a long option that is none of the command's, but like one of them; "": there is nothing to say.
std::string unknown_option(CLI::App& app, int argc, char** argv) {
    const auto commands = app.get_subcommands(
        [&](CLI::App* command) { return argc > 1 && command->get_name() == std::string_view(argv[1]); });
    if (commands.empty()) {
        return "";
    }
    std::vector<std::string> names;
    for (const CLI::Option* option : commands[0]->get_options()) {
        for (const std::string& name : option->get_lnames()) {
            names.push_back("--" + name);
        }
    }
    for (int i = 2; i < argc && std::string_view(argv[i]) != "--"; ++i) {
        const std::string word = std::string(argv[i]).substr(0, std::string_view(argv[i]).find('='));
        if (word.starts_with("--") && std::find(names.begin(), names.end(), word) == names.end()) {
            if (const std::string near = pave::nearest_name(word, names); !near.empty()) {
                return fmt::format("{} has no option \"{}\", did you mean \"{}\"?", argv[1], word, near);
            }
        }
    }
    return "";
}

} // namespace

int main(int argc, char** argv) {
    namespace cli = explore::cli;
    // Sparse factorisations allocate and free the same few megabytes thousands of times: keep them.
    mallopt(M_MMAP_THRESHOLD, 1 << 30);
    mallopt(M_TRIM_THRESHOLD, 1 << 30);
    mallopt(M_TOP_PAD, 16 << 20);
    gsl_set_error_handler_off(); // a number that cannot be computed is none; GSL would end the program
    CLI::App app{"Pavescape calibrates stress-dependent pavement models and says whether the answer can be trusted."};
    app.name("pavescape");
    app.formatter(cli::help_in_columns(cli::columns_of(STDOUT_FILENO))); // before the commands, which take it over
    app.set_help_flag("-h,--help", "print this help");
    app.set_version_flag("--version", explore::analysis::version, "print the version");
    app.require_subcommand(1);
    cli::Action action;
    std::vector<std::string> names;
    for (const cli::Command& command : cli::commands()) {
        command.add(app, action);
        names.emplace_back(command.name);
    }
    if (argc > 1 && std::string_view(argv[1]) == "--complete") { // what completion asks for
        for (const std::string& line : cli::completions(app, {argv + 2, argv + argc})) {
            fmt::print("{}\n", line);
        }
        return cli::done;
    }
    if (argc > 1 && argv[1][0] != '-' && std::find(names.begin(), names.end(), argv[1]) == names.end()) {
        const std::string near = pave::nearest_name(argv[1], names);
        if (!explore::run::is_first_of_job()) {
            return cli::done; // an exit status of another process would end the first before it has spoken
        }
        cli::complain(fmt::format("unknown command \"{}\"{}; allowed: {}", argv[1],
                                  near.empty() ? "" : ", did you mean \"" + near + "\"?", pave::join(names)));
        return cli::wrong_input;
    }
    if (const std::string words = unknown_option(app, argc, argv); !words.empty()) {
        if (explore::run::is_first_of_job()) {
            cli::complain(words);
        }
        return explore::run::is_first_of_job() ? cli::wrong_input : cli::done; // as above
    }
    app.failure_message([](auto* of, auto& error) { return "pavescape: " + CLI::FailureMessage::simple(of, error); });
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
        if (!explore::run::is_first_of_job()) {
            return cli::done; // as above
        }
        return app.exit(error) == 0 ? cli::done : cli::wrong_input;
    }
    cli::remember_command_line(argc, argv);
    const auto chosen = std::find_if(cli::commands().begin(), cli::commands().end(), [&](const cli::Command& command) {
        return command.name == app.get_subcommands()[0]->get_name();
    });
    // `rerun` waits for the commands that it starts.
    chosen->keeps_a_run || chosen->name == "rerun" ? explore::run::catch_interrupts()
                                                   : explore::run::end_at_interrupts();
    explore::run::prepare_blas();
    const int status = explore::run::begun_by_mpi() ? perform_together(action) : perform(action);
    std::fflush(nullptr);
#ifndef __SANITIZE_ADDRESS__ // which looks for leaks at exit
    // OpenBLAS joins threads of its own at exit, for ever where one of them finds no room in memory.
    std::_Exit(status);
#endif
    return status;
}
