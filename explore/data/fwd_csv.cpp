#include "data/fwd_csv.h"

#include "data/csv.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <fmt/format.h>
#include <map>
#include <numbers>
#include <tuple>

namespace explore::data {
namespace {

enum Column : std::size_t { station, lane, chainage, drop, radius, pressure, load, air, surface, columns };
constexpr std::string_view names[] = {"station",      "lane",    "chainage_m", "drop",     "radius_mm",
                                      "pressure_kPa", "load_kN", "air_C",      "surface_C"};
static_assert(std::size(names) == columns);

struct Sensor {
    std::size_t at; // column
    double offset_mm;
    double to_um;
};

// "D200_um": a sensor at 200 mm; nothing when the word is no such column.
std::optional<Sensor> sensor_of(std::string_view name, std::size_t at) {
    const double to_um = name.ends_with("_um") ? 1.0 : name.ends_with("_mm") ? 1e3 : 0.0;
    if (to_um == 0.0 || name.size() < 5 || name[0] != 'D' || std::isdigit(static_cast<unsigned char>(name[1])) == 0) {
        return std::nullopt;
    }
    double offset = 0.0;
    const char* const last = name.data() + name.size() - 3;
    const auto [end, error] = std::from_chars(name.data() + 1, last, offset);
    return error == std::errc() && end == last ? std::optional<Sensor>({at, offset, to_um}) : std::nullopt;
}

struct Header {
    std::size_t at[columns]; // npos: not there
    std::vector<Sensor> sensors;
};
constexpr std::size_t npos = std::string::npos;

Header read_header(const CsvRow& row, const std::string& file) {
    const pave::Place place{.file = file, .line = row.line};
    const std::string allowed =
        fmt::format("{}, and deflections such as D0_um or D200_mm", pave::join({std::begin(names), std::end(names)}));
    Header header;
    std::fill(std::begin(header.at), std::end(header.at), npos);
    for (std::size_t i = 0; i < row.cells.size(); ++i) {
        const std::string name(trimmed(row.cells[i]));
        const auto known = std::find(std::begin(names), std::end(names), name);
        bool twice = false;
        if (known != std::end(names)) {
            std::size_t& at = header.at[known - std::begin(names)];
            twice = at != npos;
            at = i;
        } else if (const auto sensor = sensor_of(name, i)) {
            twice = std::any_of(header.sensors.begin(), header.sensors.end(),
                                [&](const Sensor& s) { return s.offset_mm == sensor->offset_mm; });
            header.sensors.push_back(*sensor);
        } else {
            throw pave::Error(place, "unknown column", "\"" + name + "\"", allowed);
        }
        if (twice) {
            throw pave::Error(place, "this column stands twice", "\"" + name + "\"", "each once");
        }
    }
    for (const Column c : {chainage, radius}) {
        if (header.at[c] == npos) {
            throw pave::Error({.file = file, .line = row.line, .key = std::string(names[c])}, "column missing", {},
                              allowed);
        }
    }
    if ((header.at[pressure] == npos) == (header.at[load] == npos)) {
        throw pave::Error(place, "the load of a drop must be stated once",
                          header.at[load] == npos ? "neither pressure_kPa nor load_kN" : "pressure_kPa and load_kN",
                          "one of the columns pressure_kPa and load_kN");
    }
    if (header.sensors.empty()) {
        throw pave::Error(place, "there is no column of deflections", {}, allowed);
    }
    std::sort(header.sensors.begin(), header.sensors.end(),
              [](const Sensor& a, const Sensor& b) { return a.offset_mm < b.offset_mm; });
    return header;
}

} // namespace

bool recognises_fwd_csv(std::string_view text) {
    while (!text.empty()) {
        const std::string_view line = text.substr(0, text.find('\n'));
        if (!trimmed(line.substr(0, line.find('\r'))).empty() && line[0] != '#' && !line.starts_with("\xef\xbb\xbf#")) {
            return line.find("chainage_m") != npos && line.find(',') != npos;
        }
        text.remove_prefix(std::min(line.size() + 1, text.size()));
    }
    return false;
}

std::vector<FwdStation> read_fwd_csv(std::string_view text, const std::string& file) {
    const auto rows = parse_csv(text, file);
    const Header header = read_header(rows[0], file);
    std::vector<FwdStation> stations;
    std::map<std::tuple<std::string, std::string, double>, std::size_t> known;
    for (std::size_t r = 1; r < rows.size(); ++r) {
        const CsvRow& row = rows[r];
        if (row.cells.size() != rows[0].cells.size()) {
            throw pave::Error({.file = file, .line = row.line}, "wrong number of cells",
                              std::to_string(row.cells.size()), std::to_string(rows[0].cells.size()));
        }
        const auto place = [&](std::string_view column) {
            return pave::Place{.file = file, .line = row.line, .key = std::string(column)};
        };
        // Empty when the column is not there.
        const auto cell = [&](Column c) {
            return header.at[c] == npos ? std::string_view{} : trimmed(row.cells[header.at[c]]);
        };
        const auto temperature = [&](Column c) {
            return cell(c).empty() ? std::nullopt : std::optional(finite_number(cell(c), place(names[c])));
        };
        const double chainage_m = finite_number(cell(chainage), place(names[chainage]));
        const std::string name = cell(station).empty() ? fmt::format("{}", chainage_m) : std::string(cell(station));
        const auto [at, is_new] = known.try_emplace({name, std::string(cell(lane)), chainage_m}, stations.size());
        if (is_new) {
            stations.push_back({.name = name,
                                .lane = std::string(cell(lane)),
                                .chainage_m = chainage_m,
                                .file = file,
                                .line = row.line});
        }
        FwdStation& s = stations[at->second];
        s.air_C = s.air_C ? s.air_C : temperature(air);
        s.surface_C = s.surface_C ? s.surface_C : temperature(surface);

        FwdDrop d;
        d.number = static_cast<int>(s.drops.size()) + 1;
        if (header.at[drop] != npos) {
            const auto text_of = cell(drop);
            const auto [end, error] = std::from_chars(text_of.data(), text_of.data() + text_of.size(), d.number);
            if (error != std::errc() || end != text_of.data() + text_of.size()) {
                throw pave::Error(place(names[drop]), "not a whole number", "\"" + std::string(text_of) + "\"",
                                  "1, 2, 3, ...");
            }
        }
        d.radius_mm = finite_number(cell(radius), place(names[radius]));
        if (header.at[pressure] != npos) {
            d.pressure_kPa = any_number(cell(pressure), place(names[pressure]));
        } else {
            // kN over mm2 is GPa.
            const double area_mm2 = std::numbers::pi * d.radius_mm * d.radius_mm;
            d.pressure_kPa = any_number(cell(load), place(names[load])) / area_mm2 * 1e6;
        }
        for (const Sensor& sensor : header.sensors) {
            const std::string_view value = trimmed(row.cells[sensor.at]);
            if (!value.empty()) {
                d.readings.push_back(
                    {sensor.offset_mm, sensor.to_um * any_number(value, place(trimmed(rows[0].cells[sensor.at])))});
            }
        }
        s.drops.push_back(std::move(d));
    }
    if (stations.empty()) {
        throw pave::Error({.file = file}, "the file holds no stations", "a header and no rows", "at least one row");
    }
    return stations;
}

} // namespace explore::data
