#include "data/fwd_pddx.h"

#include "data/csv.h"
#include "data/fwd_lines.h"
#include "data/fwd_values.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fmt/format.h>
#include <map>
#include <numbers>

namespace explore::data {
namespace {

struct Entry {
    std::string value;
    int line = 0;
};

struct Section {
    std::string name; // lower case
    int line = 0;
    std::map<std::string, Entry> entries;                  // keys in lower case
    std::vector<std::pair<std::string, Entry>> repeated{}; // those that stand again

    const Entry* find(std::string_view key) const {
        const auto at = entries.find(lower_case(key));
        return at == entries.end() ? nullptr : &at->second;
    }
};

class PddxReader {
public:
    PddxReader(std::string_view text, std::string file) : file_(std::move(file)) {
        for_each_line(text, [&](std::string_view line, int number) { take(trimmed(line), number); });
    }

    FwdFile read() {
        const Section& device = section("device configuration");
        const Section& units = section("units");
        const Section& head = sections_.front();
        delimiter_ = symbol(head, "DelimiterSymbol", ',');
        decimal_ = symbol(head, "DecimalSymbol", '.');
        const Entry& radius = entry(device, "LoadPlateRadius");
        radius_m_ = length(units, "LoadPlateRadiusUnits") *
                    (is_nil(radius.value) ? NAN : value(radius, "LoadPlateRadius", radius.value));
        to_um_ = length(units, "DeflectionUnits") * 1e6;
        set_load(units);
        set_sensors(units, device);
        if (const auto at = std::find_if(sections_.begin(), sections_.end(),
                                         [](const Section& s) { return s.name == "operations information"; });
            at != sections_.end()) {
            date_ = at->find("StartDate") != nullptr ? at->find("StartDate")->value : "";
        }
        const Entry& place_units = entry(units, "TestLocationUnits");
        to_m_ = unit(place_units, "TestLocationUnits", split(place_units.value)[0], length_units());
        set_temperatures(units, device);
        for (const Section& at : sections_) {
            if (at.name.starts_with("test location")) {
                result_.stations.push_back(station(at));
            }
        }
        say_what_is_repeated();
        return with_drops(std::move(result_), file_, "sections [Test Location i] with DropData1 = load, deflections");
    }

private:
    void take(std::string_view line, int number) {
        if (line.empty()) {
            return;
        }
        if (line.front() == '[') {
            if (line.back() != ']') {
                throw pave::Error({.file = file_, .line = number}, "a section is never closed",
                                  "\"" + std::string(line) + "\"", "[name]");
            }
            sections_.push_back({lower_case(trimmed(line.substr(1, line.size() - 2))), number, {}});
            return;
        }
        const std::size_t equals = line.find('=');
        if (equals == std::string_view::npos || sections_.empty()) {
            return; // a comment, or a line of a time history
        }
        Section& section = sections_.back();
        const std::string key = lower_case(trimmed(line.substr(0, equals)));
        const Entry entry{std::string(trimmed(line.substr(equals + 1))), number};
        if (!section.entries.try_emplace(key, entry).second) {
            section.repeated.emplace_back(key, entry);
        }
    }

    // Drops that stand again are drops of their own (see station); of other keys that are read the first counts.
    void say_what_is_repeated() {
        constexpr std::string_view read[] = {"delimitersymbol",
                                             "decimalsymbol",
                                             "loadplateradiusunits",
                                             "loadunits",
                                             "deflectionunits",
                                             "temperatureunits",
                                             "sensorlocationunits",
                                             "testlocationunits",
                                             "loadplateradius",
                                             "numberofdeflectionsensors",
                                             "deflectionsensorxaxisdistances",
                                             "deflectionsensoryaxisdistances",
                                             "temperaturesensoruse",
                                             "startdate",
                                             "testlocation",
                                             "testlane",
                                             "testtime",
                                             "testcomment",
                                             "testtemperatures",
                                             "gpslocation"};
        for (const Section& section : sections_) {
            for (const auto& [key, entry] : section.repeated) {
                if (std::find(std::begin(read), std::end(read), key) != std::end(read)) {
                    result_.remarks.push_back(fmt::format("{}, line {}: {} stands again in [{}]: the first counts",
                                                          file_, entry.line, key, section.name));
                }
            }
        }
    }

    pave::Place place(const Entry& entry, std::string_view key) const {
        return {.file = file_, .line = entry.line, .key = std::string(key)};
    }
    const Section& section(std::string_view name) const {
        const auto at =
            std::find_if(sections_.begin(), sections_.end(), [&](const Section& s) { return s.name == name; });
        if (at == sections_.end()) {
            throw pave::Error({.file = file_}, "section missing", {}, "[" + std::string(name) + "]");
        }
        return *at;
    }
    const Entry& entry(const Section& s, std::string_view key) const {
        const Entry* found = s.find(key);
        if (found == nullptr) {
            throw pave::Error({.file = file_, .line = s.line, .key = std::string(key)}, "missing in [" + s.name + "]");
        }
        return *found;
    }
    char symbol(const Section& head, std::string_view key, char otherwise) const {
        const Entry* found = head.find(key);
        if (found == nullptr || found->value.empty()) {
            return otherwise;
        }
        const std::string word = plain_word(found->value);
        if (word == "tab") {
            return '\t';
        }
        if (word == "comma" || word == "semicolon" || word == "period") {
            return word == "comma" ? ',' : word == "semicolon" ? ';' : '.';
        }
        if (found->value.size() != 1) {
            throw pave::Error(place(*found, key), "not a symbol", "\"" + found->value + "\"", "one character");
        }
        return found->value[0];
    }
    std::vector<std::string> split(std::string_view text) const {
        const auto cells = cells_between(delimiter_, text);
        return {cells.begin(), cells.end()};
    }
    std::string with_point(std::string text) const {
        if (decimal_ != '.') {
            std::replace(text.begin(), text.end(), decimal_, '.');
        }
        return text;
    }
    double value(const Entry& from, std::string_view key, const std::string& text) const {
        return finite_number(with_point(text), place(from, key));
    }
    double number(const Section& s, std::string_view key) const {
        const Entry& found = entry(s, key);
        return value(found, key, found.value);
    }
    // Nothing where a nil stands; nils at the end are left out.
    std::vector<std::optional<double>> numbers(const Entry& from, std::string_view key) {
        std::vector<std::optional<double>> list;
        for (const std::string& part : split(from.value)) {
            list.push_back(measured(with_point(part)));
            if (!list.back() && !is_nil(part)) {
                result_.remarks.push_back(
                    fmt::format("{}, line {}, {}: \"{}\" is not a number and left out", file_, from.line, key, part));
            }
        }
        while (!list.empty() && !list.back()) {
            list.pop_back();
        }
        return list;
    }
    // The measured value; nothing: something else stands there, or the list ends before.
    std::optional<double> measured_at(const std::vector<std::string>& parts, std::size_t i) const {
        return i < parts.size() ? measured(with_point(parts[i])) : std::nullopt;
    }
    double unit(const Entry& from, std::string_view key, std::string_view word,
                std::span<const NamedUnit> known) const {
        const auto factor = factor_of(known, word);
        if (!factor) {
            throw pave::Error(place(from, key), "unknown unit", "\"" + std::string(word) + "\"", names_of(known));
        }
        return *factor;
    }
    double length(const Section& units, std::string_view key) const {
        const Entry& found = entry(units, key);
        return unit(found, key, found.value, length_units());
    }

    void set_load(const Section& units) {
        const Entry& found = entry(units, "LoadUnits");
        if (const auto pressure = factor_of(pressure_units(), found.value)) {
            to_kPa_ = *pressure / 1e3;
        } else if (const auto force = factor_of(force_units(), found.value)) {
            to_kN_ = *force / 1e3;
            to_kPa_ = *to_kN_ / (std::numbers::pi * radius_m_ * radius_m_);
        } else {
            throw pave::Error(place(found, "LoadUnits"), "unknown unit", "\"" + found.value + "\"",
                              names_of(force_units()) + ", " + names_of(pressure_units()));
        }
    }
    void set_sensors(const Section& units, const Section& device) {
        const double to_mm = length(units, "SensorLocationUnits") * 1e3;
        const Entry& x = entry(device, "DeflectionSensorXAxisDistances");
        auto along = numbers(x, "DeflectionSensorXAxisDistances");
        const Entry* y = device.find("DeflectionSensorYAxisDistances");
        auto across =
            y != nullptr ? numbers(*y, "DeflectionSensorYAxisDistances") : std::vector<std::optional<double>>{};
        const double stated = number(device, "NumberOfDeflectionSensors");
        const std::size_t read = deflections_of_a_drop();
        if (read > 0 && along.size() == read + 1 && along[0] == 0.0 && along[1] && *along[1] <= 0.0) {
            // The load cell, which stands at the centre, is counted among the sensors.
            along.erase(along.begin());
            if (across.size() == read + 1) {
                across.erase(across.begin());
            }
            result_.remarks.push_back(
                fmt::format("line {} has {} distances, line {} states {:g} sensors and a drop has "
                            "{} deflections: the first distance is taken for the load cell's",
                            x.line, read + 1, entry(device, "NumberOfDeflectionSensors").line, stated, read));
        } else if (stated != static_cast<double>(along.size())) {
            const int line = entry(device, "NumberOfDeflectionSensors").line;
            if (along.size() != read) {
                throw pave::Error(place(x, "DeflectionSensorXAxisDistances"), "not one distance a sensor",
                                  fmt::format("{} distances, {:g} sensors (line {}), {} deflections a drop",
                                              along.size(), stated, line, read));
            }
            result_.remarks.push_back(
                fmt::format("line {} states {:g} sensors; there are {} distances (line {}) and as "
                            "many deflections a drop",
                            line, stated, along.size(), x.line));
        }
        if (std::find(along.begin(), along.end(), std::nullopt) != along.end()) {
            result_.remarks.push_back(
                fmt::format("{}, line {}: a sensor without a place is left out with its readings", file_, x.line));
        }
        for (std::size_t i = 0; i < along.size(); ++i) {
            // Not a number: not placed; negative: behind the plate.
            const double x_of = along[i].value_or(NAN);
            const double y_of = i < across.size() ? across[i].value_or(0.0) : 0.0;
            offsets_mm_.push_back(to_mm * std::copysign(std::hypot(x_of, y_of), x_of));
        }
    }
    // Of the longest drop; 0: there is none.
    std::size_t deflections_of_a_drop() const {
        std::size_t most = 1;
        for (const Section& at : sections_) {
            for (const auto& [number, entry] : drops_of(at)) {
                std::size_t values = 0;
                const auto parts = split(entry->value);
                for (std::size_t i = 0; i < parts.size(); ++i) {
                    values = parts[i].empty() ? values : i + 1;
                }
                most = std::max(most, values);
            }
        }
        return most - 1;
    }
    // Of a key such as dropdata_2 in a section of drops.
    static std::optional<int> drop_number(const Section& at, std::string_view name) {
        constexpr std::string_view key = "dropdata";
        if (!at.name.starts_with("test location") || !name.starts_with(key)) {
            return std::nullopt;
        }
        std::string_view rest = name.substr(key.size());
        rest.remove_prefix(rest.starts_with('_') ? 1 : 0);
        int number = 0;
        const auto [end, error] = std::from_chars(rest.data(), rest.data() + rest.size(), number);
        return error == std::errc() && end == rest.data() + rest.size() ? std::optional(number) : std::nullopt;
    }
    // The drops of a section, by number; those whose number stands again follow, counted on.
    std::map<int, const Entry*> drops_of(const Section& at) const {
        std::map<int, const Entry*> drops;
        for (const auto& [name, entry] : at.entries) {
            if (const auto number = drop_number(at, name)) {
                drops[*number] = &entry;
            }
        }
        for (const auto& [name, entry] : at.repeated) {
            if (drop_number(at, name)) {
                drops[drops.rbegin()->first + 1] = &entry;
            }
        }
        return drops;
    }
    void set_temperatures(const Section& units, const Section& device) {
        const Entry* scale = units.find("TemperatureUnits");
        is_fahrenheit_ = scale != nullptr && plain_word(scale->value).starts_with("f");
        if (const Entry* use = device.find("TemperatureSensorUse")) {
            for (const std::string& part : split(use->value)) {
                temperature_of_.push_back(plain_word(part));
            }
        }
    }

    FwdStation station(const Section& at) const {
        const auto text = [&](std::string_view key) { return at.find(key) != nullptr ? at.find(key)->value : ""; };
        const std::vector<std::string> parts = split(text("TestLocation"));
        FwdStation s{.name = parts[0],
                     .lane = text("TestLane"),
                     .chainage_m = chainage(with_point(parts[0]), to_m_),
                     .date = date_,
                     .time = text("TestTime"),
                     .comment = text("TestComment"),
                     .file = file_};
        s.line = at.line;
        if (!s.chainage_m) {
            s.name = s.name.empty() ? at.name : s.name;
            s.remarks.push_back(
                fmt::format("line {}: TestLocation \"{}\" is no chainage",
                            at.find("TestLocation") != nullptr ? at.find("TestLocation")->line : at.line, parts[0]));
        }
        std::vector<std::string> position = split(text("GPSLocation"));
        position.resize(std::max<std::size_t>(position.size(), 2));
        set_position(s, with_point(position[0]), with_point(position[1]));
        const std::vector<std::string> read = split(text("TestTemperatures"));
        for (std::size_t i = 0; i < temperature_of_.size(); ++i) {
            const std::string& use = temperature_of_[i];
            auto* to = use == "air"                          ? &s.air_C
                       : use == "surface"                    ? &s.surface_C
                       : use == "manual" || use == "asphalt" ? &s.asphalt_C
                                                             : nullptr;
            if (const auto degree = measured_at(read, i); to != nullptr && degree) {
                *to = is_fahrenheit_ ? celsius(*degree) : *degree;
            }
        }
        const auto drops = drops_of(at);
        if (drops.empty()) {
            s.unusable = no_drops;
        }
        for (const auto& [name, entry] : at.repeated) {
            if (drop_number(at, name)) {
                s.remarks.push_back(
                    fmt::format("line {}: {} stands again and is taken for a drop of its own", entry.line, name));
            }
        }
        if (const Entry* count = at.find("NumberOfDrops");
            count != nullptr && measured(count->value) &&
            *measured(count->value) != static_cast<double>(drops.size())) {
            s.remarks.push_back(
                fmt::format("line {} states {} drops; there are {}", count->line, count->value, drops.size()));
        }
        for (const auto& [number, entry] : drops) {
            const auto values = split(entry->value);
            const auto load = measured_at(values, 0);
            FwdDrop drop{.number = number,
                         .radius_mm = 1e3 * radius_m_,
                         .pressure_kPa = load ? to_kPa_ * *load : NAN,
                         .readings = {}};
            drop.line = entry->line;
            if (load && to_kN_) {
                drop.force_kN = *to_kN_ * *load;
            }
            const bool too_long = std::any_of(
                values.begin() + static_cast<std::ptrdiff_t>(std::min(values.size(), offsets_mm_.size() + 1)),
                values.end(), [](const std::string& value) { return !value.empty(); });
            if (too_long) {
                s.remarks.push_back(
                    fmt::format("line {}: {} values, where a load and {} deflections belong; the drop is "
                                "left out",
                                entry->line, values.size(), offsets_mm_.size()));
                drop.pressure_kPa = NAN;
            }
            for (std::size_t i = 0; i < offsets_mm_.size(); ++i) {
                if (!std::isfinite(offsets_mm_[i])) {
                    continue;
                }
                if (const auto deflection = measured_at(values, i + 1)) {
                    drop.readings.push_back({offsets_mm_[i], to_um_ * *deflection});
                } else {
                    drop.not_read_mm.push_back(offsets_mm_[i]);
                }
            }
            s.drops.push_back(std::move(drop));
        }
        return s;
    }

    std::string file_;
    std::vector<Section> sections_;
    char delimiter_ = ',';
    char decimal_ = '.';
    double radius_m_ = 0.0;
    double to_um_ = 1.0;
    double to_kPa_ = 1.0;         // of a load
    std::optional<double> to_kN_; // of a load that is a force
    double to_m_ = 1.0;           // of a station
    std::string date_;
    FwdFile result_;
    bool is_fahrenheit_ = false;
    std::vector<double> offsets_mm_;
    std::vector<std::string> temperature_of_; // what each sensor of temperature reads
};

} // namespace

bool recognises_fwd_pddx(std::string_view text, const ColumnMap& /*columns*/) {
    const std::size_t at = text.find_first_not_of(" \t\r\n");
    return at != std::string_view::npos &&
           lower_case(text.substr(at, 60)).starts_with("[pavement deflection data exchange file]");
}

FwdFile read_fwd_pddx(std::string_view text, const std::string& file, const ColumnMap& /*columns*/) {
    return PddxReader(text, file).read();
}

} // namespace explore::data
