#include "blind/hidden.h"

#include "base/units.h"
#include "pavement/effects/catalog.h"
#include "pavement/forward.h"

namespace blind {

namespace {

// Other forms than the catalogue's.
double rational_distance(const fe::Field::Shape& shape, const Eigen::Vector3d& at) {
    const double d = std::hypot(std::abs(at[0]) - shape[0], at[1]);
    const double reach = 1.5 * shape[1];
    return d * d / (d * d + reach * reach);
}
double root_of_depth(const fe::Field::Shape& shape, const Eigen::Vector3d& at) {
    return std::sqrt(std::max(0.0, at[2] - shape[0]));
}
double fading_with_depth(const fe::Field::Shape& shape, const Eigen::Vector3d& at) {
    constexpr double reach = 0.2; // m
    return -1.0 / (1.0 + std::pow(std::max(0.0, at[2] - shape[0]) / reach, 4));
}

// shape: top of the layer, its thickness, place, width.
double lens(const fe::Field::Shape& shape, const Eigen::Vector3d& at) {
    return -1.0 / (1.0 + std::pow((at[2] - shape[0] - shape[2]) / shape[3], 8));
}
double crust(const fe::Field::Shape& shape, const Eigen::Vector3d& at) {
    return std::exp(-std::pow((at[2] - shape[0]) / shape[3], 2));
}
double bulge(const fe::Field::Shape& shape, const Eigen::Vector3d& at) {
    const double zeta = (at[2] - shape[0]) / shape[1];
    return 4.0 * zeta * (1.0 - zeta);
}
double wet_bottom(const fe::Field::Shape& shape, const Eigen::Vector3d& at) {
    const double zeta = (at[2] - shape[0]) / shape[1];
    return -1.0 / (1.0 + std::exp((0.67 - zeta) / 0.04));
}
// shape: x of the load's patch, half its width, place, width.
double aside(const fe::Field::Shape& shape, const Eigen::Vector3d& at) {
    return std::hypot(std::abs(at[0]) - shape[0], at[1]);
}
double outside_radius(const fe::Field::Shape& shape, const Eigen::Vector3d& at) {
    return -1.0 / (1.0 + std::exp((shape[2] - aside(shape, at)) / 0.02));
}
double loose_beside(const fe::Field::Shape& shape, const Eigen::Vector3d& at) {
    return std::expm1(-std::pow(aside(shape, at) / (2.0 * shape[3]), 4));
}
double bulb(const fe::Field::Shape& shape, const Eigen::Vector3d& at) {
    return -std::exp(-std::pow(aside(shape, at) / (2.0 * shape[3]), 2));
}

constexpr Outside outsides[] = {
    {"wet-lens", "depth", "subgrade", 2.5, lens},
    {"stiff-crust", "depth", "subgrade", 2.0, crust},
    {"compaction-bulge", "depth", "base", 2.0, bulge},
    {"wet-base-bottom", "depth", "base", 2.5, wet_bottom},
    {"cracked-asphalt", "distance", "asphalt", 3.0, outside_radius},
    {"loose-base", "distance", "base", 2.5, loose_beside},
    {"softened-bulb", "distance", "subgrade", 2.0, bulb},
    {"confined-subgrade", "theta", "subgrade", 1.5, nullptr}, // E in proportion to theta^size
    {"tilted-bar", "offset", "", 0.5, nullptr},               // every sensor farther off by this share
    {"gauges-by-depth", "level", "", 1.0, nullptr},           // readings times 1 + size (depth/0.5 m)^2
};

void apply_outside(Case& c, const Hidden& hidden, int load) {
    const Outside& outside = *hidden.outside;
    if (outside.weight != nullptr) {
        const std::size_t l = layers_named(c, outside.layer).front();
        const auto patch = c.loads[static_cast<std::size_t>(load)].footprint();
        const bool is_depth = outside.channel == "depth";
        c.layers[l].fields.push_back(
            {.parameter = {},
             .is_power = true,
             .size = hidden.size,
             .weight = outside.weight,
             .shape = {is_depth ? top_of(c, l) : patch.centre, is_depth ? c.layers[l].thickness : patch.half_x,
                       hidden.place, hidden.width}});
    } else if (outside.channel == "theta") {
        Layer& layer = c.layers.back();
        make_uzan(layer);
        layer.parameters[*layer.law->index_of("k2")] = hidden.size;
    } else {
        for (Sensor& sensor : c.sensors) {
            const bool is_deflection = sensor.quantity == Quantity::deflection;
            if (is_deflection && outside.channel == "offset") {
                sensor.x *= 1.0 + hidden.size;
            } else if (!is_deflection && outside.channel == "level") {
                sensor.gain *= 1.0 + hidden.size * std::pow(sensor.depth / 0.5, 2);
            }
        }
    }
}

// The modulus of a linear layer along the channel: [place in mm, MPa].
Json profile(const Case& c, const Hidden& hidden) {
    Json list = Json::array();
    const Outside& outside = *hidden.outside;
    const std::size_t l = outside.layer.empty() ? 0 : layers_named(c, outside.layer).front();
    if (outside.weight == nullptr || c.layers[l].law->stress_dependent()) {
        return list;
    }
    const bool is_depth = outside.channel == "depth";
    const double top = is_depth ? top_of(c, l) : 0.0;
    const fe::Field::Shape shape{top, is_depth ? c.layers[l].thickness : 0.1, hidden.place, hidden.width};
    for (double at = 0.0; at < (is_depth ? c.layers[l].thickness : 2.0); at += 0.01) {
        const Eigen::Vector3d point = is_depth ? Eigen::Vector3d{0, 0, top + at} : Eigen::Vector3d{at, 0, 0};
        list.push_back({at / unit::mm,
                        c.layers[l].parameters[0] * std::exp(hidden.size * outside.weight(shape, point)) / unit::MPa});
    }
    return list;
}

// The catalogue's forms turn a case into another for one load at a time; ours do so here.
constexpr std::string_view forms[][2] = {
    {"anisotropy-distribution", "n rises with d^2/(d^2 + (1.5 a)^2), whatever the depth"},
    {"subgrade-depth-gradient", "E grows with the root of the depth"},
    {"weak-subgrade-top", "E falls towards the top without a step, like 1/(1 + (depth/200 mm)^4)"},
    {"base-residual-stress", "a quarter more of it in the lower half of the base, a quarter less in the upper"},
    {"wheel-wander", "the wheel is anywhere within a band alike"},
};

void apply_form(Case& c, const Hidden& hidden, int load) {
    if (hidden.outside != nullptr) {
        apply_outside(c, hidden, load);
        return;
    }
    const std::string_view name = hidden.effect->name;
    const std::size_t base = 1;
    const std::size_t subgrade = c.layers.size() - 1;
    if (name == "anisotropy-distribution") {
        const auto patch = c.loads[static_cast<std::size_t>(load)].footprint();
        c.layers[base].fields.push_back({.parameter = c.layers[base].law->index_of("n"),
                                         .target = 1.0,
                                         .size = hidden.size,
                                         .weight = rational_distance,
                                         .shape = {patch.centre, patch.half_x}});
    } else if (name == "subgrade-depth-gradient") {
        c.layers[subgrade].fields.push_back(
            {.parameter = {}, .size = hidden.size, .weight = root_of_depth, .shape = {top_of(c, subgrade)}});
    } else if (name == "weak-subgrade-top") {
        c.layers[subgrade].fields.push_back({.parameter = {},
                                             .size = 1.0 - std::exp(-hidden.size),
                                             .weight = fading_with_depth,
                                             .shape = {top_of(c, subgrade)}});
    } else if (name == "base-residual-stress") {
        Layer upper = c.layers[base];
        upper.thickness /= 2.0;
        c.layers[base].thickness -= upper.thickness;
        upper.residual_stress += 0.75 * hidden.size * unit::kPa;
        c.layers[base].residual_stress += 1.25 * hidden.size * unit::kPa;
        c.layers.insert(c.layers.begin() + static_cast<std::ptrdiff_t>(base), upper);
    } else { // wheel-wander: a band of the same standard deviation
        constexpr int places = 15;
        for (Sensor& sensor : c.sensors) {
            if (sensor.load == load && c.loads[static_cast<std::size_t>(load)].type != LoadType::plate) {
                for (int i = 0; i < places; ++i) {
                    const double at = std::sqrt(3.0) * ((2.0 * i + 1.0) / places - 1.0);
                    sensor.shares.push_back({at * hidden.size * unit::mm, 0.0, 1.0 / places});
                }
            }
        }
    }
}

// Without those that only a history tells: the cases here are of peaks.
std::vector<const Effect*> drawn_effects() {
    std::vector<const Effect*> drawn;
    std::ranges::copy_if(effects(), std::back_inserter(drawn), [](const Effect* e) {
        return e->name != "damping" && e->name != "asphalt-relaxation" && e->name != "density";
    });
    return drawn;
}

} // namespace

VectorXd responses_with(const Case& plain, const std::vector<Hidden>& hidden) {
    Case c = plain;
    bool own_form = false;
    for (const Hidden& h : hidden) {
        if (h.effect != nullptr && h.form.empty()) {
            c.effects.push_back(h.options);
            c.effects.back().effect = h.effect;
            c.effects.back().size = h.size;
        }
        own_form = own_form || h.outside != nullptr || !h.form.empty();
    }
    if (!own_form) {
        return responses(c);
    }
    VectorXd all(static_cast<Eigen::Index>(plain.sensors.size()));
    for (std::size_t load = 0; load < c.loads.size(); ++load) {
        Case one = c;
        for (const Hidden& h : hidden) {
            if (h.outside != nullptr || !h.form.empty()) {
                apply_form(one, h, static_cast<int>(load));
            }
        }
        const ForwardModel model(one);
        const auto outcome = model.run(one, {}, *model.make_workspace());
        if (!outcome) {
            return {};
        }
        for (std::size_t i = 0; i < plain.sensors.size(); ++i) {
            if (plain.sensors[i].load == static_cast<int>(load)) {
                all[static_cast<Eigen::Index>(i)] = outcome->values[i];
            }
        }
    }
    return all;
}

Hidden draw_hidden(Draw& draw, const Case& c, const std::string& kind) {
    Hidden hidden;
    if (kind == "outside") {
        hidden.outside = &outsides[draw.below(std::size(outsides))];
        hidden.place = draw.uniform(hidden.outside->layer == "subgrade" ? 0.15 : 0.2, 0.4);
        hidden.width = draw.uniform(0.08, 0.15);
        return hidden;
    }
    hidden.effect = find_effect(kind);
    if (hidden.effect == nullptr) {
        const auto all = drawn_effects();
        hidden.effect = all[draw.below(all.size())];
    }
    const Effect& effect = *hidden.effect;
    const int load = static_cast<int>(draw.below(c.loads.size()));
    if (effect.takes_reading && !effect.takes_quantity) {
        hidden.options.reading = static_cast<int>(draw.below(c.sensors.size()));
    } else if (effect.takes_quantity) {
        const Sensor& sensor = c.sensors[draw.below(c.sensors.size())];
        hidden.options.quantity = sensor.quantity;
        if (draw.chance(0.7)) {
            hidden.options.load = sensor.load;
        }
    } else if (effect.takes_load && draw.chance(0.5)) {
        hidden.options.load = load;
    }
    for (const auto& [name, form] : forms) {
        if (name == effect.name && !hidden.options.load && draw.chance(0.5)) {
            hidden.form = form;
        }
    }
    return hidden;
}

Json words(const Case& c, const Hidden& hidden) {
    Json json = {{"effect", hidden.name()}, {"size", hidden.size}, {"form", hidden.form}};
    if (hidden.outside != nullptr) {
        json["channel"] = std::string(hidden.outside->channel);
        json["layer"] = std::string(hidden.outside->layer);
        json["profile"] = profile(c, hidden);
    }
    if (hidden.options.load) {
        json["load"] = c.loads[static_cast<std::size_t>(*hidden.options.load)].name;
    }
    if (hidden.options.quantity) {
        json["quantity"] = std::string(info(*hidden.options.quantity).name);
    }
    if (hidden.options.reading) {
        json["reading"] = *hidden.options.reading + 1;
    }
    return json;
}

} // namespace blind
