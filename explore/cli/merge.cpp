// pavescape merge: two runs of one study, computed on machines without a common disk, become one.
#include "base/text.h"
#include "cli/commands.h"
#include "run/program.h"
#include "run/store_merge.h"

#include <filesystem>
#include <fmt/format.h>

namespace explore::cli {
namespace {

struct MergeArguments {
    std::string first, second, out;
    bool json = false;
};

int merge(const MergeArguments& options) {
    namespace fs = std::filesystem;
    std::error_code none;
    if (fs::equivalent(options.first, options.second, none)) {
        throw pave::Error({.file = options.second}, "a run cannot be merged with itself", "the same folder twice",
                          "two folders");
    }
    if (!options.out.empty()) {
        if (fs::exists(fs::path(options.out) / "run.sqlite")) {
            throw pave::Error({.file = options.out, .key = "--out"}, "there is a run in this folder", "run.sqlite",
                              "a folder without one");
        }
        run::copy_store(options.first, options.out);
    }
    const std::string& folder = options.out.empty() ? options.first : options.out;
    const run::MergeReport report = [&] {
        try {
            return run::merge_stores(folder, options.second);
        } catch (...) {
            if (!options.out.empty()) {
                fs::remove(fs::path(options.out) / "run.sqlite", none);
            }
            throw;
        }
    }();
    if (options.json) {
        fmt::print("{}\n", report::json_text({{"run", folder},
                                              {"runs", report.runs},
                                              {"evaluations", report.evaluations},
                                              {"added", report.added},
                                              {"compared", report.compared},
                                              {"libraries", report.libraries}}));
        return done;
    }
    report::Answer answer;
    answer.verdict = fmt::format("{} now holds {}: {} came from {}, {} stood in both with the same bits.", folder,
                                 pave::counted(report.evaluations, "evaluation", "evaluations"), report.added,
                                 options.second, report.compared);
    if (!report.libraries.empty()) {
        answer.notes.push_back("Computed with different libraries, whose last bits may differ: " + report.libraries);
    }
    answer.next = fmt::format("the command that made them continues there with --out {}", run::shell_word(folder));
    fmt::print("{}", shown_answer({}, answer, ""));
    return done;
}

} // namespace

void add_merge(CLI::App& app, Action& action) {
    auto* command = app.add_subcommand("merge", "two runs of one study become one");
    auto options = std::make_shared<MergeArguments>();
    command->add_option("FIRST", options->first, "folder of a run, which gets what the second has")->required();
    command->add_option("SECOND", options->second, "folder of another run of the same study, which is only read")
        ->required();
    command->add_option("--out", options->out, "put both into a new folder instead")->type_name("DIR");
    command->add_flag("--json", options->json, "print one JSON object and nothing else");
    command->footer(
        "Where both have computed the same point the bits are compared; where they\ndiffer nothing is merged.\n"
        "Example: pavescape merge output/here output/there");
    command->callback([=, &action] { action = [=] { return merge(*options); }; });
}

} // namespace explore::cli
