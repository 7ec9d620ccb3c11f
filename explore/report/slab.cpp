#include "report/slab.h"

#include "base/text.h"
#include "report/text.h"

#include <algorithm>
#include <fmt/format.h>
#include <iterator>

namespace explore::report {

using analysis::SlabRange;
using analysis::SlabStation;
using pave::figure;

namespace {

Json json_of(const SlabRange& range) {
    return {{"value", range.value}, {"low", range.low}, {"high", range.high}};
}

bool is_liquid(const analysis::SlabResult& result) {
    return result.options.foundation == pave::layered::Foundation::dense_liquid;
}

} // namespace

Json slab_json(const analysis::SlabResult& result) {
    const std::string foundation = is_liquid(result) ? "k_MPa_per_m" : "foundation_MPa";
    Json json = {{"foundation", is_liquid(result) ? "liquid" : "solid"},
                 {"thickness_mm", result.options.thickness_mm},
                 {"poisson", result.options.poisson},
                 {"size_mm", result.options.length_mm > 0.0 ? Json(slab_size_mm(result.options)) : Json(nullptr)},
                 {"bending", optional_json(result.bending)},
                 {"stations", Json::array()},
                 {"remarks", result.remarks},
                 {"findings", findings(result)}};
    for (const SlabStation& s : result.stations) {
        Json one = {{"station", s.name},
                    {"chainage_m", optional_json(s.chainage_m)},
                    {"joint", s.is_joint},
                    {"pressure_kPa", s.pressure_kPa},
                    {"d0_um", s.d0_um},
                    {"area_mm", optional_json(s.area_mm)},
                    {"intercept_um", optional_json(s.intercept_um)},
                    {"load_transfer_percent", optional_json(s.transfer_percent)},
                    {"reason", s.reason}};
        if (s.fit) {
            one["stiffness_radius_mm"] = json_of(s.fit->stiffness_mm);
            one[foundation] = json_of(s.fit->foundation);
            one["slab_MPa"] = json_of(s.fit->slab_MPa);
            one["rms_percent"] = s.fit->rms_percent;
        }
        if (s.area_stiffness_mm) {
            one["by_area"] = {{"stiffness_radius_mm", *s.area_stiffness_mm},
                              {foundation, *s.area_foundation},
                              {"slab_MPa", *s.area_slab_MPa}};
        }
        json["stations"].push_back(std::move(one));
    }
    return json;
}

namespace {

constexpr std::size_t slab_columns = 8;

std::vector<std::string> header_of(const analysis::SlabResult& result) {
    return {"station",  "D0 um", "AREA mm",   "l mm", is_liquid(result) ? "k MPa/m" : "E0 MPa",
            "slab MPa", "RMS %", "transfer %"};
}

std::vector<std::string> station_row(const SlabStation& s) {
    const auto cell = [](const std::optional<double>& value) { return value ? figure(*value, 3) : std::string(); };
    std::vector<std::string> cells{s.name, s.d0_um > 0.0 ? figure(s.d0_um, 3) : "", cell(s.area_mm)};
    if (s.fit) {
        for (const SlabRange& range : {s.fit->stiffness_mm, s.fit->foundation, s.fit->slab_MPa}) {
            cells.push_back(figure(range.value, 3));
        }
        cells.push_back(fmt::format("{:.1f}", s.fit->rms_percent));
    }
    cells.resize(slab_columns - 1);
    cells.push_back(cell(s.transfer_percent));
    return cells;
}

std::vector<std::string> reasons_of(const analysis::SlabResult& result) {
    std::vector<std::string> reasons;
    for (const SlabStation& s : result.stations) {
        if (!s.reason.empty()) {
            reasons.push_back(fmt::format("{}: {}", s.name, s.reason));
        }
    }
    return reasons;
}

// The first of the sentences that says what to do.
std::string step_of(std::vector<std::string>& notes) {
    const auto step = std::find_if(notes.begin(), notes.end(), [](const std::string& words) {
        return words.find("Drop there again") != std::string::npos || words.find(": restore it") != std::string::npos ||
               words.find(": try --foundation") != std::string::npos;
    });
    if (step == notes.end()) {
        return "";
    }
    const std::string words = *step;
    notes.erase(step);
    return words;
}

} // namespace

Answer slab_answer(const analysis::SlabResult& result) {
    Answer answer;
    answer.lines = 30;
    answer.verdict_and_notes(findings(result));
    answer.heading = "Stations";
    answer.header = header_of(result);
    std::transform(result.stations.begin(), result.stations.end(), std::back_inserter(answer.rows), station_row);
    for (std::string& reason : reasons_of(result)) {
        answer.notes.push_back(std::move(reason));
    }
    answer.next = step_of(answer.notes);
    return answer;
}

std::string slab_text(const analysis::SlabResult& result) {
    Table table(header_of(result));
    for (const SlabStation& s : result.stations) {
        table.add(station_row(s));
    }
    return sentences(findings(result)) + "\n" + table.text() + sentences(reasons_of(result));
}

} // namespace explore::report
