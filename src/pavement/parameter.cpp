#include "pavement/parameter.h"

#include "base/error.h"
#include "base/units.h"
#include "pavement/effects/effect.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

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
        {"damping_time_ms", unit::ms, 0.0, 100.0, false, 0.5,
         "under a load with a history: stress in proportion to the strain and this times its rate, a damping ratio of "
         "pi f damping_time at the frequency f; without a value 0 in a layer that relaxes",
         [](Layer& l) -> double& { return l.damping_time; }},
    };
    return keys;
}

std::span<const KeyInfo> load_keys(LoadType type, Patch patch, bool has_history) {
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
    static const KeyInfo duration{"duration_ms",
                                  unit::ms,
                                  0.0,
                                  1e9,
                                  true,
                                  30.0,
                                  "it rises and falls as sin^2(pi t / duration): for layers that relax",
                                  nullptr,
                                  [](Load& l) -> double& { return l.duration; }};
    static const KeyInfo shift{"time_shift_ms",
                               unit::ms,
                               -1e3,
                               1e3,
                               false,
                               0.0,
                               "with a history: added to the times of readings to get those of the history",
                               nullptr,
                               [](Load& l) -> double& { return l.time_shift; }};
    const auto as_recorded = [](KeyInfo key, std::string_view meaning) {
        key.default_value = std::numeric_limits<double>::quiet_NaN();
        key.meaning = meaning;
        return key;
    };
    constexpr std::string_view of_pressure = "the largest contact pressure, in place of that of the history";
    static const KeyInfo largest_pressure = as_recorded(pressure, of_pressure);
    static const KeyInfo largest_tyre_pressure = as_recorded(tyre_pressure, of_pressure);
    static const KeyInfo largest_force =
        as_recorded(force, "the largest force of the whole wheel assembly, in place of that of the history");
    static const KeyInfo plate[] = {radius, pressure, duration};
    static const KeyInfo recorded[] = {radius, largest_pressure, shift};
    static const KeyInfo recorded_wheel_circle[] = {largest_force, largest_tyre_pressure, shift};
    static const KeyInfo recorded_wheel[] = {largest_force, largest_tyre_pressure, width, shift};
    static const KeyInfo recorded_dual_circle[] = {largest_force, largest_tyre_pressure, spacing, shift};
    static const KeyInfo recorded_dual[] = {largest_force, largest_tyre_pressure, spacing, width, shift};
    static const KeyInfo wheel_circle[] = {force, tyre_pressure, duration};
    static const KeyInfo wheel[] = {force, tyre_pressure, width, duration};
    static const KeyInfo dual_circle[] = {force, tyre_pressure, spacing, duration};
    static const KeyInfo dual[] = {force, tyre_pressure, spacing, width, duration};
    static const KeyInfo gear[] = {tyre_pressure};
    using Keys = std::span<const KeyInfo>;
    const auto of = [&](Keys circle, Keys rectangle) { return patch == Patch::circle ? circle : rectangle; };
    switch (type) {
    case LoadType::plate: return has_history ? Keys(recorded) : plate;
    case LoadType::gear: return gear;
    case LoadType::wheel: return has_history ? of(recorded_wheel_circle, recorded_wheel) : of(wheel_circle, wheel);
    case LoadType::dual_wheel: break;
    }
    return has_history ? of(recorded_dual_circle, recorded_dual) : of(dual_circle, dual);
}

std::span<const KeyInfo> load_keys(const Load& load) {
    return load_keys(load.type, load.patch, load.is_pulse());
}

double& Parameter::in(Case& c) const {
    if (in_effect) {
        return c.effects[owner].size;
    }
    if (in_correction) {
        return c.corrections[owner].factors[place];
    }
    if (in_load) {
        return key->of_load(c.loads[owner]);
    }
    Layer& layer = c.layers[owner];
    return law_index ? layer.parameters[*law_index] : key->of(layer);
}

double Parameter::get(const Case& c) const {
    Case copy;
    if (in_effect) {
        copy.effects = c.effects;
    } else if (in_correction) {
        copy.corrections = c.corrections;
    } else if (in_load) {
        copy.loads = c.loads;
    } else {
        copy.layers = c.layers;
    }
    return in(copy) / to_si;
}

namespace {

// Calls f(parameter) for every number of the case, or for that of one path alone.
template <class F>
void each_parameter(const Case& c, F f, std::string_view only = {}) {
    const auto is_wanted = [&](std::string_view owner, std::string_view key) {
        return only.empty() || (only.size() == owner.size() + 1 + key.size() && only.starts_with(owner) &&
                                only[owner.size()] == '.' && only.ends_with(key));
    };
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
            if (!is_wanted(layer.name, key.key)) {
                continue;
            }
            Parameter p = of_key(key);
            p.path = layer.name + "." + std::string(key.key);
            p.owner = static_cast<int>(l);
            f(p);
        }
        const auto infos = layer.law->parameters();
        for (std::size_t i = 0; i < infos.size(); ++i) {
            if (!infos[i].choices.empty() || !is_wanted(layer.name, infos[i].key)) {
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
        for (const KeyInfo& key : load_keys(c.loads[l])) {
            if (!is_wanted(c.loads[l].name, key.key)) {
                continue;
            }
            Parameter p = of_key(key);
            p.path = c.loads[l].name + "." + std::string(key.key);
            p.in_load = true;
            p.owner = static_cast<int>(l);
            f(p);
        }
    }
    for (std::size_t i = 0; i < c.effects.size(); ++i) {
        const Effect& effect = *c.effects[i].effect;
        // Several wrong readings: the first is "outlier", the second "outlier-2".
        const auto before = std::count_if(c.effects.begin(), c.effects.begin() + static_cast<std::ptrdiff_t>(i),
                                          [&](const AppliedEffect& other) { return other.effect == &effect; });
        const std::string name = std::string(effect.name) + (before > 0 ? "-" + std::to_string(before + 1) : "");
        if (!is_wanted(name, "size")) {
            continue;
        }
        Parameter p;
        p.path = name + ".size";
        p.in_effect = true;
        p.owner = static_cast<int>(i);
        p.low = effect.low;
        p.high = effect.high;
        f(p);
    }
    for (std::size_t i = 0; i < c.corrections.size(); ++i) {
        const std::string name = c.corrections[i].name();
        for (std::size_t k = 0; k < c.corrections[i].factors.size(); ++k) {
            std::string key = "factor_";
            key += std::to_string(k + 1);
            if (!is_wanted(name, key)) {
                continue;
            }
            Parameter p;
            p.path = std::string(name).append(".").append(key);
            p.in_correction = true;
            p.owner = static_cast<int>(i);
            p.place = k;
            p.high = largest_factor;
            p.low_is_open = true;
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
    if (!path.empty()) {
        each_parameter(
            c, [&](const Parameter& p) { found = p; }, path);
    }
    if (!found) {
        const auto paths = parameter_paths(c);
        const std::string near = nearest_name(path, paths);
        throw Error(place, "this parameter names nothing in the study", "\"" + std::string(path) + "\"",
                    (near.empty() ? "" : "did you mean \"" + near + "\"? ") + "one of " + join(paths));
    }
    return *found;
}

namespace {

using Kind = fe::Variation::Kind;

// Calls f(number, variation, factor) for every number of a case without effects that the solver differentiates by under
// a load. d(response)/d(number) is the derivative by the variation times the factor.
template <class F>
void each_number(Case& c, int load, F f) {
    for (std::size_t l = 0; l < c.layers.size(); ++l) {
        Layer& layer = c.layers[l];
        const auto own = static_cast<int>(l);
        f(layer.density, fe::Variation{.kind = Kind::unit_weight, .layer = own}, unit::gravity);
        f(layer.k0, fe::Variation{.kind = Kind::k0, .layer = own}, 1.0);
        f(layer.residual_stress, fe::Variation{.kind = Kind::residual_stress, .layer = own}, 1.0);
        f(layer.damping_time, fe::Variation{.kind = Kind::damping, .layer = own}, 1.0);
        for (std::size_t i = 0; i < layer.parameters.size(); ++i) {
            f(layer.parameters[i], fe::Variation{.kind = Kind::law_parameter, .layer = own, .index = i}, 1.0);
        }
        for (std::size_t i = 0; i < layer.fields.size(); ++i) {
            f(layer.fields[i].size, fe::Variation{.kind = Kind::field, .layer = own, .index = i}, 1.0);
        }
    }
    std::size_t spring = 0; // in the order of springs_of()
    for (Layer& layer : c.layers) {
        if (layer.compliance) {
            const double stiffness = 1.0 / *layer.compliance;
            f(*layer.compliance, fe::Variation{.kind = Kind::spring, .index = spring++}, -stiffness * stiffness);
        }
    }
    Load& on = c.loads[load];
    if (on.plate_stiffness) {
        f(*on.plate_stiffness, fe::Variation{.kind = Kind::spring, .index = spring}, 1.0);
    }
    f(on.factor, fe::Variation{.kind = Kind::load_factor}, 1.0 / on.factor);
    f(on.pressure_shape, fe::Variation{.kind = Kind::pressure_shape}, 1.0);
    if (on.inertia) {
        f(*on.inertia, fe::Variation{.kind = Kind::inertia}, 1.0);
    }
    if (on.is_pulse()) {
        f(on.time_shift, fe::Variation{.kind = Kind::time_shift}, 1.0);
    } else if (!on.inertia) {
        f(on.duration, fe::Variation{.kind = Kind::duration}, 1.0 / on.duration);
    }
    if (on.type == LoadType::plate) { // of a wheel it sets the size of the patch
        f(on.pressure, fe::Variation{.kind = Kind::load_factor}, 1.0 / on.pressure);
    }
}

// The case as a load sees it without those numbers: where two of them differ, no derivative of the solver tells.
struct Rest {
    std::vector<Layer> layers;
    Load load;
    std::vector<Sensor> sensors;
    bool operator==(const Rest&) const = default;
};

Rest rest_of(Case c, int load) {
    each_number(c, load, [](double& number, const fe::Variation&, double) { number = 0.0; });
    Rest rest{c.layers, c.loads[load], {}};
    for (Sensor& sensor : c.sensors) {
        if (sensor.load == load) {
            sensor.gain = 0.0;
            rest.sensors.push_back(sensor);
        }
    }
    return rest;
}

std::vector<double> numbers_of(Case c, int load) {
    std::vector<double> numbers;
    each_number(c, load, [&](double& number, const fe::Variation&, double) { numbers.push_back(number); });
    for (const Sensor& sensor : c.sensors) {
        numbers.push_back(sensor.gain);
    }
    return numbers;
}

Case without_geometry(Case c) {
    for (Layer& layer : c.layers) {
        for (const KeyInfo& key : layer_keys()) {
            if (key.changes_geometry) {
                key.of(layer) = 0.0;
            }
        }
    }
    for (Load& load : c.loads) {
        for (const KeyInfo& key : load_keys(load)) {
            if (key.changes_geometry) {
                key.of_load(load) = 0.0;
            }
        }
    }
    return c;
}

// Whether all that geometry changes of a case without effects is what the solver's motions hold.
bool is_moved_by_its_mesh(const Case& c, int load) {
    return !c.loads[load].plate_stiffness && !c.loads[load].inertia &&
           std::none_of(c.layers.begin(), c.layers.end(),
                        [](const Layer& layer) { return layer.compliance || !layer.fields.empty(); });
}

Derivative one_term(const fe::Variation& variation, double factor) {
    return {.terms = {{variation, factor}}, .gain_rates = {}};
}

// The derivative by a parameter of a case without effects.
std::optional<Derivative> direct_derivative(const Case& c, const Parameter& parameter, int load) {
    if (parameter.in_load && parameter.owner != load) {
        return Derivative{};
    }
    if (parameter.changes_geometry()) {
        return is_moved_by_its_mesh(c, load) ? std::optional(one_term({.kind = Kind::motion}, 1.0)) : std::nullopt;
    }
    if (parameter.in_load) {
        if (parameter.key->key == "time_shift_ms") {
            return one_term({.kind = Kind::time_shift}, parameter.to_si);
        }
        const bool is_duration = parameter.key->key == "duration_ms";
        if (is_duration && c.loads[load].inertia) {
            return std::nullopt;
        }
        // By its logarithm; so is the pressure of a plate, a factor on its load.
        return one_term({.kind = is_duration ? Kind::duration : Kind::load_factor}, 1.0 / parameter.get(c));
    }
    if (parameter.law_index) {
        return one_term({.kind = Kind::law_parameter, .layer = parameter.owner, .index = *parameter.law_index},
                        parameter.to_si);
    }
    const std::string_view key = parameter.key->key;
    if (key == "density_kg_m3") {
        return one_term({.kind = Kind::unit_weight, .layer = parameter.owner}, unit::gravity);
    }
    const Kind kind = key == "k0" ? Kind::k0 : key == "damping_time_ms" ? Kind::damping : Kind::residual_stress;
    return one_term({.kind = kind, .layer = parameter.owner}, parameter.to_si);
}

} // namespace

bool differ_in_sensors_alone(Case a, Case b, int load) {
    a.sensors.clear();
    b.sensors.clear();
    const std::vector<double> of_a = numbers_of(a, load);
    const std::vector<double> of_b = numbers_of(b, load);
    const auto same = [](double x, double y) { return x == y || (std::isnan(x) && std::isnan(y)); }; // not given
    return std::equal(of_a.begin(), of_a.end(), of_b.begin(), of_b.end(), same) &&
           rest_of(std::move(a), load) == rest_of(std::move(b), load);
}

std::optional<Derivative> exact_derivative(const Case& c, const Parameter& parameter, int load) {
    Case here = with_effects(c, load);
    if (c.ties.empty() &&
        std::none_of(c.effects.begin(), c.effects.end(), [](const AppliedEffect& e) { return is_active(e); }) &&
        std::none_of(c.corrections.begin(), c.corrections.end(), [](const Correction& k) { return is_active(k); })) {
        return direct_derivative(c, parameter, load);
    }
    const double value = parameter.get(c);
    const double scale = parameter.in_effect ? parameter.high - parameter.low : std::abs(value);
    const double step = 1e-5 * (scale > 0.0 ? scale : 1.0);
    const auto at = [&](double offset) {
        Case moved = c;
        parameter.in(moved) = (value + offset * step) * parameter.to_si;
        return with_effects(moved, load);
    };
    const std::array<Case, 4> moved{at(-2), at(-1), at(1), at(2)};
    const bool moves = rest_of(moved[0], load) != rest_of(moved[3], load);
    if (moves && !((parameter.changes_geometry() || parameter.in_effect) && is_moved_by_its_mesh(here, load) &&
                   rest_of(without_geometry(moved[0]), load) == rest_of(without_geometry(moved[3]), load))) {
        return std::nullopt;
    }
    std::array<std::vector<double>, 4> numbers;
    std::transform(moved.begin(), moved.end(), numbers.begin(), [&](const Case& m) { return numbers_of(m, load); });
    // Fourth order; exactly zero for a number that does not move.
    const auto slope = [&](std::size_t i) {
        const double far = numbers[3][i] - numbers[0][i];
        const double near = numbers[2][i] - numbers[1][i];
        return std::isnan(far) ? 0.0 : (8.0 * near - far) / (12.0 * step);
    };
    Derivative derivative;
    std::size_t i = 0;
    each_number(here, load, [&](double&, const fe::Variation& variation, double factor) {
        if (const double rate = slope(i++); rate != 0.0) {
            derivative.terms.push_back({variation, factor * rate});
        }
    });
    for (; i < numbers[0].size(); ++i) {
        derivative.gain_rates.push_back(slope(i));
    }
    if (moves) {
        if (!derivative.terms.empty()) {
            return std::nullopt;
        }
        derivative.terms.push_back({{.kind = Kind::motion}, 1.0});
    }
    return derivative;
}

} // namespace pave::pavement
