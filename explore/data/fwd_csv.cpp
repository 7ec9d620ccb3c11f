#include "data/fwd_csv.h"

#include "data/csv.h"
#include "data/fwd_columns.h"
#include "data/fwd_places.h"
#include "data/fwd_table.h"
#include "data/fwd_values.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <map>
#include <tuple>

namespace explore::data {
namespace {

// Lines below the stations that sum them up.
bool is_statistic(std::string_view name) {
    constexpr std::array<std::string_view, 22> words = {"mean",     "average",  "avg",        "std",
                                                        "stdev",    "stddev",   "min",        "minimum",
                                                        "max",      "maximum",  "median",     "sum",
                                                        "total",    "count",    "cv",         "cov",
                                                        "variance", "mittel",   "mittelwert", "standardabweichung",
                                                        "moyenne",  "ecarttype"};
    return std::find(words.begin(), words.end(), plain_word(name)) != words.end();
}

// Left and right carriageway of Chinese motorways, of "ZK0+160" and "YK0+160"; "": neither.
std::string_view carriageway(std::string_view place) {
    return place.starts_with("ZK") || place.starts_with("YK") ? place.substr(0, 2) : std::string_view{};
}

// The day of "2023-04-12 10:30", or of the days that a spreadsheet counts.
std::string_view day_of(std::string_view date) {
    const bool is_count = date.find_first_not_of(".0123456789") == std::string_view::npos &&
                          std::count(date.begin(), date.end(), '.') == 1;
    return date.substr(0, date.find_first_of(is_count ? "." : " T"));
}

// Whether its cells tell the decimal sign. Positions keep their points where the spreadsheet knows commas.
bool tells_decimals(Meaning meaning) {
    switch (meaning) {
    case Meaning::latitude:
    case Meaning::longitude:
    case Meaning::station:
    case Meaning::lane:
    case Meaning::profile:
    case Meaning::date:
    case Meaning::time:
    case Meaning::comment: return false;
    default: return true;
    }
}

class CsvReader {
public:
    CsvReader(std::string_view text, std::string file, const ColumnMap& map) : file_(std::move(file)) {
        auto table = fwd_table(text, file_, map);
        if (!table) {
            throw pave::Error({.file = file_}, "the file holds no table", {}, known_columns());
        }
        table_ = std::move(*table);
        header_ = read_header(table_.rows, table_.lines, file_, map);
        Decimals decimals(table_.separator);
        for (std::size_t r = header_.rows; r < table_.rows.size(); ++r) {
            for (const FwdColumn& column : header_.columns) {
                if (tells_decimals(column.meaning) && column.at < table_.rows[r].size() && !column.constant) {
                    decimals.look_at(trimmed(table_.rows[r][column.at]), table_.lines[r], column.name);
                }
            }
            for (const FwdHeader::Layer& layer : header_.layers) {
                if (layer.at < table_.rows[r].size()) {
                    decimals.look_at(trimmed(table_.rows[r][layer.at]), table_.lines[r], layer.name);
                }
            }
        }
        decimal_ = decimals.sign(file_);
        if (std::string doubt = decimals.doubt(); !doubt.empty()) {
            result_.remarks.push_back(file_ + ", " + std::move(doubt));
        }
    }

    FwdFile read() && {
        if (!header_.unknown.empty()) {
            result_.remarks.push_back("columns not used: " + pave::join(header_.unknown));
        }
        if (const FwdColumn* place = header_.find(Meaning::chainage); place != nullptr && !place->to_si) {
            result_.remarks.push_back(
                fmt::format("the column \"{}\" states no unit: it is taken for metres", place->name));
        }
        if (table_.above > 0) {
            result_.remarks.push_back(
                fmt::format("{}: the header is line {}, and what stands above is not used", file_, table_.lines[0]));
        }
        look_at_places();
        for (std::size_t r = header_.rows; r < table_.rows.size(); ++r) {
            if (!repeats_header(r) && !is_summary(r)) {
                take(r);
            }
        }
        forget_lone_carriageway();
        if (result_.stations.empty()) {
            throw pave::Error({.file = file_}, "the file holds no stations", "a header and no rows",
                              "at least one row");
        }
        if (too_long_ == table_.rows.size() - header_.rows) {
            throw pave::Error(
                {.file = file_, .line = table_.lines[header_.rows]}, "wrong number of cells",
                std::to_string(table_.rows[header_.rows].size()),
                fmt::format("{}, as in the header; are there decimal commas in a table separated by commas?",
                            table_.rows[0].size()));
        }
        return std::move(result_);
    }

private:
    // Tables one after the other repeat it.
    bool repeats_header(std::size_t r) const {
        const auto& names = table_.rows[0];
        const auto& row = table_.rows[r];
        return row.size() == names.size() && std::equal(row.begin(), row.end(), names.begin(), [](auto& a, auto& b) {
                   return lower_case(trimmed(with_plain_letters(a))) == lower_case(trimmed(b));
               });
    }

    bool is_summary(std::size_t r) {
        const FwdColumn* place = header_.find(Meaning::chainage);
        const std::string name = text(r, Meaning::station);
        const std::string_view words = name.empty() ? cell(r, place) : std::string_view(name);
        if (!is_statistic(words) || (place != nullptr && chainage(with_point(cell(r, place), decimal_), 1.0))) {
            return false;
        }
        result_.remarks.push_back(
            fmt::format("{}, line {}: \"{}\" is no station and left out", file_, table_.lines[r], words));
        return true;
    }

    // One carriageway alone is no lane beside another.
    void forget_lone_carriageway() {
        const bool are_two = std::any_of(result_.stations.begin(), result_.stations.end(),
                                         [&](const FwdStation& s) { return s.lane != result_.stations[0].lane; });
        if (header_.find(Meaning::lane) == nullptr && !are_two) {
            for (FwdStation& s : result_.stations) {
                s.lane.clear();
            }
        }
    }

    // Feet, miles and pounds beside a place that states no unit.
    bool is_american() const {
        return std::any_of(header_.columns.begin(), header_.columns.end(), [](const FwdColumn& c) {
            const double of_column = c.to_si.value_or(0.0);
            const auto is = [&](std::span<const NamedUnit> units, std::string_view unit) {
                return of_column == *factor_of(units, unit);
            };
            return (c.meaning == Meaning::deflection && (is(length_units(), "mil") || is(length_units(), "in"))) ||
                   (c.meaning == Meaning::load && (is(force_units(), "lbf") || is(force_units(), "kip"))) ||
                   (c.meaning == Meaning::pressure && is(pressure_units(), "psi"));
        });
    }

    const FwdColumn& place_column() const {
        const FwdColumn* place = header_.find(Meaning::chainage);
        return place == nullptr ? *header_.find(Meaning::station) : *place;
    }
    void look_at_places() {
        const FwdColumn& place = place_column();
        std::vector<std::string> cells;
        for (std::size_t r = header_.rows; r < table_.rows.size(); ++r) {
            if (!repeats_header(r)) {
                cells.push_back(with_point(cell(r, &place), decimal_));
            }
        }
        places_.emplace(cells, place.constant ? std::string_view{} : trimmed(table_.rows[0][place.at]), place.to_si,
                        is_american());
        if (!places_->remark().empty()) {
            result_.remarks.push_back(file_ + ": " + places_->remark());
        }
    }

    std::string_view cell(std::size_t r, const FwdColumn* column) const {
        const auto& row = table_.rows[r];
        return column == nullptr || column->constant || column->at >= row.size() ? std::string_view{}
                                                                                 : trimmed(row[column->at]);
    }
    std::string text(std::size_t r, Meaning meaning) const { return std::string(cell(r, header_.find(meaning))); }
    // The number of a cell, in the unit of its column; nothing, with a remark when the cell holds something else.
    std::optional<double> number(std::size_t r, const FwdColumn* column, FwdStation& station) const {
        if (column == nullptr || column->constant) {
            return column == nullptr ? std::nullopt : column->constant;
        }
        const std::string_view found = cell(r, column);
        const auto value = measured(with_point(found, decimal_));
        if (!value && !is_nil(found)) {
            station.remarks.push_back(
                fmt::format("line {}, {}: \"{}\" is not a number", table_.lines[r], column->name, found));
        }
        return value;
    }
    // In Celsius. The cell may state its scale: "20 °C".
    std::optional<double> temperature(std::size_t r, Meaning meaning, FwdStation& station) const {
        const FwdColumn* column = header_.find(meaning);
        const std::string_view found = cell(r, column);
        std::string_view number = found;
        bool is_fahrenheit = column != nullptr && column->is_fahrenheit;
        for (const std::string_view scale : {"C", "c", "F", "f", "\u2103", "\u2109"}) {
            if (number.ends_with(scale)) {
                is_fahrenheit = scale == "F" || scale == "f" || scale == "\u2109";
                number = trimmed(number.substr(0, number.size() - scale.size()));
                break;
            }
        }
        for (const std::string_view sign : {"\u00b0", "\u00ba", "deg"}) {
            number = number.ends_with(sign) ? trimmed(number.substr(0, number.size() - sign.size())) : number;
        }
        const auto value = measured(with_point(number, decimal_));
        if (!value && !is_nil(found)) {
            station.remarks.push_back(
                fmt::format("line {}, {}: \"{}\" is no temperature", table_.lines[r], column->name, found));
        }
        return value && is_fahrenheit ? std::optional(celsius(*value)) : value;
    }

    // Of all columns that name one: road, section, run.
    std::string profile(std::size_t r) const {
        std::vector<std::string> words;
        for (const FwdColumn& column : header_.columns) {
            if (column.meaning == Meaning::profile && !cell(r, &column).empty()) {
                words.emplace_back(cell(r, &column));
            }
        }
        return pave::join(words, " ");
    }

    FwdStation& station_of(std::size_t r) {
        const FwdColumn& place = place_column();
        const std::string stated = place.constant ? fmt::format("{}", *place.constant) : std::string(cell(r, &place));
        const auto chainage_m = places_->metres(with_point(stated, decimal_));
        std::string name = text(r, Meaning::station);
        name = !name.empty() ? name : !stated.empty() ? stated : fmt::format("line {}", table_.lines[r]);
        const std::string lane =
            header_.find(Meaning::lane) != nullptr ? text(r, Meaning::lane) : std::string(carriageway(stated));
        const std::string date = text(r, Meaning::date);
        const auto [at, is_new] =
            known_.try_emplace({lower_case(profile(r)), std::string(day_of(date)), name, lower_case(lane), chainage_m},
                               result_.stations.size());
        if (is_new) {
            FwdStation station{
                .name = name, .profile = profile(r), .lane = lane, .chainage_m = chainage_m, .file = file_};
            station.line = table_.lines[r];
            if (!chainage_m) {
                station.remarks.push_back(
                    stated.empty() || is_nil(stated)
                        ? fmt::format("line {}: no chainage", table_.lines[r])
                        : fmt::format("line {}, {}: \"{}\" is no chainage", table_.lines[r], place.name, stated));
            }
            if (places_->is_sum_in_feet_by_neighbours(stated)) {
                station.remarks.push_back(
                    fmt::format("\"{}\" is taken for stations of 100 ft, as pounds or mils stand beside it", stated));
            }
            result_.stations.push_back(std::move(station));
        }
        return result_.stations[at->second];
    }

    void take(std::size_t r) {
        FwdStation& s = station_of(r);
        const auto keep = [](auto& to, auto value) {
            if (!to) {
                to = value;
            }
        };
        const auto keep_text = [&](std::string& to, Meaning meaning) { to = to.empty() ? text(r, meaning) : to; };
        keep(s.air_C, temperature(r, Meaning::air, s));
        keep(s.surface_C, temperature(r, Meaning::surface, s));
        keep(s.asphalt_C, temperature(r, Meaning::asphalt, s));
        if (!s.latitude) {
            const auto position = [&](Meaning meaning) {
                std::string found = with_plain_letters(text(r, meaning));
                std::replace(found.begin(), found.end(), ',', '.');
                return found;
            };
            set_position(s, position(Meaning::latitude), position(Meaning::longitude));
        }
        take_layers(r, s);
        keep_text(s.date, Meaning::date);
        keep_text(s.time, Meaning::time);
        add_comment(s, text(r, Meaning::comment));
        if (table_.rows[r][0].starts_with('#')) {
            s.remarks.push_back(fmt::format(
                "line {} begins with # and is read as a drop: comments stand above the header", table_.lines[r]));
        }

        const auto& row = table_.rows[r];
        const auto beyond =
            std::find_if(row.begin() + static_cast<std::ptrdiff_t>(std::min(row.size(), table_.rows[0].size())),
                         row.end(), [](const std::string& c) { return !trimmed(c).empty(); });
        if (beyond != row.end()) {
            ++too_long_;
            s.remarks.push_back(fmt::format("line {}: {} cells and {} columns, the drop is left out", table_.lines[r],
                                            row.size(), table_.rows[0].size()));
            if (s.drops.empty() && s.unusable.empty()) {
                s.unusable =
                    fmt::format("line {}: {} cells and {} columns", table_.lines[r], row.size(), table_.rows[0].size());
            }
            return;
        }
        s.unusable.clear();
        FwdDrop d{.number = drop_number(r, s), .readings = {}};
        d.line = table_.lines[r];
        set_load(r, d, s);
        for (const FwdColumn* sensor : header_.deflections()) {
            if (const auto value = number(r, sensor, s)) {
                d.readings.push_back({sensor->offset_mm, *value * (*sensor->to_si * 1e6)}); // 1e-6 x 1e6 is 1
            } else {
                d.not_read_mm.push_back(sensor->offset_mm);
            }
        }
        s.drops.push_back(std::move(d));
    }

    void take_layers(std::size_t r, FwdStation& s) const {
        for (const bool is_error : {false, true}) {
            for (const FwdHeader::Layer& layer : header_.layers) {
                const auto& row = table_.rows[r];
                const auto value = layer.at < row.size() && layer.column.is_error == is_error
                                       ? measured(with_point(trimmed(row[layer.at]), decimal_))
                                       : std::nullopt;
                if (!value && !is_error && layer.at < row.size() && !is_nil(trimmed(row[layer.at]))) {
                    s.remarks.push_back(fmt::format("line {}, {}: \"{}\" is not a number", table_.lines[r], layer.name,
                                                    trimmed(row[layer.at])));
                }
                if (value && !is_error) {
                    s.layers.try_emplace(layer.column.layer, StatedThickness{.mm = layer.column.to_mm * *value});
                } else if (const auto of = s.layers.find(layer.column.layer);
                           value && *value > 0.0 && of != s.layers.end()) {
                    of->second.sd_mm = layer.column.to_mm * *value;
                }
            }
        }
    }

    // The operator's comments at the drops, each once.
    static void add_comment(FwdStation& s, const std::string& words) {
        if (!words.empty() && s.comment.find(words) == std::string::npos) {
            s.comment += (s.comment.empty() ? "" : "; ") + words;
        }
    }

    int drop_number(std::size_t r, FwdStation& s) const {
        const int counted = static_cast<int>(s.drops.size()) + 1;
        const auto stated = number(r, header_.find(Meaning::drop), s);
        return stated && *stated == std::floor(*stated) && std::abs(*stated) < 1e6 ? static_cast<int>(*stated)
                                                                                   : counted;
    }

    void set_load(std::size_t r, FwdDrop& d, FwdStation& s) const {
        const FwdColumn* radius = header_.find(Meaning::radius);
        const FwdColumn* diameter = header_.find(Meaning::diameter);
        const FwdColumn* plate = radius != nullptr ? radius : diameter;
        const auto size = number(r, plate, s);
        d.radius_mm = size ? *size * *plate->to_si * 1e3 / (radius != nullptr ? 1.0 : 2.0) : NAN;
        d.pressure_kPa = NAN;
        const FwdColumn* force = header_.find(Meaning::load);
        if (const auto newtons = number(r, force, s)) {
            d.force_kN = *newtons * *force->to_si / 1e3;
            d.pressure_kPa = plate_pressure_kPa(*d.force_kN, d.radius_mm);
        }
        const FwdColumn* pressure = header_.find(Meaning::pressure);
        if (const auto stated = number(r, pressure, s)) {
            take_pressure(d, *stated * *pressure->to_si / 1e3, fmt::format("line {}", table_.lines[r]), s);
        }
    }

    std::string file_;
    FwdTable table_;
    FwdHeader header_;
    std::optional<Places> places_; // known once the rows are
    char decimal_ = '.';
    FwdFile result_;
    // By profile, date, name, lane and chainage; upper and lower case are one.
    std::map<std::tuple<std::string, std::string, std::string, std::string, std::optional<double>>, std::size_t> known_;
    std::size_t too_long_ = 0; // lines with more cells than the header
};

} // namespace

bool recognises_fwd_csv(std::string_view text, const ColumnMap& columns) {
    return has_fwd_table(text, columns);
}

FwdFile read_fwd_csv(std::string_view text, const std::string& file, const ColumnMap& columns) {
    return CsvReader(text, file, columns).read();
}

} // namespace explore::data
