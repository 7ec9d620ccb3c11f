#include "report/survey.h"

#include "analysis/survey/survey_findings.h"
#include "base/text.h"
#include "report/lives.h"

#include <fmt/format.h>

namespace explore::report {

using analysis::StationResult;
using analysis::SurveyResult;

std::optional<Json> survey_geojson(const SurveyResult& result) {
    Json features = Json::array();
    for (const StationResult& s : result.stations) {
        const auto& f = s.station;
        if (!f.latitude || !f.longitude) {
            continue;
        }
        Json properties = {{"station", f.name},
                           {"profile", f.profile},
                           {"lane", f.lane},
                           {"chainage_m", optional_json(f.chainage_m)},
                           {"status", std::string(to_string(s.state))},
                           {"reason", analysis::reason_of(s)},
                           {"date", f.date},
                           {"time", f.time},
                           {"comment", f.comment},
                           {"air_C", optional_json(f.air_C)},
                           {"surface_C", optional_json(f.surface_C)},
                           {"asphalt_C", s.asphalt ? Json(s.asphalt->celsius) : Json(nullptr)},
                           {"remarks", pave::join(analysis::remarks_of(result, s), "; ")},
                           {"file", f.file},
                           {"line", f.line}};
        if (s.has_bowl()) {
            properties["normalised_D0_um"] = s.indices->d0_um;
            properties["SCI_um"] = optional_json(s.indices->sci_um);
            properties["BDI_um"] = optional_json(s.indices->bdi_um);
            properties["BCI_um"] = optional_json(s.indices->bci_um);
            properties["AREA_mm"] = optional_json(s.indices->area_mm);
            if (s.at_reference) {
                properties["D0_um_at_reference"] = optional_json(s.at_reference->d0_um);
                properties["SCI_um_at_reference"] = optional_json(s.at_reference->sci_um);
            }
            properties["deflection_ratio"] = optional_json(s.ratio());
            properties["verdict"] = std::string(analysis::verdict(s));
            properties["verdict_reason"] = analysis::why_no_ratio(s);
        }
        const auto names = result.parameter_names();
        for (std::size_t k = 0; s.is_fitted() && k < names.size(); ++k) {
            const auto& p = s.fit->parameters[k];
            properties[names[k]] = p.value;
            properties[names[k] + " low"] = p.low;
            properties[names[k] + " high"] = p.high;
            properties[names[k] + " determined"] = p.determined;
        }
        const auto outputs = result.outputs();
        for (std::size_t o = 0; s.is_fitted() && o < s.fit->outputs.size(); ++o) {
            const auto& p = s.fit->outputs[o];
            const std::string name = fmt::format("{} [{}]", outputs[o].output, outputs[o].unit.name);
            properties[name] = outputs[o].in_unit(p.value);
            properties[name + " low"] = p.determined ? Json(outputs[o].in_unit(p.low)) : Json(nullptr);
            properties[name + " high"] = p.determined ? Json(outputs[o].in_unit(p.high)) : Json(nullptr);
        }
        add_life_properties(s, properties);
        features.push_back({{"type", "Feature"},
                            {"geometry", {{"type", "Point"}, {"coordinates", {*f.longitude, *f.latitude}}}},
                            {"properties", std::move(properties)}});
    }
    return features.empty() ? std::nullopt
                            : std::optional(Json{{"type", "FeatureCollection"}, {"features", std::move(features)}});
}

} // namespace explore::report
