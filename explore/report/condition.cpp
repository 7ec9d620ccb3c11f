#include "report/condition.h"

#include "base/units.h"
#include "data/condition.h"
#include "data/structural_number.h"

#include <cmath>

namespace explore::report {
namespace {

constexpr double standard_radius_mm = 150.0;
constexpr double characteristic_k = 1.645;

Json class_json(const std::optional<data::Condition>& found) {
    return found ? Json(std::string(data::condition_words[static_cast<std::size_t>(*found)])) : Json(nullptr);
}

} // namespace

Json condition_json(const analysis::StationResult& station) {
    if (station.bowl().radius_mm != standard_radius_mm) {
        return nullptr;
    }
    const auto indices = data::indices_of(station.bowl(), data::condition_pressure_kPa);
    Json json = Json::object();
    for (std::size_t base = 0; base < data::base_kinds.size(); ++base) {
        const auto c = data::condition_of(indices, static_cast<data::BaseKind>(base));
        json[std::string(data::base_kinds[base])] = {{"D0", class_json(c.d0)},
                                                     {"curvature_radius", class_json(c.roc)},
                                                     {"SCI", class_json(c.sci)},
                                                     {"BDI", class_json(c.bdi)},
                                                     {"BCI", class_json(c.bci)}};
    }
    return json;
}

Json structural_json(const analysis::SurveyResult& result, const analysis::StationResult& station) {
    if (!result.study || result.study->has_own_model) {
        return nullptr;
    }
    const auto& layers = result.study->model.layers;
    double thickness_mm = 0.0;
    for (std::size_t i = 0; i + 1 < layers.size(); ++i) {
        const auto own = station.station.layers.find(layers[i].name);
        thickness_mm += own == station.station.layers.end() ? layers[i].thickness / pave::unit::mm : own->second.mm;
    }
    std::optional<double> d0_um;
    if (station.at_reference && station.at_reference->d0_um) {
        d0_um = station.bowl().d0_um() * *station.at_reference->d0_um / station.indices->d0_um;
    }
    const auto found = thickness_mm > 0.0 ? data::structural_number(station.bowl(), thickness_mm, d0_um) : std::nullopt;
    return !found ? Json(nullptr)
                  : Json{{"SN_eff", found->sn_eff},
                         {"subgrade_MPa", found->subgrade_MPa},
                         {"design_subgrade_MPa", data::design_share * found->subgrade_MPa},
                         {"pavement_MPa", found->pavement_MPa},
                         {"offset_mm", found->offset_mm},
                         {"D0_at_C", d0_um ? Json(*result.reference_C) : Json(nullptr)},
                         {"thickness_mm", thickness_mm}};
}

Json reference_json(const analysis::SurveyResult& result, const analysis::StationResult& station) {
    if (!station.at_reference) {
        return nullptr;
    }
    const data::IndicesAtReference& at = *station.at_reference;
    return {{"asphalt_C", *result.reference_C},
            {"pressure_kPa", station.normalised_kPa},
            {"D0_um", optional_json(at.d0_um)},
            {"SCI_um", optional_json(at.sci_um)},
            {"BDI_um", optional_json(at.bdi_um)},
            {"BCI_um", optional_json(at.bci_um)},
            {"reason", at.why_not},
            {"out_of_range", at.out_of_range}};
}

Json characteristic_json(const analysis::SurveyResult& result, const analysis::RoadSection& section) {
    std::vector<double> d0;
    double sum = 0.0;
    for (std::size_t i = section.first; i <= section.last; ++i) {
        if (const auto& s = result.stations[i]; s.has_bowl()) {
            d0.push_back(s.indices->d0_um);
            sum += d0.back();
        }
    }
    if (d0.size() < 2) {
        return nullptr;
    }
    const double mean = sum / static_cast<double>(d0.size());
    double squares = 0.0;
    for (const double d : d0) {
        squares += (d - mean) * (d - mean);
    }
    const double sd = std::sqrt(squares / static_cast<double>(d0.size() - 1));
    return {{"mean_um", mean}, {"sd_um", sd}, {"k", characteristic_k}, {"D0_um", mean + characteristic_k * sd}};
}

} // namespace explore::report
