// How much of an answer the terminal shows: one place for all commands that have one.
#include "report/answer.h"

#include "cli/common.h"
#include "run/files.h"

#include <cstdlib>
#include <unistd.h>

namespace explore::cli {

void add_depth(CLI::App& app, CommonOptions& options) {
    auto* verbose = app.add_flag("--verbose", options.verbose, "print all details, not the answer alone");
    app.add_flag("--quiet", options.quiet, "print the verdict alone")->excludes(verbose);
}

std::string shown_answer(const CommonOptions& options, std::string_view name, const report::Json& json,
                         const std::string& page) {
    const char* no_colour = std::getenv("NO_COLOR");
    const bool has_colour = isatty(STDOUT_FILENO) == 1 && (no_colour == nullptr || *no_colour == '\0');
    return report::laid_out(report::answer_of(std::string(name), json),
                            options.verbose ? report::Depth::full
                            : options.quiet ? report::Depth::verdict
                                            : report::Depth::brief,
                            page, has_colour);
}

int hand_over_answer(analysis::Session& session, const CommonOptions& options, std::string_view name,
                     const report::Json& json, const std::string& page) {
    if (name != "diagnose") { // which keeps a page of its own
        run::write_file(session.folder(), std::string(name) + ".txt", page);
    }
    return hand_over(session, options, name, json, [&] { return shown_answer(options, name, json, page); });
}

} // namespace explore::cli
