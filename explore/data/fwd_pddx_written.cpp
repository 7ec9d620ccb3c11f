#include "data/fwd_pddx_written.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <set>

namespace explore::data {
namespace {

using Stations = std::vector<const FwdStation*>;

bool alike(const FwdStation& a, const FwdStation& b) {
    const double radius_a = a.drops[0].radius_mm;
    const double radius_b = b.drops[0].radius_mm;
    const bool one_plate = radius_a == radius_b || (std::isnan(radius_a) && std::isnan(radius_b));
    return one_plate && a.date == b.date && a.profile == b.profile;
}

// In one line, without what would close or part a value.
std::string in_one_line(std::string text) {
    std::replace_if(
        text.begin(), text.end(), [](char c) { return c == '\n' || c == '\r'; }, ' ');
    return text;
}

std::string number(const std::optional<double>& value) {
    return value && std::isfinite(*value) ? fmt::format("{}", *value) : "";
}

std::string drop_text(const FwdDrop& drop, int number_of_drop, bool by_force, const std::set<double>& offsets) {
    std::vector<std::string> values{by_force ? number(drop.force_kN) : number(drop.pressure_kPa)};
    for (const double offset : offsets) {
        const auto at = std::find_if(drop.readings.begin(), drop.readings.end(),
                                     [&](const FwdReading& r) { return r.offset_mm == offset; });
        values.push_back(at == drop.readings.end() ? "" : number(at->deflection_um));
    }
    return fmt::format("DropData_{} = {}\n", number_of_drop, fmt::join(values, ", "));
}

std::string station_text(const FwdStation& s, std::size_t number_of_station, bool by_force,
                         const std::set<double>& offsets) {
    std::string text = fmt::format("[Test Location {}]\nTestLocation = {}\n", number_of_station,
                                   s.chainage_m ? number(s.chainage_m) : in_one_line(s.name));
    const auto add = [&](std::string_view key, const std::string& value) {
        if (!value.empty()) {
            text += fmt::format("{} = {}\n", key, in_one_line(value));
        }
    };
    add("TestLane", s.lane);
    add("TestTime", s.time);
    if (s.latitude && s.longitude) {
        add("GPSLocation", fmt::format("{}, {}", *s.latitude, *s.longitude));
    }
    add("TestComment", s.comment);
    text += fmt::format("TestTemperatures = {}, {}, {}\nNumberOfDrops = {}\n", number(s.air_C), number(s.surface_C),
                        number(s.asphalt_C), s.drops.size());
    int last = 0; // drops whose numbers do not rise are numbered anew
    for (const FwdDrop& drop : s.drops) {
        last = std::max(last + 1, drop.number);
        text += drop_text(drop, last, by_force, offsets);
    }
    return text;
}

std::string file_text(const Stations& stations) {
    std::set<double> offsets;
    bool by_force = true;
    for (const FwdStation* s : stations) {
        for (const FwdDrop& drop : s->drops) {
            by_force = by_force && drop.force_kN;
            for (const FwdReading& reading : drop.readings) {
                offsets.insert(reading.offset_mm);
            }
        }
    }
    const FwdStation& first = *stations[0];
    const std::string radius = number(first.drops[0].radius_mm);
    std::string text =
        fmt::format("[Pavement Deflection Data Exchange File]\n"
                    "PDDXVersionNumber = 1.0\nDelimiterSymbol = ,\nDecimalSymbol = .\n"
                    "[Operations Information]\nStartDate = {}\n"
                    "[Units]\nLoadPlateRadiusUnits = millimeter\nLoadUnits = {}\n"
                    "DeflectionUnits = micrometer\nTemperatureUnits = Celsius\n"
                    "SensorLocationUnits = millimeter\nTestLocationUnits = meter\n"
                    "[Location Identification]\nSectionName = {}\n"
                    "[Device Configuration]\nLoadPlateRadius = {}\nNumberOfDeflectionSensors = {}\n"
                    "DeflectionSensorXAxisDistances = {}\n"
                    "TemperatureSensorUse = air, surface, asphalt\n",
                    in_one_line(first.date), by_force ? "kilonewton" : "kilopascal", in_one_line(first.profile),
                    radius.empty() ? "N/A" : radius, offsets.size(), fmt::join(offsets, ", "));
    for (std::size_t i = 0; i < stations.size(); ++i) {
        text += station_text(*stations[i], i + 1, by_force, offsets);
    }
    return text;
}

} // namespace

std::vector<std::string> pddx_of(std::span<const FwdFile> files) {
    std::vector<Stations> groups;
    for (const FwdFile& file : files) {
        for (const FwdStation& s : file.stations) {
            if (s.drops.empty()) {
                continue;
            }
            const auto group =
                std::find_if(groups.begin(), groups.end(), [&](const Stations& g) { return alike(*g[0], s); });
            if (group == groups.end()) {
                groups.push_back({&s});
            } else {
                group->push_back(&s);
            }
        }
    }
    std::vector<std::string> texts;
    for (const Stations& group : groups) {
        texts.push_back(file_text(group));
    }
    return texts;
}

} // namespace explore::data
