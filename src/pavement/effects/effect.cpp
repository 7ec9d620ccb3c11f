#include "pavement/effects/effect.h"

#include "base/text.h"
#include "base/units.h"
#include "material/catalog.h"
#include "pavement/buried.h"
#include "pavement/tie.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <utility>

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
    apply_ties(out);
    out.ties.clear();
    out.effects.clear();
    out.corrections.clear();
    // Effects need not be the same under every load.
    out.settings.shares_paths = c.settings.shares_paths && c.effects.empty() && c.corrections.empty();
    // Gains know instruments by their places, so they act before others move them; the order of gains is none.
    for (const bool of_gains : {true, false}) {
        for (const AppliedEffect& applied : c.effects) {
            if (is_active(applied) && applied.effect->takes_quantity == of_gains) {
                applied.effect->apply(out, with_layer(c, applied), load);
            }
        }
    }
    for (const Correction& correction : c.corrections) {
        if (is_active(correction)) {
            apply(out, correction, load);
        }
    }
    if (c.settings.wall_follows) { // sensors are where the case states them: moved ones do not move the wall
        out.settings.extent = c.default_extent(out.depth());
    }
    return out;
}

namespace {

// As this load meets it, where numbers that are not given equal themselves.
Case seen_by_load(const Case& whole, std::size_t load) {
    Case seen = with_effects(whole, static_cast<int>(load));
    for (Layer& layer : seen.layers) {
        std::replace_if(
            layer.parameters.begin(), layer.parameters.end(), [](double p) { return std::isnan(p); }, 0.0);
    }
    return seen;
}

} // namespace

ChangedReadings readings_changed_alone(const Case& c, const AppliedEffect& applied) {
    if (!why_impossible(c, applied).empty() || c.loads.empty()) {
        return {};
    }
    Case with = c;
    with.effects = {applied};
    with.effects[0].size = applied.effect->typical;
    Case without = c;
    without.effects.clear();
    ChangedReadings changed{.sensors = {}, .are_scaled = applied.effect->null == 1.0};
    for (std::size_t l = 0; l < c.loads.size(); ++l) {
        const Case here = seen_by_load(with, l);
        const Case before = seen_by_load(without, l);
        if (here.layers != before.layers || here.loads != before.loads ||
            here.sensors.size() != before.sensors.size()) {
            return {};
        }
        for (std::size_t s = 0; s < here.sensors.size(); ++s) {
            if (static_cast<std::size_t>(here.sensors[s].load) != l || here.sensors[s] == before.sensors[s]) {
                continue;
            }
            Sensor scaled_alone = before.sensors[s];
            scaled_alone.gain *= applied.effect->typical;
            changed.are_scaled = changed.are_scaled && scaled_alone == here.sensors[s];
            changed.sensors.push_back(s);
        }
    }
    changed.are_scaled = changed.are_scaled && !changed.sensors.empty();
    return changed;
}

std::string layer_stiffened(const Case& c, const AppliedEffect& applied) {
    if (applied.effect->layer == LayerRole::none || !why_impossible(c, applied).empty() || c.loads.empty()) {
        return "";
    }
    Case with = c;
    with.effects = {applied};
    with.effects[0].size = applied.effect->typical;
    Case without = c;
    without.effects.clear();
    const Case plain = seen_by_load(without, 0);
    const std::vector<Layer> changed = seen_by_load(with, 0).layers;
    std::string name;
    const auto same_but_for_stiffness = [](Layer a, const Layer& b) {
        a.law = b.law;
        a.parameters = b.parameters;
        a.fields = b.fields;
        return a == b;
    };
    // A layer may have become several of its name, that follow one another.
    std::size_t at = 0;
    for (const Layer& layer : plain.layers) {
        std::vector<Layer> parts;
        for (; at < changed.size() && changed[at].name == layer.name; ++at) {
            parts.push_back(changed[at]);
        }
        if (parts.size() == 1 && parts[0] == layer) {
            continue;
        }
        double thickness = 0.0;
        for (Layer& part : parts) {
            thickness += std::exchange(part.thickness, layer.thickness);
        }
        const bool is_stiffness = name.empty() && std::abs(thickness - layer.thickness) < 1e-9 &&
                                  std::all_of(parts.begin(), parts.end(),
                                              [&](const Layer& part) { return same_but_for_stiffness(part, layer); });
        if (!is_stiffness) {
            return "";
        }
        name = layer.name;
    }
    for (std::size_t l = 0; l < c.loads.size(); ++l) {
        const Case here = seen_by_load(with, l);
        const Case before = seen_by_load(without, l);
        if (here.layers != changed || here.loads != before.loads || here.sensors != before.sensors) {
            return "";
        }
    }
    return name;
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

std::string stiffness_words(double factor) {
    return factor >= 1.0 ? fmt::format("{} times the stated modulus", figure(factor, 2))
                         : fmt::format("{} % of the stated modulus", figure(100.0 * factor, 2));
}

std::string share_words(double factor) {
    return fmt::format("{} % {} what is stated", figure(100.0 * std::abs(factor - 1.0), 2),
                       factor >= 1.0 ? "above" : "below");
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
        .high_is_limit = true,
        .typical = 0.5,
        .mechanism =
            "The layers slide on each other against a shear spring per area of compliance 1/k = (1 mm/MPa) size/(1 - "
            "size), while the vertical displacement stays continuous; 0 is bonded, 1 frictionless. Strains jump at "
            "the interface: the layer above bends on its own.",
        .source = "Goodman, Taylor and Brekke (1968), joint elements; the shear spring compliance of BISAR (de Jong et "
                  "al. 1973)",
        .acts_on = {},
        .layer = LayerRole::base,
        .in_words = [](const AppliedEffect& a) -> std::string {
            return fmt::format("the shear spring between the layers yields by {} mm/MPa",
                               figure(slip_compliance(a.size) * unit::MPa / unit::mm, 2));
        },
    };
}

bool is_plate(const Case& c, std::optional<int> load) {
    if (load) {
        return c.loads[*load].type == LoadType::plate;
    }
    return std::any_of(c.loads.begin(), c.loads.end(), [](const Load& l) { return l.type == LoadType::plate; });
}

std::string why_not_in_time(const Case& c) {
    const bool in_time = std::any_of(c.loads.begin(), c.loads.end(), [](const Load& load) { return load.is_pulse(); });
    return in_time ? "" : "only under a load with a history does the section move in time";
}

bool has_gauges(const Case& c) {
    return std::any_of(c.sensors.begin(), c.sensors.end(),
                       [](const Sensor& sensor) { return sensor.measured && is_buried(sensor); });
}

std::vector<Sensor::Share> shares_of(const Sensor& sensor) {
    return sensor.shares.empty() ? std::vector<Sensor::Share>{{.gauge = sensor.gauge}} : sensor.shares;
}

void make_uzan(Layer& layer) {
    const auto modulus = layer.law->index_of("modulus_MPa");
    const auto poisson = layer.law->index_of("poisson");
    if (layer.law->stress_dependent() || !modulus || !poisson) {
        return;
    }
    const double e = layer.parameters[*modulus];
    const double nu = layer.parameters[*poisson];
    layer.law = material::find_law("uzan");
    layer.parameters.clear();
    for (const material::ParameterInfo& info : layer.law->parameters()) {
        layer.parameters.push_back(info.to_si * info.default_value.value_or(0.0));
    }
    const auto set = [&](std::string_view key, double value) { layer.parameters[*layer.law->index_of(key)] = value; };
    set("modulus_axis", 1.0);
    set("k1", e / unit::reference_pressure);
    set("n", 1.0);
    set("poisson_12", nu);
    set("poisson_31", nu);
}

double shear_ratio_of(const Layer& layer) {
    const auto value = [&](std::string_view key) { return layer.parameters[*layer.law->index_of(key)]; };
    const double stated = value("shear_ratio");
    if (!std::isnan(stated)) {
        return stated;
    }
    const double n = value("n"); // 1/G13 = 1/E1 + (1 + 2 nu31)/E3
    return n / (1.0 + (1.0 + 2.0 * value("poisson_31")) * n);
}

namespace {

// From -1/2 at the top to 1/2 at the bottom.
double evenly_down(const fe::Field::Shape& shape, const Eigen::Vector3d& at) {
    return (at[2] - shape[0]) / shape[1] - 0.5;
}

} // namespace

void add_modulus_gradient(Case& c, std::string_view layer, double size) {
    const auto layers = layers_named(c, layer);
    const double top = top_of(c, layers.front());
    double thickness = 0.0;
    for (const std::size_t l : layers) {
        thickness += c.layers[l].thickness;
    }
    for (const std::size_t l : layers) {
        c.layers[l].fields.push_back(
            {.parameter = {}, .is_power = true, .size = size, .weight = evenly_down, .shape = {top, thickness}});
    }
}

} // namespace pave::pavement
