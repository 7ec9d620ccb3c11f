#include "study/read_load.h"

#include "base/units.h"
#include "data/history.h"
#include "pavement/pulse.h"
#include "study/table_reader.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace explore::study {

using namespace pave::pavement;
namespace unit = pave::unit;

void check_inside(const Study& study, const std::string& name, const pave::Place& place) {
    if (leaves_folder(std::filesystem::path(study.file).parent_path(), name)) {
        throw pave::Error(place, "this file lies outside the study's own folder", "\"" + name + "\"",
                          "a file in it or below, or outside = true in [data]");
    }
}

namespace {

// A load that a file says the time of, and the force or the pressure too where it is not a number yet. What is missing
// then, the reader says at its place.
void set_history(Load& load, const data::History& history, const TableReader& reader) {
    const double largest = *std::max_element(history.values.begin(), history.values.end());
    if (load.type == LoadType::plate) {
        const double area = std::numbers::pi * load.radius * load.radius;
        if (std::isnan(load.pressure)) {
            load.pressure = history.is_force ? largest * unit::kN / area : largest * unit::kPa;
        }
    } else {
        double& recorded = history.is_force ? load.force : load.pressure;
        if (std::isnan(recorded)) {
            recorded = largest * (history.is_force ? unit::kN : unit::kPa);
        }
        const char* other = history.is_force ? "pressure_kPa" : "force_kN";
        if (std::isnan(history.is_force ? load.pressure : load.force)) {
            throw pave::Error(
                reader.place(other), "the size of the patch follows from the force and the pressure", {},
                fmt::format("{}: the history has the {}", other, history.is_force ? "force" : "pressure"));
        }
    }
    for (std::size_t i = 0; i < history.time_ms.size(); ++i) {
        load.history.push_back({history.time_ms[i] * unit::ms, history.values[i] / largest});
    }
}

} // namespace

Load read_load(const toml::table& table, const Study& study, bool outside, const TextReader& read_text) {
    const std::string& file = study.file;
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
    const bool has_history = table.contains(keys::load_history.key);
    if (load.type != LoadType::gear) {
        reader.expect(std::array{keys::load_history});
    } else if (has_history) {
        throw pave::Error(reader.place(keys::load_history), "a history is of a plate, a wheel or a dual wheel",
                          "type = \"gear\"", "one of the wheels of the gear");
    }
    if (has_history && table.contains("duration_ms")) {
        throw pave::Error(reader.place("duration_ms"), "the history of this load says how long it presses",
                          "duration_ms", "history alone");
    }
    for (const KeyInfo& key : load_keys(load.type, load.patch, has_history)) {
        key.of_load(load) = key.to_si * reader.number(key.key, key.low, key.high, key.low_is_open, key.default_value);
    }
    if (has_history) {
        const std::string name = reader.text(keys::load_history);
        if (!outside) {
            check_inside(study, name, reader.place(keys::load_history));
        }
        const auto [path, text] = read_text(name, reader.place(keys::load_history), "history");
        set_history(load, data::history_of(text, path), reader);
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

void check_steps(const Study& study) {
    constexpr std::size_t most = 20000;
    for (std::size_t l = 0; l < study.model.loads.size(); ++l) {
        const Load& load = study.model.loads[l];
        if (!load.is_pulse()) {
            continue;
        }
        const std::size_t steps = steps_of(study.model, static_cast<int>(l));
        if (steps > most) {
            throw pave::Error({.file = study.file, .key = "solver.time_step_ms"},
                              "the load \"" + load.name + "\" would be followed for too many steps",
                              std::to_string(steps), fmt::format("at most {}", most));
        }
    }
}

} // namespace explore::study
