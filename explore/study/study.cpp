#include "study/study.h"

#include "base/text.h"
#include "base/units.h"
#include "data/csv.h"
#include "data/hash.h"
#include "material/catalog.h"
#include "pavement/effects/catalog.h"
#include "study/pavement_function.h"
#include "study/table_reader.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>

namespace explore::study {
namespace {

using namespace pave::pavement;
namespace unit = pave::unit;

// endless_from: of the lowest layer of a half-space, the depth of its top [m]; none: of any other layer.
Layer read_layer(const toml::table& table, const std::string& file, std::optional<double> endless_from) {
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
        if (endless_from && key.changes_geometry) { // how deep it is meshed
            fallback = std::max(3.0, 2.0 * *endless_from) / key.to_si;
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

Load read_load(const toml::table& table, const std::string& file) {
    TableReader reader(table, file, "[[loads]]");
    Load load;
    load.name = reader.text(keys::load_name);
    reader.rename("load \"" + load.name + "\"");
    load.type = static_cast<LoadType>(reader.choice(keys::load_type));
    if (load.type == LoadType::plate || load.type == LoadType::gear) {
        load.patch = Patch::circle;
    } else {
        load.patch = static_cast<Patch>(reader.choice(keys::load_patch));
    }
    for (const KeyInfo& key : load_keys(load.type, load.patch)) {
        key.of_load(load) = key.to_si * reader.number(key.key, key.low, key.high, key.low_is_open, key.default_value);
    }
    if (load.type == LoadType::gear) {
        for (const auto* wheel : reader.tables(keys::load_wheels)) {
            TableReader r(*wheel, file, "load \"" + load.name + "\" wheels");
            load.wheels.push_back({unit::mm * r.number(keys::wheel_x), unit::mm * r.number(keys::wheel_y),
                                   unit::kN * r.number(keys::wheel_force)});
            r.done();
        }
        if (load.wheels.empty()) {
            throw pave::Error(reader.place(keys::load_wheels), "a gear needs wheels", {},
                              std::string(keys::load_wheels.allowed));
        }
        if (load.circles_overlap()) {
            throw pave::Error(reader.place(keys::load_wheels), "two wheels of the gear overlap", {},
                              "wheels farther apart, or a higher pressure");
        }
    }
    reader.done();
    return load;
}

template <class T>
std::vector<std::string> names_of(const std::vector<T>& items) {
    std::vector<std::string> names;
    names.reserve(items.size());
    for (const T& item : items) {
        names.push_back(item.name);
    }
    return names;
}

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

data::Dimension dimension_of(Quantity quantity) {
    return quantity == Quantity::deflection  ? data::Dimension::length
           : quantity <= Quantity::strain_yy ? data::Dimension::strain
                                             : data::Dimension::pressure;
}

Sensor sensor_of(const data::Measurement& m, const Case& model) {
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
    check_sensor(model, s, place(m.quantity.c_str()));
    return s;
}

Output read_output(const toml::table& table, const std::string& file, const Case& model) {
    TableReader reader(table, file, "[[outputs]]");
    Output output;
    output.name = reader.text(keys::output_name);
    reader.rename("output \"" + output.name + "\"");
    output.sensor.load = find_load(model, reader.text(keys::output_load), reader.place(keys::output_load));
    output.sensor.quantity = find_quantity(reader.text(keys::output_quantity), reader.place(keys::output_quantity));
    output.sensor.x = unit::mm * reader.number(keys::output_x);
    output.sensor.y = unit::mm * reader.number(keys::output_y);
    output.sensor.depth = unit::mm * reader.number(keys::output_depth);
    output.sensor.gauge = unit::mm * reader.number(keys::output_gauge);
    output.sensor.measured = false;
    reader.done();
    check_sensor(model, output.sensor, reader.place(""));
    return output;
}

std::vector<std::string> effect_names() {
    std::vector<std::string> names;
    for (const Effect* effect : effects()) {
        names.emplace_back(effect->name);
    }
    return names;
}

// Throws pave::Error where the study cannot have the effect.
void check_effect(const Study& study, const AppliedEffect& applied, const pave::Place& place) {
    if (const std::string why = why_impossible(study.model, applied); !why.empty()) {
        throw pave::Error(place, "the study cannot have this effect: " + why,
                          "\"" + std::string(applied.effect->name) + "\"",
                          "what it acts on: " + std::string(applied.effect->acts_on));
    }
}

void read_effect(const toml::table& table, Study& study) {
    TableReader reader(table, study.file, "[[effects]]");
    AppliedEffect applied;
    applied.effect = effects()[reader.choice(keys::effect_name, effect_names())];
    const Effect& effect = *applied.effect;
    reader.rename("effect \"" + std::string(effect.name) + "\"");
    applied.size = reader.number(keys::effect_size, effect.low, effect.high, false, effect.null);
    Case& model = study.model;
    if (effect.layer != LayerRole::none) {
        applied.layer = reader.text(keys::effect_layer, "");
        const auto names = names_of(model.layers);
        if (!applied.layer.empty() && std::find(names.begin(), names.end(), applied.layer) == names.end()) {
            throw pave::Error(reader.place(keys::effect_layer), "this layer is not in the study",
                              "\"" + applied.layer + "\"", pave::join(names));
        }
    }
    if (effect.takes_load) {
        if (const std::string load = reader.text(keys::effect_load, ""); !load.empty()) {
            applied.load = find_load(model, load, reader.place(keys::effect_load));
        }
    }
    if (effect.takes_quantity) {
        if (const std::string quantity = reader.text(keys::effect_quantity, ""); !quantity.empty()) {
            applied.quantity = find_quantity(quantity, reader.place(keys::effect_quantity));
        }
    }
    if (effect.takes_reading) {
        const int last = std::max(1, static_cast<int>(study.measurements.size()));
        applied.reading = reader.integer(keys::effect_reading, 1, last, 1) - 1;
    }
    reader.done();
    for (const AppliedEffect& other : model.effects) {
        if (other.effect == applied.effect) {
            throw pave::Error(reader.place("name"), "this effect stands twice", "\"" + std::string(effect.name) + "\"",
                              "each once");
        }
    }
    check_effect(study, applied, reader.place("name"));
    model.effects.push_back(std::move(applied));
}

void read_parameter(const toml::table& table, Study& study) {
    TableReader reader(table, study.file, "[[parameters]]");
    problem::Axis axis;
    axis.name = reader.text(keys::parameter_name);
    const Parameter parameter = find_parameter(study.model, axis.name, reader.place("name"));
    if (study.model.half_space && !parameter.in_load && parameter.changes_geometry() &&
        parameter.owner + 1 == static_cast<int>(study.model.layers.size())) {
        throw pave::Error(reader.place("name"), "the lowest layer of a half-space has no bottom to move",
                          "\"" + axis.name + "\"", "bottom = \"rigid\" in [section]");
    }
    reader.rename("parameter \"" + axis.name + "\"");
    axis.scale = static_cast<problem::Scale>(reader.choice(keys::parameter_scale));
    const bool is_log = axis.scale == problem::Scale::log;
    const double low = is_log ? std::max(parameter.low, 0.0) : parameter.low;
    axis.low = reader.number(keys::parameter_min, low, parameter.high, parameter.low_is_open || is_log);
    axis.high = reader.number(keys::parameter_max, low, parameter.high, parameter.low_is_open || is_log);
    axis.points = reader.has(keys::parameter_points) ? reader.integer(keys::parameter_points) : 0;
    if (!(axis.low < axis.high)) {
        throw pave::Error(reader.place(keys::parameter_min), "the bounds are swapped or equal",
                          fmt::format("min = {}, max = {}", axis.low, axis.high), "min < max");
    }
    axis.start = parameter.get(study.model);
    if (!std::isfinite(axis.start)) {
        throw pave::Error(reader.place("name"), "the layer does not state this key, so it cannot be varied",
                          "\"" + axis.name + "\"", "a value for it in the layer");
    }
    if (axis.points == 1 && !(axis.start >= axis.low && axis.start <= axis.high)) {
        throw pave::Error(reader.place(keys::parameter_points),
                          "one point means held at the study's own value, which is out of bounds",
                          fmt::format("{}", axis.start), fmt::format("{} to {}", axis.low, axis.high));
    }
    for (const auto& other : study.space.axes) {
        if (other.name == axis.name) {
            throw pave::Error(reader.place("name"), "this parameter stands twice", "\"" + axis.name + "\"",
                              "each once");
        }
    }
    reader.done();
    if (parameter.in_effect) {
        study.model.effects[parameter.owner].present = true;
    }
    study.parameters.push_back(parameter);
    study.space.axes.push_back(std::move(axis));
}

// Sorts the measurements into groups. A name in held_out or weights is that of a group or of a load (all its groups).
void set_groups(Study& study, const pave::Place& place, const std::vector<std::string>& held_out,
                const toml::table* weights) {
    study.groups.clear();
    std::vector<std::string> names;
    for (std::size_t i = 0; i < study.measurements.size(); ++i) {
        const auto& m = study.measurements[i];
        const std::string name = m.load + "." + m.quantity;
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

void read_data(const toml::table& table, Study& study, Readings readings) {
    TableReader reader(table, study.file, "[data]");
    if (reader.has(keys::data_files)) {
        study.data.files = reader.texts(keys::data_files);
        if (study.data.files.empty()) {
            throw pave::Error(reader.place(keys::data_files), "the list of measurement files is empty", "[]",
                              "at least one file");
        }
    }
    const bool outside = reader.flag(keys::data_outside);
    const auto folder = std::filesystem::path(study.file).parent_path();
    for (const std::string& file : study.data.files) {
        if (!outside && leaves_folder(folder, file)) {
            throw pave::Error(reader.place(keys::data_files), "this file lies outside the study's own folder",
                              "\"" + file + "\"", "a file in it or below, or outside = true");
        }
    }
    study.data.misfit = static_cast<problem::MisfitKind>(reader.choice(keys::data_misfit));
    study.data.log_floor = reader.number(keys::data_log_floor);
    if (reader.has(keys::data_noise_relative)) {
        study.data.noise_relative = reader.number(keys::data_noise_relative);
    }
    if (reader.has(keys::data_noise_floor)) {
        study.data.noise_floor = reader.number(keys::data_noise_floor);
    }
    const std::vector<std::string> held_out =
        reader.has(keys::data_held_out) ? reader.texts(keys::data_held_out) : std::vector<std::string>{};
    const toml::table* weights = reader.table(keys::data_weights);
    reader.done();
    if (readings == Readings::elsewhere) {
        return;
    }
    for (const std::string& file : study.data.files) {
        const std::string path = (folder / file).string();
        if (std::error_code error; !std::filesystem::exists(path, error)) {
            throw pave::Error(reader.place(keys::data_files), "this measurement file does not exist",
                              "\"" + path + "\"", "a path relative to the study's own folder");
        }
        for (auto& m : data::read_measurements(path)) {
            study.model.sensors.push_back(sensor_of(m, study.model));
            study.measurements.push_back(std::move(m));
        }
    }
    set_groups(study, reader.place(keys::data_held_out), held_out, weights);
}

// The largest |measured| [SI] of the load and quantity of each measurement.
std::vector<double> largest_of_group(const Study& study) {
    std::map<std::pair<std::string, std::string>, double> largest;
    for (const auto& m : study.measurements) {
        double& value = largest[{m.load, m.quantity}];
        value = std::max(value, std::abs(m.value * m.unit.to_si));
    }
    std::vector<double> result;
    for (const auto& m : study.measurements) {
        result.push_back(largest[{m.load, m.quantity}]);
    }
    return result;
}

void set_noise(Study& study) {
    const auto largest = largest_of_group(study);
    const bool has_model = study.data.noise_relative || study.data.noise_floor;
    for (std::size_t i = 0; i < study.measurements.size(); ++i) {
        const auto& m = study.measurements[i];
        double sigma = 0.0;
        if (m.sigma) {
            sigma = *m.sigma * m.unit.to_si;
        } else if (has_model) {
            sigma = std::hypot(study.data.noise_relative.value_or(0.0) * m.value * m.unit.to_si,
                               study.data.noise_floor.value_or(0.0) * largest[i]);
        }
        study.sigma.push_back(sigma);
    }
    // A reading without one, where others state theirs: their median share, of its own group if it has one there.
    using Group = std::pair<std::string, std::string>;
    std::map<Group, std::vector<double>> shares; // of all under the empty name
    const auto size_of = [&](std::size_t i) {
        const auto& m = study.measurements[i];
        return std::max(std::abs(m.value * m.unit.to_si), 1e-3 * largest[i]);
    };
    const auto group_of = [&](std::size_t i) {
        return Group{study.measurements[i].load, study.measurements[i].quantity};
    };
    for (std::size_t i = 0; i < study.sigma.size(); ++i) {
        if (study.sigma[i] > 0.0 && size_of(i) > 0.0) {
            shares[group_of(i)].push_back(study.sigma[i] / size_of(i));
            shares[{}].push_back(study.sigma[i] / size_of(i));
        }
    }
    std::map<Group, double> median;
    for (auto& [group, list] : shares) {
        const auto middle = list.begin() + static_cast<std::ptrdiff_t>(list.size() / 2);
        std::nth_element(list.begin(), middle, list.end());
        median[group] = *middle;
    }
    for (std::size_t i = 0; i < study.sigma.size() && !median.empty(); ++i) {
        if (!(study.sigma[i] > 0.0)) {
            const auto own = median.find(group_of(i));
            study.sigma[i] = (own != median.end() ? own->second : median[{}]) * size_of(i);
            ++study.noise_assumed;
        }
    }
    if (std::all_of(study.sigma.begin(), study.sigma.end(), [](double s) { return s > 0.0; })) {
        study.noise = NoiseSource::stated;
        return;
    }
    study.sigma.clear();
    study.noise_assumed = 0;
    study.noise = NoiseSource::estimated;
}

std::string hash_of(std::string text, const std::vector<data::Measurement>& measurements) {
    for (const auto& m : measurements) {
        text += fmt::format("\n{},{},{},{},{},{},{},{},{}", m.load, m.quantity, m.x_mm, m.y_mm, m.depth_mm, m.gauge_mm,
                            m.value, m.unit.name, m.sigma.value_or(0.0));
    }
    return data::hash_of(text);
}

std::string hash_of(toml::table table, const Study& study) {
    table.erase("title");
    std::ostringstream text;
    text << toml::default_formatter(table);
    return hash_of(text.str(), study.measurements);
}

problem::Misfit misfit_of(const Study& study, const std::vector<std::size_t>& rows, const std::vector<double>& factor) {
    std::vector<problem::Misfit::Term> terms;
    const auto largest = largest_of_group(study);
    for (std::size_t k = 0; k < rows.size(); ++k) {
        const std::size_t i = rows[k];
        const auto& m = study.measurements[i];
        problem::Misfit::Term term{.response = i, .measured = m.value * m.unit.to_si, .factor = factor[k]};
        switch (study.data.misfit) {
        case problem::MisfitKind::log: term.scale = study.data.log_floor * largest[i]; break;
        case problem::MisfitKind::relative: term.scale = std::abs(term.measured); break;
        case problem::MisfitKind::weighted:
            term.scale = study.noise == NoiseSource::stated ? study.sigma[i] : std::abs(term.measured);
            break;
        }
        if (!(term.scale > 0.0)) {
            throw pave::Error(
                {.file = m.file, .line = m.line, .key = "value"}, "a reading of zero has no place in this misfit",
                fmt::format("{}", m.value),
                "another value, a sigma with misfit = \"weighted\", or a group with some reading that is not zero");
        }
        terms.push_back(term);
    }
    if (study.noise == NoiseSource::stated) {
        std::vector<double> measured(study.responses(), 0.0);
        for (const problem::Misfit::Term& term : terms) {
            measured[term.response] = term.measured;
        }
        const Eigen::VectorXd slopes = problem::Misfit(study.data.misfit, terms).slopes(measured);
        for (std::size_t k = 0; k < terms.size(); ++k) {
            // The factor is the root of a weight, which counts as a variance.
            terms[k].noise = slopes[static_cast<Eigen::Index>(k)] / terms[k].factor * study.sigma[terms[k].response];
        }
    }
    return {study.data.misfit, std::move(terms)};
}

// toml++ goes down a key such as a.b.c one call a part.
void refuse_deep_keys(const std::string& text, const std::string& file) {
    constexpr std::ptrdiff_t most_parts = 1000;
    int line = 1;
    for (std::size_t begin = 0; begin < text.size(); ++line) {
        const std::size_t end = std::min(text.find('\n', begin), text.size());
        if (std::count(text.begin() + static_cast<std::ptrdiff_t>(begin),
                       text.begin() + static_cast<std::ptrdiff_t>(end), '.') > most_parts) {
            throw pave::Error({.file = file, .line = line}, "a line with so many full stops is no key or value", {},
                              fmt::format("at most {}", most_parts));
        }
        begin = end + 1;
    }
}

// Unless stated, the wall stands where the sensors and the depth want it: set when all of them are known.
constexpr double not_stated = 1e9;

} // namespace

std::string_view Study::noise_name() const {
    return noise == NoiseSource::estimated ? "estimated" : noise_assumed > 0 ? "partly stated" : "stated";
}

std::string Study::stem() const {
    return std::filesystem::path(file).stem().string();
}

std::string_view Study::response_unit(std::size_t i) const {
    return i < measurements.size() ? measurements[i].unit.name : info(model.sensors[i].quantity).unit;
}

double Study::response_to_si(std::size_t i) const {
    return i < measurements.size() ? measurements[i].unit.to_si : info(model.sensors[i].quantity).to_si;
}

bool leaves_folder(const std::filesystem::path& path) {
    const auto normal = path.lexically_normal();
    return normal.is_absolute() || (!normal.empty() && *normal.begin() == "..");
}

bool leaves_folder(const std::filesystem::path& folder, const std::filesystem::path& path) {
    std::error_code error; // of a file that is not there, or of a circle of links: others complain of those
    const auto own = std::filesystem::canonical(folder.empty() ? "." : folder, error);
    const auto target = error ? own : std::filesystem::canonical(folder / path, error);
    return leaves_folder(path) || (!error && leaves_folder(target.lexically_relative(own)));
}

Study load_study(const std::string& file, Readings readings) {
    Study study;
    study.file = file;
    const std::string text = data::read_file(file, "study");
    refuse_deep_keys(text, file);
    toml::table table;
    try {
        table = toml::parse(text, file);
    } catch (const toml::parse_error& error) {
        throw pave::Error({.file = file, .line = static_cast<int>(error.source().begin.line)}, "this is not valid TOML",
                          std::string(error.description()), "see toml.io for the format");
    }
    TableReader reader(table, file, "");
    reader.integer(keys::schema);
    study.title = reader.text(keys::title, study.stem());

    // Layers and loads share one list of names: parameter paths begin with one.
    std::set<std::string> names;
    const auto check_name = [&](const std::string& name, const toml::table& item) {
        if (name.empty() || name.find('.') != std::string::npos || pave::printable(name) != name ||
            !names.insert(name).second) {
            throw pave::Error(TableReader(item, file, "").place("name"), "layers and loads are told apart by name",
                              "\"" + name + "\"",
                              "each name once, not empty, without a full stop or a control character");
        }
    };
    if (const auto* section = reader.table("section")) {
        TableReader r(*section, file, "[section]");
        study.model.half_space = r.choice(keys::section_bottom) == 1;
        r.done();
    }
    const auto layers = reader.tables("layers");
    for (const auto* layer : layers) {
        const bool endless = study.model.half_space && layer == layers.back();
        study.model.layers.push_back(
            read_layer(*layer, file, endless ? std::optional(study.model.depth()) : std::nullopt));
        check_name(study.model.layers.back().name, *layer);
    }
    for (const auto* load : reader.tables("loads")) {
        study.model.loads.push_back(read_load(*load, file));
        check_name(study.model.loads.back().name, *load);
    }
    if (study.model.layers.empty()) {
        throw pave::Error({.file = file, .key = "layers"}, "the section has no layers", {}, "at least one [[layers]]");
    }
    if (study.model.loads.empty()) {
        throw pave::Error({.file = file, .key = "loads"}, "the study has no loads", {}, "at least one [[loads]]");
    }
    if (const auto* solver = reader.table("solver")) {
        TableReader r(*solver, file, "[solver]");
        auto& settings = study.model.settings;
        settings.integration = static_cast<Integration>(r.choice(keys::solver_integration));
        check_integration(study.model, r.place(keys::solver_integration.key));
        settings.solver.path_tolerance = r.number(keys::solver_path);
        settings.solver.equilibrium_tolerance = r.number(keys::solver_equilibrium);
        r.done();
    }
    study.model.settings.extent = not_stated;
    if (const auto* mesh = reader.table("mesh")) {
        TableReader r(*mesh, file, "[mesh]");
        study.model.settings.extent = r.has(keys::mesh_extent) ? r.number(keys::mesh_extent) : not_stated;
        study.model.settings.refine = r.number(keys::mesh_refine);
        r.done();
    }
    if (const auto* data = reader.table("data")) {
        read_data(*data, study, readings);
    }
    set_noise(study);
    for (const auto* output : reader.tables("outputs")) {
        study.outputs.push_back(read_output(*output, file, study.model));
        study.model.sensors.push_back(study.outputs.back().sensor);
    }
    study.extent_is_stated = study.model.settings.extent != not_stated;
    // A wall that is stated is meant to be there.
    study.model.settings.layered = !study.extent_is_stated || study.model.half_space;
    if (!study.extent_is_stated) {
        study.model.settings.extent = study.model.default_extent();
    }
    for (const auto* effect : reader.tables("effects")) {
        read_effect(*effect, study);
    }
    for (const auto* parameter : reader.tables("parameters")) {
        read_parameter(*parameter, study);
    }
    reader.done();
    if (readings == Readings::own && study.model.sensors.empty()) {
        throw pave::Error({.file = file}, "the study asks for nothing", "neither measurements nor outputs",
                          "[data] files, or [[outputs]]");
    }
    study.hash = hash_of(table, study);
    return study;
}

Study with_measurements(Study study, std::vector<data::Measurement> measurements) {
    study.model.sensors.clear();
    study.outputs.clear();
    study.sigma.clear();
    if (!study.extent_is_stated) {
        study.model.settings.extent = not_stated;
    }
    for (const auto& m : measurements) {
        study.model.sensors.push_back(sensor_of(m, study.model));
    }
    study.measurements = std::move(measurements);
    set_groups(study, {}, {}, nullptr);
    set_noise(study);
    if (!study.extent_is_stated) {
        study.model.settings.extent = study.model.default_extent();
    }
    study.hash = hash_of(study.hash, study.measurements);
    return study;
}

const Effect& effect_named(const std::string& name, const pave::Place& place) {
    if (const Effect* effect = find_effect(name)) {
        return *effect;
    }
    const auto names = effect_names();
    const std::string near = pave::nearest_name(name, names);
    throw pave::Error(place, near.empty() ? "unknown effect" : "unknown effect, did you mean \"" + near + "\"?",
                      "\"" + name + "\"", pave::join(names));
}

Study with_effect(Study study, const std::string& name, double size, const pave::Place& place) {
    const Effect* effect = &effect_named(name, place);
    if (!(size >= effect->low && size <= effect->high)) {
        throw pave::Error(place, "size out of range", fmt::format("{} = {}", name, size),
                          fmt::format("{} <= size <= {} [{}]", effect->low, effect->high, effect->unit));
    }
    auto& applied = study.model.effects;
    auto own = std::find_if(applied.begin(), applied.end(), [&](const auto& a) { return a.effect == effect; });
    if (own == applied.end()) {
        AppliedEffect added;
        added.effect = effect;
        check_effect(study, added, place);
        own = applied.insert(applied.end(), std::move(added));
    }
    own->size = size;
    return study;
}

namespace {

problem::Problem problem_of(const Study& study, const std::vector<bool>& loads, problem::Misfit misfit) {
    if (study.parameters.empty()) {
        throw pave::Error({.file = study.file, .key = "parameters"}, "this command needs parameters to change", {},
                          "at least one [[parameters]]");
    }
    if (study.space.dimension() > 40) {
        throw pave::Error({.file = study.file, .key = "parameters"}, "too many parameters",
                          fmt::format("{}", study.space.dimension()), "at most 40");
    }
    return {study.space, make_function(study.model, study.parameters, loads), std::move(misfit)};
}

} // namespace

problem::Problem make_prediction_problem(const Study& study) {
    return problem_of(study, {}, problem::Misfit(study.data.misfit, {}));
}

std::vector<bool> fitted_loads(const Study& study) {
    std::vector<bool> loads(study.model.loads.size(), false);
    for (const Group& group : study.groups) {
        if (!group.held_out) {
            loads[static_cast<std::size_t>(study.model.sensors[group.rows[0]].load)] = true;
        }
    }
    return loads;
}

problem::Problem make_problem(const Study& study, Scope scope) {
    if (study.measurements.empty()) {
        throw pave::Error({.file = study.file, .key = "data"}, "this command needs measurements", {},
                          "[data] files = [...]");
    }
    std::vector<std::size_t> rows;
    std::vector<double> factor;
    const std::vector<bool> loads =
        scope == Scope::everything ? std::vector<bool>(study.model.loads.size(), true) : fitted_loads(study);
    for (const Group& group : study.groups) {
        if (!group.held_out) {
            rows.insert(rows.end(), group.rows.begin(), group.rows.end());
            factor.insert(factor.end(), group.rows.size(), std::sqrt(group.weight));
        }
    }
    return problem_of(study, loads, misfit_of(study, rows, factor));
}

problem::Problem make_noise_problem(const Study& study, Scope scope) {
    problem::Problem p = make_problem(study, scope);
    if (study.noise == NoiseSource::estimated) {
        return p;
    }
    std::vector<problem::Misfit::Term> terms(p.misfit.terms().begin(), p.misfit.terms().end());
    for (problem::Misfit::Term& term : terms) {
        term.factor /= term.noise;
        term.noise = 1.0;
    }
    p.misfit = problem::Misfit(p.misfit.kind(), std::move(terms));
    return p;
}

problem::Problem make_problem(const Study& study, const Group& group) {
    std::vector<bool> loads(study.model.loads.size(), false);
    loads[static_cast<std::size_t>(study.model.sensors[group.rows[0]].load)] = true;
    return problem_of(study, loads, misfit_of(study, group.rows));
}

problem::Misfit misfit_of(const Study& study, const std::vector<std::size_t>& rows) {
    return misfit_of(study, rows, std::vector<double>(rows.size(), 1.0));
}

} // namespace explore::study
