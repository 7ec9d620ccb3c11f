#include "data/reading.h"

#include "data/csv.h"

#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <stdexcept>

namespace explore::data {
namespace {

enum Column : std::size_t { load, quantity, x_mm, y_mm, depth_mm, gauge_mm, value, unit, sigma, time_ms, columns };
constexpr std::array<std::string_view, columns> names = {"load",     "quantity", "x_mm", "y_mm",  "depth_mm",
                                                         "gauge_mm", "value",    "unit", "sigma", "time_ms"};

} // namespace

std::span<const Unit> units() {
    static constexpr Unit all[] = {
        {"mm", Dimension::length, 1e-3},    {"um", Dimension::length, 1e-6},   {"microstrain", Dimension::strain, 1e-6},
        {"strain", Dimension::strain, 1.0}, {"kPa", Dimension::pressure, 1e3}, {"MPa", Dimension::pressure, 1e6},
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

std::string Reading::label() const {
    return is_measured() ? fmt::format("{}@{:g},{:g},{:g}", group(), x_mm, y_mm, depth_mm) +
                               (time_ms ? fmt::format(",{:g}ms", *time_ms) : "")
                         : output;
}

std::string Reading::label_with_unit() const {
    return fmt::format("{} [{}]", label(), unit.name);
}

std::string Reading::place_words() const {
    std::string at;
    if (y_mm != 0.0) {
        at = fmt::format(" at x = {:g}, y = {:g} mm", x_mm, y_mm);
    } else if (x_mm != 0.0 || quantity == "deflection") {
        at = fmt::format(" at {:g} mm", x_mm);
    }
    return (quantity == "deflection" && depth_mm == 0.0 ? quantity
                                                        : fmt::format("{} {:g} mm deep", quantity, depth_mm)) +
           at;
}

std::string Reading::words() const {
    return place_words() + " under " + load + (time_ms ? fmt::format(" at {:g} ms", *time_ms) : "");
}

std::string_view measurement_header() {
    return "load,quantity,x_mm,y_mm,depth_mm,gauge_mm,value,unit,sigma";
}

std::string measurement_row(const Reading& r) {
    return fmt::format("{},{},{},{},{},{},{},{},{}\n", csv_cell(r.load), r.quantity, r.x_mm, r.y_mm, r.depth_mm,
                       r.gauge_mm, r.value, r.unit.name, r.sigma ? fmt::format("{}", *r.sigma) : "");
}

bool has_times(std::span<const Reading> readings) {
    return std::any_of(readings.begin(), readings.end(), [](const Reading& r) { return r.time_ms.has_value(); });
}

std::string measurement_rows(std::span<const Reading> readings) {
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

std::vector<Reading> measurements_of(std::string_view text, const std::string& file) {
    const CsvTable table = parse_table(text, file);
    const auto& rows = table.rows;
    const std::string header_words = "the header " + std::string(measurement_header());
    if (rows.empty()) {
        throw pave::Error({.file = file}, "the file holds no measurements", "nothing but comments or blank lines",
                          header_words + " and at least one row");
    }
    std::array<std::size_t, columns> place_of;
    place_of.fill(rows[0].cells.size());
    for (std::size_t i = 0; i < rows[0].cells.size(); ++i) {
        const auto cell = trimmed(rows[0].cells[i]);
        const auto known = std::find(names.begin(), names.end(), cell);
        if (known == names.end()) {
            const std::string near = pave::nearest_name(cell, {names.begin(), names.end()});
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
        if (c != time_ms && place_of[c] == rows[0].cells.size()) {
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
        const auto cell = [&](Column c) { return trimmed(row.cells[place_of[c]]); };
        const auto place = [&](Column c) {
            return pave::Place{.file = file, .line = row.line, .key = std::string(names[c])};
        };
        const auto cell_number = [&](Column c) { return table.number(cell(c), place(c)); };
        Reading m;
        m.file = file;
        m.line = row.line;
        m.load = cell(load);
        m.quantity = cell(quantity);
        m.x_mm = cell_number(x_mm);
        m.y_mm = cell_number(y_mm);
        m.depth_mm = cell_number(depth_mm);
        m.gauge_mm = cell_number(gauge_mm);
        if (m.gauge_mm < 0.0) {
            throw pave::Error(place(gauge_mm), "a gauge length cannot be negative", std::string(cell(gauge_mm)),
                              "0 or more");
        }
        m.value = cell_number(value);
        std::vector<std::string> unit_names;
        const Unit* found = nullptr;
        for (const Unit& u : units()) {
            unit_names.emplace_back(u.name);
            found = u.name == cell(unit) ? &u : found;
        }
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
        if (place_of[time_ms] < row.cells.size() && !cell(time_ms).empty()) {
            m.time_ms = cell_number(time_ms);
        }
        measurements.push_back(std::move(m));
    }
    if (measurements.empty()) {
        throw pave::Error({.file = file}, "the file holds no measurements", "a header and no rows", "at least one row");
    }
    return measurements;
}

} // namespace explore::data
