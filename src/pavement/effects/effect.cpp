#include "pavement/effects/effect.h"

#include "base/units.h"

#include <algorithm>

namespace pave::pavement {

bool is_active(const AppliedEffect& applied) {
    return applied.present || applied.size != applied.effect->null;
}

std::optional<std::size_t> layer_of_role(const Case& c, LayerRole role) {
    const auto named = [&](std::string_view name) -> std::optional<std::size_t> {
        const auto found =
            std::find_if(c.layers.begin(), c.layers.end(), [&](const Layer& layer) { return layer.name == name; });
        return found == c.layers.end() ? std::nullopt : std::optional<std::size_t>(found - c.layers.begin());
    };
    const std::size_t count = c.layers.size();
    switch (role) {
    case LayerRole::asphalt: {
        const auto found = named("asphalt");
        return found || count < 2 ? found : 0;
    }
    case LayerRole::base: {
        if (const auto found = named("base")) {
            return found;
        }
        for (std::size_t l = 0; l + 1 < count; ++l) {
            if (c.layers[l].law->stress_dependent()) {
                return l;
            }
        }
        return count < 2 ? std::nullopt : std::optional(count - 2);
    }
    case LayerRole::subgrade: {
        const auto found = named("subgrade");
        return found ? found : count - 1;
    }
    case LayerRole::none: break;
    }
    return std::nullopt;
}

namespace {

// With the layer that the effect acts on unless the case says otherwise; without one where the section has none.
AppliedEffect with_layer(const Case& c, AppliedEffect applied) {
    if (applied.layer.empty()) {
        if (const auto layer = layer_of_role(c, applied.effect->layer)) {
            applied.layer = c.layers[*layer].name;
        }
    }
    return applied;
}

} // namespace

Case with_effects(const Case& c, int load) {
    Case out = c;
    out.effects.clear();
    for (const AppliedEffect& applied : c.effects) {
        if (is_active(applied)) {
            applied.effect->apply(out, with_layer(c, applied), load);
        }
    }
    return out;
}

std::string why_impossible(const Case& c, const AppliedEffect& applied) {
    const Effect& effect = *applied.effect;
    const AppliedEffect complete = with_layer(c, applied);
    if (effect.layer != LayerRole::none && complete.layer.empty()) {
        return "the section has no such layer";
    }
    return effect.refuses != nullptr ? effect.refuses(c, complete) : "";
}

std::vector<std::size_t> layers_named(const Case& c, std::string_view name) {
    std::vector<std::size_t> found;
    for (std::size_t l = 0; l < c.layers.size(); ++l) {
        if (c.layers[l].name == name) {
            found.push_back(l);
        }
    }
    return found;
}

double top_of(const Case& c, std::size_t layer) {
    double z = 0.0;
    for (std::size_t l = 0; l < layer; ++l) {
        z += c.layers[l].thickness;
    }
    return z;
}

void scale_modulus(Layer& layer, double factor) {
    for (const std::size_t i : layer.law->scale_parameters()) {
        layer.parameters[i] *= factor;
    }
}

double slip_compliance(double size) {
    constexpr double reference = unit::mm / unit::MPa;
    constexpr double bonded = 1e-5; // a shear stress of 1 MPa moves it by 10 nm
    return reference * (size / (1.0 - size) + bonded);
}

Effect interface_slip() {
    return {
        .name = {},
        .unit = "-",
        .null = 0.0,
        .low = 0.0,
        .high = 0.999,
        .typical = 0.5,
        .mechanism =
            "The layers slide on each other against a shear spring per area of compliance 1/k = (1 mm/MPa) size/(1 - "
            "size), while the vertical displacement stays continuous; 0 is bonded, 1 frictionless. Strains jump at "
            "the interface: the layer above bends on its own.",
        .source = "Goodman, Taylor and Brekke (1968), joint elements; the shear spring compliance of BISAR (de Jong et "
                  "al. 1973)",
        .acts_on = {},
        .layer = LayerRole::base,
    };
}

bool is_plate(const Case& c, std::optional<int> load) {
    if (load) {
        return c.loads[*load].type == LoadType::plate;
    }
    return std::any_of(c.loads.begin(), c.loads.end(), [](const Load& l) { return l.type == LoadType::plate; });
}

bool has_gauges(const Case& c) {
    return std::any_of(c.sensors.begin(), c.sensors.end(),
                       [](const Sensor& sensor) { return sensor.measured && sensor.quantity != Quantity::deflection; });
}

} // namespace pave::pavement
