#include "analysis/survey/survey_layers.h"

#include "base/error.h"
#include "base/text.h"
#include "base/units.h"
#include "data/fwd_values.h"
#include "pavement/parameter.h"

#include <algorithm>
#include <fmt/format.h>
#include <set>

namespace explore::analysis {
namespace {

std::vector<std::string> layers_of(const study::Study& study) {
    std::vector<std::string> names;
    for (const auto& layer : study.model.layers) {
        names.push_back(layer.name);
    }
    if (study.model.half_space) {
        names.pop_back();
    }
    return names;
}

// The study's own name of a layer; nothing: it has none of that name.
std::optional<std::string> name_in(const std::vector<std::string>& layers, const std::string& stated) {
    const auto at = std::find_if(layers.begin(), layers.end(), [&](const std::string& name) {
        return data::plain_word(name) == data::plain_word(stated);
    });
    return at == layers.end() ? std::nullopt : std::optional(*at);
}

// The stations' own columns under the study's names; what can be no thickness is remarked and left out.
std::set<std::string> rename(SurveyResult& result, const std::vector<std::string>& layers) {
    std::set<std::string> unknown;
    for (StationResult& s : result.stations) {
        data::StationLayers named;
        for (const auto& [stated, thickness] : s.station.layers) {
            const auto name = name_in(layers, stated);
            if (!name) {
                unknown.insert(stated);
                continue;
            }
            const auto key = pave::pavement::find_parameter(result.study->model, *name + ".thickness_mm", {});
            if (thickness.mm >= key.low && thickness.mm <= key.high && thickness.mm > 0.0) {
                named[*name] = thickness;
            } else {
                s.station.remarks.push_back(
                    fmt::format("a thickness of {} of {:g} mm is not used", *name, thickness.mm));
            }
        }
        s.station.layers = std::move(named);
    }
    return unknown;
}

void add_table(SurveyResult& result, const std::vector<std::string>& layers, const std::string& file) {
    const data::LayerTable table = data::read_layer_table(file);
    std::vector<std::string> unknown = table.unknown;
    std::vector<std::string> used;
    for (const std::string& stated : table.layers()) {
        const auto name = name_in(layers, stated);
        if (!name) {
            unknown.push_back(stated);
            continue;
        }
        used.push_back(*name);
        for (StationResult& s : result.stations) {
            if (s.station.chainage_m && !s.station.layers.contains(*name)) {
                if (const auto there = data::thickness_at(table, stated, s.station.lane, *s.station.chainage_m)) {
                    s.station.layers[*name] = *there;
                }
            }
        }
    }
    if (used.empty()) {
        throw pave::Error({.file = file}, "no column names a layer of the study", pave::join(table.layers()),
                          "the layers of the study: " + pave::join(layers));
    }
    if (!table.places.empty()) {
        result.remarks.push_back(fmt::format("{}: {}.", file, table.places));
    }
    if (!unknown.empty()) {
        result.remarks.push_back(fmt::format("{}: columns not used, as they name no layer of the study ({}): {}", file,
                                             pave::join(layers), pave::join(unknown)));
    }
    const double first = table.rows.front().chainage_m;
    const double last = table.rows.back().chainage_m;
    const std::size_t beyond = result.count([&](const StationResult& s) {
        return s.station.chainage_m && (*s.station.chainage_m < first || *s.station.chainage_m > last);
    });
    result.remarks.push_back(
        fmt::format("{}: thicknesses of {} are interpolated linearly by chainage{}.", file, pave::join(used),
                    beyond == 0 ? std::string()
                                : fmt::format("; {} beyond its {:g} to {:g} m {} that of the nearest row",
                                              pave::counted(beyond, "station", "stations"), first, last,
                                              beyond == 1 ? "takes" : "take")));
}

// Where the study seeks a thickness that stations state, the stations' is its prior.
void check_axis(const SurveyResult& result, const std::string& layer) {
    const std::string path = layer + ".thickness_mm";
    const auto& axes = result.study->space.axes;
    const auto axis = std::find_if(axes.begin(), axes.end(), [&](const auto& a) { return a.name == path; });
    if (axis == axes.end()) {
        return;
    }
    const pave::Place place{.file = result.study->file, .key = path};
    if (axis->level != problem::Level::station) {
        throw pave::Error(place, "stations state this thickness, and the study takes it for common to them", {},
                          "level = \"station\"");
    }
    const bool all_state = std::all_of(result.stations.begin(), result.stations.end(), [&](const StationResult& s) {
        const auto there = s.station.layers.find(layer);
        return there == s.station.layers.end() || there->second.sd_mm;
    });
    if (!axis->prior && !all_state) {
        throw pave::Error(place, "stations state this thickness, and nothing how far it may be off", {},
                          fmt::format("a column {}_sd_mm, a prior in the study, or no such parameter", layer));
    }
}

void say_what_is_used(SurveyResult& result, const std::string& layer) {
    std::size_t stated = 0;
    bool has_error = false;
    double low = std::numeric_limits<double>::infinity();
    double high = 0.0;
    for (const StationResult& s : result.stations) {
        if (const auto there = s.station.layers.find(layer); there != s.station.layers.end()) {
            ++stated;
            has_error = has_error || there->second.sd_mm.has_value();
            low = std::min(low, there->second.mm);
            high = std::max(high, there->second.mm);
        }
    }
    if (stated == 0) {
        return;
    }
    const auto names = result.parameter_names();
    const bool is_sought = std::find(names.begin(), names.end(), layer + ".thickness_mm") != names.end();
    const auto key = pave::pavement::find_parameter(result.study->model, layer + ".thickness_mm", {});
    std::string text =
        fmt::format("{} is {} mm thick by what {} of {} state{}", layer,
                    low == high ? fmt::format("{:.4g}", low) : fmt::format("{:.4g} to {:.4g}", low, high), stated,
                    pave::counted(result.stations.size(), "station", "stations"),
                    is_sought ? ", which is the prior of the thickness there" : "");
    if (stated < result.stations.size()) {
        text += fmt::format("; the study's {:g} mm at the others", key.get(result.study->model));
    }
    result.remarks.push_back(text + ".");
    if (has_error && !is_sought) {
        result.remarks.push_back(fmt::format(
            "{}_sd_mm is not used: {}.thickness_mm is no parameter of the study, so its error is in no range.", layer,
            layer));
    }
}

} // namespace

void set_layers(SurveyResult& result, const std::string& table) {
    if (!result.study && !table.empty()) {
        throw pave::Error({.key = "--layers"}, "thicknesses are of the layers of a study", "no --study",
                          "--study STUDY beside it");
    }
    const auto layers = result.study ? layers_of(*result.study) : std::vector<std::string>{};
    const std::set<std::string> unknown = rename(result, layers);
    if (!unknown.empty()) {
        result.remarks.push_back(fmt::format(
            "columns not used{}: {}",
            result.study ? ", as they name no layer of the study (" + pave::join(layers) + ")" : std::string(),
            pave::join({unknown.begin(), unknown.end()})));
    }
    if (!table.empty()) {
        add_table(result, layers, table);
    }
    for (const std::string& layer : layers) {
        check_axis(result, layer);
        say_what_is_used(result, layer);
    }
}

} // namespace explore::analysis
