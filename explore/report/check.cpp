#include "report/check.h"

#include "analysis/common/layout.h"
#include "analysis/common/repeated_rows.h"
#include "base/error.h"
#include "base/text.h"
#include "report/text.h"
#include "run/program.h"
#include "run/progress.h"

#include <fmt/format.h>

namespace explore::report {
namespace {

using pave::counted;

// Sentences on what is doubtful.
std::vector<std::string> remarks_on(const study::Study& study) {
    std::vector<std::string> remarks = analysis::doubtful_readings(study);
    remarks.push_back(analysis::repeated_rows_words(study));
    remarks.push_back(analysis::noise_key_words(study));
    std::erase(remarks, "");
    return remarks;
}

} // namespace

Answer check_answer(const CheckedStudy& checked) {
    const study::Study& study = checked.study;
    const std::vector<std::string> remarks = remarks_on(study);
    Answer answer;
    answer.lines = 30;
    const std::size_t readings = study.measured().size();
    const std::string rest = fmt::format("{}, {}", counted(study.parameters.size(), "parameter", "parameters"),
                                         counted(study.outputs().size(), "output", "outputs"));
    answer.verdict =
        (readings == 0
             ? fmt::format("The study is well formed, but has no readings to be fitted: {}.", rest)
             : fmt::format("The study is well formed: {}, noise {}, {}.", counted(readings, "reading", "readings"),
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
    if (checked.commands.empty()) {
        answer.notes.emplace_back("What commands take is not known of a model of your own; --time runs it once.");
    } else {
        answer.heading =
            fmt::format("Time on {}, {}", counted(static_cast<std::size_t>(checked.threads), "thread", "threads"),
                        checked.is_timed ? "from runs made just now at the study's own values"
                                         : "estimated from sizes alone (--time runs the model)");
        answer.header = {"command", "runs", "time"};
        for (const analysis::Estimate& e : checked.commands) {
            answer.rows.push_back(
                {e.command, e.runs,
                 e.seconds < 1.0 ? fmt::format("{:.0f} ms", 1e3 * e.seconds) : run::duration_words(e.seconds)});
        }
    }
    const std::string file = run::shell_word(study.file);
    // Whether your own model answers is not known before it ran.
    answer.next = readings == 0 || checked.commands.empty() ? "pavescape forward " + file
                  : study.parameters.empty()                ? "state [[parameters]], what is to be fitted"
                                                            : "pavescape fit " + file;
    return answer;
}

Json check_json(const CheckedStudy& checked) {
    const study::Study& study = checked.study;
    constexpr double giga = 1e9;
    Json commands = Json::array();
    for (const analysis::Estimate& e : checked.commands) {
        commands.push_back({{"command", e.command}, {"runs", e.runs}, {"seconds", e.seconds}});
    }
    Json groups = Json::array();
    for (const auto& group : study.groups) {
        groups.push_back({{"group", group.name}, {"readings", group.rows.size()}, {"held_out", group.held_out}});
    }
    return {{"status", checked.is_timed ? "converged" : "read"},
            {"readings", study.measured().size()},
            {"groups", groups},
            {"parameters", study.parameters.size()},
            {"outputs", study.outputs().size()},
            {"doubtful", analysis::doubtful_readings(study)},
            {"repeated", analysis::repeated_rows_words(study)},
            {"noise_keys", analysis::noise_key_words(study)},
            {"threads", checked.threads},
            {"timed", checked.is_timed},
            {"estimate", {{"memory_GB", checked.cost.memory / giga}, {"seconds", checked.cost.seconds}}},
            {"commands", commands}};
}

std::string check_text(const CheckedStudy& checked) {
    const Answer answer = check_answer(checked);
    std::string text = readings_summary(checked.study) + sentences(answer.notes);
    if (!answer.header.empty()) {
        Table table(answer.header);
        for (const std::vector<std::string>& row : answer.rows) {
            table.add(row);
        }
        text += "\n  " + answer.heading + "\n" + table.text();
    }
    return text;
}

} // namespace explore::report
