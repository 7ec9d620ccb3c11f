#include "report/diagnose.h"

#include "analysis/diagnose/diagnose_verdict.h"
#include "analysis/explore/build.h"
#include "base/text.h"
#include "base/units.h"
#include "pavement/effects/effect.h"
#include "report/text.h"
#include "run/files.h"
#include "run/progress.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace explore::report {
namespace {

using analysis::DiagnosedModel;
using analysis::DiagnoseResult;
using analysis::members_words;
using analysis::SeparatingReading;
using diagnose::Diagnosis;
using diagnose::Judged;

// Where the extended study of a run stands.
std::string extended_path(const DiagnoseResult& result, const analysis::RunOptions& run) {
    return result.is_extended() ? run.folder + "/extended.toml" : "";
}

Json judged_json(const Judged& judged, double misfit, const std::string& study_path) {
    return {{"misfit", misfit},          {"chi2", judged.chi2}, {"dof", judged.dof},
            {"p_value", judged.p_value}, {"aicc", judged.aicc}, {"p_pattern", judged.pattern.p_value},
            {"study", study_path}};
}

Json intervals_json(const problem::ParameterSpace& space, const std::vector<diagnose::Interval>& intervals) {
    Json json = Json::object();
    for (std::size_t k = 0; k < intervals.size(); ++k) {
        json[space.axes[k].name] = {
            {"value", intervals[k].value}, {"low", intervals[k].low}, {"high", intervals[k].high}};
    }
    return json;
}

Json held_out_json(const diagnose::HeldOut& held) {
    Json folds = Json::array();
    for (const auto& fold : held.folds) {
        folds.push_back({{"left_out", fold.name}, {"rmse_before", fold.before}, {"rmse_after", fold.after}});
    }
    return {{"rmse_before", held.before}, {"rmse_after", held.after}, {"readings", held.readings}, {"folds", folds}};
}

// A reading that could be taken.
Json measurement_json(const data::Reading& reading) {
    Json json = place_json(reading);
    json.update({{"reading", reading.words()},
                 {"unit", reading.unit.name},
                 {"sigma", reading.in_unit(reading.noise.absolute)}});
    return json;
}

Json separating_json(const SeparatingReading& s, const std::vector<diagnose::Candidate>& candidates,
                     const Diagnosis& d) {
    Json predicted = Json::array();
    for (std::size_t e = 0; e < s.values.size(); ++e) {
        predicted.push_back(
            {{"explanation", members_words(candidates, d.to_compare()[s.explanations[e]].fit.model.members)},
             {"value", s.values[e]}});
    }
    Json json = measurement_json(s.reading);
    json["reading"] = s.words();
    json["again"] = s.again;
    json.update({{"power", s.again ? Json(nullptr) : Json(s.power)},
                 {"rate_now", s.again ? Json(nullptr) : Json(s.rate_now)},
                 {"predicted", predicted}});
    return json;
}

Json telling_json(const analysis::TellingReading& telling) {
    Json json = measurement_json(telling.reading);
    json["bits"] = telling.bits;
    return json;
}

Json channel_json(const pave::pavement::Correction& correction) {
    return {{"channel", std::string(info(correction.channel).name)}, {"layer", correction.layer}};
}

Json corrections_json(const DiagnoseResult& f) {
    Json list = Json::array();
    for (std::size_t i = 0; i < f.located.size(); ++i) {
        const analysis::LocatedCorrection& found = f.located[i];
        const diagnose::Correction& own = f.diagnosis.location->corrections[i];
        const auto& channel = info(found.correction.channel);
        Json json = channel_json(found.correction);
        json["name"] = found.correction.name();
        json["p_familywise"] = own.p_familywise;
        json["log_evidence_ratio"] = own.log_ratio;
        json["strength"] = own.strength;
        json["unit"] = std::string(channel.unit);
        for (const char* key : {"at", "values", "low", "high", "modulus_MPa", "variance_left", "seen"}) {
            json[key] = Json::array();
        }
        for (const analysis::LocatedPlace& place : found.places) {
            json["at"].push_back(place.at);
            json["values"].push_back(place.value);
            json["low"].push_back(place.low);
            json["high"].push_back(place.high);
            if (channel.of_layer) {
                json["modulus_MPa"].push_back(place.modulus / pave::unit::MPa);
            }
            json["variance_left"].push_back(place.variance_left);
            json["seen"].push_back(place.seen());
        }
        json["contrast"] = contrast_json(found);
        json["alike"] = Json::array();
        for (const std::size_t c : own.alike) {
            json["alike"].push_back(channel_json(f.corrections[c]));
        }
        json["explained_by"] = Json::array();
        for (const diagnose::Likeness& like : own.explained_by) {
            const auto& candidate = f.candidates[f.diagnosis.effects[like.effect].candidate];
            json["explained_by"].push_back({{"effect", candidate.effect},
                                            {"on", candidate.on},
                                            {"share", like.share},
                                            {"leaves_noise", like.leaves_noise}});
        }
        list.push_back(std::move(json));
    }
    return list;
}

Json hypotheses_json(const Diagnosis& d) {
    Json list = Json::array();
    for (const auto& [r, probability] : d.decision.hypotheses) {
        const diagnose::Row& row = d.ledger.rows()[r];
        Json json = {{"kind", std::string(hypotheses::kind_names[static_cast<int>(row.hypothesis.kind)])},
                     {"name", row.hypothesis.name},
                     {"in_words", analysis::row_words(row)},
                     {"probability", probability}};
        if (row.is_premise) {
            json.update({{"premise", true}, {"log_evidence", nullptr}, {"chi2", nullptr}, {"p_value", nullptr}});
        } else {
            json.update({{"log_evidence", row.log_evidence},
                         {"chi2", row.fit.chi2},
                         {"p_value", row.fit.p_value},
                         {"noise", row.noise}});
        }
        json["sizes"] = Json::object();
        for (const diagnose::Sized& size : row.sizes) {
            json["sizes"][size.name] = {{"value", size.value}, {"low", size.low}, {"high", size.high}};
        }
        list.push_back(std::move(json));
    }
    if (const auto& other = d.ledger.elsewhere()) { // beside the most probable one
        list.push_back({{"kind", "effect"},
                        {"name", other->words},
                        {"in_words", other->words},
                        {"probability", other->probability},
                        {"elsewhere", true},
                        {"log_evidence", nullptr},
                        {"chi2", nullptr},
                        {"p_value", nullptr},
                        {"sizes", Json::object()}});
    }
    return list;
}

Json diagnosis_json(const DiagnoseResult& f, const std::string& extended_path) {
    const Diagnosis& d = f.diagnosis;
    const bool is_extended = f.is_extended();
    const DiagnosedModel& before = *f.before;
    Json json = {{"verdict", std::string(diagnose::verdict_names[static_cast<int>(d.verdict())])},
                 {"causes", d.decision.causes},
                 {"hypotheses", hypotheses_json(d)},
                 {"noise_factor", d.decision.noise_factor},
                 {"baseline", judged_json(d.baseline, before.misfit, f.study.file)}};
    json["baseline"]["parameters"] = intervals_json(before.study.space, before.parameters);
    if (f.study.noise == study::NoiseSource::estimated) {
        json["baseline"]["p_value"] = d.screening.p_familywise; // the only evidence there is
    }
    json["baseline"]["p_familywise"] = d.screening.p_familywise;
    const Judged& best = is_extended ? *d.extended : d.baseline;
    const DiagnosedModel& reported = is_extended ? *f.after : before;
    json["extended"] = judged_json(best, reported.misfit, is_extended ? extended_path : f.study.file);
    json["extended"]["parameters"] = intervals_json(reported.study.space, reported.parameters);
    if (is_extended) {
        json["extended"]["effects"] = Json::array();
        for (const std::size_t c : best.model.members) {
            if (c >= f.candidates.size()) {
                continue;
            }
            json["extended"]["effects"].push_back({{"effect", f.candidates[c].effect}, {"on", f.candidates[c].on}});
        }
    }
    Json gain = {{"misfit_reduction", is_extended ? 1.0 - reported.misfit / before.misfit : 0.0},
                 {"held_out_rmse_before", nullptr},
                 {"held_out_rmse_after", nullptr},
                 {"delta_aicc", best.aicc - d.baseline.aicc}};
    if (d.places) {
        gain["held_out_rmse_before"] = d.places->before;
        gain["held_out_rmse_after"] = is_extended ? d.places->after : d.places->before;
        gain["by_place"] = held_out_json(*d.places);
    }
    if (d.loads) {
        gain["by_load"] = held_out_json(*d.loads);
    }
    if (before.held_out_rms) {
        gain["study_held_out"] = {{"readings", f.study.held_out_readings()},
                                  {"rms_before", *before.held_out_rms},
                                  {"rms_after", *reported.held_out_rms}};
    }
    json["gain"] = std::move(gain);
    json["evidence"] = {{"p_familywise", d.p_evidence},
                        {"bartlett_factor", d.bartlett},
                        {"bootstrap", d.bootstrap},
                        {"bootstrap_as_large", d.bootstrap_above}};
    Json candidates = Json::array();
    for (const auto& effect : d.effects) {
        Json one = {{"effect", f.candidates[effect.candidate].effect},
                    {"on", f.candidates[effect.candidate].on},
                    {"unit", std::string(f.variants[effect.candidate].applied.effect->unit)},
                    {"variants", effect.variants},
                    {"score_z", effect.score},
                    {"p_familywise", effect.p_familywise},
                    {"delta_aicc", nullptr},
                    {"size", nullptr},
                    {"size_low", nullptr},
                    {"size_high", nullptr}};
        if (effect.fit) {
            one["delta_aicc"] = effect.delta_aicc;
            one["delta_chi2"] = -effect.gain;
            one["chi2"] = effect.fit->chi2;
            one["p_value"] = effect.fit->p_value;
            one["size"] = effect.size.value;
            one["alike"] = Json::array();
            for (const auto& other : effect.alike) {
                one["alike"].push_back({{"on", f.candidates[other.candidate].on},
                                        {"size", other.size.value},
                                        {"size_low", other.size.low},
                                        {"size_high", other.size.high},
                                        {"delta_chi2", other.behind}});
            }
            one["size_low"] = effect.size.low;
            one["size_high"] = effect.size.high;
        } else {
            one["not_fitted"] = effect.impossible;
        }
        candidates.push_back(std::move(one));
    }
    json["candidates"] = std::move(candidates);
    Json explanations = Json::array();
    for (const auto& e : d.explanations) {
        Json names = Json::array();
        for (const std::size_t c : e.fit.model.members) {
            names.push_back({{"effect", f.candidates[c].effect}, {"on", f.candidates[c].on}});
        }
        explanations.push_back({{"effects", names},
                                {"chi2", e.fit.chi2},
                                {"p_value", e.fit.p_value},
                                {"delta_aicc", e.fit.aicc - d.baseline.aicc},
                                {"behind", e.behind}});
        if (const auto& rms = f.held_out[explanations.size() - 1]) {
            explanations.back()["study_held_out_rms"] = *rms;
        }
    }
    json["explanations"] = std::move(explanations);
    json["corrections"] = corrections_json(f);
    Json confounding = Json::array();
    for (const auto& pair : d.confounding) {
        confounding.push_back({{"effect", f.candidates[pair.a].effect},
                               {"other", f.candidates[pair.b].effect},
                               {"cosine", pair.cosine},
                               {"rate", pair.rate}});
    }
    json["confounding"] = std::move(confounding);
    Json measurements = Json::array();
    for (const SeparatingReading& reading : f.next) {
        measurements.push_back(separating_json(reading, f.candidates, d));
    }
    for (const analysis::TellingReading& reading : f.telling) {
        measurements.push_back(telling_json(reading));
    }
    json["next_measurement"] = measurements.empty() ? Json::object() : measurements[0];
    if (!measurements.empty()) {
        measurements.erase(0);
    }
    json["further_measurements"] = std::move(measurements);
    Json groups = Json::array();
    for (std::size_t g = 0; g < f.layout.groups.size() && g < d.groups.size(); ++g) {
        const auto& test = d.groups[g];
        groups.push_back({{"group", f.layout.groups[g].name},
                          {"readings", f.layout.groups[g].terms.size()},
                          {"chi2", test.chi2},
                          {"mean", test.mean},
                          {"p_sign", test.p_sign},
                          {"p_runs", test.p_runs}});
    }
    json["groups"] = std::move(groups);
    add_model_errors(json, f.study, f.mesh, f.path);
    Json constancy = Json::array();
    for (const auto& c : d.constancy) {
        constancy.push_back({{"parameter", f.study.space.axes[c.axis].name},
                             {"group", f.layout.groups[c.group].name},
                             {"score_z", c.score}});
    }
    json["parameter_constancy"] = std::move(constancy);
    std::vector<double> measured;
    std::vector<double> baseline;
    std::vector<double> extended;
    json["readings"] = Json::array();
    for (std::size_t i = 0; i < f.study.measured().size(); ++i) {
        const data::Reading& m = f.study.readings[i];
        measured.push_back(m.in_unit(m.measured()));
        baseline.push_back(m.in_unit(before.evaluation.responses[i]));
        if (f.after) {
            extended.push_back(m.in_unit(f.after->evaluation.responses[i]));
        }
        Json reading = place_json(m);
        reading["unit"] = std::string(m.unit.name);
        json["readings"].push_back(std::move(reading));
    }
    json["responses"] = {{"measured", measured}, {"baseline", baseline}, {"extended", extended}};
    json["residuals"] = {{"baseline", residuals_of(f, d.baseline.model)},
                         {"extended", d.extended ? residuals_of(f, d.extended->model) : std::vector<double>{}}};
    Json outputs = Json::array();
    for (const std::size_t i : f.study.outputs()) {
        const data::Reading& output = f.study.readings[i];
        outputs.push_back({{"name", output.output},
                           {"unit", std::string(output.unit.name)},
                           {"before", output.in_unit(before.evaluation.responses[i])},
                           {"after", output.in_unit(reported.evaluation.responses[i])}});
        for (const analysis::OutputUncertainty& range : f.outputs) {
            if (range.reading == i) {
                outputs.back().update(output_range_json(output, range));
            }
        }
    }
    json["outputs"] = std::move(outputs);
    json["noise"] = {{"source", f.study.noise_name()}, {"residual_standard_deviation", std::sqrt(d.variance)}};
    json["findings"] = findings(f);
    json["warnings"] = warnings_json(reported.evaluation);
    return json;
}

} // namespace

void write_extended(const DiagnoseResult& result, const analysis::RunOptions& run) {
    run::write_file(run.folder, "extended.toml", result.extended_study(run.folder));
}

Json diagnose_json(const DiagnoseResult& result, const analysis::RunOptions& run) {
    if (result.failed()) {
        return {{"status", "failed"}, {"reason", result.diagnosis.failed}};
    }
    Json json = diagnosis_json(result, extended_path(result, run));
    json["study"] = study_json(result.study);
    json["version"] = analysis::version;
    json["seed"] = run.seed;
    json["model"] = result.options.model.name();
    if (result.reduced) {
        json["reduced_model"] = reduced_json(*result.reduced);
    }
    json["run"] = run.folder;
    return json;
}

} // namespace explore::report
