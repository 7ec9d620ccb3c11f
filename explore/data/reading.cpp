#include "data/reading.h"

#include "data/csv.h"

#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <mutex>
#include <set>
#include <stdexcept>

namespace explore::data {
namespace {

enum Column : std::size_t {
    load,
    quantity,
    x_mm,
    y_mm,
    depth_mm,
    gauge_mm,
    value,
    unit,
    sigma,
    time_ms,
    name,
    columns
};
constexpr std::array<std::string_view, columns> names = {
    "load", "quantity", "x_mm", "y_mm", "depth_mm", "gauge_mm", "value", "unit", "sigma", "time_ms", "name"};

} // namespace

std::span<const Unit> units() {
    static constexpr Unit all[] = {
        {"mm", Dimension::length, 1e-3},    {"um", Dimension::length, 1e-6},   {"microstrain", Dimension::strain, 1e-6},
        {"strain", Dimension::strain, 1.0}, {"um/m", Dimension::strain, 1e-6}, {"mm/m", Dimension::strain, 1e-3},
        {"kPa", Dimension::pressure, 1e3},  {"MPa", Dimension::pressure, 1e6},
    };
    return all;
}

const Unit& unit_named(std::string_view name) {
    const auto all = units();
    const auto found = std::find_if(all.begin(), all.end(), [&](const Unit& u) { return u.name == name; });
    if (found == all.end()) {
        throw std::out_of_range("no unit " + std::string(name));
    }
    return *found;
}

Unit any_unit(std::string_view name) {
    const auto all = units();
    const auto found = std::find_if(all.begin(), all.end(), [&](const Unit& u) { return u.name == name; });
    if (found != all.end()) {
        return *found;
    }
    static std::mutex mutex;
    static std::set<std::string, std::less<>> names; // a unit holds a view of its name
    const std::scoped_lock lock(mutex);
    return {*names.emplace(name).first, Dimension::other, 1.0};
}

std::string Reading::label() const {
    if (is_measured() && !name.empty()) {
        return name;
    }
    return is_measured() ? fmt::format("{}@{:g},{:g},{:g}", group(), x_mm, y_mm, depth_mm) +
                               (time_ms ? fmt::format(",{:g}ms", *time_ms) : "")
                         : output;
}

std::string Reading::label_with_unit() const {
    return fmt::format("{} [{}]", label(), unit.name);
}

std::string Reading::place_words() const {
    if (!name.empty()) {
        return name;
    }
    std::string at;
    if (y_mm != 0.0) {
        at = fmt::format(" at x = {:g}, y = {:g} mm", x_mm, y_mm);
    } else if (x_mm != 0.0 || quantity == "deflection") {
        at = fmt::format(" at {:g} mm", x_mm);
    }
    const bool on_surface = quantity == "deflection" || quantity == "slope" || quantity == "benkelman";
    return (on_surface && depth_mm == 0.0 ? quantity : fmt::format("{} {:g} mm deep", quantity, depth_mm)) + at;
}

std::string Reading::words() const {
    if (!name.empty()) {
        return name;
    }
    return place_words() + " under " + load + (time_ms ? fmt::format(" at {:g} ms", *time_ms) : "");
}

std::string_view measurement_header() {
    return "load,quantity,x_mm,y_mm,depth_mm,gauge_mm,value,unit,sigma";
}

std::string measurement_row(const Reading& r) {
    return fmt::format("{},{},{},{},{},{},{}{},{},{}\n", csv_cell(r.load), csv_cell(r.quantity), r.x_mm, r.y_mm,
                       r.depth_mm, r.gauge_mm, sign_of(r.censored), r.value, r.unit.name,
                       r.sigma ? fmt::format("{}", *r.sigma) : "");
}

bool has_times(std::span<const Reading> readings) {
    return std::any_of(readings.begin(), readings.end(), [](const Reading& r) { return r.time_ms.has_value(); });
}

std::string measurement_rows(std::span<const Reading> readings) {
    if (std::any_of(readings.begin(), readings.end(), [](const Reading& r) { return !r.name.empty(); })) {
        std::string text = fmt::format("name,time_ms,{}\n", measurement_header());
        for (const Reading& r : readings) {
            text += csv_cell(r.name) + (r.time_ms ? fmt::format(",{},", *r.time_ms) : ",,") + measurement_row(r);
        }
        return text;
    }
    if (!has_times(readings)) {
        std::string text = fmt::format("{}\n", measurement_header());
        for (const Reading& r : readings) {
            text += measurement_row(r);
        }
        return text;
    }
    std::string text = fmt::format("time_ms,{}\n", measurement_header());
    for (const Reading& r : readings) {
        text += (r.time_ms ? fmt::format("{},", *r.time_ms) : ",") + measurement_row(r);
    }
    return text;
}

namespace {

std::vector<Reading> readings_of(std::string_view text, const std::string& file, bool any_model) {
    const CsvTable table = parse_table(text, file);
    const auto& rows = table.rows;
    const std::string header_words = any_model ? "a header with value and any of name, load, quantity, x_mm, y_mm, "
                                                 "depth_mm, gauge_mm, time_ms, unit, sigma"
                                               : "the header " + std::string(measurement_header());
    if (rows.empty()) {
        throw pave::Error({.file = file}, "the file holds no measurements", "nothing but comments or blank lines",
                          header_words + " and at least one row");
    }
    std::array<std::size_t, columns> place_of;
    place_of.fill(rows[0].cells.size());
    for (std::size_t i = 0; i < rows[0].cells.size(); ++i) {
        const auto cell = trimmed(rows[0].cells[i]);
        const auto last = any_model ? names.end() : names.begin() + name;
        const auto known = std::find(names.begin(), last, cell);
        if (known == last) {
            const std::string near = pave::nearest_name(cell, {names.begin(), last});
            throw pave::Error({.file = file, .line = rows[0].line},
                              near.empty() ? "unknown column" : "unknown column, did you mean \"" + near + "\"?",
                              "\"" + std::string(cell) + "\"", header_words);
        }
        std::size_t& place = place_of[known - names.begin()];
        if (place != rows[0].cells.size()) {
            throw pave::Error({.file = file, .line = rows[0].line, .key = std::string(cell)},
                              "this column appears twice", {}, header_words);
        }
        place = i;
    }
    for (std::size_t c = 0; c < columns; ++c) {
        const bool is_optional = c == time_ms || c == name || (any_model && c != value);
        if (!is_optional && place_of[c] == rows[0].cells.size()) {
            throw pave::Error({.file = file, .line = rows[0].line, .key = std::string(names[c])}, "column missing", {},
                              header_words);
        }
    }
    std::vector<Reading> measurements;
    for (std::size_t r = 1; r < rows.size(); ++r) {
        const CsvRow& row = rows[r];
        if (row.cells.size() != rows[0].cells.size()) {
            throw pave::Error({.file = file, .line = row.line}, "wrong number of cells",
                              std::to_string(row.cells.size()), std::to_string(rows[0].cells.size()));
        }
        const auto cell = [&](Column c) {
            return place_of[c] < row.cells.size() ? trimmed(row.cells[place_of[c]]) : std::string_view();
        };
        const auto place = [&](Column c) {
            return pave::Place{.file = file, .line = row.line, .key = std::string(names[c])};
        };
        const auto cell_number = [&](Column c) {
            return any_model && c != value && cell(c).empty() ? 0.0 : table.number(cell(c), place(c));
        };
        Reading m;
        m.file = file;
        m.line = row.line;
        m.load = cell(load);
        m.quantity = cell(quantity);
        m.name = cell(name);
        if (any_model) {
            m.load = m.load.empty() ? "model" : m.load;
            m.quantity = m.quantity.empty() ? "reading" : m.quantity;
        }
        m.x_mm = cell_number(x_mm);
        m.y_mm = cell_number(y_mm);
        m.depth_mm = cell_number(depth_mm);
        m.gauge_mm = cell_number(gauge_mm);
        if (m.gauge_mm < 0.0) {
            throw pave::Error(place(gauge_mm), "a gauge length cannot be negative", std::string(cell(gauge_mm)),
                              "0 or more");
        }
        const std::string_view written = cell(value);
        for (const Censored side : {Censored::below, Censored::above}) {
            m.censored = written.starts_with(sign_of(side)) ? side : m.censored;
        }
        std::string_view digits = written.substr(m.censored == Censored::no ? 0 : 1);
        if (m.censored != Censored::no && digits.starts_with('=')) { // "<=4" says what "<4" does
            digits.remove_prefix(1);
        }
        m.value = table.number(trimmed(digits), place(value));
        std::vector<std::string> unit_names;
        const Unit* found = nullptr;
        for (const Unit& u : units()) {
            unit_names.emplace_back(u.name);
            found = u.name == cell(unit) ? &u : found;
        }
        const Unit other = any_unit(any_model && !cell(unit).empty() ? cell(unit) : "-");
        found = any_model && found == nullptr ? &other : found;
        if (found == nullptr) {
            throw pave::Error(place(unit), "unknown unit", "\"" + std::string(cell(unit)) + "\"",
                              pave::join(unit_names));
        }
        m.unit = *found;
        if (!cell(sigma).empty()) {
            m.sigma = cell_number(sigma);
            if (!(*m.sigma > 0.0)) {
                throw pave::Error(place(sigma), "a standard deviation must be positive", std::string(cell(sigma)),
                                  "more than 0, or empty");
            }
        }
        if (!cell(time_ms).empty()) {
            m.time_ms = cell_number(time_ms);
        }
        measurements.push_back(std::move(m));
    }
    if (measurements.empty()) {
        throw pave::Error({.file = file}, "the file holds no measurements", "a header and no rows", "at least one row");
    }
    return measurements;
}

} // namespace

std::vector<Reading> measurements_of(std::string_view text, const std::string& file) {
    return readings_of(text, file, false);
}

std::vector<Reading> named_measurements_of(std::string_view text, const std::string& file) {
    return readings_of(text, file, true);
}

} // namespace explore::data
