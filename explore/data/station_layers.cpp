#include "data/station_layers.h"

#include "base/error.h"
#include "base/text.h"
#include "data/csv.h"
#include "data/fwd_columns.h"
#include "data/fwd_places.h"
#include "data/fwd_values.h"

#include <algorithm>
#include <fmt/format.h>
#include <set>

namespace explore::data {
namespace {

constexpr std::string_view wanted_layers = "chainage_m, <layer>_mm such as asphalt_mm, <layer>_sd_mm, lane";

struct Cell {
    std::size_t at = 0;
    std::string name;
    LayerColumn column;
};

} // namespace

std::optional<LayerColumn> layer_column(std::string_view name) {
    name = trimmed(name);
    if (!name.empty() && (name.back() == ')' || name.back() == ']')) {
        name.remove_suffix(1);
    }
    const std::size_t at = name.find_last_of("_ ([");
    const auto unit = at == std::string_view::npos ? std::nullopt : factor_of(length_units(), name.substr(at + 1));
    const std::size_t end = unit ? name.substr(0, at).find_last_not_of("_ ([") : std::string_view::npos;
    if (end == std::string_view::npos) {
        return std::nullopt;
    }
    LayerColumn column{.layer = std::string(name.substr(0, end + 1)), .to_mm = *unit * 1e3};
    for (const std::string_view word : {"_sd", " sd"}) {
        if (lower_case(column.layer).ends_with(word) && column.layer.size() > word.size()) {
            column.layer.resize(column.layer.size() - word.size());
            column.is_error = true;
            break;
        }
    }
    return column;
}

std::vector<std::string> LayerTable::layers() const {
    std::set<std::string> names;
    for (const Row& row : rows) {
        for (const auto& [name, thickness] : row.layers) {
            names.insert(name);
        }
    }
    return {names.begin(), names.end()};
}

LayerTable read_layer_table(const std::string& file) {
    const CsvTable read = parse_table(read_file(file, "table of layers", Encoding::of_instruments), file);
    if (read.rows.empty()) {
        throw pave::Error({.file = file}, "the file holds no table", {}, std::string(wanted_layers));
    }
    const CsvRow& header = read.rows[0];
    LayerTable table{.file = file, .rows = {}};
    std::optional<std::size_t> place;
    std::optional<std::size_t> lane;
    std::optional<double> to_m;
    std::vector<Cell> cells;
    for (std::size_t i = 0; i < header.cells.size(); ++i) {
        const std::string name(trimmed(header.cells[i]));
        const auto known = column_named(name);
        if (known && known->meaning == Meaning::chainage) {
            place = i;
            to_m = known->to_si;
        } else if (known && known->meaning == Meaning::lane) {
            lane = i;
        } else if (const auto column = layer_column(name)) {
            cells.push_back({i, name, *column});
        } else if (!name.empty()) {
            table.unknown.push_back(name);
        }
    }
    if (!place || cells.empty()) {
        throw pave::Error({.file = file, .line = header.line, .key = place ? "<layer>_mm" : "chainage_m"},
                          "column missing", pave::join(header.cells), std::string(wanted_layers));
    }
    std::stable_sort(cells.begin(), cells.end(),
                     [](const Cell& a, const Cell& b) { return a.column.is_error < b.column.is_error; });
    const auto stated_at = [&](const CsvRow& row) {
        std::string stated(*place < row.cells.size() ? trimmed(row.cells[*place]) : std::string_view{});
        if (read.decimal_comma) {
            std::replace(stated.begin(), stated.end(), ',', '.');
        }
        return stated;
    };
    std::vector<std::string> all_stated;
    for (std::size_t r = 1; r < read.rows.size(); ++r) {
        all_stated.push_back(stated_at(read.rows[r]));
    }
    const Places places(all_stated, trimmed(header.cells[*place]), to_m, false);
    table.places = places.remark();
    std::set<std::tuple<std::string, double, std::string>> seen; // lane, chainage and layer
    for (std::size_t r = 1; r < read.rows.size(); ++r) {
        const CsvRow& row = read.rows[r];
        const auto cell = [&](std::size_t at) {
            return at < row.cells.size() ? trimmed(row.cells[at]) : std::string_view{};
        };
        const std::string& stated = all_stated[r - 1];
        const auto chainage_m = places.metres(stated);
        if (!chainage_m) {
            throw pave::Error({.file = file, .line = row.line, .key = header.cells[*place]}, "no chainage",
                              "\"" + stated + "\"", "metres, or kilometres+metres as in 1+250");
        }
        LayerTable::Row found{
            .lane = lane ? std::string(cell(*lane)) : "", .chainage_m = *chainage_m, .layers = {}, .line = row.line};
        for (const Cell& c : cells) {
            if (is_nil(cell(c.at))) {
                continue;
            }
            const pave::Place at{.file = file, .line = row.line, .key = c.name};
            const double mm = c.column.to_mm * read.number(cell(c.at), at);
            if (!(mm > 0.0)) {
                throw pave::Error(at, c.column.is_error ? "no standard deviation" : "no thickness",
                                  std::string(cell(c.at)), "a positive number; nothing where it is not known");
            }
            if (!c.column.is_error) {
                if (!seen.insert({lower_case(found.lane), *chainage_m, c.column.layer}).second) {
                    throw pave::Error(at, "two rows state this layer at one place", std::string(cell(c.at)),
                                      "one row a place");
                }
                found.layers[c.column.layer].mm = mm;
            } else if (const auto of = found.layers.find(c.column.layer); of != found.layers.end()) {
                of->second.sd_mm = mm;
            }
        }
        table.rows.push_back(std::move(found));
    }
    std::stable_sort(table.rows.begin(), table.rows.end(),
                     [](const auto& a, const auto& b) { return a.chainage_m < b.chainage_m; });
    if (table.layers().empty()) {
        throw pave::Error({.file = file}, "the table states no thickness", {}, std::string(wanted_layers));
    }
    return table;
}

std::optional<StatedThickness> thickness_at(const LayerTable& table, const std::string& layer, const std::string& lane,
                                            double chainage_m) {
    const LayerTable::Row* before = nullptr;
    const LayerTable::Row* after = nullptr;
    for (const LayerTable::Row& row : table.rows) {
        if (!row.layers.contains(layer) || (!row.lane.empty() && lower_case(row.lane) != lower_case(lane))) {
            continue;
        }
        if (row.chainage_m <= chainage_m) {
            before = &row;
        } else if (after == nullptr) {
            after = &row;
        }
    }
    if (before == nullptr && after == nullptr) {
        return std::nullopt;
    }
    const auto& a = *(before == nullptr ? after : before);
    const auto& b = *(after == nullptr ? before : after);
    const double span = b.chainage_m - a.chainage_m;
    const double t = span > 0.0 ? (chainage_m - a.chainage_m) / span : 0.0;
    const StatedThickness& left = a.layers.at(layer);
    const StatedThickness& right = b.layers.at(layer);
    StatedThickness found{.mm = (1.0 - t) * left.mm + t * right.mm, .sd_mm = {}, .is_from_table = true};
    if (left.sd_mm && right.sd_mm) {
        found.sd_mm = (1.0 - t) * *left.sd_mm + t * *right.sd_mm;
    }
    return found;
}

} // namespace explore::data
