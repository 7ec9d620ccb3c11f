// pavescape check: reads a study to the end, says what would run and how long it would take.
#include "analysis/studies/check.h"
#include "analysis/common/layout.h"
#include "analysis/common/repeated_rows.h"
#include "analysis/common/run_cost.h"
#include "base/text.h"
#include "cli/commands.h"
#include "report/text.h"
#include "run/parallel.h"
#include "run/program.h"
#include "run/progress.h"

#include <algorithm>
#include <cstdio>
#include <fmt/format.h>

namespace explore::cli {
namespace {

using pave::counted;

constexpr double giga = 1e9;

struct CheckArguments {
    CommonOptions common;
    bool time = false; // by runs
};

// Sentences on what is doubtful.
std::vector<std::string> remarks_on(const study::Study& study) {
    std::vector<std::string> remarks = analysis::doubtful_readings(study);
    remarks.push_back(analysis::repeated_rows_words(study));
    remarks.push_back(analysis::noise_key_words(study));
    std::erase(remarks, "");
    return remarks;
}

report::Answer answer_on(const study::Study& study, const std::vector<analysis::Estimate>& list,
                         const std::vector<std::string>& remarks, int threads, bool timed) {
    report::Answer answer;
    answer.lines = 30;
    const std::size_t readings = study.measured().size();
    const std::string rest = fmt::format("{}, {}", counted(study.parameters.size(), "parameter", "parameters"),
                                         counted(study.outputs().size(), "output", "outputs"));
    answer.verdict =
        (readings == 0
             ? fmt::format("The study can be run, but has no readings to be fitted: {}.", rest)
             : fmt::format("The study can be run: {}, their noise {}, {}.", counted(readings, "reading", "readings"),
                           study.noise == study::NoiseSource::stated ? study.noise_name()
                                                                     : "to be estimated from the fit",
                           rest)) +
        (remarks.empty() ? "" : fmt::format(" {} to look at.", counted(remarks.size(), "remark", "remarks")));
    answer.notes = remarks;
    std::vector<std::string> groups;
    for (const auto& group : study.groups) {
        groups.push_back(fmt::format("{}: {}{}", group.name, group.rows.size(),
                                     group.held_out        ? " (held out)"
                                     : group.weight != 1.0 ? fmt::format(" (weight {:g})", group.weight)
                                                           : ""));
    }
    if (!groups.empty()) {
        answer.notes.push_back("Readings of " + pave::join(groups) + ".");
    }
    if (list.empty()) {
        answer.notes.emplace_back("What commands take is not known of a model of your own; --time runs it once.");
    } else {
        answer.heading = fmt::format("Time on {}, {}", counted(static_cast<std::size_t>(threads), "thread", "threads"),
                                     timed ? "from runs made just now at the study's own values"
                                           : "estimated from sizes alone (--time runs the model)");
        answer.header = {"command", "runs", "time"};
        for (const analysis::Estimate& e : list) {
            answer.rows.push_back(
                {e.command, e.runs,
                 e.seconds < 1.0 ? fmt::format("{:.0f} ms", 1e3 * e.seconds) : run::duration_words(e.seconds)});
        }
    }
    const std::string file = run::shell_word(study.file);
    answer.next = readings == 0              ? "pavescape forward " + file
                  : study.parameters.empty() ? "state [[parameters]], what is to be fitted"
                                             : "pavescape fit " + file;
    return answer;
}

int check_study(const CheckArguments& chosen) {
    const CommonOptions& options = chosen.common;
    const study::Study study = study::load_study(options.study);
    const int threads = run::usable_threads(options.threads);
    // Said before it is known whether the study is sound: not on standard output.
    const auto& loads = study.model.loads;
    if (!std::all_of(loads.begin(), loads.end(), [](const auto& load) { return load.is_axisymmetric(); })) {
        fmt::print(stderr, "a mesh in three dimensions is made ...\n");
    }
    const auto cost = analysis::affordable_cost(study, threads);
    if (cost.memory > 0.0) {
        fmt::print(stderr, "it asks for some {:.1f} GB a thread and {} a run{}\n", cost.memory / giga,
                   run::duration_words(cost.seconds), chosen.time ? "; runs are timed ..." : "");
    } else if (chosen.time) {
        fmt::print(stderr, "runs are timed ...\n");
    }
    const auto list = analysis::check(study, threads, chosen.time ? analysis::Timing::runs : analysis::Timing::sizes);
    if (!list) {
        return hand_over_failure(options,
                                 {{"status", std::string(to_string(list.status()))}, {"reason", list.failure().reason}},
                                 fmt::format("the study can be read, but has no answer at its own values: {}: {}",
                                             to_string(list.status()), list.failure().reason));
    }
    const std::vector<std::string> remarks = remarks_on(study);
    const report::Answer answer = answer_on(study, *list, remarks, threads, chosen.time);
    if (options.json) {
        report::Json commands = report::Json::array();
        for (const analysis::Estimate& e : *list) {
            commands.push_back({{"command", e.command}, {"runs", e.runs}, {"seconds", e.seconds}});
        }
        report::Json groups = report::Json::array();
        for (const auto& group : study.groups) {
            groups.push_back({{"group", group.name}, {"readings", group.rows.size()}, {"held_out", group.held_out}});
        }
        fmt::print("{}\n",
                   report::json_text({{"status", chosen.time ? "converged" : "read"},
                                      {"readings", study.measured().size()},
                                      {"groups", groups},
                                      {"parameters", study.parameters.size()},
                                      {"outputs", study.outputs().size()},
                                      {"doubtful", analysis::doubtful_readings(study)},
                                      {"repeated", analysis::repeated_rows_words(study)},
                                      {"noise_keys", analysis::noise_key_words(study)},
                                      {"threads", threads},
                                      {"timed", chosen.time},
                                      {"estimate", {{"memory_GB", cost.memory / giga}, {"seconds", cost.seconds}}},
                                      {"commands", commands}}));
        return done;
    }
    std::string page = report::readings_summary(study);
    for (const std::string& words : remarks) {
        page += "  " + words + "\n";
    }
    page += list->empty() ? "\n  What commands take is not known of a model of your own; --time runs it once.\n"
                          : "\n  " + answer.heading + "\n";
    report::Table table(answer.header);
    for (const std::vector<std::string>& row : answer.rows) {
        table.add(row);
    }
    fmt::print("{}", shown_answer(options, answer, page + (list->empty() ? "" : table.text())));
    return done;
}

} // namespace

void add_check(CLI::App& app, Action& action) {
    auto* command = app.add_subcommand("check", "checks a whole study, and says what each command would take");
    auto options = std::make_shared<CheckArguments>();
    command->add_option("STUDY", options->common.study, "study file (TOML)")->required();
    command
        ->add_option("--threads", options->common.threads,
                     "number of threads that the times are for (default: one a core)")
        ->check(CLI::Range(1, 4096));
    command->add_flag("--time", options->time, "run the model at the study's own values to time it");
    command->add_flag("--json", options->common.json, "print one JSON object and nothing else");
    add_depth(*command, options->common);
    command->footer("Example: pavescape check grids/captif-p1-fwd.toml");
    command->callback([=, &action] { action = [=] { return check_study(*options); }; });
}

} // namespace explore::cli
