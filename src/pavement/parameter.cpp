#include "pavement/parameter.h"

#include "base/error.h"
#include "base/units.h"

#include <cmath>

namespace pave::pavement {

std::span<const KeyInfo> layer_keys() {
    static const KeyInfo keys[] = {
        {"thickness_mm",
         unit::mm,
         0.0,
         1e5,
         true,
         {},
         "thickness of the layer",
         [](Layer& l) -> double& { return l.thickness; },
         nullptr,
         true},
        {"density_kg_m3",
         1.0,
         0.0,
         1e4,
         false,
         {},
         "density: its weight makes the initial stress",
         [](Layer& l) -> double& { return l.density; }},
        {"k0",
         1.0,
         0.0,
         10.0,
         false,
         {},
         "horizontal over vertical initial stress",
         [](Layer& l) -> double& { return l.k0; }},
        {"residual_stress_kPa", unit::kPa, 0.0, 1e3, false, 0.0, "horizontal compression locked in by compaction",
         [](Layer& l) -> double& { return l.residual_stress; }},
    };
    return keys;
}

std::span<const KeyInfo> load_keys(LoadType type, Patch patch) {
    static const KeyInfo pressure{
        "pressure_kPa", unit::kPa, 0.0, 1e4, true, {}, "contact pressure", nullptr, [](Load& l) -> double& {
            return l.pressure;
        }};
    static const KeyInfo tyre_pressure = [] {
        KeyInfo key = pressure;
        key.changes_geometry = true; // at a given force it sets the size of the patch
        return key;
    }();
    static const KeyInfo radius{"radius_mm",
                                unit::mm,
                                0.0,
                                5e3,
                                true,
                                {},
                                "radius of the plate",
                                nullptr,
                                [](Load& l) -> double& { return l.radius; },
                                true};
    static const KeyInfo force{"force_kN",
                               unit::kN,
                               0.0,
                               1e4,
                               true,
                               {},
                               "force of the whole wheel assembly",
                               nullptr,
                               [](Load& l) -> double& { return l.force; },
                               true};
    static const KeyInfo spacing{"spacing_mm",
                                 unit::mm,
                                 0.0,
                                 5e3,
                                 true,
                                 {},
                                 "distance of the patch centres of a dual",
                                 nullptr,
                                 [](Load& l) -> double& { return l.spacing; },
                                 true};
    static const KeyInfo width{"patch_width_mm",
                               unit::mm,
                               0.0,
                               2e3,
                               true,
                               160.0,
                               "width of a rectangular patch",
                               nullptr,
                               [](Load& l) -> double& { return l.patch_width; },
                               true};
    static const KeyInfo plate[] = {radius, pressure};
    static const KeyInfo wheel_circle[] = {force, tyre_pressure};
    static const KeyInfo wheel[] = {force, tyre_pressure, width};
    static const KeyInfo dual_circle[] = {force, tyre_pressure, spacing};
    static const KeyInfo dual[] = {force, tyre_pressure, spacing, width};
    switch (type) {
    case LoadType::plate: return plate;
    case LoadType::wheel: return patch == Patch::circle ? std::span<const KeyInfo>(wheel_circle) : wheel;
    case LoadType::dual_wheel: break;
    }
    return patch == Patch::circle ? std::span<const KeyInfo>(dual_circle) : dual;
}

double& Parameter::in(Case& c) const {
    if (in_load) {
        return key->of_load(c.loads[owner]);
    }
    Layer& layer = c.layers[owner];
    return law_index ? layer.parameters[*law_index] : key->of(layer);
}

double Parameter::get(const Case& c) const {
    Case copy;
    if (in_load) {
        copy.loads = c.loads;
    } else {
        copy.layers = c.layers;
    }
    return in(copy) / to_si;
}

namespace {

// Calls f(parameter) for every number of the case.
template <class F>
void each_parameter(const Case& c, F f) {
    const auto of_key = [](const KeyInfo& key) {
        Parameter p;
        p.key = &key;
        p.to_si = key.to_si;
        p.low = key.low;
        p.high = key.high;
        p.low_is_open = key.low_is_open;
        return p;
    };
    for (std::size_t l = 0; l < c.layers.size(); ++l) {
        const Layer& layer = c.layers[l];
        for (const KeyInfo& key : layer_keys()) {
            Parameter p = of_key(key);
            p.path = layer.name + "." + std::string(key.key);
            p.owner = static_cast<int>(l);
            f(p);
        }
        const auto infos = layer.law->parameters();
        for (std::size_t i = 0; i < infos.size(); ++i) {
            if (!infos[i].choices.empty()) {
                continue;
            }
            Parameter p;
            p.path = layer.name + "." + std::string(infos[i].key);
            p.owner = static_cast<int>(l);
            p.law_index = i;
            p.to_si = infos[i].to_si;
            p.low = infos[i].low;
            p.high = infos[i].high;
            p.low_is_open = infos[i].low_is_open;
            f(p);
        }
    }
    for (std::size_t l = 0; l < c.loads.size(); ++l) {
        for (const KeyInfo& key : load_keys(c.loads[l].type, c.loads[l].patch)) {
            Parameter p = of_key(key);
            p.path = c.loads[l].name + "." + std::string(key.key);
            p.in_load = true;
            p.owner = static_cast<int>(l);
            f(p);
        }
    }
}

} // namespace

std::vector<std::string> parameter_paths(const Case& c) {
    std::vector<std::string> paths;
    each_parameter(c, [&](const Parameter& p) { paths.push_back(p.path); });
    return paths;
}

Parameter find_parameter(const Case& c, std::string_view path, const Place& place) {
    std::optional<Parameter> found;
    each_parameter(c, [&](const Parameter& p) {
        if (p.path == path) {
            found = p;
        }
    });
    if (!found) {
        const auto paths = parameter_paths(c);
        const std::string near = nearest_name(path, paths);
        throw Error(place, "this parameter names nothing in the study", "\"" + std::string(path) + "\"",
                    (near.empty() ? "" : "did you mean \"" + near + "\"? ") + "one of " + join(paths));
    }
    return *found;
}

Derivative derivative_of(const Case& c, const Parameter& parameter) {
    using Kind = fe::Variation::Kind;
    if (parameter.in_load) { // the pressure of a plate: a factor on its load
        return {{.kind = Kind::load_factor}, 1.0 / parameter.get(c)};
    }
    if (parameter.law_index) {
        return {{.kind = Kind::law_parameter, .layer = parameter.owner, .index = *parameter.law_index},
                parameter.to_si};
    }
    const std::string_view key = parameter.key->key;
    if (key == "density_kg_m3") {
        return {{.kind = Kind::unit_weight, .layer = parameter.owner}, unit::gravity};
    }
    return {{.kind = key == "k0" ? Kind::k0 : Kind::residual_stress, .layer = parameter.owner}, parameter.to_si};
}

} // namespace pave::pavement
