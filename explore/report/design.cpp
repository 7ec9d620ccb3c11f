#include "report/design.h"

#include "base/text.h"
#include "report/text.h"

#include <cmath>
#include <fmt/format.h>

namespace explore::report {
namespace {

using analysis::CriterionLife;
using analysis::DesignResult;
using analysis::LifeRange;
using pave::figure;

Json number(double value) {
    return std::isfinite(value) ? Json(value) : Json(nullptr);
}

void add_range(Json& json, const std::string& name, const LifeRange& range) {
    json[name + "_low"] = number(range.low);
    json[name + "_high"] = number(range.high);
    json[name + "_if_wrong"] = {{"low", number(range.wide_low)}, {"high", number(range.wide_high)}};
}

Json criterion_json(const CriterionLife& c) {
    Json json = {{"name", c.criterion.name},
                 {"law", c.criterion.law},
                 {"strain_microstrain", number(c.strain.best)},
                 {"allowable", number(c.allowable.best)},
                 {"remaining", number(c.remaining.best)},
                 {"remaining_years", number(c.years.best)},
                 {"low", number(c.years.low)},
                 {"high", number(c.years.high)}};
    add_range(json, "strain", c.strain);
    add_range(json, "allowable", c.allowable);
    add_range(json, "remaining", c.remaining);
    json["if_wrong"] = {{"low", number(c.years.wide_low)}, {"high", number(c.years.wide_high)}};
    json["passed"] = c.criterion.passed;
    json["required"] = c.required;
    json["place"] = place_json(c.place);
    json["extrapolated"] = c.extrapolated;
    if (c.criterion.guide != nullptr) {
        json["formula"] = std::string(c.criterion.guide->formula);
        json["source"] = std::string(c.criterion.guide->source);
    } else {
        json["formula"] = c.criterion.life->text();
    }
    return json;
}

std::string repetitions_words(double value) {
    if (std::isnan(value) || value > 1e12) {
        return std::isnan(value) ? "-" : "> 1e12";
    }
    std::string text = fmt::format("{:.2g}", value);
    if (const auto at = text.find("e+"); at != std::string::npos) { // 2.6e7, not 2.6e+07
        text.erase(at + 1, text[at + 2] == '0' ? 2 : 1);
    }
    return text;
}

std::string years_words(double value) {
    constexpr double long_time = 200.0;
    return std::isnan(value) ? "-" : value > long_time ? "> 200" : figure(value, 2);
}

std::string range_words(const LifeRange& range, const auto& words) {
    if (std::isnan(range.low)) {
        return "-";
    }
    const std::string low = words(range.low);
    const std::string high = words(range.high);
    return low == high ? low : fmt::format("{} to {}", low, high);
}

std::string millimetres(const std::optional<double>& mm, double most) {
    return mm ? fmt::format("{:.0f}", *mm) : fmt::format("> {:g}", most);
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
                          {"tried_up_to", overlay.most}};
    json["computed"] = result.computed;
    json["kept"] = result.kept;
    json["seconds"] = result.seconds;
    return json;
}

std::string design_text(const DesignResult& result, const analysis::RunOptions& run) {
    Table table({"criterion", "strain", "repeats", "95 %", "years", "95 %", "first"});
    for (const CriterionLife& c : result.criteria) {
        table.add({c.criterion.name, std::isnan(c.strain.best) ? "-" : figure(c.strain.best),
                   repetitions_words(c.allowable.best), range_words(c.allowable, repetitions_words),
                   years_words(c.years.best), range_words(c.years, years_words),
                   result.no_range.empty() ? fmt::format("{:.0f} %", 100.0 * c.governs) : "-"});
    }
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
