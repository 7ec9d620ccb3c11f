#include "data/history.h"

#include "data/csv.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace explore::data {
namespace {

constexpr std::string_view wanted_columns = "the columns time_ms and force_kN, or time_ms and pressure_kPa";

// Where a column stands; none: nowhere. Throws pave::Error where it appears twice.
std::optional<std::size_t> column(const CsvRow& header, std::string_view name, const std::string& file) {
    std::optional<std::size_t> place;
    for (std::size_t i = 0; i < header.cells.size(); ++i) {
        if (trimmed(header.cells[i]) == name) {
            if (place) {
                throw pave::Error({.file = file, .line = header.line, .key = std::string(name)},
                                  "this column appears twice", {}, std::string(wanted_columns));
            }
            place = i;
        }
    }
    return place;
}

} // namespace

History history_of(std::string_view text, const std::string& file) {
    const CsvTable table = parse_table(text, file);
    const auto& rows = table.rows;
    if (rows.empty()) {
        throw pave::Error({.file = file}, "the file holds no history", "nothing but comments or blank lines",
                          "a header with " + std::string(wanted_columns) + ", and at least two rows");
    }
    const CsvRow& header = rows[0];
    const auto time = column(header, "time_ms", file);
    const auto force = column(header, "force_kN", file);
    const auto pressure = column(header, "pressure_kPa", file);
    if (!time || (!force && !pressure)) {
        std::string found;
        for (const std::string& cell : header.cells) {
            found += (found.empty() ? "" : ", ") + std::string(trimmed(cell));
        }
        throw pave::Error({.file = file, .line = header.line, .key = !time ? "time_ms" : "force_kN"}, "column missing",
                          found, std::string(wanted_columns));
    }
    if (force && pressure) {
        throw pave::Error({.file = file, .line = header.line}, "the load appears twice", "force_kN and pressure_kPa",
                          std::string(wanted_columns));
    }
    History history{.is_force = force.has_value(), .time_ms = {}, .values = {}};
    const std::size_t value = force ? *force : *pressure;
    const std::string value_name = force ? "force_kN" : "pressure_kPa";
    for (std::size_t r = 1; r < rows.size(); ++r) {
        const CsvRow& row = rows[r];
        if (row.cells.size() != header.cells.size()) {
            throw pave::Error({.file = file, .line = row.line}, "wrong number of cells",
                              std::to_string(row.cells.size()), std::to_string(header.cells.size()));
        }
        const pave::Place place{.file = file, .line = row.line, .key = "time_ms"};
        const double at = table.number(trimmed(row.cells[*time]), place);
        if (!(std::abs(at) <= latest_ms)) {
            throw pave::Error(place, "value out of range", fmt::format("{:g}", at),
                              fmt::format("-{0:g} <= value <= {0:g}", latest_ms));
        }
        if (!history.time_ms.empty() && !(at > history.time_ms.back())) {
            throw pave::Error(place, "the times of a history increase from row to row",
                              fmt::format("{:g} after {:g}", at, history.time_ms.back()), "a later time");
        }
        history.time_ms.push_back(at);
        history.values.push_back(
            table.number(trimmed(row.cells[value]), {.file = file, .line = row.line, .key = value_name}));
    }
    if (history.values.size() < 2) {
        throw pave::Error({.file = file}, "a history has at least two rows", std::to_string(history.values.size()),
                          "the load at two times or more");
    }
    if (!(*std::max_element(history.values.begin(), history.values.end()) > 0.0)) {
        throw pave::Error({.file = file, .line = header.line, .key = value_name},
                          "the load of a history presses at some time", "no value above zero",
                          "a value above zero; pressing is positive");
    }
    return history;
}

} // namespace explore::data
