#include "analysis/diagnose/bottom_hint.h"

#include "analysis/common/floor.h"
#include "pavement/effects/effect.h"

#include <algorithm>
#include <fmt/format.h>

namespace explore::analysis {
namespace {

// Whether an explanation has an effect of one of these names whose size is more than that.
bool is_explained_by(const DiagnoseResult& result, std::initializer_list<std::string_view> names, double size) {
    const std::size_t axes = result.study.space.axes.size();
    return std::ranges::any_of(result.diagnosis.to_compare(), [&](const auto& explanation) {
        const auto& model = explanation.fit.model;
        for (std::size_t m = 0; m < model.members.size(); ++m) {
            const std::size_t c = model.members[m];
            const bool is_effect = c < result.variants.size(); // else a coefficient of a correction
            if (is_effect && std::ranges::find(names, result.variants[c].applied.effect->name) != names.end() &&
                model.evaluation.parameters[axes + m] > size) {
                return true;
            }
        }
        return false;
    });
}

} // namespace

bool is_floor_sought_deepest(const DiagnoseResult& result) {
    const auto& d = result.diagnosis;
    const double beyond_noise = d.baseline.chi2 - d.baseline.dof;
    return std::ranges::any_of(d.effects, [&](const auto& found) {
        const auto& effect = *result.variants[found.candidate].applied.effect;
        return effect.name == "floor-depth" && found.fit && found.size.value > 0.9 * effect.high &&
               found.gain > 0.5 * beyond_noise;
    });
}

std::string bottom_hint(const DiagnoseResult& result) {
    if (result.study.model.layers.empty()) { // another's model
        return "";
    }
    const std::string& last = result.study.model.layers.back().name;
    if (result.study.model.half_space && !result.premises.no_floor &&
        is_explained_by(result, {"subgrade-depth-gradient", "weak-subgrade-top"}, 0.0)) {
        return rock_words(result.study);
    }
    if (!result.study.model.half_space && !result.is_floor_weighed && is_floor_sought_deepest(result)) {
        return fmt::format("There may be no floor at all: bottom = \"half-space\" under [section], where {} goes on "
                           "for ever, tells whether that fits better.",
                           last);
    }
    return "";
}

} // namespace explore::analysis
