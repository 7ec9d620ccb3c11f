#include "report/road.h"

#include "analysis/road/road_findings.h"
#include "analysis/survey/survey_findings.h"
#include "base/text.h"
#include "data/csv.h"
#include "report/answer.h"
#include "report/lives.h"
#include "report/survey.h"
#include "report/table.h"

#include <algorithm>
#include <fmt/format.h>

namespace explore::report {
namespace {

using analysis::CommonParameter;
using analysis::RoadResult;
using analysis::RoadStation;
using pave::figure;

constexpr std::string_view causes[] = {"sensor", "common-parameters", "unlike-neighbours", "not-explained"};

std::string_view level_of(const CommonParameter& p) {
    return p.section ? "section" : "shared";
}

Json range_json(const analysis::ParameterRange& range) {
    return {{"value", range.value}, {"low", range.low}, {"high", range.high}, {"determined", range.determined}};
}

Json common_json(const RoadResult& result, const CommonParameter& p) {
    Json json = {{"name", result.survey.study->space.axes[p.axis].name}};
    json.update(range_json(p.range));
    json["level"] = level_of(p);
    if (p.section) {
        json["section"] = *p.section;
    }
    json["stations"] = p.stations;
    json["width"] = p.width;
    json["median_width_alone"] = p.alone_width;
    json["narrower"] = p.narrower;
    json["determined_alone"] = p.alone_determined;
    return json;
}

Json against_road_json(const RoadResult& result, const RoadStation& s) {
    Json json = {{"section", s.section ? Json(*s.section) : Json(nullptr)},
                 {"chi2", s.chi2},
                 {"degrees_of_freedom", s.dof},
                 {"p_familywise", s.p_familywise},
                 {"outlier", s.is_outlier},
                 {"chi2_alone", s.chi2_alone}};
    const auto names = result.survey.parameter_names();
    for (std::size_t k = 0; k < names.size(); ++k) {
        json["alone"][names[k]] = range_json(s.alone[k]);
    }
    return json;
}

Json diagnosis_json(const analysis::RoadDiagnosis& d) {
    Json json = {{"verdict", diagnose::verdict_names[static_cast<int>(d.decision.verdict)]},
                 {"causes", Json::array()},
                 {"noise_factor", d.decision.noise_factor},
                 {"chi2", d.chi2},
                 {"degrees_of_freedom", d.dof},
                 {"p_value", d.p_value},
                 {"candidates", Json::array()}};
    for (const std::size_t cause : d.causes) {
        json["causes"].push_back(d.effects[cause].name);
    }
    for (const auto& e : d.effects) {
        Json one = {{"effect", e.name}, {"on", e.on}, {"score", e.score}, {"p_familywise", e.p_familywise}};
        if (e.chi2) {
            one["chi2"] = *e.chi2;
            one["p_value"] = e.p_value;
            one["size"] = e.size;
            one["size_low"] = e.low;
            one["size_high"] = e.high;
            one["words"] = e.words;
        }
        json["candidates"].push_back(std::move(one));
    }
    return json;
}

std::string number(double value) {
    return fmt::format("{}", value);
}

} // namespace

Json road_json(const RoadResult& result) {
    Json json = survey_json(result.survey);
    json["findings"] = analysis::findings_of(result);
    json["remarks"] = analysis::findings_of(result.survey);
    json["shared"] = Json::array();
    json["section_parameters"] = Json::array();
    for (const CommonParameter& p : result.common) {
        json[p.section ? "section_parameters" : "shared"].push_back(common_json(result, p));
    }
    json["landscape"] = Json::array();
    for (const analysis::CommonRegion& region : result.regions) {
        const auto& x = result.survey.study->space.axes[result.common[region.a].axis];
        const auto& y = result.survey.study->space.axes[result.common[region.b].axis];
        json["landscape"].push_back({{"x", x.name},
                                     {"y", y.name},
                                     {"log_x", x.scale == problem::Scale::log},
                                     {"log_y", y.scale == problem::Scale::log},
                                     {"border", region.border}});
    }
    for (const RoadStation& s : result.stations) {
        json["stations"][s.station]["road"] = against_road_json(result, s);
    }
    json["outliers"] = Json::array();
    for (const auto& o : result.outliers) {
        const RoadStation& s = result.stations[o.station];
        json["outliers"].push_back({{"station", result.survey.stations[s.station].station.name},
                                    {"chainage_m", optional_json(result.survey.stations[s.station].station.chainage_m)},
                                    {"chi2", s.chi2},
                                    {"degrees_of_freedom", s.dof},
                                    {"p_familywise", s.p_familywise},
                                    {"cause", std::string(causes[static_cast<int>(o.cause)])},
                                    {"reason", analysis::outlier_words(result, o)}});
    }
    json["chi2"] = result.chi2;
    json["degrees_of_freedom"] = result.dof;
    json["p_value"] = result.p_value;
    json["noise_factor"] = result.noise_factor();
    json["conflict"] = {
        {"chi2", result.conflict_chi2}, {"degrees_of_freedom", result.conflict_dof}, {"p_value", result.conflict_p}};
    json["weakest"] = {{"direction", result.weakest}, {"sd", result.weakest_sd}, {"condition", result.condition}};
    if (result.withheld) {
        const analysis::WithheldLevel& w = *result.withheld;
        json["withheld"] = {
            {"stations", w.stations},           {"readings", w.readings}, {"rms_percent", w.rms_percent},
            {"noise_percent", w.noise_percent}, {"chi2", w.chi2},         {"p_value", w.p_value},
            {"sensors", Json::array()}};
        for (const auto& s : w.sensors) {
            json["withheld"]["sensors"].push_back({{"offset_mm", s.offset_mm},
                                                   {"stations", s.stations},
                                                   {"mean_percent", s.mean_percent},
                                                   {"error_percent", s.error_percent},
                                                   {"p_familywise", s.p_familywise},
                                                   {"fitted_percent", s.fitted_percent},
                                                   {"load_percent", s.load_percent},
                                                   {"load_error_percent", s.load_error_percent},
                                                   {"load_p_familywise", s.load_p_familywise}});
        }
    }
    json["courses"] = Json::array();
    for (const auto& c : result.courses) {
        Json stations = Json::array();
        for (std::size_t i = 0; i < c.stations.size(); ++i) {
            Json one = {{"station", result.survey.stations[result.stations[c.stations[i]].station].station.name}};
            one.update(range_json(c.ranges[i]));
            stations.push_back(std::move(one));
        }
        json["courses"].push_back({{"name", result.survey.study->space.axes[c.axis].name},
                                   {"lane", c.lane},
                                   {"length_m", c.length_m},
                                   {"sd", c.sd},
                                   {"p_none", c.p_none},
                                   {"narrower", c.narrower},
                                   {"stations", std::move(stations)}});
    }
    if (result.diagnosis) {
        json["diagnosis"] = diagnosis_json(*result.diagnosis);
    }
    json["converged"] = result.converged;
    json["rounds"] = result.rounds;
    json["answer"] = answer_of("road", json).verdict;
    return json;
}

std::string road_csv(const RoadResult& result) {
    const auto names = result.survey.parameter_names();
    std::string text = "station,profile,lane,chainage_m,section,status,chi2,degrees_of_freedom,p_familywise,outlier";
    for (const std::string& name : names) {
        for (const std::string_view column :
             {"", " low", " high", " determined", " alone", " alone low", " alone high", " alone determined"}) {
            text += "," + data::csv_cell(name + std::string(column));
        }
    }
    for (const std::string& column : life_columns(result.survey)) {
        text += "," + data::csv_cell(column);
    }
    text += ",drops_used,file,line\n";
    for (const RoadStation& s : result.stations) {
        const analysis::StationResult& station = result.survey.stations[s.station];
        const data::FwdStation& f = station.station;
        std::vector<std::string> cells{f.name,
                                       f.profile,
                                       f.lane,
                                       f.chainage_m ? number(*f.chainage_m) : "",
                                       s.section ? std::to_string(*s.section + 1) : "",
                                       std::string(to_string(station.state)),
                                       number(s.chi2),
                                       number(s.dof),
                                       number(s.p_familywise),
                                       s.is_outlier ? "true" : "false"};
        for (std::size_t k = 0; k < names.size(); ++k) {
            for (const auto* range : {&station.fit->parameters[k], &s.alone[k]}) {
                cells.insert(cells.end(), {number(range->value), number(range->low), number(range->high),
                                           range->determined ? "true" : "false"});
            }
        }
        for (std::string& text_of_life : life_cells(result.survey, station)) {
            cells.push_back(std::move(text_of_life));
        }
        std::size_t drops = 0;
        for (const std::size_t level : station.used_levels()) {
            drops += station.bowls->levels[level].drops.size();
        }
        cells.insert(cells.end(), {std::to_string(drops), f.file, std::to_string(f.line)});
        for (std::size_t i = 0; i < cells.size(); ++i) {
            text += (i > 0 ? "," : "") + data::csv_cell(cells[i]);
        }
        text += "\n";
    }
    return text;
}

std::string road_text(const RoadResult& result) {
    const auto outliers =
        std::count_if(result.stations.begin(), result.stations.end(), [](const auto& s) { return s.is_outlier; });
    std::string text = fmt::format(
        "{} as one experiment, {} left out as outliers; {}\n\nWhat the stations have in common (95 % ranges; ?: not "
        "determined; times narrower: by standard errors)\n",
        pave::counted(result.stations.size(), "station", "stations"), outliers,
        result.converged ? fmt::format("converged in {} rounds", result.rounds) : "not converged");
    Table table({"", "value", "from", "to", "% of its box", "median station alone", "times narrower", "stations"});
    for (const CommonParameter& p : result.common) {
        table.add({common_name(result, p), figure(p.range.value) + (p.range.determined ? "" : " ?"),
                   figure(p.range.low), figure(p.range.high), fmt::format("{:.1f}", 100.0 * p.width),
                   fmt::format("{:.1f}", 100.0 * p.alone_width), fmt::format("{:.1f}", p.narrower),
                   std::to_string(p.stations)});
    }
    text += table.text() + "\nWhat that means\n";
    for (const std::string& words : analysis::findings_of(result)) {
        text += "  " + words + "\n";
    }
    return text + "\nThe stations\n" + survey_text(result.survey);
}

} // namespace explore::report
