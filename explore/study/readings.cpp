#include "study/readings.h"

#include "base/units.h"
#include "data/hash.h"
#include "data/history.h"
#include "pavement/forward.h"
#include "study/read_model.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace explore::study {

using namespace pave::pavement;
namespace unit = pave::unit;

int find_load(const Case& model, const std::string& name, const pave::Place& place) {
    for (std::size_t l = 0; l < model.loads.size(); ++l) {
        if (model.loads[l].name == name) {
            return static_cast<int>(l);
        }
    }
    throw pave::Error(place, "this load is not in the study", "\"" + name + "\"", pave::join(names_of(model.loads)));
}

Quantity find_quantity(const std::string& name, const pave::Place& place) {
    std::vector<std::string> names;
    for (const QuantityInfo& q : quantities) {
        if (q.name == name) {
            return q.quantity;
        }
        names.emplace_back(q.name);
    }
    throw pave::Error(place, "unknown quantity", "\"" + name + "\"", pave::join(names));
}

std::optional<double> time_of(std::optional<double> time_ms, const Load& load, const pave::Place& place) {
    if (!time_ms) {
        return std::nullopt;
    }
    if (!load.is_pulse()) {
        throw pave::Error(place, "only under a load with a history is there a time to read at",
                          fmt::format("{:g}", *time_ms), "nothing, or history = \"FILE.csv\" in the load");
    }
    if (!(std::abs(*time_ms) <= data::latest_ms)) {
        throw pave::Error(place, "value out of range", fmt::format("{:g}", *time_ms),
                          fmt::format("-{0:g} <= value <= {0:g}", data::latest_ms));
    }
    return *time_ms * unit::ms;
}

namespace {

data::Dimension dimension_of(Quantity quantity) {
    switch (quantity) {
    case Quantity::deflection:
    case Quantity::benkelman: return data::Dimension::length;
    case Quantity::strain_zz:
    case Quantity::strain_xx:
    case Quantity::strain_yy:
    case Quantity::slope: return data::Dimension::strain;
    default: return data::Dimension::pressure;
    }
}

Sensor sensor_of(const data::Reading& m, const Case& model) {
    const auto place = [&](const char* key) { return pave::Place{.file = m.file, .line = m.line, .key = key}; };
    Sensor s;
    s.load = find_load(model, m.load, place("load"));
    s.quantity = find_quantity(m.quantity, place("quantity"));
    if (m.unit.dimension != dimension_of(s.quantity)) {
        std::vector<std::string> fitting;
        for (const auto& u : data::units()) {
            if (u.dimension == dimension_of(s.quantity)) {
                fitting.emplace_back(u.name);
            }
        }
        throw pave::Error(place("unit"), "this unit does not fit the quantity " + m.quantity,
                          "\"" + std::string(m.unit.name) + "\"", pave::join(fitting));
    }
    s.x = m.x_mm * unit::mm;
    s.y = m.y_mm * unit::mm;
    s.depth = m.depth_mm * unit::mm;
    s.gauge = m.gauge_mm * unit::mm;
    s.time = time_of(m.time_ms, model.loads[static_cast<std::size_t>(s.load)], place("time_ms"));
    check_sensor(model, s, place(m.quantity.c_str()));
    return s;
}

} // namespace

void add_measurement(Study& study, data::Reading reading) {
    study.model.sensors.push_back(study.has_own_model ? own_sensor(study, reading) : sensor_of(reading, study.model));
    study.readings.push_back(std::move(reading));
}

std::vector<double> largest_of_group(const Study& study) {
    std::map<std::pair<std::string, std::string>, double> largest;
    for (const auto& m : study.measured()) {
        double& value = largest[{m.load, m.quantity}];
        value = std::max(value, std::abs(m.measured()));
    }
    std::vector<double> result;
    for (const auto& m : study.measured()) {
        result.push_back(largest[{m.load, m.quantity}]);
    }
    return result;
}

void set_groups(Study& study, const pave::Place& place, const std::vector<std::string>& held_out,
                const toml::table* weights) {
    study.groups.clear();
    std::vector<std::string> names;
    for (std::size_t i = 0; i < study.measured().size(); ++i) {
        const auto& m = study.readings[i];
        const std::string name = m.group();
        auto group =
            std::find_if(study.groups.begin(), study.groups.end(), [&](const Group& g) { return g.name == name; });
        if (group == study.groups.end()) {
            study.groups.push_back({.name = name, .rows = {}});
            group = study.groups.end() - 1;
            names.push_back(name);
            if (std::find(names.begin(), names.end(), m.load) == names.end()) {
                names.push_back(m.load);
            }
        }
        group->rows.push_back(i);
    }
    const auto each = [&](const std::string& name, const pave::Place& where, const auto& action) {
        bool found = false;
        for (Group& group : study.groups) {
            if (group.name == name || group.name.substr(0, group.name.rfind('.')) == name) {
                action(group);
                found = true;
            }
        }
        if (!found) {
            throw pave::Error(where, "no reading belongs to this group", "\"" + name + "\"", pave::join(names));
        }
    };
    for (const std::string& name : held_out) {
        each(name, place, [](Group& group) { group.held_out = true; });
    }
    if (weights != nullptr) {
        TableReader reader(*weights, study.file, "[data.weights]");
        for (const auto& [key, node] : *weights) {
            const std::string name(key.str());
            const double weight = reader.number(name, 0.0, 1e6, true);
            each(name, reader.place(name), [&](Group& group) { group.weight = weight; });
        }
    }
    if (!study.groups.empty() &&
        std::all_of(study.groups.begin(), study.groups.end(), [](const Group& g) { return g.held_out; })) {
        throw pave::Error(place, "every reading is held out: nothing is left to fit", pave::join(held_out),
                          "at least one group that is fitted");
    }
}

void read_noise(const toml::table& table, Study& study, const TableReader& of_data) {
    TableReader reader(table, study.file, "[data.noise]");
    if (reader.has(keys::noise_relative)) {
        if (study.data.noise_relative) {
            throw pave::Error(of_data.place(keys::data_noise_relative), "the relative noise is given twice",
                              "noise_relative and [data.noise] relative", "one of them");
        }
        study.data.noise_relative = reader.number(keys::noise_relative);
    }
    study.data.noise_line = reader.place("").line;
    study.data.noise_common_relative = reader.number(keys::noise_common_relative);
    study.data.noise_correlation_length = unit::mm * reader.number(keys::noise_correlation);
    study.data.noise_correlation_time = unit::ms * reader.number(keys::noise_correlation_time);
    study.data.noise_drift = unit::um / unit::ms * reader.number(keys::noise_drift);
    study.data.noise_of_drops = reader.has(keys::noise_of_drops) ? reader.integer(keys::noise_of_drops) : 0;
    study.data.noise_shared_relative = reader.number(keys::noise_shared_relative);
    study.data.noise_shared_common_relative = reader.number(keys::noise_shared_common_relative);
    const bool is_student = reader.choice(keys::noise_loss) == 1;
    if (!is_student && reader.has(keys::noise_degrees)) {
        throw pave::Error(reader.place(keys::noise_degrees), "degrees are of loss = \"student\"", "no such loss",
                          "loss = \"student\" beside it, or no degrees");
    }
    const double degrees = reader.number(keys::noise_degrees);
    study.data.noise_degrees = is_student ? degrees : 0.0;
    study.data.noise_scale_is_sought = reader.choice(keys::noise_scale) == 1;
    if (study.data.noise_scale_is_sought && (is_student || study.data.misfit != problem::MisfitKind::weighted)) {
        throw pave::Error(reader.place(keys::noise_scale), "a size of the noise is fitted by a misfit of normal noise",
                          is_student ? std::string("loss = \"student\"")
                                     : fmt::format("misfit = \"{}\"", to_string(study.data.misfit)),
                          "misfit = \"weighted\" and loss = \"normal\"");
    }
    if (study.data.shapes_noise() && study.data.misfit != problem::MisfitKind::weighted) {
        throw pave::Error(
            reader.place(study.data.noise_common_relative > 0.0          ? keys::noise_common_relative
                         : study.data.noise_shared_relative > 0.0        ? keys::noise_shared_relative
                         : study.data.noise_shared_common_relative > 0.0 ? keys::noise_shared_common_relative
                         : study.data.noise_correlation_length > 0.0     ? keys::noise_correlation
                         : study.data.noise_correlation_time > 0.0       ? keys::noise_correlation_time
                         : study.data.noise_drift > 0.0                  ? keys::noise_drift
                                                                         : keys::noise_loss),
            study.data.correlates_noise() ? "errors that readings have in common need a misfit by the stated noise"
                                          : "a distribution of errors needs a misfit by the stated noise",
            fmt::format("misfit = \"{}\"", to_string(study.data.misfit)), "misfit = \"weighted\" in [data]");
    }
    if (const auto* absolute = reader.table(keys::noise_absolute)) {
        TableReader each(*absolute, study.file, "[data.noise] absolute");
        for (const auto& [key, node] : *absolute) {
            const std::string name(key.str());
            const auto units = data::units();
            const auto unit = std::find_if(units.begin(), units.end(), [&](const auto& u) { return u.name == name; });
            if (unit == units.end()) {
                throw pave::Error(each.place(name), "unknown unit", "\"" + name + "\"",
                                  std::string(keys::noise_absolute.allowed));
            }
            double& value = study.data.noise_absolute[static_cast<std::size_t>(unit->dimension)];
            if (value > 0.0) {
                throw pave::Error(each.place(name), "this kind of reading has two absolute noises", "\"" + name + "\"",
                                  "one unit a kind");
            }
            value = unit->to_si * each.number(name, 0.0, 1e9, false);
        }
    }
    reader.done();
}

data::NoisePlace noise_place(const Sensor& sensor) {
    return {.load = sensor.load,
            .quantity = static_cast<int>(sensor.quantity),
            .x = sensor.x,
            .y = sensor.y,
            .depth = sensor.depth,
            .time = sensor.time};
}

namespace {

// By how much the noise of a reading differs from what is stated: a mean of n drops has the root of n-th part of what
// one has.
double drops_factor(const DataSettings& data, const data::Reading& m) {
    return data.noise_of_drops > 0 && m.drops > 0 ? std::sqrt(static_cast<double>(data.noise_of_drops) / m.drops) : 1.0;
}

// Adds to what each reading states what ties the errors of a load, and their distribution.
void shape_noise(Study& study) {
    const DataSettings& data = study.data;
    const std::span<data::Reading> measured(study.readings.data(), study.measured().size());
    if (!data.shapes_noise() || measured.empty()) {
        return;
    }
    if (study.noise != NoiseSource::stated) {
        throw pave::Error({.file = study.file, .line = data.noise_line, .key = "[data.noise]"},
                          "errors can be tied, or given a distribution, only where each reading's own is stated",
                          "common_relative, correlation_mm or loss without the noise of a single reading",
                          "relative or absolute beside them, or sigma in the measurement file");
    }
    for (std::size_t i = 0; i < measured.size(); ++i) {
        data::Noise& noise = measured[i].noise;
        noise.common_relative = drops_factor(data, measured[i]) * data.noise_common_relative;
        if (measured[i].drops > 0) { // what its drops share
            noise.common_relative = std::hypot(noise.common_relative, data.noise_shared_common_relative);
            noise.drift = data.noise_shared_relative * std::abs(measured[i].measured());
        }
        noise.relative = std::hypot(noise.relative, noise.common_relative);
        noise.correlation_length = data.noise_correlation_length;
        noise.correlation_time = data.noise_correlation_time;
        const Sensor& sensor = study.model.sensors[i];
        if (sensor.quantity == Quantity::deflection && sensor.time) {
            noise.drift = data.noise_drift * *sensor.time;
        }
        noise.degrees = data.noise_degrees;
        for (std::size_t j = 0; j < i && data.correlates_readings(); ++j) {
            if (data::own_correlation(noise_place(study.model.sensors[i]), noise_place(study.model.sensors[j]),
                                      data.noise_correlation_length, data.noise_correlation_time) == 1.0) {
                const std::string key(data.noise_correlation_length > 0.0 ? keys::noise_correlation.key
                                                                          : keys::noise_correlation_time.key);
                throw pave::Error({.file = measured[i].file, .line = measured[i].line, .key = key},
                                  "two readings of one place under one load cannot have correlated noise: their "
                                  "errors would be the same",
                                  measured[i].label(), "their mean as one reading, or " + key + " = 0");
            }
        }
    }
}

// The probability of a limit is that of independent normal errors of a known size.
void check_limits(const Study& study) {
    const auto measured = study.measured();
    const auto limit = std::find_if(measured.begin(), measured.end(),
                                    [](const data::Reading& m) { return m.censored != data::Censored::no; });
    if (limit == measured.end()) {
        return;
    }
    const auto refuse = [&](std::string_view found, std::string_view allowed) {
        throw pave::Error({.file = limit->file, .line = limit->line, .key = "value"},
                          fmt::format("a reading of which a limit is known ({}{:g}) needs the probability of its error",
                                      sign_of(limit->censored), limit->value),
                          found, allowed);
    };
    if (study.noise != NoiseSource::stated) {
        refuse(study.noise == NoiseSource::sought ? "[data.noise] scale = \"sought\"" : "no stated noise",
               "a sigma, or [data.noise], of a size that is known");
    }
    if (study.data.misfit != problem::MisfitKind::weighted) {
        refuse(fmt::format("misfit = \"{}\"", to_string(study.data.misfit)), "misfit = \"weighted\"");
    }
    if (study.data.shapes_noise()) {
        refuse("[data.noise] with errors in common or loss = \"student\"", "independent normal errors");
    }
}

} // namespace

void set_noise(Study& study) {
    const auto largest = largest_of_group(study);
    const std::span<data::Reading> measured(study.readings.data(), largest.size());
    const auto& absolute = study.data.noise_absolute;
    const bool has_absolute = std::any_of(absolute.begin(), absolute.end(), [](double value) { return value > 0.0; });
    const bool is_of_any = std::any_of(measured.begin(), measured.end(), [&](const data::Reading& m) {
        return absolute[static_cast<std::size_t>(m.unit.dimension)] > 0.0;
    });
    if (has_absolute && !is_of_any && !measured.empty()) {
        throw pave::Error({.file = study.file, .key = "[data.noise] absolute"}, "no reading is in a unit of this kind",
                          fmt::format("readings in {}", measured[0].unit.name),
                          "a unit of the readings, sigma in the measurement file, or relative");
    }
    for (std::size_t i = 0; i < measured.size(); ++i) {
        data::Reading& m = measured[i];
        m.noise = {};
        if (m.sigma) {
            m.noise.absolute = *m.sigma * m.unit.to_si;
        } else {
            const double factor = drops_factor(study.data, m);
            m.noise.relative = factor * study.data.noise_relative.value_or(0.0);
            m.noise.absolute =
                factor * std::hypot(study.data.noise_floor.value_or(0.0) * largest[i],
                                    study.data.noise_absolute[static_cast<std::size_t>(m.unit.dimension)]);
        }
    }
    // A reading without one, where others state theirs: their median share, of its own group if it has one there.
    std::map<std::string, std::vector<double>> shares; // of all under the empty name
    const auto size_of = [&](std::size_t i) { return std::max(std::abs(measured[i].measured()), 1e-3 * largest[i]); };
    for (std::size_t i = 0; i < measured.size(); ++i) {
        const double deviation = measured[i].noise.deviation(measured[i].measured());
        if (deviation > 0.0 && size_of(i) > 0.0) {
            shares[measured[i].group()].push_back(deviation / size_of(i));
            shares[{}].push_back(deviation / size_of(i));
        }
    }
    std::map<std::string, double> median;
    for (auto& [group, list] : shares) {
        const auto middle = list.begin() + static_cast<std::ptrdiff_t>(list.size() / 2);
        std::nth_element(list.begin(), middle, list.end());
        median[group] = *middle;
    }
    const auto is_stated = [](const data::Reading& m) { return m.noise.deviation(m.measured()) > 0.0; };
    study.noise_assumed = 0;
    for (std::size_t i = 0; i < measured.size() && !median.empty(); ++i) {
        if (!is_stated(measured[i])) {
            const auto own = median.find(measured[i].group());
            measured[i].noise = {.absolute = (own != median.end() ? own->second : median[{}]) * size_of(i)};
            ++study.noise_assumed;
        }
    }
    const bool scale_is_sought = study.data.noise_scale_is_sought;
    if (scale_is_sought && median.empty()) {
        for (data::Reading& m : measured) {
            m.noise = {.relative = unit_of_sought_noise};
        }
    }
    if (std::all_of(measured.begin(), measured.end(), is_stated)) {
        study.noise = NoiseSource::stated;
        shape_noise(study);
        if (scale_is_sought) {
            study.noise = NoiseSource::sought;
            for (data::Reading& m : measured) {
                m.noise.scale_is_sought = true;
            }
        }
        check_limits(study);
        return;
    }
    if (scale_is_sought) {
        throw pave::Error({.file = study.file, .line = study.data.noise_line, .key = "[data.noise] scale"},
                          "where no noise is stated its size is a share of each reading", "a reading of zero",
                          "a sigma of every reading, relative or absolute");
    }
    for (data::Reading& m : measured) {
        m.noise = {};
    }
    study.noise_assumed = 0;
    study.noise = NoiseSource::estimated;
    shape_noise(study);
    check_limits(study);
}

std::string hash_with_readings(std::string text, std::span<const data::Reading> readings) {
    for (const auto& m : readings) {
        text += fmt::format("\n{},{},{},{},{},{},{},{},{}", m.load, m.quantity, m.x_mm, m.y_mm, m.depth_mm, m.gauge_mm,
                            m.value, m.unit.name, m.sigma.value_or(0.0));
        if (m.time_ms) {
            text += fmt::format(",{}", *m.time_ms);
        }
        if (m.drops > 0) {
            text += fmt::format(",{} drops", m.drops);
        }
        if (!m.name.empty()) {
            text += "," + m.name;
        }
        text += sign_of(m.censored);
    }
    return data::hash_of(text);
}

void settle_extent(Study& study) {
    if (study.model.settings.wall_follows) {
        study.model.settings.extent = study.model.default_extent();
    }
}

} // namespace explore::study
