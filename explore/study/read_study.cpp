// Reads a study file and checks every key.
#include "base/text.h"
#include "base/units.h"
#include "data/csv.h"
#include "data/fwd.h"
#include "material/catalog.h"
#include "pavement/effects/catalog.h"
#include "pavement/forward.h"
#include "pavement/tie.h"
#include "study/constraints.h"
#include "study/corrections.h"
#include "study/criteria.h"
#include "study/function_study.h"
#include "study/no_study.h"
#include "study/prior_correlations.h"
#include "study/read_layer.h"
#include "study/read_load.h"
#include "study/read_model.h"
#include "study/read_solver.h"
#include "study/readings.h"
#include "study/seasons.h"
#include "study/table_reader.h"

#include <algorithm>
#include <cmath>

namespace explore::study {
namespace {

using namespace pave::pavement;
namespace unit = pave::unit;

void read_output(const toml::table& table, Study& study) {
    if (study.has_own_model) {
        read_own_output(table, study);
        return;
    }
    TableReader reader(table, study.file, "[[outputs]]");
    data::Reading output;
    output.output = reader.text(keys::output_name);
    check_new_output(study, output.output, reader.place(keys::output_name));
    reader.rename("output \"" + output.output + "\"");
    Sensor sensor;
    output.load = reader.text(keys::output_load);
    sensor.load = find_load(study.model, output.load, reader.place(keys::output_load));
    output.quantity = reader.text(keys::output_quantity);
    sensor.quantity = find_quantity(output.quantity, reader.place(keys::output_quantity));
    output.unit = data::unit_named(info(sensor.quantity).unit);
    output.x_mm = reader.number(keys::output_x);
    output.y_mm = reader.number(keys::output_y);
    output.depth_mm = reader.number(keys::output_depth);
    output.gauge_mm = reader.number(keys::output_gauge);
    sensor.x = unit::mm * output.x_mm;
    sensor.y = unit::mm * output.y_mm;
    sensor.depth = unit::mm * output.depth_mm;
    sensor.gauge = unit::mm * output.gauge_mm;
    if (reader.has(keys::output_time)) {
        output.time_ms = reader.number(keys::output_time);
        sensor.time = time_of(output.time_ms, study.model.loads[static_cast<std::size_t>(sensor.load)],
                              reader.place(keys::output_time));
    }
    sensor.measured = false;
    reader.done();
    check_sensor(study.model, sensor, reader.place(""));
    study.model.sensors.push_back(sensor);
    study.readings.push_back(std::move(output));
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
    if (effect.takes_reading && reader.has(keys::effect_reading)) {
        const int last = std::max(1, static_cast<int>(study.measured().size()));
        applied.reading = reader.integer(keys::effect_reading, 1, last, 1) - 1;
    }
    if (effect.takes_thickness && reader.has(keys::effect_thickness)) {
        applied.thickness = unit::mm * reader.number(keys::effect_thickness);
    }
    if (effect.takes_offsets && reader.has(keys::effect_offsets)) {
        for (const double offset : reader.numbers(keys::effect_offsets)) {
            applied.offsets.push_back(unit::mm * offset);
        }
    }
    reader.done();
    for (const AppliedEffect& other : model.effects) {
        if (other.effect == applied.effect && // another wrong reading is another effect
            !(effect.is_error_of_reading && applied.reading.value_or(0) != other.reading.value_or(0))) {
            throw pave::Error(reader.place("name"), "this effect is given twice",
                              "\"" + std::string(effect.name) + "\"", "each once");
        }
    }
    check_effect(study, applied, reader.place("name"));
    model.effects.push_back(std::move(applied));
}

// Whatever varies is modelled where it does nothing, too.
void set_present(Case& model, const Parameter& parameter) {
    if (parameter.in_effect) {
        model.effects[static_cast<std::size_t>(parameter.owner)].present = true;
    } else if (parameter.in_correction) {
        model.corrections[static_cast<std::size_t>(parameter.owner)].present = true;
    }
}

void read_parameter(const toml::table& table, Study& study) {
    TableReader reader(table, study.file, "[[parameters]]");
    reader.expect(std::array{keys::parameter_equals, // of a number that is not searched
                             keys::parameter_min, keys::parameter_max, keys::parameter_scale, keys::parameter_points,
                             keys::parameter_level, keys::parameter_prior});
    problem::Axis axis;
    axis.name = reader.text(keys::parameter_name);
    const Parameter parameter = study.has_own_model ? add_own_parameter(study, axis.name, reader.place("name"))
                                                    : find_parameter(study.model, axis.name, reader.place("name"));
    if (study.model.half_space && !parameter.in_load && parameter.changes_geometry() &&
        parameter.owner + 1 == static_cast<int>(study.model.layers.size())) {
        throw pave::Error(reader.place("name"), "the lowest layer of a half-space has no bottom to move",
                          "\"" + axis.name + "\"", "bottom = \"rigid\" in [section]");
    }
    reader.rename("parameter \"" + axis.name + "\"");
    axis.scale = static_cast<problem::Scale>(reader.choice(keys::parameter_scale));
    const bool is_log = axis.scale == problem::Scale::log;
    const double low = is_log ? std::max(parameter.low, 0.0) : parameter.low;
    const bool is_open = parameter.low_is_open || (is_log && low == 0.0);
    axis.low = reader.number(keys::parameter_min, low, parameter.high, is_open);
    axis.high = reader.number(keys::parameter_max, low, parameter.high, is_open);
    axis.points = reader.has(keys::parameter_points) ? reader.integer(keys::parameter_points) : 0;
    if (!(axis.low < axis.high)) {
        throw pave::Error(reader.place(keys::parameter_min), "the bounds are swapped or equal",
                          fmt::format("min = {}, max = {}", axis.low, axis.high), "min < max");
    }
    axis.level = static_cast<problem::Level>(reader.choice(keys::parameter_level));
    if (study.has_own_model && !parameter.in_effect) {
        parameter.in(study.model) = own_value(reader, axis);
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
            throw pave::Error(reader.place("name"), "this parameter is given twice", "\"" + axis.name + "\"",
                              "each once");
        }
    }
    if (const auto* prior = reader.table(keys::parameter_prior)) {
        TableReader r(*prior, study.file, "prior of \"" + axis.name + "\"");
        axis.prior = problem::Prior{.mean = r.number(keys::prior_mean, axis.low, axis.high, false),
                                    .sd = r.number(keys::prior_sd)};
        // Several times the range in logarithms: meant in the parameter's unit.
        const double widest = 3.0 * std::log(axis.high / axis.low);
        if (axis.scale == problem::Scale::log && axis.prior->sd > widest) {
            throw pave::Error(r.place(keys::prior_sd.key),
                              "the sd of a prior on a logarithmic axis is that of the natural logarithm",
                              fmt::format("{:g}", axis.prior->sd),
                              fmt::format("sd over mean, {:.2g} here, if it was meant in the parameter's unit; at most "
                                          "{:.2g}",
                                          axis.prior->sd / axis.prior->mean, widest));
        }
        r.done();
    }
    reader.done();
    set_present(study.model, parameter);
    study.parameters.push_back(parameter);
    study.space.axes.push_back(std::move(axis));
}

void read_tie(const toml::table& table, Study& study) {
    TableReader reader(table, study.file, "[[parameters]]");
    const std::string path = reader.text(keys::parameter_name);
    if (study.has_own_model) {
        throw pave::Error(reader.place(keys::parameter_equals),
                          "a study with [model] has no numbers that follow others", "\"" + path + "\"",
                          "a parameter that the model computes from the others itself");
    }
    const std::string expression = reader.text(keys::parameter_equals);
    for (const auto& [key, node] : table) {
        if (key.str() != std::string_view(keys::parameter_name) &&
            key.str() != std::string_view(keys::parameter_equals)) {
            throw pave::Error(reader.place(key.str()), "what follows other numbers is not searched",
                              "\"" + std::string(key.str()) + "\"", "name and equals alone");
        }
    }
    const auto axis = std::find_if(study.space.axes.begin(), study.space.axes.end(),
                                   [&](const auto& other) { return other.name == path; });
    const bool is_tied =
        std::any_of(study.model.ties.begin(), study.model.ties.end(), [&](const Tie& tie) { return tie.path == path; });
    if (axis != study.space.axes.end() || is_tied) {
        throw pave::Error(reader.place("name"), "this parameter is given twice", "\"" + path + "\"", "each once");
    }
    add_tie(study.model, path, expression, reader.place(keys::parameter_equals));
    set_present(study.model, find_parameter(study.model, path, {}));
}

void read_data(const toml::table& table, Study& study, Readings readings, const TextReader& read_text) {
    TableReader reader(table, study.file, "[data]");
    if (reader.has(keys::data_files)) {
        study.data.files = reader.texts(keys::data_files);
        if (study.data.files.empty()) {
            throw pave::Error(reader.place(keys::data_files), "the list of measurement files is empty", "[]",
                              "at least one file");
        }
    }
    const bool outside = reader.flag(keys::data_outside);
    for (const std::string& file : study.data.files) {
        if (!outside) {
            check_inside(study, file, reader.place(keys::data_files));
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
    if (const auto* noise = reader.table(keys::data_noise)) {
        read_noise(*noise, study, reader);
    }
    const std::vector<std::string> held_out =
        reader.has(keys::data_held_out) ? reader.texts(keys::data_held_out) : std::vector<std::string>{};
    const toml::table* weights = reader.table(keys::data_weights);
    reader.done();
    if (readings == Readings::elsewhere) {
        return;
    }
    std::vector<std::pair<std::string, std::string>> read; // as named, and where it is
    for (const std::string& file : study.data.files) {
        const auto [path, text] = read_text(file, reader.place(keys::data_files), "measurement file");
        for (const auto& [name, before] : read) {
            if (data::is_same_file(before, path)) {
                throw pave::Error(reader.place(keys::data_files), "a measurement file is named twice",
                                  "\"" + name + "\", \"" + file + "\"",
                                  "each file once: its readings would count as independent ones");
            }
        }
        read.emplace_back(file, path);
        for (auto& m :
             study.has_own_model ? data::named_measurements_of(text, path) : data::measurements_of(text, path)) {
            add_measurement(study, std::move(m));
        }
    }
    set_groups(study, reader.place(keys::data_held_out), held_out, weights);
}

// own_files: what the files of a model of its own hold.
std::string hash_of(toml::table table, const Study& study, const std::string& own_files) {
    table.erase("title");
    table.erase("measure");
    table.erase("criteria"); // which change no run
    table.erase("seasons");
    std::ostringstream text;
    text << toml::default_formatter(table);
    for (const Load& load : study.model.loads) {
        for (const auto& [time, share] : load.history) { // of wheels the pressure does not say the force
            text << fmt::format("\n{},{},{}", time, share * load.pressure, share * load.total_force());
        }
    }
    text << own_files;
    const bool has_path = std::any_of(study.model.layers.begin(), study.model.layers.end(),
                                      [](const Layer& layer) { return layer.law->stress_dependent(); });
    if (has_path && !study.model.is_hyperelastic() &&
        study.model.settings.integration == Integration::incremental) { // the default is the program's own
        text << fmt::format("\n{} load steps by Radau's nodes", study.model.settings.solver.load_steps);
    }
    return hash_with_readings(text.str(), study.measured());
}

// function: the study's model, where the caller has it.
Study parse(std::string text, const std::string& file, Readings readings, const TextReader& read_text,
            const std::shared_ptr<const external::Simulator>& function = nullptr) {
    Study study;
    study.file = file;
    refuse_deep_keys(text, file);
    toml::table table;
    try {
        table = toml::parse(text, file);
    } catch (const toml::parse_error& error) {
        refuse_readings(text, file);
        throw pave::Error({.file = file, .line = static_cast<int>(error.source().begin.line)}, "this is not valid TOML",
                          std::string(error.description()), "see toml.io for the format");
    }
    TableReader reader(table, file, "");
    reader.refuse_others(root_keys()); // before something is missing because it is called otherwise
    reader.integer(keys::schema);
    study.title = reader.text(keys::title, study.stem());

    const auto* own_model = function == nullptr ? reader.table("model") : nullptr;
    if (own_model != nullptr || function != nullptr) {
        begin_own_model(study, table);
    }
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
    const auto loads = reader.tables("loads");
    // The reflection of a pulse at the bottom comes late from there.
    const bool has_history =
        std::any_of(loads.begin(), loads.end(), [](const auto* load) { return load->contains("history"); });
    for (const auto* layer : layers) {
        const bool endless = study.model.half_space && layer == layers.back();
        study.model.layers.push_back(read_layer(
            *layer, file,
            endless ? std::optional(std::max(has_history ? 8.0 : 3.0, 2.0 * study.model.depth())) : std::nullopt));
        check_name(study.model.layers.back().name, *layer);
    }
    for (const auto* load : loads) {
        study.model.loads.push_back(read_load(*load, study, table["data"]["outside"].value_or(false), read_text));
        check_name(study.model.loads.back().name, *load);
    }
    if (study.model.layers.empty() && !study.has_own_model) {
        throw pave::Error({.file = file, .key = "layers"}, "the section has no layers", {}, "at least one [[layers]]");
    }
    if (study.model.loads.empty() && !study.has_own_model) {
        throw pave::Error({.file = file, .key = "loads"}, "the study has no loads", {}, "at least one [[loads]]");
    }
    if (const auto* solver = reader.table("solver")) {
        read_solver(*solver, study);
    }
    study.model.settings.extent = extent_not_stated;
    if (const auto* mesh = reader.table("mesh")) {
        TableReader r(*mesh, file, "[mesh]");
        study.model.settings.extent = r.has(keys::mesh_extent) ? r.number(keys::mesh_extent) : extent_not_stated;
        study.model.settings.refine = r.number(keys::mesh_refine);
        r.done();
    }
    if (const auto* measure = reader.table("measure")) {
        TableReader r(*measure, file, "[measure]");
        for (const std::string& name : r.texts(keys::measure_possible)) {
            study.possible.push_back(find_quantity(name, r.place(keys::measure_possible)));
        }
        r.done();
    }
    if (const auto* data = reader.table("data")) {
        read_data(*data, study, readings, read_text);
    }
    set_noise(study);
    for (const auto* output : reader.tables("outputs")) {
        read_output(*output, study);
    }
    study.model.settings.wall_follows = study.model.settings.extent == extent_not_stated;
    // A wall that is stated is meant to be there.
    study.model.settings.layered = study.model.settings.wall_follows || study.model.half_space;
    settle_extent(study);
    const auto effects = reader.tables("effects");
    std::shared_ptr<const OwnEffects> own_effects;
    if (study.has_own_model) {
        own_effects = read_own_effects(effects, study);
    } else {
        for (const auto* effect : effects) {
            read_effect(*effect, study);
        }
    }
    for (const auto* correction : reader.tables("corrections")) {
        read_correction(*correction, study);
    }
    for (std::size_t l = 0; l < loads.size() && !study.has_own_model; ++l) {
        const pave::Place place = TableReader(*loads[l], file, "").place("");
        check_load(study.model, static_cast<int>(l), {.file = file, .line = place.line});
    }
    const auto parameters = reader.tables("parameters");
    for (const bool tied : {false, true}) { // what follows others comes after them
        for (const auto* parameter : parameters) {
            if (parameter->contains(keys::parameter_equals.key) == tied) {
                tied ? read_tie(*parameter, study) : read_parameter(*parameter, study);
            }
        }
    }
    if (const std::string wrong = apply_ties(study.model); !wrong.empty()) {
        throw pave::Error({.file = file, .key = "[[parameters]] equals"}, "a tied number is out of range", wrong,
                          "values of the others that keep it in range");
    }
    read_prior_correlations(reader.tables("prior_correlations"), study);
    for (const auto* constraint : reader.tables("constraints")) {
        TableReader r(*constraint, file, "[[constraints]]");
        const std::string that = r.text(keys::constraint_that);
        study.constraints.push_back(read_constraint(study, that, r.place(keys::constraint_that)));
        r.done();
    }
    reader.tables("criteria");
    reader.tables("seasons");
    reader.done();
    std::string own_files;
    if (study.has_own_model) {
        check_own_model(study);
    }
    if (function != nullptr) {
        own_files = "\n" + function->description();
        set_function(study, function, own_effects);
    } else if (own_model != nullptr) {
        own_files = read_model(*own_model, study, own_effects, read_text);
    }
    check_steps(study);
    if (readings == Readings::own && study.model.sensors.empty()) {
        throw pave::Error({.file = file}, "the study asks for nothing", "neither measurements nor outputs",
                          "[data] files, or [[outputs]]");
    }
    study.hash = study.file_hash = hash_of(table, study, own_files);
    study.text = std::move(text);
    criteria_of(study); // complain
    seasons_of(study);
    return study;
}

} // namespace

Study load_study(const std::string& file, Readings readings) {
    std::vector<data::InputFile> inputs{{file, data::read_file(file, "study")}};
    const auto beside = [&inputs, folder = std::filesystem::path(file).parent_path()](
                            const std::string& name, const pave::Place& place, std::string_view what) {
        const std::string path = (folder / name).string();
        if (std::error_code error; !std::filesystem::exists(path, error)) {
            throw pave::Error(place, fmt::format("this {} does not exist", what), "\"" + path + "\"",
                              "a path relative to the study's own folder");
        }
        inputs.push_back(
            {path,
             data::read_file(path, what, what == file_of_program ? data::Encoding::bytes : data::Encoding::utf8)});
        return NamedText{path, inputs.back().bytes};
    };
    Study study = parse(inputs[0].bytes, file, readings, beside);
    study.inputs = std::make_shared<const std::vector<data::InputFile>>(std::move(inputs));
    return study;
}

Study study_of(std::string text, const std::string& name, const std::map<std::string, std::string>& files) {
    return study_with(nullptr, std::move(text), name, files);
}

Study study_with(std::shared_ptr<const external::Simulator> function, std::string text, const std::string& name,
                 const std::map<std::string, std::string>& files) {
    const auto given = [&](const std::string& file, const pave::Place& place, std::string_view what) {
        const auto found = files.find(file);
        if (found == files.end()) {
            std::string names;
            for (const auto& [known, content] : files) {
                names += (names.empty() ? "" : ", ") + known;
            }
            throw pave::Error(place, fmt::format("this {} was not given", what), "\"" + file + "\"", names);
        }
        return NamedText{file, found->second};
    };
    return parse(std::move(text), name, Readings::own, given, std::move(function));
}

} // namespace explore::study
