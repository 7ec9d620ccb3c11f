// How much of an answer the terminal shows, and how wide: one place for all commands that have one.
#include "report/answer.h"

#include "base/error.h"
#include "cli/common.h"
#include "cli/terminal.h"
#include "run/files.h"
#include "run/message.h"

#include <algorithm>
#include <cstdlib>
#include <sys/ioctl.h>
#include <unistd.h>

namespace explore::cli {

bool is_terminal(int file) {
    return isatty(file) == 1;
}

std::size_t columns_of(int file) {
    constexpr std::size_t least = 40;
    constexpr std::size_t most = 100; // longer lines are hard to read
    winsize size{};
    return is_terminal(file) && ioctl(file, TIOCGWINSZ, &size) == 0 && size.ws_col > 0
               ? std::clamp<std::size_t>(size.ws_col, least, most)
               : report::terminal_columns;
}

void add_depth(CLI::App& app, CommonOptions& options) {
    auto* verbose = app.add_flag("--verbose", options.verbose, "print all details, not the answer alone");
    app.add_flag("--quiet", options.quiet, "print the verdict alone")->excludes(verbose);
}

std::string shown_answer(const CommonOptions& options, const report::Answer& answer, const std::string& page) {
    const char* no_colour = std::getenv("NO_COLOR");
    const bool has_colour = is_terminal(STDOUT_FILENO) && (no_colour == nullptr || *no_colour == '\0');
    return report::laid_out(answer,
                            options.verbose ? report::Depth::full
                            : options.quiet ? report::Depth::verdict
                                            : report::Depth::brief,
                            page, has_colour, columns_of(STDOUT_FILENO));
}

std::string shown_answer(const CommonOptions& options, std::string_view name, const report::Json& json,
                         const std::string& page) {
    return shown_answer(options, report::answer_of(std::string(name), json), page);
}

int hand_over_answer(analysis::Session& session, const CommonOptions& options, std::string_view name,
                     const report::Json& json, const report::Answer& answer, const std::string& page) {
    if (name != "diagnose") { // which keeps a page of its own
        run::write_file(session.folder(), std::string(name) + ".txt", page);
    }
    return hand_over(session, options, name, json, [&] { return shown_answer(options, answer, page); });
}

int hand_over_answer(analysis::Session& session, const CommonOptions& options, std::string_view name,
                     const report::Json& json, const std::string& page) {
    return hand_over_answer(session, options, name, json, report::answer_of(std::string(name), json), page);
}

void complain(std::string_view text) {
    std::string line = "pavescape: " + std::string(text);
    if (is_terminal(STDERR_FILENO)) {
        line = pave::join(report::wrapped(line, columns_of(STDERR_FILENO), 2), "\n");
    }
    run::message("{}\n", line);
}

} // namespace explore::cli
