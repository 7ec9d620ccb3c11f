#include "report/design.h"

#include "base/text.h"
#include "report/text.h"
#include "run/program.h"
#include "study/seasons.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace explore::report {
namespace {

using analysis::CriterionLife;
using analysis::DesignResult;
using analysis::LifeRange;
using pave::figure;

// If the model may lack something, no number stands for what the law or the data
// do not bound.
Json wide_json(const CriterionLife& c, const LifeRange& range) {
    const auto end = [&](double value, double allowable) {
        return c.beyond(allowable) == 0 ? finite_json(value) : Json(nullptr);
    };
    return {{"low", end(range.wide_low, c.allowable.wide_low)}, {"high", end(range.wide_high, c.allowable.wide_high)}};
}

void add_range(Json& json, const std::string& name, const CriterionLife& c, const LifeRange& range) {
    json[name + "_low"] = finite_json(range.low);
    json[name + "_high"] = finite_json(range.high);
    json[name + "_if_wrong"] = wide_json(c, range);
}

// Which numbers are beyond what the guide uses the law for.
Json beyond_json(const CriterionLife& c) {
    Json list = Json::array();
    for (const auto& [name, value] : {std::pair{"allowable", c.allowable.best},
                                      {"allowable_low", c.allowable.low},
                                      {"allowable_high", c.allowable.high}}) {
        if (c.beyond(value) != 0) {
            list.push_back(name);
        }
    }
    return list;
}

Json criterion_json(const CriterionLife& c) {
    Json json = {{"name", c.criterion.name},
                 {"law", c.criterion.law},
                 {"strain_microstrain", finite_json(c.strain.best)},
                 {"allowable", finite_json(c.allowable.best)},
                 {"remaining", finite_json(c.remaining.best)},
                 {"remaining_years", finite_json(c.years.best)},
                 {"low", finite_json(c.years.low)},
                 {"high", finite_json(c.years.high)}};
    json["strain_low"] = finite_json(c.strain.low);
    json["strain_high"] = finite_json(c.strain.high);
    json["strain_if_wrong"] = {{"low", finite_json(c.strain.wide_low)}, {"high", finite_json(c.strain.wide_high)}};
    add_range(json, "allowable", c, c.allowable);
    add_range(json, "remaining", c, c.remaining);
    json["if_wrong"] = wide_json(c, c.years);
    json["if_wrong"]["held_by_data"] = c.short_is_held && c.long_is_held;
    json["distribution"] = Json::array();
    for (const auto& [repetitions, probability] : c.distribution) {
        json["distribution"].push_back({{"allowable", finite_json(repetitions)}, {"probability", probability}});
    }
    json["passed"] = c.criterion.passed;
    json["required"] = c.required;
    json["place"] = place_json(c.place);
    json["extrapolated"] = c.extrapolated();
    json["beyond_law"] = beyond_json(c);
    if (c.criterion.guide != nullptr) {
        json["used_for"] = {{"least", c.least()}, {"most", c.most()}};
        json["formula"] = std::string(c.criterion.guide->formula);
        json["source"] = std::string(c.criterion.guide->source);
    } else {
        json["formula"] = c.criterion.life->text();
    }
    return json;
}

// The step that narrows the life most.
Json next_json(const DesignResult& result) {
    constexpr std::size_t shown = 10;
    Json list = Json::array();
    for (std::size_t i = 0; i < std::min(shown, result.next.size()); ++i) {
        const analysis::NarrowingStep& step = result.next[i];
        Json json = {{"what", step.words()}, {"at_hand", step.is_at_hand}, {"left", step.left}};
        if (step.reading) {
            json["place"] = place_json(*step.reading);
        }
        const auto cost = result.overlay->cost();
        json["overlay_saved_mm"] = cost ? Json(*cost * (1.0 - step.left)) : Json(nullptr);
        list.push_back(std::move(json));
    }
    return list;
}

std::string range_words(const CriterionLife& c, const auto& words) {
    if (std::isnan(c.allowable.low)) {
        return "-";
    }
    const std::string low = words(c, c.allowable.low);
    const std::string high = words(c, c.allowable.high);
    return low == high ? low : fmt::format("{} to {}", low, high);
}

// The header and a row a criterion.
std::vector<std::vector<std::string>> table_of(const DesignResult& result) {
    std::vector<std::vector<std::string>> rows{{"criterion", "strain", "repeats", "95 %", "years", "95 %", "first"}};
    for (const CriterionLife& c : result.criteria) {
        rows.push_back({c.criterion.name, std::isnan(c.strain.best) ? "-" : figure(c.strain.best),
                        repetitions_words(c, c.allowable.best), range_words(c, analysis::repetitions_words),
                        years_words(c, c.allowable.best), range_words(c, analysis::years_words),
                        result.no_range.empty() ? fmt::format("{:.0f} %", 100.0 * c.governs) : "-"});
    }
    return rows;
}

} // namespace

Json design_json(const DesignResult& result, const analysis::RunOptions& run) {
    if (result.failed()) {
        return {{"status", "failed"}, {"reason", result.failure}};
    }
    const problem::Evaluation& best = result.answer.minima[0].evaluation;
    Json json = {
        {"status", "converged"},
        {"run", run.folder},
        {"study", study_json(result.study)},
        {"findings", findings(result)},
        {"best", {{"misfit", best.misfit}, {"parameters", parameters_json(result.study.space, best.parameters)}}},
        {"criteria", Json::array()},
        {"governs", Json::object()}};
    for (const CriterionLife& c : result.criteria) {
        json["criteria"].push_back(criterion_json(c));
        json["governs"][c.criterion.name] =
            result.no_range.empty() ? Json(c.governs) : Json(&c == &result.governing() ? 1.0 : 0.0);
    }
    const analysis::Overlay& overlay = *result.overlay;
    json["overlay_mm"] = {{"value", optional_json(overlay.best)},
                          {"low", optional_json(overlay.low)},
                          {"high", optional_json(overlay.high)},
                          {"at_reliability", optional_json(overlay.reliable)},
                          {"reliability_percent", result.options.reliability_percent},
                          {"layer", result.study.model.layers[0].name},
                          {"tried_up_to", overlay.most},
                          {"cost_of_what_is_open", optional_json(overlay.cost())}};
    json["next"] = next_json(result);
    json["seasons"] = Json::array();
    for (const auto& season : study::seasons_of(result.study)) {
        Json factors = Json::object();
        for (std::size_t i = 0; i < season.factors.size(); ++i) {
            factors[result.study.model.layers[i].name] = season.factors[i];
        }
        json["seasons"].push_back({{"name", season.name}, {"share", season.share}, {"factors", factors}});
    }
    json["strains_from_between"] = {{"runs", result.runs_between}, {"off", result.off_between}};
    json["computed"] = result.computed;
    json["kept"] = result.kept;
    json["seconds"] = result.seconds;
    return json;
}

Answer design_answer(const DesignResult& result, const analysis::RunOptions& run) {
    Answer answer;
    answer.verdict_and_notes(findings(result));
    answer.heading = "Lives (95 %): repetitions of the axle, years left, which criterion ends first";
    const auto table = table_of(result);
    answer.header = table.front();
    answer.rows.assign(table.begin() + 1, table.end());
    const auto deciding = std::find_if(answer.notes.begin(), answer.notes.end(), [](const std::string& words) {
        return words.starts_with("What would decide: ");
    });
    if (deciding != answer.notes.end()) {
        answer.next = "what would decide" + deciding->substr(deciding->find(':')) + "\n";
        answer.notes.erase(deciding);
    }
    answer.next +=
        (answer.next.empty() ? "" : "Page: ") + std::string("pavescape report ") + run::shell_word(run.folder);
    return answer;
}

std::string design_text(const DesignResult& result, const analysis::RunOptions& run) {
    const auto rows = table_of(result);
    Table table(rows.front());
    std::for_each(rows.begin() + 1, rows.end(), [&](const auto& row) { table.add(row); });
    const analysis::Overlay& overlay = *result.overlay;
    std::string mm = fmt::format("  overlay [mm]: {} at the best set", millimetres(overlay.best, overlay.most));
    if (result.no_range.empty()) {
        mm += fmt::format(", {} to {} (95 %), {} at {:g} %", millimetres(overlay.low, overlay.most),
                          millimetres(overlay.high, overlay.most), millimetres(overlay.reliable, overlay.most),
                          result.options.reliability_percent);
    }
    return fmt::format(
        "{}\n{}{}\n  strain in microstrain; repeats: allowable repetitions of the axle\n  results: {}/design.json\n",
        sentences(findings(result)), table.text(), mm, run.folder);
}

} // namespace explore::report
