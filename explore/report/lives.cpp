#include "report/lives.h"

#include "analysis/survey/survey_lives.h"
#include "base/text.h"
#include "report/figure.h"
#include "report/text.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace explore::report {
namespace {

using analysis::CriterionLife;
using analysis::StationLives;
using analysis::StationResult;
using analysis::SurveyResult;

const StationLives* lives_of(const StationResult& s) {
    return s.is_fitted() && s.fit->lives ? &*s.fit->lives : nullptr;
}

std::string years_with_range(const CriterionLife& c) {
    const std::string best = analysis::years_words(c, c.allowable.best);
    return std::isnan(c.allowable.low) ? best
                                       : fmt::format("{} ({} to {})", best, analysis::years_words(c, c.allowable.low),
                                                     analysis::years_words(c, c.allowable.high));
}

} // namespace

std::vector<std::string> criteria_names(const SurveyResult& result) {
    std::vector<std::string> names;
    for (const StationResult& s : result.stations) {
        if (const StationLives* lives = lives_of(s)) {
            for (const CriterionLife& c : lives->criteria) {
                names.push_back(c.criterion.name);
            }
            break;
        }
    }
    return names;
}

Json lives_json(const StationLives& lives) {
    Json json = {{"ends_first", lives.first().criterion.name},
                 {"years", finite_json(lives.first().years.best)},
                 {"years_low", finite_json(lives.first().years.low)},
                 {"years_high", finite_json(lives.first().years.high)},
                 {"overlay_mm",
                  {{"value", optional_json(lives.overlay.best)},
                   {"low", optional_json(lives.overlay.low)},
                   {"high", optional_json(lives.overlay.high)},
                   {"at_reliability", optional_json(lives.overlay.reliable)},
                   {"reliability_percent", analysis::usual_reliability_percent},
                   {"tried_up_to", lives.overlay.most}}},
                 {"criteria", Json::object()}};
    for (const CriterionLife& c : lives.criteria) {
        json["criteria"][c.criterion.name] = {{"strain_microstrain", finite_json(c.strain.best)},
                                              {"allowable", finite_json(c.allowable.best)},
                                              {"allowable_low", finite_json(c.allowable.low)},
                                              {"allowable_high", finite_json(c.allowable.high)},
                                              {"years", finite_json(c.years.best)},
                                              {"years_low", finite_json(c.years.low)},
                                              {"years_high", finite_json(c.years.high)},
                                              {"required", c.required},
                                              {"extrapolated", c.extrapolated()},
                                              {"place", place_json(c.place)}};
    }
    return json;
}

Json section_life_json(const SurveyResult& result, const analysis::RoadSection& section) {
    const auto life = analysis::life_of_section(result, section);
    return !life ? Json(nullptr)
                 : Json{{"stations", life->stations},
                        {"years", finite_json(life->years)},
                        {"years_low", finite_json(life->years_low)},
                        {"years_high", finite_json(life->years_high)},
                        {"overlay_mm", optional_json(life->overlay_mm)},
                        {"overlay_mm_at_reliability", optional_json(life->overlay_reliable_mm)}};
}

std::vector<std::string> life_columns(const SurveyResult& result) {
    const auto names = criteria_names(result);
    std::vector<std::string> columns;
    if (names.empty()) {
        return columns;
    }
    for (const std::string& name : names) {
        columns.insert(columns.end(),
                       {name + " repetitions", name + " years", name + " years low", name + " years high"});
    }
    columns.insert(columns.end(), {"ends_first", "overlay_mm", "overlay_mm low", "overlay_mm high",
                                   fmt::format("overlay_mm at {:g} %", analysis::usual_reliability_percent)});
    return columns;
}

std::vector<std::string> life_cells(const SurveyResult& result, const StationResult& station) {
    std::vector<std::string> cells;
    const StationLives* lives = lives_of(station);
    if (lives == nullptr) {
        cells.resize(life_columns(result).size());
        return cells;
    }
    for (const CriterionLife& c : lives->criteria) {
        cells.insert(cells.end(), {cell(c.allowable.best), cell(c.years.best), cell(c.years.low), cell(c.years.high)});
    }
    const analysis::Overlay& overlay = lives->overlay;
    cells.insert(cells.end(), {lives->first().criterion.name, cell(overlay.best), cell(overlay.low), cell(overlay.high),
                               cell(overlay.reliable)});
    return cells;
}

void add_life_properties(const StationResult& station, Json& properties) {
    if (const StationLives* lives = lives_of(station)) {
        const CriterionLife& first = lives->first();
        properties["ends_first"] = first.criterion.name;
        properties["years"] = finite_json(first.years.best);
        properties["years low"] = finite_json(first.years.low);
        properties["years high"] = finite_json(first.years.high);
        properties["overlay_mm"] = optional_json(lives->overlay.best);
        properties["overlay_mm low"] = optional_json(lives->overlay.low);
        properties["overlay_mm high"] = optional_json(lives->overlay.high);
        properties[fmt::format("overlay_mm at {:g} %", analysis::usual_reliability_percent)] =
            optional_json(lives->overlay.reliable);
    }
}

std::string life_table(const SurveyResult& result) {
    Table table({"station", "ends first", "years left (95 %)", "overlay mm",
                 fmt::format("mm at {:g} %", analysis::usual_reliability_percent)});
    for (const StationResult& s : result.stations) {
        if (!s.is_fitted()) {
            continue;
        }
        const StationLives* lives = lives_of(s);
        if (lives == nullptr) {
            table.add({s.station.name, "no answer", "", "", ""});
            continue;
        }
        table.add({s.station.name, lives->first().criterion.name, years_with_range(lives->first()),
                   millimetres(lives->overlay.best, lives->overlay.most),
                   lives->has_range ? millimetres(lives->overlay.reliable, lives->overlay.most) : "?"});
    }
    return table.text();
}

std::string section_life_table(const SurveyResult& result) {
    Table table({"from m", "to m", "stations", "years that 85 % exceed", "overlay mm enough at 85 %",
                 fmt::format("mm at {:g} %", analysis::usual_reliability_percent)});
    for (const auto& section : result.sections) {
        const auto life = analysis::life_of_section(result, section);
        if (!life) {
            continue;
        }
        // With the words of a criterion's years: long is as good as for ever.
        const auto years = [](double value) {
            constexpr double longest = 200.0;
            return value > longest ? fmt::format("> {:g}", longest) : pave::figure(value, 2);
        };
        const auto thickness = [](const std::optional<double>& mm) {
            return mm ? fmt::format("{:.0f}", *mm) : std::string("> 400");
        };
        table.add({fmt::format("{:g}", *result.stations[section.first].station.chainage_m),
                   fmt::format("{:g}", *result.stations[section.last].station.chainage_m),
                   std::to_string(life->stations),
                   fmt::format("{} ({} to {})", years(life->years), years(life->years_low), years(life->years_high)),
                   thickness(life->overlay_mm), thickness(life->overlay_reliable_mm)});
    }
    return table.text();
}

} // namespace explore::report
