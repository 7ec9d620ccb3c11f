#include "study/read_model.h"

#include "base/text.h"
#include "base/units.h"
#include "data/hash.h"
#include "external/model.h"
#include "external/program.h"
#include "external/um_bridge.h"
#include "study/variants.h"

#include <algorithm>
#include <cmath>
#include <sstream>

namespace explore::study {
namespace {

namespace fs = std::filesystem;
namespace unit = pave::unit;
using nlohmann::json;

constexpr double any_number = 1e300;

// Of the model's values: the study's parameters but sizes of effects, then what the effects change.
problem::ParameterSpace values_of(const Study& study, const OwnEffects& effects) {
    problem::ParameterSpace space;
    for (std::size_t k = 0; k < study.parameters.size(); ++k) {
        if (!study.parameters[k].in_effect) {
            space.axes.push_back(study.space.axes[k]);
        }
    }
    for (const OwnEffect& own : effects) {
        problem::Axis axis = size_axis(own.effect);
        axis.name = own.parameter;
        space.axes.push_back(std::move(axis));
    }
    return space;
}

std::vector<std::string> names_of_values(const problem::ParameterSpace& space) {
    std::vector<std::string> names;
    for (const problem::Axis& axis : space.axes) {
        names.push_back(axis.name);
    }
    return names;
}

// A file that [model] names, from the study's own folder: `folder` before it.
std::string from_folder(const std::string& folder, const std::string& name) {
    return folder.empty() ? name : (fs::path(folder) / name).lexically_normal().generic_string();
}

std::vector<external::Wanted> wanted_of(const Study& study) {
    std::vector<external::Wanted> wanted;
    for (const data::Reading& r : study.readings) {
        wanted.push_back({.label = r.label(),
                          .load = r.load,
                          .quantity = r.quantity,
                          .x_mm = r.x_mm,
                          .y_mm = r.y_mm,
                          .depth_mm = r.depth_mm,
                          .gauge_mm = r.gauge_mm,
                          .time_ms = r.time_ms,
                          .output = r.output});
    }
    return wanted;
}

json json_of(const toml::table& table) {
    std::ostringstream text;
    text << toml::json_formatter(table);
    return json::parse(text.str());
}

// A name in the folder of a run.
std::string inside_folder(const std::string& name, const pave::Place& place) {
    if (name.empty() || leaves_folder(fs::path(name))) {
        throw pave::Error(place, "this is no file in the folder of a run", "\"" + name + "\"",
                          "a name or a path without .. in front");
    }
    return name;
}

external::OutputFile read_output_file(const toml::table& table, const Study& study,
                                      const std::vector<external::Wanted>& wanted) {
    TableReader r(table, study.file, "[model] outputs");
    external::OutputFile output;
    output.file = inside_folder(r.text(keys::model_output_file), r.place(keys::model_output_file));
    if (r.has(keys::model_output_reading)) {
        const std::string name = r.text(keys::model_output_reading);
        std::vector<std::string> labels;
        for (std::size_t i = 0; i < wanted.size(); ++i) {
            labels.push_back(wanted[i].label);
            if (wanted[i].label == name) {
                if (output.reading) {
                    throw pave::Error(r.place(keys::model_output_reading), "two readings have this name",
                                      "\"" + name + "\"", "each name once, in the column name of the measurements");
                }
                output.reading = i;
            }
        }
        if (!output.reading) {
            const std::string near = pave::nearest_name(name, labels);
            throw pave::Error(r.place(keys::model_output_reading),
                              near.empty() ? "no reading or output has this name"
                                           : "no reading or output has this name, did you mean \"" + near + "\"?",
                              "\"" + name + "\"", pave::join(labels));
        }
    }
    const bool by_line = r.has(keys::model_output_line);
    const bool by_table = r.has(keys::model_output_by);
    const bool by_pointer = r.has(keys::model_output_at);
    if (int{by_line} + int{by_table} + int{by_pointer} != 1 || (by_line && !output.reading) ||
        (by_table && output.reading)) {
        throw pave::Error(r.place(""), "this says no place of readings",
                          pave::join({by_line ? "line" : "no line", by_table ? "by" : "no by",
                                      by_pointer ? "at" : "no at", output.reading ? "reading" : "no reading"}),
                          "reading with line and column; by, of a CSV table; or at, of JSON, with or without reading");
    }
    if (by_line) {
        const std::string text = r.text(keys::model_output_line);
        output.line = external::line_of(text);
        if (!output.line) {
            throw pave::Error(r.place(keys::model_output_line), "this says no line", "\"" + text + "\"",
                              std::string(keys::model_output_line.allowed));
        }
        output.column = static_cast<std::size_t>(r.integer(keys::model_output_column));
    } else if (by_table) {
        output.by = r.texts(keys::model_output_by);
        const auto& known = external::by_columns();
        for (const std::string& column : output.by) {
            if (std::find(known.begin(), known.end(), column) == known.end()) {
                throw pave::Error(r.place(keys::model_output_by), "readings are not told apart by this",
                                  "\"" + column + "\"", pave::join(known));
            }
        }
        if (output.by.empty()) {
            throw pave::Error(r.place(keys::model_output_by), "the list of columns is empty", "[]", pave::join(known));
        }
        output.value_column = r.text(keys::model_output_value, std::string("value"));
    } else {
        output.at = r.text(keys::model_output_at);
        if (!output.at.empty() && !output.at.starts_with('/')) {
            throw pave::Error(r.place(keys::model_output_at), "this is no JSON pointer", "\"" + output.at + "\"",
                              "\"\" for the whole, or /name, /name/0");
        }
    }
    r.done();
    return output;
}

void check_outputs(const std::vector<external::OutputFile>& outputs, const std::vector<external::Wanted>& wanted,
                   const pave::Place& place) {
    std::vector<char> named(wanted.size(), 0);
    for (const external::OutputFile& output : outputs) {
        if (!output.reading) {
            return;
        }
        if (named[*output.reading]++ != 0) {
            throw pave::Error(place, "a reading is given twice", "\"" + wanted[*output.reading].label + "\"",
                              "each once");
        }
    }
    const auto missing = std::find(named.begin(), named.end(), 0);
    if (missing != named.end()) {
        throw pave::Error(place, "nothing says where this reading stands",
                          "\"" + wanted[static_cast<std::size_t>(missing - named.begin())].label + "\"",
                          "an entry with reading = ..., or one with by or at for all that have none");
    }
}

std::shared_ptr<const external::Simulator> read_program(TableReader& reader, const Study& study,
                                                        const OwnEffects& effects,
                                                        const std::vector<std::string>& names,
                                                        const TextReader& read_text) {
    const std::string own_folder = reader.text(keys::model_folder, "");
    const fs::path study_folder = fs::path(study.file).parent_path();
    const fs::path folder = fs::current_path() / study_folder / own_folder; // both may be empty
    const auto check_in_folder = [&](const std::string& name, const Key& key) {
        if (leaves_folder(study_folder / own_folder, name)) {
            throw pave::Error(reader.place(key), "this file lies outside the model's folder", "\"" + name + "\"",
                              "a file in it or below, and folder = \"PATH\" in [model] where it is another than the "
                              "study's own");
        }
    };
    const auto wanted = wanted_of(study);
    external::ProgramSettings settings;
    settings.command = reader.texts(keys::model_command);
    if (settings.command.empty() || settings.command[0].empty()) {
        throw pave::Error(reader.place(keys::model_command), "the command is empty", "[]",
                          std::string(keys::model_command.allowed));
    }
    if (std::string& program = settings.command[0]; program.find('/') != std::string::npos) {
        program = (folder / program).lexically_normal().string(); // else it is looked for as the shell does
    }
    for (const toml::table* table : reader.tables(keys::model_inputs)) {
        TableReader r(*table, study.file, "[model] inputs");
        const std::string name = r.text(keys::model_input_template);
        check_in_folder(name, keys::model_inputs);
        const auto [path, text] =
            read_text(from_folder(own_folder, name), r.place(keys::model_input_template), "template");
        const std::string file = inside_folder(r.text(keys::model_input_file), r.place(keys::model_input_file));
        settings.inputs.push_back({external::Template(text, path, names), file});
        r.done();
    }
    for (std::size_t k = 0; k < names.size(); ++k) {
        if (std::none_of(settings.inputs.begin(), settings.inputs.end(),
                         [&](const auto& input) { return input.from.uses(k); })) {
            const std::size_t own = k + effects.size() - names.size(); // of a parameter that is no effect's: beyond
            throw pave::Error(own < effects.size() ? effects[own].place : reader.place(keys::model_inputs),
                              "no template has a place for this parameter", "\"" + names[k] + "\"",
                              "{{" + names[k] + "}} in a template");
        }
    }
    if (reader.has(keys::model_files)) {
        for (const std::string& name : reader.texts(keys::model_files)) {
            check_in_folder(name, keys::model_files);
            const auto [path, bytes] =
                read_text(from_folder(own_folder, name), reader.place(keys::model_files), file_of_program);
            settings.files.push_back(
                {inside_folder(name, reader.place(keys::model_files)), fs::absolute(path).lexically_normal().string()});
        }
    }
    const auto outputs = reader.tables(keys::model_outputs);
    if (outputs.empty()) {
        throw pave::Error(reader.place(keys::model_outputs), "nothing says where the readings stand", {},
                          std::string(keys::model_outputs.allowed));
    }
    for (const toml::table* table : outputs) {
        settings.outputs.push_back(read_output_file(*table, study, wanted));
    }
    check_outputs(settings.outputs, wanted, reader.place(keys::model_outputs));
    settings.time_limit = reader.has(keys::model_time_limit) ? reader.number(keys::model_time_limit) : 0.0;
    settings.keep = static_cast<external::Keep>(reader.choice(keys::model_keep));
    return external::make_program(std::move(settings), names, wanted);
}

std::shared_ptr<const external::Simulator> read_server(TableReader& reader, const toml::table& table,
                                                       const Study& study, std::size_t parameters) {
    external::ServerSettings settings;
    if (reader.has(keys::model_url) == reader.has(keys::model_urls)) {
        throw pave::Error(reader.place(""), "a server has an address",
                          table.contains("url") ? "url and urls" : "neither url nor urls", "one of url and urls");
    }
    const Key& key = reader.has(keys::model_url) ? keys::model_url : keys::model_urls;
    settings.urls =
        reader.has(keys::model_url) ? std::vector{reader.text(keys::model_url)} : reader.texts(keys::model_urls);
    for (const std::string& url : settings.urls) {
        constexpr std::string_view scheme = "http://";
        if (!url.starts_with(scheme) || url.size() == scheme.size() ||
            url.find('/', scheme.size()) != std::string::npos) {
            throw pave::Error(reader.place(key), "this is no address of a server", "\"" + url + "\"",
                              "http://HOST:PORT");
        }
    }
    if (settings.urls.empty()) {
        throw pave::Error(reader.place(key), "the list of servers is empty", "[]", "http://HOST:PORT");
    }
    settings.name = reader.text(keys::model_name, settings.name);
    if (const toml::table* config = reader.table(keys::model_config)) {
        settings.config = json_of(*config);
    }
    settings.parameters = parameters;
    settings.responses = study.readings.size();
    settings.time_limit = reader.has(keys::model_time_limit) ? reader.number(keys::model_time_limit) : 0.0;
    return external::make_client(std::move(settings));
}

} // namespace

void begin_own_model(Study& study, const toml::table& table) {
    for (const char* name : {"section", "layers", "loads", "solver", "mesh", "measure", "corrections"}) {
        if (table.contains(name)) {
            throw pave::Error(TableReader(table, study.file, "").place(name),
                              "this belongs to the built-in model, and the study has one of its own", name,
                              "[model], [data], [[parameters]], [[effects]], [[outputs]], [[constraints]] and "
                              "[[prior_correlations]]");
        }
    }
    study.has_own_model = true;
    study.model.corrections.emplace_back();
}

void check_own_name(const std::string& name, const pave::Place& place) {
    if (name.empty() || name.find_first_of("{}: \t\n\r=,\"") != std::string::npos || pave::printable(name) != name) {
        throw pave::Error(place, "this cannot be the name of a parameter", "\"" + name + "\"",
                          "letters, digits and signs but blanks, braces, quotes, colons, commas and =");
    }
}

pave::pavement::Parameter add_own_parameter(Study& study, const std::string& name, const pave::Place& place) {
    if (auto size = own_size(study, name)) {
        return *std::move(size);
    }
    check_own_name(name, place);
    auto& values = study.model.corrections[0].factors;
    pave::pavement::Parameter parameter;
    parameter.path = name;
    parameter.in_correction = true;
    parameter.place = values.size();
    parameter.low = -any_number;
    parameter.high = any_number;
    values.push_back(0.0);
    return parameter;
}

double own_value(TableReader& reader, const problem::Axis& axis) {
    return reader.number(keys::parameter_value.key, axis.low, axis.high, false, axis.physical(0.5));
}

pave::pavement::Sensor own_sensor(Study& study, const data::Reading& reading) {
    pave::pavement::Sensor sensor;
    auto& loads = study.model.loads;
    const auto load = std::find_if(loads.begin(), loads.end(), [&](const auto& l) { return l.name == reading.load; });
    sensor.load = static_cast<int>(load - loads.begin());
    if (load == loads.end()) {
        loads.push_back({.name = reading.load});
    }
    // An effect of one quantity has one of those that are there but deflections, of which more is known.
    std::vector<std::string> known;
    for (const data::Reading& other : study.readings) {
        if (std::find(known.begin(), known.end(), other.quantity) == known.end()) {
            known.push_back(other.quantity);
        }
    }
    const auto own = static_cast<std::size_t>(std::find(known.begin(), known.end(), reading.quantity) - known.begin());
    sensor.quantity = pave::pavement::quantities[1 + own % (std::size(pave::pavement::quantities) - 1)].quantity;
    sensor.x = reading.x_mm * unit::mm;
    sensor.y = reading.y_mm * unit::mm;
    sensor.depth = reading.depth_mm * unit::mm;
    sensor.gauge = reading.gauge_mm * unit::mm;
    if (reading.time_ms) {
        sensor.time = *reading.time_ms * unit::ms;
    }
    sensor.measured = reading.is_measured();
    return sensor;
}

void check_new_output(const Study& study, const std::string& name, const pave::Place& place) {
    for (const data::Reading& known : study.readings) {
        if (!known.is_measured() && known.output == name) {
            throw pave::Error(place, "two outputs have this name", "\"" + name + "\"", "a name of its own");
        }
    }
}

void read_own_output(const toml::table& table, Study& study) {
    TableReader reader(table, study.file, "[[outputs]]");
    data::Reading output;
    output.output = reader.text(keys::output_name);
    check_new_output(study, output.output, reader.place(keys::output_name));
    reader.rename("output \"" + output.output + "\"");
    const std::string known = study.model.loads.empty() ? "model" : study.model.loads[0].name;
    output.load = reader.text(keys::output_load, known);
    output.quantity = reader.text(keys::output_quantity, output.output);
    output.unit = data::any_unit(reader.text(keys::output_unit, std::string("-")));
    output.x_mm = reader.number(keys::output_x.key, keys::output_x.low, keys::output_x.high, false, 0.0);
    output.y_mm = reader.number(keys::output_y.key, keys::output_y.low, keys::output_y.high, false, 0.0);
    output.depth_mm =
        reader.number(keys::output_depth.key, keys::output_depth.low, keys::output_depth.high, false, 0.0);
    output.gauge_mm =
        reader.number(keys::output_gauge.key, keys::output_gauge.low, keys::output_gauge.high, false, 0.0);
    if (reader.has(keys::output_time)) {
        output.time_ms = reader.number(keys::output_time);
    }
    reader.done();
    study.model.sensors.push_back(own_sensor(study, output));
    study.readings.push_back(std::move(output));
}

void check_own_model(const Study& study) {
    if (study.space.axes.empty()) {
        throw pave::Error({.file = study.file, .key = "parameters"}, "a model of your own is a function of parameters",
                          {}, "at least one [[parameters]]");
    }
    if (!study.model.ties.empty()) {
        throw pave::Error({.file = study.file, .key = "[[parameters]] equals"},
                          "what follows other numbers is the built-in model's", study.model.ties[0].path,
                          "the arithmetic in the model itself");
    }
}

namespace {

void set_model(Study& study, std::shared_ptr<const external::Simulator> simulator, problem::ParameterSpace space,
               std::shared_ptr<const OwnEffects> effects) {
    std::vector<double> to_si;
    for (const data::Reading& reading : study.readings) {
        to_si.push_back(reading.unit.to_si);
    }
    study.external =
        std::make_shared<OwnModel>(std::move(simulator), std::move(space), std::move(to_si), std::move(effects));
}

} // namespace

void set_function(Study& study, std::shared_ptr<const external::Simulator> function,
                  std::shared_ptr<const OwnEffects> effects) {
    check_own_effects(*effects, study);
    problem::ParameterSpace space = values_of(study, *effects);
    set_model(study, std::move(function), std::move(space), std::move(effects));
}

std::string read_model(const toml::table& table, Study& study, std::shared_ptr<const OwnEffects> effects,
                       const TextReader& read_text) {
    TableReader reader(table, study.file, "[model]");
    // Of the other type: no misspelt ones.
    reader.expect(std::array{keys::model_command, keys::model_inputs, keys::model_files, keys::model_outputs,
                             keys::model_folder, keys::model_keep, keys::model_url, keys::model_urls, keys::model_name,
                             keys::model_config});
    const bool is_program = reader.choice(keys::model_type) == 0;
    std::string contents;
    const TextReader remembered = [&](const std::string& name, const pave::Place& place, std::string_view what) {
        NamedText read = read_text(name, place, what);
        contents += "\n" + data::hash_of(read.text);
        return read;
    };
    check_own_effects(*effects, study);
    problem::ParameterSpace space = values_of(study, *effects);
    auto simulator = is_program ? read_program(reader, study, *effects, names_of_values(space), remembered)
                                : read_server(reader, table, study, space.axes.size());
    reader.done();
    set_model(study, std::move(simulator), std::move(space), std::move(effects));
    return contents;
}

} // namespace explore::study
