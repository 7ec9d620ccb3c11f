#include "report/model_words.h"

#include "base/error.h"
#include "pavement/effects/effect.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <vector>

namespace explore::report {
namespace {

bool is_cross_anisotropic(const study::Study& study, std::size_t l) {
    const pave::pavement::Layer& layer = study.model.layers[l];
    const auto in_plane = layer.law->index_of("poisson_12");
    const auto vertical = layer.law->index_of("poisson_31");
    const auto ratio = layer.law->index_of("n");
    if (!in_plane || !vertical || !ratio) {
        return layer.law->index_of("poisson_12").has_value();
    }
    const auto shear = layer.law->index_of("shear_ratio");
    const bool searched = std::any_of(study.parameters.begin(), study.parameters.end(), [&](const auto& parameter) {
        return parameter.owner == static_cast<int>(l) && parameter.law_index &&
               (*parameter.law_index == *ratio || *parameter.law_index == *in_plane ||
                *parameter.law_index == *vertical || parameter.law_index == shear);
    });
    const auto& p = layer.parameters;
    return searched || p[*ratio] != 1.0 || p[*in_plane] != p[*vertical] || (shear && !std::isnan(p[*shear]));
}

void say(std::string& text, const std::vector<std::string>& names, const std::string& one, const std::string& many) {
    if (!names.empty()) {
        text += fmt::format("{} {}. ", pave::join(names), names.size() == 1 ? one : many);
    }
}

} // namespace

std::string model_words(const study::Study& study) {
    if (study.has_own_model) {
        return "The study has a model of its own.";
    }
    const auto& model = study.model;
    std::vector<std::string> isotropic, cross_anisotropic, joints;
    for (std::size_t l = 0; l < model.layers.size(); ++l) {
        const auto& layer = model.layers[l];
        (is_cross_anisotropic(study, l) ? cross_anisotropic : isotropic).push_back(layer.name);
        if (layer.compliance && l + 1 < model.layers.size()) {
            joints.push_back(fmt::format("{} on {}", layer.name, model.layers[l + 1].name));
        }
    }
    std::string text;
    say(text, isotropic, "is isotropic", "are isotropic");
    say(text, cross_anisotropic, "is cross-anisotropic", "are cross-anisotropic");
    if (model.layers.size() > 1) {
        text += joints.empty() ? "Layers are bonded. "
                               : fmt::format("Shear springs join {}; other layers are bonded. ", pave::join(joints));
    }
    text += model.half_space ? "The last layer goes on for ever. " : "The last layer stands on a rigid rough floor. ";
    std::vector<std::string> at_rest, recorded, inert, stiff;
    for (const auto& load : model.loads) {
        (load.is_pulse() ? recorded : load.inertia ? inert : at_rest).push_back(load.name);
        if (load.plate_stiffness) {
            stiff.push_back(load.name);
        }
    }
    say(text, at_rest, "acts at rest", "act at rest");
    say(text, recorded, "acts over time as it was recorded", "act over time as they were recorded");
    say(text, inert, "is a pulse that moves the mass of the section", "are pulses that move the mass of the section");
    say(text, stiff, "acts through a plate that resists bending", "act through plates that resist bending");
    for (const auto& applied : model.effects) {
        text +=
            fmt::format("Effect {} = {:g} [{}] is added. ", applied.effect->name, applied.size, applied.effect->unit);
    }
    text.pop_back();
    return text;
}

} // namespace explore::report
