#include "report/predictive.h"

#include "analysis/explore/build.h"
#include "base/text.h"
#include "report/text.h"
#include "run/program.h"

#include <algorithm>
#include <fmt/format.h>

namespace explore::report {

using analysis::PredictedReading;
using pave::figure;

Json predicted_json(const study::Study& study, const std::vector<PredictedReading>& readings) {
    Json rows = Json::array();
    for (const PredictedReading& p : readings) {
        const data::Reading& reading = study.readings[p.row];
        Json row = place_json(reading);
        row["measured"] = reading.value;
        row["unit"] = std::string(reading.unit.name);
        row["low"] = reading.in_unit(p.low);
        row["median"] = reading.in_unit(p.median);
        row["high"] = reading.in_unit(p.high);
        row["pit"] = p.below;
        row["inside"] = p.is_inside();
        rows.push_back(std::move(row));
    }
    return rows;
}

std::string predicted_table(const study::Study& study, const std::vector<PredictedReading>& readings) {
    Table table({"reading", "measured", "2.5 %", "50 %", "97.5 %", "unit", "below", ""});
    for (const PredictedReading& p : readings) {
        const data::Reading& reading = study.readings[p.row];
        table.add({reading.words(), fmt::format("{}{}", data::sign_of(reading.censored), reading.value),
                   figure(reading.in_unit(p.low)), figure(reading.in_unit(p.median)), figure(reading.in_unit(p.high)),
                   std::string(reading.unit.name), fmt::format("{:.3f}", p.below), p.is_inside() ? "" : "outside"});
    }
    return table.text();
}

Json prior_check_json(const analysis::PriorCheck& check, const analysis::RunOptions& run) {
    if (check.failed()) {
        return {{"status", "failed"}, {"reason", check.reason()}, {"points", check.points}};
    }
    Json unreached = Json::array();
    for (const std::size_t row : check.unreached()) {
        unreached.push_back(check.study.readings[row].label());
    }
    return {{"unreached", std::move(unreached)},
            {"readings", predicted_json(check.study, check.readings)},
            {"points", check.points},
            {"answered", check.answered},
            {"effective", check.effective},
            {"findings", analysis::findings(check)},
            {"study", study_json(check.study)},
            {"version", analysis::version},
            {"seed", run.seed},
            {"run", run.folder}};
}

Answer prior_check_answer(const analysis::PriorCheck& check, const analysis::RunOptions& run) {
    Answer answer;
    answer.verdict_and_notes(analysis::findings(check));
    answer.heading = "Readings as the prior predicts them, with their noise";
    answer.header = {"reading", "measured", "2.5 %", "50 %", "97.5 %", "unit", ""};
    for (const PredictedReading& p : check.readings) {
        const data::Reading& reading = check.study.readings[p.row];
        answer.rows.push_back(
            {reading.words(), fmt::format("{}{}", data::sign_of(reading.censored), figure(reading.value)),
             figure(reading.in_unit(p.low)), figure(reading.in_unit(p.median)), figure(reading.in_unit(p.high)),
             std::string(reading.unit.name), p.is_inside() ? "" : "outside"});
    }
    answer.notes.push_back(fmt::format("{} points of the prior, {} with an answer ({} computed, {} kept from before).",
                                       check.points, check.answered, check.computed, check.kept));
    answer.next = check.unreached().empty() ? "pavescape sample " + run::shell_word(check.study.file)
                                            : "look at units, places, bounds and the section before any fit\n"
                                              "Results: " +
                                                  run.folder + "/sample-prior.json";
    return answer;
}

std::string prior_check_text(const analysis::PriorCheck& check) {
    return fmt::format(
        "{}\n{} points of the prior, {} with an answer ({} computed, {} kept from before). Each reading as "
        "they predict it, with its noise:\n{}\n{}",
        sentences(analysis::findings(check)), check.points, check.answered, check.computed, check.kept,
        predicted_table(check.study, check.readings), study_summary(check.study));
}

} // namespace explore::report
