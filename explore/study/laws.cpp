#include "study/laws.h"

#include "pavement/effects/effect.h"

#include <fmt/format.h>

namespace explore::study {

using pave::material::Law;
using pave::material::ParameterInfo;

namespace {

// Where a law keeps this parameter of another.
std::optional<std::size_t> counterpart(const Law& law, const ParameterInfo& of_another) {
    const auto same = law.index_of(of_another.key);
    return same || of_another.alias.empty() ? same : law.index_of(of_another.alias);
}

// SI values of the new law where the old one had these. A law without the modulus ratio n is isotropic.
std::vector<double> translated(const Law& from, const std::vector<double>& values, const Law& to) {
    std::vector<double> result;
    for (const ParameterInfo& info : to.parameters()) {
        if (const auto old = counterpart(from, info)) {
            result.push_back(values[*old]);
        } else {
            result.push_back(info.to_si * (info.usual ? info.usual->start
                                                      : info.default_value.value_or(info.key == "n" ? 1.0 : 0.0)));
        }
    }
    return result;
}

} // namespace

std::vector<std::size_t> stress_dependent_layers(const Study& study) {
    std::vector<std::size_t> layers;
    for (std::size_t l = 0; l < study.model.layers.size(); ++l) {
        if (study.model.layers[l].law->stress_dependent()) {
            layers.push_back(l);
        }
    }
    return layers;
}

Study with_law(Study study, std::size_t number, const Law& law, const pave::Place& place) {
    pave::pavement::Layer& layer = study.model.layers[number];
    const Law& old = *layer.law;
    if (&old == &law) {
        return study;
    }
    layer.parameters = translated(old, layer.parameters, law);
    study.model.settings.layered = false; // laws are compared by the same engine
    layer.law = &law;
    const auto axes = std::move(study.space.axes);
    const auto parameters = std::move(study.parameters);
    study.space.axes.clear();
    study.parameters.clear();
    const auto vary = [&](problem::Axis axis) {
        study.parameters.push_back(pave::pavement::find_parameter(study.model, axis.name, place));
        study.space.axes.push_back(std::move(axis));
    };
    for (std::size_t k = 0; k < axes.size(); ++k) {
        problem::Axis axis = axes[k];
        if (parameters[k].law_index && parameters[k].owner == static_cast<int>(number)) {
            const auto there = counterpart(law, old.parameters()[*parameters[k].law_index]);
            if (!there) {
                continue;
            }
            axis.name = layer.name + "." + std::string(law.parameters()[*there].key);
            const auto same_name = [&](const problem::Axis& other) { return other.name == axis.name; };
            if (std::any_of(study.space.axes.begin(), study.space.axes.end(), same_name)) {
                continue; // both of Poisson's ratios were varied
            }
        }
        vary(std::move(axis));
    }
    for (const ParameterInfo& info : law.parameters()) {
        if (info.usual && !counterpart(old, info)) {
            vary({.name = layer.name + "." + std::string(info.key),
                  .low = info.usual->low,
                  .high = info.usual->high,
                  .scale = info.usual->log ? problem::Scale::log : problem::Scale::linear,
                  .start = info.usual->start});
        }
    }
    for (const auto& applied : study.model.effects) {
        if (const std::string why = pave::pavement::why_impossible(study.model, applied); !why.empty()) {
            throw pave::Error(place,
                              fmt::format("the effect \"{}\" of the study cannot act with the law \"{}\"",
                                          applied.effect->name, law.name()),
                              why, "another law, or a study without that effect");
        }
    }
    if (study.parameters.empty()) {
        throw pave::Error(place, fmt::format("with the law \"{}\" nothing is left to vary", law.name()));
    }
    study.hash += fmt::format("+{}:{}", layer.name, law.name());
    return study;
}

} // namespace explore::study
