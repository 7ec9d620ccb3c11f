#include "study/read_layer.h"

#include "material/catalog.h"
#include "pavement/parameter.h"
#include "study/table_reader.h"

#include <algorithm>

namespace explore::study {

using namespace pave::pavement;

Layer read_layer(const toml::table& table, const std::string& file, std::optional<double> meshed) {
    TableReader reader(table, file, "[[layers]]");
    Layer layer;
    layer.name = reader.text(keys::layer_name);
    reader.rename("layer \"" + layer.name + "\"");
    std::vector<std::string> law_names;
    for (const auto* law : pave::material::laws()) {
        law_names.emplace_back(law->name());
    }
    layer.law = pave::material::laws()[reader.choice(keys::layer_law, law_names)];
    reader.expect(layer_keys());
    reader.expect(layer.law->parameters());
    for (const KeyInfo& key : layer_keys()) {
        auto fallback = key.default_value;
        if (key.key == "damping_time_ms" && layer.law->relaxes()) { // it damps by itself
            fallback = 0.0;
        }
        if (meshed && key.changes_geometry) {
            fallback = *meshed / key.to_si;
        }
        key.of(layer) = key.to_si * reader.number(key.key, key.low, key.high, key.low_is_open, fallback);
    }
    for (const auto& info : layer.law->parameters()) {
        if (!info.choices.empty()) {
            const std::vector<std::string> words(info.choices.begin(), info.choices.end());
            std::optional<std::size_t> fallback;
            if (info.default_value) {
                fallback = static_cast<std::size_t>(*info.default_value);
            }
            layer.parameters.push_back(static_cast<double>(reader.choice(info.key, words, fallback)));
        } else {
            layer.parameters.push_back(
                info.to_si * reader.number(info.key, info.low, info.high, info.low_is_open, info.default_value));
        }
    }
    reader.done();
    if (const std::string why = layer.law->impossible(layer.parameters); !why.empty()) {
        std::vector<std::string> found;
        for (std::size_t i = 0; i < layer.parameters.size(); ++i) {
            const auto fades = layer.law->relaxation_derivative(layer.parameters, i);
            const bool is_share = std::any_of(fades.begin(), fades.end(), [](const auto& f) { return f.share != 0.0; });
            if (is_share || !layer.law->unit_stiffness_derivative(layer.parameters, {}, i).isZero(0.0)) {
                found.push_back(fmt::format("{} = {:g}", layer.law->parameters()[i].key, layer.parameters[i]));
            }
        }
        throw pave::Error(reader.place(""), "no material has these parameters", pave::join(found), why);
    }
    return layer;
}

} // namespace explore::study
