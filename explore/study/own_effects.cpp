#include "study/own_effects.h"

#include "base/text.h"
#include "pavement/effects/catalog.h"
#include "study/read_model.h"
#include "study/readings.h"

#include <algorithm>
#include <fmt/format.h>

namespace explore::study {

using namespace pave::pavement;

namespace {

// Of the catalogue those that act on readings, whatever is read.
constexpr std::string_view of_readings[] = {"outlier", "sensor-gain"};

bool is_of_readings(std::string_view name) {
    return std::find(std::begin(of_readings), std::end(of_readings), name) != std::end(of_readings);
}

// The size that stands in [[effects]]; nothing: it has none.
std::optional<double> size_in(TableReader& reader, const Effect& effect) {
    return reader.has(keys::effect_size)
               ? std::optional(reader.number(keys::effect_size.key, effect.low, effect.high, false))
               : std::nullopt;
}

AppliedEffect read_of_readings(TableReader& reader, const Study& study, const Effect& effect) {
    AppliedEffect applied{.effect = &effect, .size = size_in(reader, effect).value_or(effect.null)};
    if (reader.has(keys::effect_reading)) {
        applied.reading =
            reader.integer(keys::effect_reading, 1, std::max(1, static_cast<int>(study.measured().size())), 1) - 1;
    }
    if (effect.takes_load && reader.has(keys::effect_load)) {
        applied.load = find_load(study.model, reader.text(keys::effect_load), reader.place(keys::effect_load));
    }
    if (effect.takes_quantity && reader.has(keys::effect_quantity)) {
        const std::string quantity = reader.text(keys::effect_quantity);
        std::vector<std::string> names;
        for (std::size_t i = 0; i < study.readings.size(); ++i) {
            names.push_back(study.readings[i].quantity);
            if (quantity == names.back()) {
                applied.quantity = study.model.sensors[i].quantity;
            }
        }
        if (!applied.quantity) {
            throw pave::Error(reader.place(keys::effect_quantity), "no reading has this quantity",
                              "\"" + quantity + "\"", pave::join(names));
        }
    }
    return applied;
}

// Reads everything but the name.
void read_declared(TableReader& reader, const OwnEffects& others, OwnEffect& own) {
    own.parameter = reader.text(keys::effect_parameter);
    own.place = reader.place(keys::effect_parameter);
    for (const OwnEffect& other : others) {
        if (&other != &own && other.parameter == own.parameter) {
            throw pave::Error(own.place, "two effects change this parameter", "\"" + own.parameter + "\"",
                              "one parameter an effect");
        }
    }
    check_own_name(own.parameter, own.place);
    Effect& effect = own.effect;
    const std::vector<double> range = reader.numbers(keys::effect_range);
    if (range.size() != 2 || !(range[0] < range[1])) {
        throw pave::Error(reader.place(keys::effect_range), "a range has two ends, the smaller first",
                          fmt::format("[{}]", fmt::join(range, ", ")), "[LEAST, LARGEST]");
    }
    effect.low = range[0];
    effect.high = range[1];
    effect.log_scale = effect.low > 0.0;
    const auto within = [&](const Key& key) { return reader.number(key.key, effect.low, effect.high, false); };
    effect.null = within(keys::effect_null);
    effect.typical = within(keys::effect_typical);
    if (effect.typical == effect.null) {
        throw pave::Error(reader.place(keys::effect_typical), "a typical size is another than none",
                          fmt::format("{}", effect.typical), "a size that is seen in practice");
    }
    own.mechanism = fmt::format("The study declares it: its model's parameter {} is {:g} without the effect, {:g} is "
                                "typical of it.",
                                own.parameter, effect.null, effect.typical);
    own.acts_on = own.parameter;
    effect.name = own.name;
    effect.unit = "-";
    effect.mechanism = own.mechanism;
    effect.source = "the study";
    effect.acts_on = own.acts_on;
    effect.apply = [](Case&, const AppliedEffect&, int) {}; // the model itself does it
    effect.in_words = [](const AppliedEffect& a) {
        return fmt::format("{} is {:.4g}, not {:g}", a.effect->acts_on, a.size, a.effect->null);
    };
}

// How the sensors read with this effect of this size alone.
std::vector<double> gains(const Study& study, AppliedEffect applied, double size) {
    Case bare;
    bare.loads = study.model.loads;
    bare.sensors = study.model.sensors;
    applied.size = size;
    applied.effect->apply(bare, applied, 0);
    std::vector<double> gains;
    for (const Sensor& sensor : bare.sensors) {
        gains.push_back(sensor.gain);
    }
    return gains;
}

const OwnModel& own_model_of(const Study& study) {
    return static_cast<const OwnModel&>(*study.external); // the only one that studies have
}

} // namespace

OwnModel::OwnModel(std::shared_ptr<const external::Simulator> simulator, problem::ParameterSpace space,
                   std::vector<double> to_si, std::shared_ptr<const OwnEffects> declared)
    : external::Model(std::move(simulator), std::move(space), std::move(to_si), declared->size()),
      effects(std::move(declared)) {}

std::shared_ptr<const OwnEffects> read_own_effects(const std::vector<const toml::table*>& tables, Study& study) {
    auto declared = std::make_shared<OwnEffects>();
    for (const toml::table* table : tables) {
        TableReader reader(*table, study.file, "[[effects]]");
        const std::string name = reader.text(keys::effect_name);
        reader.rename("effect \"" + name + "\"");
        if (is_of_readings(name)) {
            AppliedEffect applied = read_of_readings(reader, study, *find_effect(name));
            reader.done();
            check_effect(study, applied, reader.place(keys::effect_name));
            study.model.effects.push_back(std::move(applied));
            continue;
        }
        if (name.empty() || name.find('.') != std::string::npos || pave::printable(name) != name ||
            find_effect(name) != nullptr) {
            throw pave::Error(reader.place(keys::effect_name), "this cannot be the name of an effect of your own",
                              "\"" + name + "\"",
                              "a name without a full stop that no effect of the built-in model has; or " +
                                  pave::join({of_readings[0].data(), of_readings[1].data()}) + ", of readings");
        }
        for (const OwnEffect& other : *declared) {
            if (other.name == name) {
                throw pave::Error(reader.place(keys::effect_name), "this effect is given twice", "\"" + name + "\"",
                                  "each once");
            }
        }
        OwnEffect& own = declared->emplace_back();
        own.name = name;
        read_declared(reader, *declared, own);
        const auto size = size_in(reader, own.effect);
        reader.done();
        if (size) {
            study.model.effects.push_back({.effect = &own.effect, .size = *size});
        }
    }
    return declared;
}

void check_own_effects(const OwnEffects& effects, const Study& study) {
    for (const OwnEffect& own : effects) {
        for (const problem::Axis& axis : study.space.axes) {
            if (axis.name == own.parameter) {
                throw pave::Error(own.place, "this parameter is fitted: it is no effect that the model may lack",
                                  "\"" + own.parameter + "\"", "a parameter of the model that is not fitted");
            }
        }
    }
}

std::vector<const Effect*> effects_of(const Study& study) {
    if (!study.has_own_model) {
        return {effects().begin(), effects().end()};
    }
    std::vector<const Effect*> list;
    for (const OwnEffect& own : *own_model_of(study).effects) {
        list.push_back(&own.effect);
    }
    for (const std::string_view name : of_readings) {
        list.push_back(find_effect(name));
    }
    return list;
}

const Effect& effect_named(const Study& study, const std::string& name, const pave::Place& place) {
    std::vector<std::string> names;
    for (const Effect* effect : effects_of(study)) {
        names.emplace_back(effect->name);
        if (name == effect->name) {
            return *effect;
        }
    }
    const std::string near = pave::nearest_name(name, names);
    throw pave::Error(place, near.empty() ? "unknown effect" : "unknown effect, did you mean \"" + near + "\"?",
                      "\"" + name + "\"", pave::join(names));
}

std::optional<Parameter> own_size(const Study& study, const std::string& path) {
    Case sizes;
    sizes.effects = study.model.effects;
    const auto paths = parameter_paths(sizes);
    return std::find(paths.begin(), paths.end(), path) != paths.end()
               ? std::optional(find_parameter(sizes, path, {.file = study.file}))
               : std::nullopt;
}

std::shared_ptr<const problem::ForwardFunction> own_function(const Study& study,
                                                             const std::vector<Parameter>& parameters) {
    const auto& applied = study.model.effects;
    std::vector<double> nominal = study.model.corrections[0].factors;
    std::vector<std::size_t> place(applied.size()); // of each effect among values and scalings
    for (const OwnEffect& own : *own_model_of(study).effects) {
        const auto known =
            std::find_if(applied.begin(), applied.end(), [&](const auto& a) { return a.effect == &own.effect; });
        if (known != applied.end()) {
            place[static_cast<std::size_t>(known - applied.begin())] = nominal.size();
        }
        nominal.push_back(known == applied.end() ? own.effect.null : known->size);
    }
    std::vector<external::Scaling> scalings;
    for (std::size_t e = 0; e < applied.size(); ++e) {
        if (!is_of_readings(applied[e].effect->name)) {
            continue;
        }
        place[e] = nominal.size() + scalings.size();
        const std::vector<double> at_zero = gains(study, applied[e], 0.0); // gains are straight in the size
        const std::vector<double> at_one = gains(study, applied[e], 1.0);
        external::Scaling scaling{.rows = {}, .size = applied[e].size};
        for (std::size_t i = 0; i < at_zero.size(); ++i) {
            if (at_one[i] != at_zero[i]) {
                scaling.rows.push_back({i, at_zero[i], at_one[i] - at_zero[i]});
            }
        }
        scalings.push_back(std::move(scaling));
    }
    std::vector<std::size_t> which;
    for (const Parameter& parameter : parameters) {
        which.push_back(parameter.in_effect ? place[static_cast<std::size_t>(parameter.owner)] : parameter.place);
    }
    return external::make_function(study.external, std::move(nominal), std::move(scalings), std::move(which));
}

} // namespace explore::study
