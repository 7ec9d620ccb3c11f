#include "report/survey.h"

#include "analysis/survey/survey_findings.h"
#include "analysis/survey/weak_stations.h"
#include "base/units.h"
#include "data/csv.h"
#include "report/condition.h"
#include "report/figure.h"
#include "report/lives.h"

#include <algorithm>
#include <fmt/format.h>
#include <set>

namespace explore::report {
namespace {

using analysis::StationResult;
using analysis::StationState;
using analysis::SurveyResult;

constexpr std::string_view temperature_sources[] = {"measured", "BELLS3", "BELLS3, with the air of the hour"};

bool d250_is_interpolated(const StationResult& s) {
    return !s.bowl().has_sensor_at(data::ratio_offset_mm);
}

std::vector<int> drops_used(const StationResult& s) {
    std::vector<int> drops;
    for (const std::size_t level : s.used_levels()) {
        drops.insert(drops.end(), s.bowls->levels[level].drops.begin(), s.bowls->levels[level].drops.end());
    }
    std::sort(drops.begin(), drops.end());
    return drops;
}

std::vector<int> drops_left_out(const StationResult& s) {
    const auto used = drops_used(s);
    std::vector<int> drops;
    for (const data::FwdDrop& drop : s.station.drops) {
        if (std::find(used.begin(), used.end(), drop.number) == used.end()) {
            drops.push_back(drop.number);
        }
    }
    return drops;
}

Json indices_json(const StationResult& s) {
    const data::BowlIndices& indices = *s.indices;
    Json json = {{"pressure_kPa", s.normalised_kPa},
                 {"D0_um", indices.d0_um},
                 {"SCI_um", optional_json(indices.sci_um)},
                 {"BDI_um", optional_json(indices.bdi_um)},
                 {"BCI_um", optional_json(indices.bci_um)},
                 {"AREA_mm", optional_json(indices.area_mm)},
                 {"curvature_radius_m", optional_json(indices.curvature_radius_m)},
                 {"Evd_MPa", optional_json(indices.evd_MPa)},
                 {"surface_moduli", Json::array()}};
    for (const auto& m : indices.surface_moduli) {
        json["surface_moduli"].push_back({{"offset_mm", m.offset_mm}, {"modulus_MPa", m.modulus_MPa}});
    }
    return json;
}

Json readings_json(const StationResult& s, std::size_t level, const std::vector<double>* model_um) {
    Json readings = Json::array();
    const auto& bowl = s.bowls->levels[level];
    for (std::size_t i = 0; i < bowl.readings.size(); ++i) {
        Json reading = {{"offset_mm", bowl.readings[i].offset_mm}, {"measured_um", bowl.readings[i].deflection_um}};
        if (bowl.readings[i].scatter) {
            reading["scatter"] = *bowl.readings[i].scatter;
        }
        if (model_um != nullptr) {
            reading["model_um"] = (*model_um)[i];
        }
        readings.push_back(std::move(reading));
    }
    return readings;
}

Json held_by_json(const study::Study& study, const analysis::StationFit& fit) {
    Json texts = Json::array();
    for (const std::size_t i : fit.held_by) {
        texts.push_back(study.constraints[i].text);
    }
    return texts;
}

void add_fit(const SurveyResult& result, const StationResult& s, Json& json) {
    const analysis::StationFit& fit = *s.fit;
    const landscape::Minimum& best = fit.best;
    // Indices are no back-calculation and must not be read as one.
    json[s.is_fitted() ? "fit" : "attempt"] = {
        {"parameters", parameters_json(result.study->space, best.evaluation.parameters)},
        {"misfit", best.evaluation.misfit},
        {"rms_percent", fit.rms_percent},
        {"status", std::string(to_string(best.evaluation.status))},
        {"converged", best.converged},
        {"on_bound", bound_words(result.study->space, best.on_bound)},
        {"held_by", held_by_json(*result.study, fit)},
        {"starts", fit.starts},
        {"starts_in_best", best.members.size()},
        {"minima", fit.minima},
        {"chi2", fit.local.chi2},
        {"degrees_of_freedom", fit.local.degrees_of_freedom},
        {"p_value", fit.local.p_value},
        {"warnings", warnings_json(best.evaluation)}};
    if (s.is_fitted()) {
        const auto names = result.parameter_names();
        for (std::size_t k = 0; k < names.size(); ++k) {
            const auto& p = fit.parameters[k];
            json["parameters"][names[k]] = {
                {"value", p.value}, {"low", p.low}, {"high", p.high}, {"determined", p.determined}};
        }
        const auto outputs = result.outputs();
        for (std::size_t o = 0; o < fit.outputs.size(); ++o) {
            const auto& p = fit.outputs[o];
            json["outputs"][outputs[o].output] = {
                {"value", outputs[o].in_unit(p.value)},
                {"low", p.determined ? Json(outputs[o].in_unit(p.low)) : Json(nullptr)},
                {"high", p.determined ? Json(outputs[o].in_unit(p.high)) : Json(nullptr)},
                {"unit", std::string(outputs[o].unit.name)},
                {"determined", p.determined}};
        }
        if (fit.lives) {
            json["lives"] = lives_json(*fit.lives);
        }
    }
}

Json station_json(const SurveyResult& result, const StationResult& s) {
    const auto& f = s.station;
    Json json = {{"station", f.name},
                 {"profile", f.profile},
                 {"lane", f.lane},
                 {"chainage_m", optional_json(f.chainage_m)},
                 {"file", f.file},
                 {"line", f.line},
                 {"date", f.date},
                 {"time", f.time},
                 {"latitude", optional_json(f.latitude)},
                 {"longitude", optional_json(f.longitude)},
                 {"comment", f.comment},
                 {"air_C", optional_json(f.air_C)},
                 {"surface_C", optional_json(f.surface_C)},
                 {"asphalt_C", s.asphalt ? Json(s.asphalt->celsius) : Json(nullptr)},
                 {"drops", f.drops.size()},
                 {"status", std::string(to_string(s.state))},
                 {"reason", analysis::reason_of(s)},
                 {"remarks", analysis::remarks_of(result, s)},
                 {"drops_used", drops_used(s)},
                 {"drops_left_out", drops_left_out(s)},
                 {"parameters", Json::object()},
                 {"outputs", Json::object()}};
    if (s.asphalt) {
        json["asphalt_C_source"] = std::string(temperature_sources[static_cast<int>(s.asphalt->source)]);
    }
    json["layers"] = Json::object(); // that the station states
    for (const auto& [layer, stated] : f.layers) {
        json["layers"][layer] = {{"thickness_mm", stated.mm},
                                 {"sd_mm", optional_json(stated.sd_mm)},
                                 {"source", stated.is_from_table ? "table" : "station"}};
    }
    if (!s.has_bowl()) {
        return json;
    }
    const auto& bowl = s.bowl();
    json["radius_mm"] = bowl.radius_mm;
    json["pressure_kPa"] = bowl.pressure_kPa;
    json["D0_um"] = bowl.d0_um();
    json["D0_um_at_common_pressure"] = result.d0_at_common(s);
    json["D250_um"] = optional_json(bowl.at(data::ratio_offset_mm));
    json["D250_is_interpolated"] = s.ratio() ? Json(d250_is_interpolated(s)) : Json(nullptr);
    json["deflection_ratio"] = optional_json(s.ratio());
    json["deflection_ratio_reason"] = analysis::why_no_ratio(s);
    json["pass"] = s.passes() ? Json(*s.passes()) : Json(nullptr);
    json["normalised"] = indices_json(s);
    json["condition"] = condition_json(s);
    json["structural_number"] = structural_json(result, s);
    json["at_reference"] = reference_json(result, s);
    json["readings_left_out"] = Json::array();
    for (const auto& r : s.bowls->readings_left_out) {
        json["readings_left_out"].push_back(
            {{"drop", r.drop}, {"offset_mm", r.offset_mm}, {"read_um", r.read_um}, {"repeats_um", r.repeats_um}});
    }
    json["drops_disagree"] = Json::array();
    for (const auto& d : s.bowls->disagreements) {
        json["drops_disagree"].push_back(
            {{"offset_mm", d.offset_mm}, {"percent", 100.0 * d.share}, {"low_um", d.low_um}, {"high_um", d.high_um}});
    }
    const auto levels = s.used_levels();
    for (std::size_t i = 0; i < levels.size(); ++i) {
        const auto* model = s.fit ? &s.fit->model_um[i] : nullptr;
        if (levels[i] == s.bowls->main) {
            json["readings"] = readings_json(s, levels[i], model);
        }
        json["levels"].push_back({{"pressure_kPa", s.bowls->levels[levels[i]].pressure_kPa},
                                  {"drops", s.bowls->levels[levels[i]].drops},
                                  {"readings", readings_json(s, levels[i], model)}});
    }
    if (s.fit) {
        add_fit(result, s, json);
    }
    if (s.asphalt_at_reference_MPa) {
        json["asphalt_modulus_at_reference_MPa"] = *s.asphalt_at_reference_MPa;
    }
    return json;
}

Json percentiles_json(const analysis::Percentiles& p) {
    return p.stations == 0 ? Json(nullptr)
                           : Json{{"p15", p.p15}, {"p50", p.p50}, {"p85", p.p85}, {"stations", p.stations}};
}

Json sections_json(const SurveyResult& result) {
    Json sections = Json::array();
    const auto names = result.parameter_names();
    for (const auto& section : result.sections) {
        Json json = {{"profile", section.profile},
                     {"lane", section.lane},
                     {"from_m", *result.stations[section.first].station.chainage_m},
                     {"to_m", *result.stations[section.last].station.chainage_m},
                     {"from_station", result.stations[section.first].station.name},
                     {"to_station", result.stations[section.last].station.name},
                     {"stations", section.d0_um.stations},
                     {"fitted", section.fitted},
                     {"D0_um", percentiles_json(section.d0_um)},
                     {"characteristic", characteristic_json(result, section)}};
        for (std::size_t k = 0; k < names.size(); ++k) {
            json["parameters"][names[k]] = percentiles_json(section.parameters[k]);
        }
        if (result.has_lives()) {
            json["life"] = section_life_json(result, section);
        }
        sections.push_back(std::move(json));
    }
    return sections;
}

// Distances of all sensors that were read, of the level that counts.
std::set<double> all_offsets(const SurveyResult& result) {
    std::set<double> offsets;
    for (const StationResult& s : result.stations) {
        for (std::size_t i = 0; s.has_bowl() && i < s.bowl().readings.size(); ++i) {
            offsets.insert(s.bowl().readings[i].offset_mm);
        }
    }
    return offsets;
}

std::string in_one_cell(const std::vector<int>& numbers) {
    std::string text;
    for (const int n : numbers) {
        text += (text.empty() ? "" : " ") + std::to_string(n);
    }
    return text;
}

Json weak_json(const SurveyResult& result) {
    const auto weak = analysis::weak_stations(result);
    if (!weak) {
        return nullptr;
    }
    Json json = Json::array();
    for (const auto& w : *weak) {
        json.push_back({{"station", w.station},
                        {"times_median", w.d0_ratio},
                        {"parameter", w.parameter ? Json(result.parameter_names()[*w.parameter]) : Json(nullptr)},
                        {"parameter_times_median", w.parameter ? Json(w.parameter_ratio) : Json(nullptr)}});
    }
    return json;
}

} // namespace

Json survey_json(const SurveyResult& result) {
    const analysis::SurveyCounts counts = result.counts();
    Json json = {{"stations", Json::array()},
                 {"counts",
                  {{"stations", result.stations.size()},
                   {"rejected", counts.rejected},
                   {"pass", counts.pass},
                   {"fail", counts.fail},
                   {"no_ratio", counts.no_ratio},
                   {"fitted", counts.fitted},
                   {"doubtful", counts.doubtful},
                   {"no_fit", counts.no_fit},
                   {"failed", counts.failed}}},
                 {"findings", analysis::findings_of(result)},
                 {"deflection_ratio",
                  {{"definition", ratio_words},
                   {"limit", data::deflection_ratio_limit},
                   {"interpolation", interpolation_words}}},
                 {"common_pressure_kPa", result.common_pressure_kPa},
                 {"reference_C", optional_json(result.reference_C)},
                 {"temperature_curve",
                  result.reference_C ? Json(std::string(data::words_of(result.curve).name)) : Json(nullptr)},
                 {"repeatability", optional_json(result.repeatability)},
                 {"noise_factor", result.noise_factor},
                 {"sections", sections_json(result)}};
    for (const StationResult& s : result.stations) {
        json["stations"].push_back(station_json(result, s));
    }
    json["weak_stations"] = weak_json(result);
    json["suspect_sensor"] = nullptr;
    if (result.suspect) {
        const auto& s = *result.suspect;
        json["suspect_sensor"] = {{"offset_mm", s.offset_mm},         {"stations", s.stations},
                                  {"same_sign", s.same_sign},         {"p", s.p},
                                  {"model_percent", s.model_percent}, {"fits_at_mm", optional_json(s.fits_at_mm)}};
    }
    json["sensor_residuals"] = Json::array();
    for (const auto& r : result.residuals) {
        json["sensor_residuals"].push_back({{"offset_mm", r.offset_mm},
                                            {"stations", r.stations},
                                            {"above", r.above},
                                            {"model_percent", r.percent},
                                            {"scatter_percent", r.scatter_percent},
                                            {"one_sign", r.one_sign}});
    }
    json["load_residuals"] = Json::array();
    for (const auto& r : result.load_residuals) {
        json["load_residuals"].push_back({{"pressure_kPa", r.pressure_kPa},
                                          {"stations", r.stations},
                                          {"above", r.above},
                                          {"model_percent", r.percent},
                                          {"scatter_percent", r.scatter_percent},
                                          {"one_sign", r.one_sign}});
    }
    json["section_is_suspect"] = result.section_is_suspect;
    json["section_trials"] = Json::array();
    for (const auto& t : result.trials) {
        json["section_trials"].push_back({{"section", t.words},
                                          {"stations", t.stations},
                                          {"rms_percent", t.rms_percent},
                                          {"rms_percent_of_study", t.rms_percent_of_study},
                                          {"misfit_ratio", t.misfit_ratio}});
    }
    json["better_layout"] = nullptr;
    if (result.layout) {
        const auto& l = *result.layout;
        json["better_layout"] = {{"offsets_mm", l.offsets_mm},
                                 {"stations", l.stations},
                                 {"rms_percent", l.rms_percent},
                                 {"rms_percent_of_file", l.rms_percent_of_file},
                                 {"misfit_ratio", l.misfit_ratio}};
    }
    if (result.study) {
        const study::Study& study = *result.study;
        json["study"] = study_json(study);
        json["misfit_kind"] = std::string(to_string(study.data.misfit));
        json["explored_points"] = analysis::survey_explored_points;
        json["fits_all_levels"] = result.fits_all_levels;
    }
    return json;
}

std::string survey_csv(const SurveyResult& result) {
    std::vector<std::string> header = {"station",
                                       "profile",
                                       "lane",
                                       "chainage_m",
                                       "status",
                                       "reason",
                                       "radius_mm",
                                       "pressure_kPa",
                                       "D0_um",
                                       "D0_um_at_common_pressure",
                                       "D250_um",
                                       "D250_is_interpolated",
                                       "deflection_ratio",
                                       "verdict",
                                       "verdict_reason",
                                       "normalised_to_kPa",
                                       "normalised_D0_um",
                                       "SCI_um",
                                       "BDI_um",
                                       "BCI_um",
                                       "AREA_mm",
                                       "curvature_radius_m",
                                       "surface_modulus_MPa"};
    const auto offsets = all_offsets(result);
    for (const double offset : offsets) {
        header.push_back(fmt::format("measured_D{:g}_um", offset));
    }
    const auto names = result.parameter_names();
    for (const std::string& name : names) {
        header.insert(header.end(), {name, name + " low", name + " high", name + " determined"});
    }
    const auto outputs = result.outputs();
    for (const auto& output : outputs) {
        const std::string name = fmt::format("{} [{}]", output.output, output.unit.name);
        header.insert(header.end(), {name, name + " low", name + " high"});
    }
    for (std::string& column : life_columns(result)) {
        header.push_back(std::move(column));
    }
    if (result.study) {
        header.insert(header.end(),
                      {"misfit", "rms_percent", "converged", "on_bound", "asphalt_modulus_at_reference_MPa"});
    }
    if (result.reference_C) {
        header.insert(header.end(),
                      {"D0_um_at_reference", "SCI_um_at_reference", "BDI_um_at_reference", "BCI_um_at_reference"});
    }
    header.insert(header.end(), {"air_C", "surface_C", "asphalt_C", "asphalt_C_source", "latitude", "longitude", "date",
                                 "time", "comment", "drops_used", "drops_left_out", "remarks", "file", "line"});
    std::string text;
    const auto add = [&](const std::vector<std::string>& cells) {
        for (std::size_t i = 0; i < cells.size(); ++i) {
            text += (i > 0 ? "," : "") + data::csv_cell(cells[i]);
        }
        text += "\n";
    };
    add(header);
    for (const StationResult& s : result.stations) {
        const auto& f = s.station;
        std::vector<std::string> cells = {
            f.name, f.profile, f.lane, cell(f.chainage_m), std::string(to_string(s.state)), analysis::reason_of(s)};
        if (s.has_bowl()) {
            const auto& bowl = s.bowl();
            const auto& indices = *s.indices;
            cells.insert(cells.end(), {cell(bowl.radius_mm), cell(bowl.pressure_kPa), cell(bowl.d0_um()),
                                       cell(result.d0_at_common(s)), cell(bowl.at(data::ratio_offset_mm)),
                                       !s.ratio()                ? ""
                                       : d250_is_interpolated(s) ? "true"
                                                                 : "false",
                                       cell(s.ratio()), std::string(analysis::verdict(s)), analysis::why_no_ratio(s),
                                       cell(s.normalised_kPa), cell(indices.d0_um), cell(indices.sci_um),
                                       cell(indices.bdi_um), cell(indices.bci_um), cell(indices.area_mm),
                                       cell(indices.curvature_radius_m), cell(indices.surface_moduli[0].modulus_MPa)});
            for (const double offset : offsets) {
                cells.push_back(bowl.has_sensor_at(offset) ? cell(bowl.at(offset)) : "");
            }
        } else {
            cells.resize(cells.size() + 17 + offsets.size());
        }
        if (s.is_fitted()) {
            for (const auto& p : s.fit->parameters) {
                cells.insert(cells.end(), {cell(p.value), cell(p.low), cell(p.high), p.determined ? "true" : "false"});
            }
        } else {
            cells.resize(cells.size() + 4 * names.size());
        }
        for (std::size_t o = 0; o < outputs.size(); ++o) {
            if (!s.is_fitted() || s.fit->outputs.empty()) {
                cells.resize(cells.size() + 3);
                continue;
            }
            const auto& p = s.fit->outputs[o];
            cells.insert(cells.end(),
                         {cell(outputs[o].in_unit(p.value)), p.determined ? cell(outputs[o].in_unit(p.low)) : "",
                          p.determined ? cell(outputs[o].in_unit(p.high)) : ""});
        }
        for (std::string& text_of_life : life_cells(result, s)) {
            cells.push_back(std::move(text_of_life));
        }
        if (result.study && s.fit) {
            const landscape::Minimum& best = s.fit->best;
            cells.insert(cells.end(),
                         {cell(best.evaluation.misfit), cell(s.fit->rms_percent), best.converged ? "true" : "false",
                          pave::join(bound_words(result.study->space, best.on_bound)),
                          cell(s.asphalt_at_reference_MPa)});
        } else if (result.study) {
            cells.resize(cells.size() + 5);
        }
        if (result.reference_C) {
            const auto at = s.at_reference.value_or(data::IndicesAtReference{});
            cells.insert(cells.end(), {cell(at.d0_um), cell(at.sci_um), cell(at.bdi_um), cell(at.bci_um)});
        }
        cells.insert(cells.end(),
                     {cell(f.air_C), cell(f.surface_C), s.asphalt ? cell(s.asphalt->celsius) : "",
                      s.asphalt ? std::string(temperature_sources[static_cast<int>(s.asphalt->source)]) : "",
                      cell(f.latitude), cell(f.longitude), f.date, f.time, f.comment, in_one_cell(drops_used(s)),
                      in_one_cell(drops_left_out(s)), pave::join(analysis::remarks_of(result, s), "; "), f.file,
                      std::to_string(f.line)});
        add(cells);
    }
    return text;
}

} // namespace explore::report
