#include "data/fwd_columns.h"

#include "data/fwd_offsets.h"

#include "base/error.h"
#include "data/csv.h"
#include "data/fwd_table.h"
#include "data/fwd_values.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fmt/format.h>
#include <set>
#include <utility>

namespace explore::data {
namespace {

struct Word {
    std::string_view word; // compared by plain_word()
    Meaning meaning;
};
constexpr Word words[] = {{"station", Meaning::station},
                          {"point", Meaning::station},
                          {"testpoint", Meaning::station},
                          {"testlocation", Meaning::station},
                          {"name", Meaning::station},
                          {"id", Meaning::station},
                          {"lane", Meaning::lane},
                          {"road", Meaning::profile},
                          {"roadname", Meaning::profile},
                          {"route", Meaning::profile},
                          {"section", Meaning::profile},
                          {"sectionid", Meaning::profile},
                          {"run", Meaning::profile},
                          {"direction", Meaning::profile},
                          {"carriageway", Meaning::profile},
                          {"chainage", Meaning::chainage},
                          {"distance", Meaning::chainage},
                          {"dist", Meaning::chainage},
                          {"milepost", Meaning::chainage},
                          {"drop", Meaning::drop},
                          {"dropno", Meaning::drop},
                          {"dropnumber", Meaning::drop},
                          {"impact", Meaning::drop},
                          {"imp", Meaning::drop},
                          {"radius", Meaning::radius},
                          {"plateradius", Meaning::radius},
                          {"loadplateradius", Meaning::radius},
                          {"diameter", Meaning::diameter},
                          {"platediameter", Meaning::diameter},
                          {"pressure", Meaning::pressure},
                          {"stress", Meaning::pressure},
                          {"contactpressure", Meaning::pressure},
                          {"contactstress", Meaning::pressure},
                          {"platepressure", Meaning::pressure},
                          {"peakpressure", Meaning::pressure},
                          {"load", Meaning::load},
                          {"force", Meaning::load},
                          {"peakload", Meaning::load},
                          {"peakforce", Meaning::load},
                          {"air", Meaning::air},
                          {"airtemp", Meaning::air},
                          {"airtemperature", Meaning::air},
                          {"tair", Meaning::air},
                          {"surface", Meaning::surface},
                          {"surfacetemp", Meaning::surface},
                          {"surfacetemperature", Meaning::surface},
                          {"tsurf", Meaning::surface},
                          {"pavementtemp", Meaning::surface},
                          {"pavementtemperature", Meaning::surface},
                          {"asphalt", Meaning::asphalt},
                          {"asphalttemp", Meaning::asphalt},
                          {"asphalttemperature", Meaning::asphalt},
                          {"tasphalt", Meaning::asphalt},
                          {"latitude", Meaning::latitude},
                          {"lat", Meaning::latitude},
                          {"gpslat", Meaning::latitude},
                          {"gpslatitude", Meaning::latitude},
                          {"longitude", Meaning::longitude},
                          {"long", Meaning::longitude},
                          {"lon", Meaning::longitude},
                          {"lng", Meaning::longitude},
                          {"gpslon", Meaning::longitude},
                          {"gpslong", Meaning::longitude},
                          {"gpslongitude", Meaning::longitude},
                          {"date", Meaning::date},
                          {"testdate", Meaning::date},
                          {"time", Meaning::time},
                          {"testtime", Meaning::time},
                          {"remark", Meaning::comment},
                          {"comment", Meaning::comment},
                          {"note", Meaning::comment}};

// A column of this word and unit ("": none).
std::optional<FwdColumn> column_of(std::string_view base, std::string_view unit) {
    std::string word = plain_word(base);
    FwdColumn column{.meaning = Meaning::station, .name = {}};
    if (const auto offset = sensor_offset_mm(base)) {
        column.meaning = Meaning::deflection;
        column.offset_mm = *offset;
        column.to_si = deflection_unit(unit);
        return unit.empty() || column.to_si ? std::optional(column) : std::nullopt;
    }
    if (word == "km" && unit.empty()) {
        return FwdColumn{.meaning = Meaning::chainage, .name = {}, .to_si = 1e3, .rank = std::size(words)};
    }
    const auto known =
        std::find_if(std::begin(words), std::end(words), [&](const Word& w) { return plain_word(w.word) == word; });
    if (known == std::end(words)) {
        return std::nullopt;
    }
    column.meaning = known->meaning;
    column.rank = static_cast<std::size_t>(known - std::begin(words));
    const auto with = [&](std::span<const NamedUnit> units) {
        column.to_si = factor_of(units, unit);
        return unit.empty() || column.to_si ? std::optional(column) : std::nullopt;
    };
    switch (column.meaning) {
    case Meaning::station:
        if (!unit.empty() && word == "station") { // American: the place itself
            column.meaning = Meaning::chainage;
            return with(length_units());
        }
        break;
    case Meaning::chainage:
    case Meaning::radius:
    case Meaning::diameter: return with(length_units());
    case Meaning::pressure: return with(pressure_units());
    case Meaning::load:
        if (!unit.empty() && factor_of(pressure_units(), unit)) {
            column.meaning = Meaning::pressure;
            return with(pressure_units());
        }
        return with(force_units());
    case Meaning::air:
    case Meaning::surface:
    case Meaning::asphalt: {
        std::string scale = plain_word(unit);
        for (const std::string_view sign : {"°", "º", "deg"}) {
            scale = scale.starts_with(sign) ? scale.substr(sign.size()) : scale;
        }
        column.is_fahrenheit = scale.starts_with('f');
        return scale.empty() || scale.starts_with('c') || column.is_fahrenheit || scale == "℃" || scale == "℉"
                   ? std::optional(column)
                   : std::nullopt;
    }
    default: break;
    }
    return unit.empty() ? std::optional(column) : std::nullopt;
}

// Sensors that are numbered, not placed: 0, 1, 2, ... or 1, 2, 3, ...
bool are_numbered(const std::vector<FwdColumn*>& deflections) {
    if (deflections.size() < 3) {
        return false;
    }
    const double first = deflections[0]->offset_mm;
    for (std::size_t i = 0; i < deflections.size(); ++i) {
        if (deflections[i]->offset_mm != first + static_cast<double>(i)) {
            return false;
        }
    }
    return first == 0.0 || first == 1.0;
}

// The cell of a row; "": the row ends before.
std::string_view cell_of(const std::vector<std::string>& row, std::size_t at) {
    return at < row.size() ? trimmed(row[at]) : std::string_view{};
}

constexpr std::string_view columns_hint =
    "--columns \"D0_um = D1, D200_um = D2\", or a second row of the header with the offsets in mm";

// Rows in even steps of at most ten milliseconds are one drop over time, not the peaks of a road's drops.
bool is_over_time(const FwdHeader& header, const std::vector<std::vector<std::string>>& rows) {
    const FwdColumn* time = header.find(Meaning::time);
    constexpr std::size_t least_rows = 6;
    if (time == nullptr || time->constant || header.find(Meaning::chainage) != nullptr || rows.size() < least_rows) {
        return false;
    }
    std::vector<double> times;
    for (std::size_t i = 1; i < least_rows; ++i) {
        const auto value = measured(cell_of(rows[i], time->at));
        if (!value) {
            return false;
        }
        times.push_back(*value);
    }
    constexpr double longest = 10.0; // ms
    const double step = times[1] - times[0];
    for (std::size_t i = 1; i < times.size(); ++i) {
        if (!(step > 0.0 && step <= longest && std::abs(times[i] - times[i - 1] - step) < 1e-3 * step)) {
            return false;
        }
    }
    return true;
}

} // namespace

std::optional<double> deflection_unit(std::string_view word) {
    return word.empty() ? std::nullopt : factor_of(length_units(), word);
}

std::optional<FwdColumn> column_named(std::string_view name) {
    name = trimmed(name);
    std::optional<FwdColumn> column;
    const std::size_t open = name.find_last_of("([");
    if (open != std::string_view::npos && open > 0 && (name.back() == ')' || name.back() == ']')) {
        column = column_of(trimmed(name.substr(0, open)), trimmed(name.substr(open + 1, name.size() - open - 2)));
    }
    for (const char separator : {'_', ' ', '.', '/'}) {
        if (const std::size_t at = name.rfind(separator); !column && at != std::string_view::npos && at > 0) {
            const std::string_view unit = trimmed(name.substr(at + 1));
            column = unit.empty() ? std::nullopt : column_of(trimmed(name.substr(0, at)), unit);
        }
    }
    if (!column) {
        column = column_of(name, {});
    }
    if (column) {
        column->name = std::string(name);
    }
    return column;
}

const FwdColumn* FwdHeader::find(Meaning meaning) const {
    const auto at =
        std::find_if(columns.begin(), columns.end(), [&](const FwdColumn& c) { return c.meaning == meaning; });
    return at == columns.end() ? nullptr : &*at;
}

std::vector<const FwdColumn*> FwdHeader::deflections() const {
    std::vector<const FwdColumn*> found;
    for (const FwdColumn& column : columns) {
        if (column.meaning == Meaning::deflection) {
            found.push_back(&column);
        }
    }
    return found;
}

std::string known_columns() {
    return "chainage_m, radius_mm, pressure_kPa or load_kN, deflections such as D0_um or D200_mm; and station, lane, "
           "road, section, <layer>_mm, drop, air_C, surface_C, asphalt_C, latitude, longitude, date, time, remark";
}

FwdHeader read_header(const std::vector<std::vector<std::string>>& rows, const std::vector<int>& lines,
                      const std::string& file, const ColumnMap& map) {
    const pave::Place place{.file = file, .line = lines[0]};
    std::vector<std::string> names(rows[0].size());
    std::transform(rows[0].begin(), rows[0].end(), names.begin(),
                   [](const std::string& c) { return std::string(trimmed(c)); });
    FwdHeader header;
    // Names by the cell where they stand; a map may give one column two: where a station is, and what it is called.
    std::vector<std::pair<std::size_t, std::string>> named;
    std::set<std::size_t> mapped;
    bool are_numbers = false; // the deflections of the table are numbered, not placed
    for (const auto& [ours, theirs] : map) {
        auto column = column_named(ours);
        if (!column && !(layer_column(ours) && !measured(theirs))) {
            throw pave::Error({.key = "--columns"}, "unknown column", "\"" + ours + "\"", known_columns());
        }
        const auto at = std::find_if(names.begin(), names.end(), [&, theirs = theirs](const std::string& n) {
            return lower_case(n) == lower_case(with_plain_letters(theirs));
        });
        const bool is_deflection = column && column->meaning == Meaning::deflection;
        if (at != names.end()) {
            const auto cell = static_cast<std::size_t>(at - names.begin());
            const bool is_taken = is_deflection && std::any_of(named.begin(), named.end(), [&](const auto& other) {
                                      const auto known = column_named(other.second);
                                      return other.first == cell && known && known->meaning == Meaning::deflection;
                                  });
            if (is_taken) {
                throw pave::Error({.key = "--columns"}, "two sensors are read from one column", "\"" + theirs + "\"",
                                  "a column of its own for each sensor");
            }
            named.emplace_back(cell, ours);
            mapped.insert(cell);
            const auto own = column_named(theirs);
            are_numbers = are_numbers || (is_deflection && own && own->meaning == Meaning::deflection &&
                                          own->offset_mm != column->offset_mm);
        } else if (const auto constant = column && !is_deflection ? measured(theirs) : std::nullopt) {
            column->constant = *constant;
            header.columns.push_back(*column);
        } else {
            throw pave::Error(place, "there is no such column", "\"" + theirs + "\"", pave::join(names));
        }
    }
    for (std::size_t i = 0; i < names.size(); ++i) {
        if (!mapped.contains(i) && !names[i].empty()) { // empty: of a comma at the end of the line
            named.emplace_back(i, names[i]);
        }
    }
    std::stable_sort(named.begin(), named.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    const bool places_deflections = std::any_of(map.begin(), map.end(), [](const auto& entry) {
        const auto column = column_named(entry.first);
        return column && column->meaning == Meaning::deflection;
    });
    for (const auto& [cell, name] : named) {
        auto column = column_named(name);
        // Where the map says which columns are deflections, one that it does not name, and that has no unit or a number
        // in place of an offset, was not chosen.
        const bool is_not_chosen = column && column->meaning == Meaning::deflection && places_deflections &&
                                   !mapped.contains(cell) && (are_numbers || !column->to_si);
        if (const auto layer = column ? std::nullopt : layer_column(name)) {
            header.layers.push_back({cell, name, *layer});
            continue;
        }
        if (!column || is_not_chosen) {
            header.unknown.push_back(name);
            continue;
        }
        column->at = cell;
        const auto same = std::find_if(header.columns.begin(), header.columns.end(), [&](const FwdColumn& c) {
            return c.meaning == column->meaning && c.offset_mm == column->offset_mm && c.meaning != Meaning::profile;
        });
        if (same != header.columns.end()) {
            // "ID" beside "station" is another column, "load_lbf" beside "load_kN" the same one.
            const bool is_load = column->meaning == Meaning::load || column->meaning == Meaning::pressure ||
                                 column->meaning == Meaning::radius || column->meaning == Meaning::diameter ||
                                 column->meaning == Meaning::deflection;
            if (is_load || column->rank == same->rank) {
                throw pave::Error(place, "this column appears twice", "\"" + name + "\"", "each once");
            }
            if (column->rank < same->rank && !same->constant) {
                std::swap(*same, *column);
            }
            header.unknown.push_back(column->name);
            continue;
        }
        header.columns.push_back(*column);
    }

    std::vector<FwdColumn*> deflections;
    const FwdColumn* load = nullptr;
    const auto find_columns = [&] {
        deflections.clear();
        for (FwdColumn& column : header.columns) {
            if (column.meaning == Meaning::deflection) {
                deflections.push_back(&column);
            }
        }
        load = header.find(Meaning::load) != nullptr ? header.find(Meaning::load) : header.find(Meaning::pressure);
    };
    find_columns();
    // A column that a table lacks may stand there under a name that is not known.
    std::vector<std::string> not_known = header.unknown;
    for (const FwdHeader::Layer& layer : header.layers) {
        not_known.push_back(layer.name);
    }
    const std::string unknown = not_known.empty() ? "" : "columns not known: " + pave::join(not_known);
    if (deflections.empty()) {
        for (const std::string& name : not_known) {
            if (is_deflection_in_another_unit(name)) {
                throw pave::Error(place, "the unit of this column is not known", "\"" + name + "\"",
                                  "one of " + names_of(length_units()) + ", as in D0_um or \"D300 (mils)\"");
            }
        }
        throw pave::Error(place, "there is no column of deflections", unknown, known_columns());
    }
    if (is_over_time(header, rows)) {
        throw pave::Error(place, "this is one drop over time, not the peaks of a road's drops",
                          "rows that follow each other in milliseconds",
                          "one row a drop; an F25 file with time histories (new --from FILE --station S --pulses); or "
                          "a study of your own with a history and readings that have a time_ms");
    }
    bool numbered = are_numbered(deflections);
    // Further rows of the header: no load in them, and all deflections numbers (offsets) or units.
    while (header.rows < rows.size() && load != nullptr && !load->constant) {
        const auto& row = rows[header.rows];
        if (measured(cell_of(row, load->at))) {
            break;
        }
        const auto all = [&](const auto& is) {
            return std::all_of(deflections.begin(), deflections.end(),
                               [&](const FwdColumn* c) { return is(cell_of(row, c->at)); });
        };
        constexpr std::size_t least_places = 3;
        const double unit_mm = offset_unit_mm(row);
        const auto placed =
            static_cast<std::size_t>(std::count_if(deflections.begin(), deflections.end(), [&](const FwdColumn* c) {
                return place_mm(cell_of(row, c->at), unit_mm).has_value();
            }));
        if (numbered && placed >= least_places &&
            all([&](std::string_view cell) { return is_nil(cell) || place_mm(cell, unit_mm).has_value(); })) {
            std::set<std::size_t> without; // a sensor that is not to be read has no place
            for (FwdColumn* column : deflections) {
                const auto mm = place_mm(cell_of(row, column->at), unit_mm);
                column->offset_mm = mm.value_or(0.0);
                if (!mm) {
                    without.insert(column->at);
                    header.unknown.push_back(column->name);
                }
            }
            std::erase_if(header.columns, [&](const FwdColumn& c) {
                return c.meaning == Meaning::deflection && without.contains(c.at);
            });
            find_columns();
            numbered = false;
        } else if (all([](std::string_view cell) { return deflection_unit(cell).has_value(); })) {
            for (FwdColumn& column : header.columns) {
                const std::string_view unit = cell_of(row, column.at);
                if (const auto with_unit = column_of(column.name, unit);
                    with_unit && !column.to_si && !column.constant) {
                    column.to_si = with_unit->to_si;
                    column.is_fahrenheit = with_unit->is_fahrenheit;
                    column.meaning = with_unit->meaning;
                }
            }
        } else {
            break;
        }
        ++header.rows;
    }
    if (numbered) {
        throw pave::Error(place, "the sensors are numbered, and nothing says where they stand",
                          fmt::format("\"{}\" to \"{}\"", deflections.front()->name, deflections.back()->name),
                          columns_hint);
    }
    std::set<double> offsets;
    for (const FwdColumn* column : deflections) {
        if (!offsets.insert(column->offset_mm).second) {
            throw pave::Error(place, "two sensors stand at one place", fmt::format("{:g} mm", column->offset_mm),
                              "each once");
        }
    }
    for (const FwdColumn& column : header.columns) {
        const bool needs_unit = column.meaning == Meaning::deflection || column.meaning == Meaning::radius ||
                                column.meaning == Meaning::diameter || column.meaning == Meaning::pressure ||
                                column.meaning == Meaning::load;
        if (needs_unit && !column.to_si) {
            throw pave::Error(place, "this column states no unit", "\"" + column.name + "\"",
                              "a unit in its name, as in load_kN, pressure_kPa, radius_mm, D0_um, \"D300 (mils)\"");
        }
    }
    const bool station_is_place = header.find(Meaning::chainage) == nullptr && header.find(Meaning::station) != nullptr;
    if (header.find(Meaning::chainage) == nullptr && !station_is_place) {
        throw pave::Error({.file = file, .line = lines[0], .key = "chainage_m"}, "column missing", unknown,
                          known_columns());
    }
    if (header.find(Meaning::radius) == nullptr && header.find(Meaning::diameter) == nullptr) {
        throw pave::Error({.file = file, .line = lines[0], .key = "radius_mm"}, "column missing", unknown,
                          known_columns() + "; of a plate that is the same everywhere: --columns \"radius_mm = 150\"");
    }
    if (header.find(Meaning::pressure) == nullptr && header.find(Meaning::load) == nullptr) {
        throw pave::Error(place, "the load of a drop is not stated",
                          "neither pressure_kPa nor load_kN" + (unknown.empty() ? "" : "; " + unknown),
                          "one of the columns pressure_kPa and load_kN");
    }
    std::stable_sort(header.columns.begin(), header.columns.end(),
                     [](const FwdColumn& a, const FwdColumn& b) { return a.offset_mm < b.offset_mm; });
    return header;
}

} // namespace explore::data
