#include "data/fwd_pddx.h"

#include "data/csv.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fmt/format.h>
#include <map>
#include <numbers>

namespace explore::data {
namespace {

// Lower case without blanks, hyphens and a plural s: "kilo-Newtons" and "kilonewton" are the same unit.
std::string plain(std::string_view unit) {
    std::string out;
    for (const char c : lower_case(unit)) {
        if (c != ' ' && c != '-' && c != '_') {
            out += c;
        }
    }
    if (out.size() > 3 && out.ends_with('s')) {
        out.pop_back();
    }
    return out;
}

struct Entry {
    std::string value;
    int line = 0;
};

struct Section {
    std::string name; // lower case
    int line = 0;
    std::map<std::string, Entry> entries; // keys in lower case

    const Entry* find(std::string_view key) const {
        const auto at = entries.find(lower_case(key));
        return at == entries.end() ? nullptr : &at->second;
    }
};

struct Unit {
    std::string_view name;
    double factor;
};
constexpr Unit lengths[] = {{"millimeter", 1e-3}, {"mm", 1e-3},         {"centimeter", 1e-2}, {"cm", 1e-2},
                            {"meter", 1.0},       {"m", 1.0},           {"kilometer", 1e3},   {"km", 1e3},
                            {"inch", 0.0254},     {"inche", 0.0254},    {"in", 0.0254},       {"foot", 0.3048},
                            {"feet", 0.3048},     {"ft", 0.3048},       {"yard", 0.9144},     {"mile", 1609.344},
                            {"micron", 1e-6},     {"micrometer", 1e-6}, {"um", 1e-6},         {"mil", 25.4e-6}};
constexpr Unit forces[] = {{"newton", 1.0},
                           {"n", 1.0},
                           {"kilonewton", 1e3},
                           {"kn", 1e3},
                           {"poundforce", 4.4482216152605},
                           {"pound", 4.4482216152605},
                           {"lbf", 4.4482216152605},
                           {"lb", 4.4482216152605},
                           {"kip", 4448.2216152605}};
constexpr Unit pressures[] = {{"pascal", 1.0},
                              {"pa", 1.0},
                              {"kilopascal", 1e3},
                              {"kpa", 1e3},
                              {"megapascal", 1e6},
                              {"mpa", 1e6},
                              {"psi", 6894.757293168},
                              {"poundspersquareinch", 6894.757293168},
                              {"poundpersquareinch", 6894.757293168}};

std::optional<double> factor_of(std::span<const Unit> units, std::string_view word) {
    const std::string name = plain(word);
    const auto at = std::find_if(units.begin(), units.end(), [&](const Unit& unit) { return unit.name == name; });
    return at == units.end() ? std::nullopt : std::optional(at->factor);
}

std::string names_of(std::span<const Unit> units) {
    std::vector<std::string> names;
    for (const Unit& unit : units) {
        names.emplace_back(unit.name);
    }
    return pave::join(names);
}

class Reader {
public:
    Reader(std::string_view text, std::string file) : file_(std::move(file)) {
        for (int number = 1; !text.empty(); ++number) {
            const std::string_view whole = text.substr(0, text.find('\n'));
            std::string_view line = whole;
            if (number == 1 && line.starts_with("\xef\xbb\xbf")) {
                line.remove_prefix(3);
            }
            take(trimmed(line.ends_with('\r') ? line.substr(0, line.size() - 1) : line), number);
            text.remove_prefix(std::min(whole.size() + 1, text.size()));
        }
    }

    std::vector<FwdStation> stations() {
        const Section& device = section("device configuration");
        const Section& units = section("units");
        const Section& head = sections_.front();
        delimiter_ = symbol(head, "DelimiterSymbol", ',');
        decimal_ = symbol(head, "DecimalSymbol", '.');
        radius_m_ = length(units, "LoadPlateRadiusUnits") * number(device, "LoadPlateRadius");
        to_um_ = length(units, "DeflectionUnits") * 1e6;
        set_load(units);
        set_sensors(units, device);
        const Entry& place_units = entry(units, "TestLocationUnits");
        to_m_ = unit(place_units, "TestLocationUnits", split(place_units.value)[0], lengths);
        set_temperatures(units, device);
        std::vector<FwdStation> stations;
        for (const Section& at : sections_) {
            if (at.name.starts_with("test location")) {
                if (auto found = station(at); !found.drops.empty()) {
                    stations.push_back(std::move(found));
                }
            }
        }
        if (stations.empty()) {
            throw pave::Error({.file = file_}, "the file holds no drops", {},
                              "sections [Test Location i] with DropData1 = load, deflections");
        }
        return stations;
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
        sections_.back().entries[lower_case(trimmed(line.substr(0, equals)))] = {
            std::string(trimmed(line.substr(equals + 1))), number};
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
        const std::string word = plain(found->value);
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
        std::vector<std::string> parts;
        for (;;) {
            const std::size_t at = text.find(delimiter_);
            parts.emplace_back(trimmed(text.substr(0, at)));
            if (at == std::string_view::npos) {
                return parts;
            }
            text.remove_prefix(at + 1);
        }
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
    // number_of: finite_number, or any_number for what was measured, which stops nothing.
    std::vector<double> numbers(const Entry& from, std::string_view key,
                                double (*number_of)(std::string_view, const pave::Place&) = finite_number) const {
        std::vector<double> list;
        for (const std::string& part : split(from.value)) {
            if (!part.empty()) {
                list.push_back(number_of(with_point(part), place(from, key)));
            }
        }
        return list;
    }
    double unit(const Entry& from, std::string_view key, std::string_view word, std::span<const Unit> known) const {
        const auto factor = factor_of(known, word);
        if (!factor) {
            throw pave::Error(place(from, key), "unknown unit", "\"" + std::string(word) + "\"", names_of(known));
        }
        return *factor;
    }
    double length(const Section& units, std::string_view key) const {
        const Entry& found = entry(units, key);
        return unit(found, key, found.value, lengths);
    }

    void set_load(const Section& units) {
        const Entry& found = entry(units, "LoadUnits");
        if (const auto pressure = factor_of(pressures, found.value)) {
            to_kPa_ = *pressure / 1e3;
        } else if (const auto force = factor_of(forces, found.value)) {
            to_kPa_ = *force / (std::numbers::pi * radius_m_ * radius_m_) / 1e3;
        } else {
            throw pave::Error(place(found, "LoadUnits"), "unknown unit", "\"" + found.value + "\"",
                              names_of(forces) + ", " + names_of(pressures));
        }
    }
    void set_sensors(const Section& units, const Section& device) {
        const double to_mm = length(units, "SensorLocationUnits") * 1e3;
        const Entry& x = entry(device, "DeflectionSensorXAxisDistances");
        const auto along = numbers(x, "DeflectionSensorXAxisDistances");
        const double stated = number(device, "NumberOfDeflectionSensors");
        if (stated != static_cast<double>(along.size())) {
            throw pave::Error(place(x, "DeflectionSensorXAxisDistances"), "not one distance a sensor",
                              fmt::format("{} distances, {:g} sensors", along.size(), stated));
        }
        const Entry* y = device.find("DeflectionSensorYAxisDistances");
        const auto across = y != nullptr ? numbers(*y, "DeflectionSensorYAxisDistances") : std::vector<double>{};
        for (std::size_t i = 0; i < along.size(); ++i) {
            offsets_mm_.push_back(to_mm * std::hypot(along[i], i < across.size() ? across[i] : 0.0));
        }
    }
    void set_temperatures(const Section& units, const Section& device) {
        const Entry* scale = units.find("TemperatureUnits");
        is_fahrenheit_ = scale != nullptr && plain(scale->value).starts_with("f");
        if (const Entry* use = device.find("TemperatureSensorUse")) {
            for (const std::string& part : split(use->value)) {
                temperature_of_.push_back(plain(part));
            }
        }
    }

    FwdStation station(const Section& at) const {
        const Entry& where = entry(at, "TestLocation");
        const std::vector<std::string> parts = split(where.value);
        FwdStation s{.name = parts[0],
                     .lane = at.find("TestLane") != nullptr ? at.find("TestLane")->value : "",
                     .chainage_m = to_m_ * value(where, "TestLocation", parts[0]),
                     .file = file_,
                     .line = at.line};
        if (const Entry* found = at.find("TestTemperatures")) {
            const std::vector<std::string> read = split(found->value);
            for (std::size_t i = 0; i < std::min(read.size(), temperature_of_.size()); ++i) {
                auto* to = temperature_of_[i] == "air"       ? &s.air_C
                           : temperature_of_[i] == "surface" ? &s.surface_C
                                                             : nullptr;
                // Nothing is computed with them: one that cannot be read is not there.
                const auto degrees = number_or_nothing(with_point(read[i]));
                if (to != nullptr && degrees) {
                    *to = is_fahrenheit_ ? (*degrees - 32.0) / 1.8 : *degrees;
                }
            }
        }
        std::map<int, const Entry*> drops; // by number
        constexpr std::string_view key = "dropdata";
        for (const auto& [name, entry] : at.entries) {
            if (!name.starts_with(key)) {
                continue;
            }
            std::string_view rest = std::string_view(name).substr(key.size());
            rest.remove_prefix(rest.starts_with('_') ? 1 : 0);
            int number = 0;
            const auto [end, error] = std::from_chars(rest.data(), rest.data() + rest.size(), number);
            if (error == std::errc() && end == rest.data() + rest.size()) {
                drops[number] = &entry;
            }
        }
        for (const auto& [number, entry] : drops) {
            const auto read = numbers(*entry, "DropData", any_number);
            if (read.size() != offsets_mm_.size() + 1) {
                throw pave::Error(
                    place(*entry, fmt::format("DropData{}", number)), "wrong number of values",
                    std::to_string(read.size()),
                    fmt::format("{}: the load and {} deflections", offsets_mm_.size() + 1, offsets_mm_.size()));
            }
            FwdDrop drop{
                .number = number, .radius_mm = 1e3 * radius_m_, .pressure_kPa = to_kPa_ * read[0], .readings = {}};
            for (std::size_t i = 0; i < offsets_mm_.size(); ++i) {
                drop.readings.push_back({offsets_mm_[i], to_um_ * read[i + 1]});
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
    double to_kPa_ = 1.0; // of a load
    double to_m_ = 1.0;   // of a station
    bool is_fahrenheit_ = false;
    std::vector<double> offsets_mm_;
    std::vector<std::string> temperature_of_; // what each sensor of temperature reads
};

} // namespace

bool recognises_fwd_pddx(std::string_view text) {
    if (text.starts_with("\xef\xbb\xbf")) {
        text.remove_prefix(3);
    }
    const std::size_t at = text.find_first_not_of(" \t\r\n");
    return at != std::string_view::npos &&
           lower_case(text.substr(at, 60)).starts_with("[pavement deflection data exchange file]");
}

std::vector<FwdStation> read_fwd_pddx(std::string_view text, const std::string& file) {
    return Reader(text, file).stations();
}

} // namespace explore::data
