#include "data/fwd_csv.h"

#include "data/csv.h"
#include "data/fwd_columns.h"
#include "data/fwd_values.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <map>
#include <tuple>

namespace explore::data {
namespace {

constexpr std::size_t npos = std::string_view::npos;
constexpr std::array separators = {',', ';', '\t'};

// The first line that is neither blank nor a comment.
std::string_view first_line(std::string_view text) {
    while (!text.empty()) {
        const std::string_view line = text.substr(0, text.find('\n'));
        if (!trimmed(line.substr(0, line.find('\r'))).empty() && line[0] != '#') {
            return line.substr(0, line.find('\r'));
        }
        text.remove_prefix(std::min(line.size() + 1, text.size()));
    }
    return {};
}

// Spreadsheets may name the separator in a line before the table: sep=;
bool names_separator(std::string_view line) {
    return lower_case(line).starts_with("sep=");
}

// The one that parts the header most often.
char separator_of(std::string_view line) {
    char best = separators[0];
    std::ptrdiff_t most = -1;
    for (const char separator : separators) {
        bool is_quoted = false;
        std::ptrdiff_t count = 0;
        for (const char c : line) {
            is_quoted = is_quoted != (c == '"');
            count += c == separator && !is_quoted ? 1 : 0;
        }
        if (count > most) {
            most = count;
            best = separator;
        }
    }
    return best;
}

struct Table {
    std::vector<std::vector<std::string>> rows; // none of them blank
    std::vector<int> lines;                     // where they stand
    char separator = ',';
};

Table read_table(std::string_view text, const std::string& file) {
    Table table;
    const std::string_view line = first_line(text);
    const bool named = names_separator(line);
    table.separator = named && line.size() > 4 ? line[4] : separator_of(line);
    for (CsvRow& row : parse_csv(text, file, table.separator)) {
        const bool is_blank = std::all_of(row.cells.begin(), row.cells.end(),
                                          [](const std::string& cell) { return trimmed(cell).empty(); });
        if (!is_blank && !(named && table.rows.empty() && names_separator(row.cells[0]))) {
            table.rows.push_back(std::move(row.cells));
            table.lines.push_back(row.line);
        }
    }
    return table;
}

// Without what parts thousands for the eye: blanks, no-break spaces, apostrophes between digits.
std::string without_blanks(std::string_view cell) {
    std::string out;
    const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
    for (std::size_t i = 0; i < cell.size();) {
        std::size_t length = 0;
        for (const std::string_view blank : {" ", "'", "\u00a0", "\u2009", "\u202f", "\u2019"}) {
            length = cell.substr(i).starts_with(blank) ? blank.size() : length;
        }
        if (length > 0 && !out.empty() && is_digit(out.back()) && i + length < cell.size() &&
            is_digit(cell[i + length])) {
            i += length;
        } else {
            out += cell[i++];
        }
    }
    return out;
}

// Digits in groups of three behind this sign: "1.234.567" of '.'.
bool is_grouped(std::string_view digits, char sign) {
    const std::size_t first = digits.find(sign);
    if (first == std::string_view::npos || first == 0 || first > 3 || digits[0] == '0') {
        return false;
    }
    for (std::size_t at = first; at != std::string_view::npos; at = digits.find(sign, at + 1)) {
        const std::size_t next = std::min(digits.find(sign, at + 1), digits.size());
        if (next - at != 4) {
            return false;
        }
    }
    return true;
}

// Which sign parts the whole from the rest in the numbers of a file.
class Decimals {
public:
    // separator: a file separated by semicolons or tabs comes from where the comma is the decimal sign.
    explicit Decimals(char separator) : otherwise_(separator == ',' ? '.' : ',') {}

    void look_at(std::string_view cell, int line, std::string_view column) {
        const std::string text = without_blanks(cell);
        const std::size_t comma = text.rfind(',');
        const std::size_t point = text.rfind('.');
        if (text.find_first_not_of("+-.,0123456789") != std::string::npos || (comma == point)) {
            return; // no number, or neither sign
        }
        const bool has_both = comma != std::string::npos && point != std::string::npos;
        const char last = has_both ? (comma > point ? ',' : '.') : comma != std::string::npos ? ',' : '.';
        if (!has_both && is_grouped(text, last)) {
            doubtful_[last == ',' ? 0 : 1] = true;
            return;
        }
        Sight& sight = seen_[last == ',' ? 0 : 1];
        if (sight.line == 0) {
            sight = {line, std::string(column), std::string(cell)};
        }
    }

    // Throws pave::Error where the file contradicts itself.
    char sign(const std::string& file) const {
        const auto& [comma, point] = seen_;
        if (comma.line > 0 && point.line > 0) {
            const Sight& second = comma.line > point.line ? comma : point;
            const Sight& first = comma.line > point.line ? point : comma;
            throw pave::Error(
                {.file = file, .line = second.line, .key = second.column},
                "decimal points and decimal commas in one table",
                fmt::format("\"{}\", and \"{}\" in line {}, {}", second.cell, first.cell, first.line, first.column),
                "one of them");
        }
        if (comma.line > 0 || point.line > 0) {
            return comma.line > 0 ? ',' : '.';
        }
        // "1,234" alone: thousands where commas part the cells, decimals where they do not; "1.234" is a decimal point.
        return doubtful_[0] && !doubtful_[1] ? otherwise_ : '.';
    }

private:
    struct Sight {
        int line = 0;
        std::string column;
        std::string cell;
    };
    std::array<Sight, 2> seen_; // of commas, of points
    std::array<bool, 2> doubtful_{false, false};
    char otherwise_;
};

// The cell as a program reads it: no thousands, a decimal point.
std::string with_point(std::string_view cell, char decimal) {
    std::string text = without_blanks(cell);
    const char group = decimal == ',' ? '.' : ',';
    const std::size_t start = text.find_first_of("0123456789");
    if (start == std::string::npos) {
        return text;
    }
    const std::string_view whole = std::string_view(text).substr(start, text.find(decimal, start) - start);
    if (is_grouped(whole, group)) {
        std::string joined(whole);
        joined.erase(std::remove(joined.begin(), joined.end(), group), joined.end());
        text.replace(start, whole.size(), joined);
    }
    if (decimal == ',') {
        std::replace(text.begin(), text.end(), ',', '.');
    }
    return text;
}

// Whether its cells tell the decimal sign. Positions keep their points where the spreadsheet knows commas.
bool tells_decimals(Meaning meaning) {
    switch (meaning) {
    case Meaning::latitude:
    case Meaning::longitude:
    case Meaning::station:
    case Meaning::lane:
    case Meaning::date:
    case Meaning::time:
    case Meaning::comment: return false;
    default: return true;
    }
}

class Reader {
public:
    Reader(std::string_view text, std::string file, const ColumnMap& map)
        : file_(std::move(file)),
          table_(read_table(text, file_)) {
        if (table_.rows.empty()) {
            throw pave::Error({.file = file_}, "the file holds no table", {}, known_columns());
        }
        header_ = read_header(table_.rows, table_.lines, file_, map);
        Decimals decimals(table_.separator);
        for (std::size_t r = header_.rows; r < table_.rows.size(); ++r) {
            for (const FwdColumn& column : header_.columns) {
                if (tells_decimals(column.meaning) && column.at < table_.rows[r].size() && !column.constant) {
                    decimals.look_at(trimmed(table_.rows[r][column.at]), table_.lines[r], column.name);
                }
            }
        }
        decimal_ = decimals.sign(file_);
    }

    FwdFile read() && {
        if (!header_.unknown.empty()) {
            result_.remarks.push_back("columns not used: " + pave::join(header_.unknown));
        }
        if (const FwdColumn* place = header_.find(Meaning::chainage); place != nullptr && !place->to_si) {
            result_.remarks.push_back(
                fmt::format("the column \"{}\" states no unit: it is taken for metres", place->name));
        }
        for (std::size_t r = header_.rows; r < table_.rows.size(); ++r) {
            if (table_.rows[r] != table_.rows[0]) { // tables one after the other repeat it
                take(r);
            }
        }
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
                fmt::format("line {}, {}: \"{}\" is no number", table_.lines[r], column->name, found));
        }
        return value;
    }
    std::optional<double> temperature(std::size_t r, Meaning meaning) const {
        const FwdColumn* column = header_.find(meaning);
        const auto value = measured(with_point(cell(r, column), decimal_));
        return value && column->is_fahrenheit ? std::optional(celsius(*value)) : value;
    }

    FwdStation& station_of(std::size_t r) {
        const FwdColumn* place = header_.find(Meaning::chainage);
        const bool by_name = place == nullptr;
        place = by_name ? header_.find(Meaning::station) : place;
        const std::string stated = place->constant ? fmt::format("{}", *place->constant) : std::string(cell(r, place));
        const auto chainage_m = chainage(with_point(stated, decimal_), place->to_si.value_or(1.0));
        std::string name = text(r, Meaning::station);
        name = !name.empty() ? name : !stated.empty() ? stated : fmt::format("line {}", table_.lines[r]);
        const auto [at, is_new] =
            known_.try_emplace({name, text(r, Meaning::lane), chainage_m}, result_.stations.size());
        if (is_new) {
            FwdStation station{.name = name, .lane = text(r, Meaning::lane), .chainage_m = chainage_m, .file = file_};
            station.line = table_.lines[r];
            if (!chainage_m) {
                station.remarks.push_back(
                    stated.empty() || is_nil(stated)
                        ? fmt::format("line {}: no chainage", table_.lines[r])
                        : fmt::format("line {}, {}: \"{}\" is no chainage", table_.lines[r], place->name, stated));
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
        keep(s.air_C, temperature(r, Meaning::air));
        keep(s.surface_C, temperature(r, Meaning::surface));
        keep(s.asphalt_C, temperature(r, Meaning::asphalt));
        const auto position = [&](Meaning meaning) {
            std::string found = text(r, meaning);
            std::replace(found.begin(), found.end(), ',', '.');
            return degrees(found);
        };
        keep(s.latitude, position(Meaning::latitude));
        keep(s.longitude, position(Meaning::longitude));
        keep_text(s.date, Meaning::date);
        keep_text(s.time, Meaning::time);
        keep_text(s.comment, Meaning::comment);

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
            }
        }
        s.drops.push_back(std::move(d));
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
            const double kPa = *stated * *pressure->to_si / 1e3;
            if (d.force_kN && !(std::abs(d.pressure_kPa / kPa - 1.0) <= 0.05)) {
                s.remarks.push_back(fmt::format("line {}: {:g} kN on this plate are {:.0f} kPa, the line states {:g} "
                                                "kPa, which is taken",
                                                table_.lines[r], *d.force_kN, d.pressure_kPa, kPa));
            }
            d.pressure_kPa = kPa;
            d.force_kN.reset();
        }
    }

    std::string file_;
    Table table_;
    FwdHeader header_;
    char decimal_ = '.';
    FwdFile result_;
    std::map<std::tuple<std::string, std::string, std::optional<double>>, std::size_t> known_;
    std::size_t too_long_ = 0; // lines with more cells than the header
};

} // namespace

bool recognises_fwd_csv(std::string_view text, const ColumnMap& columns) {
    std::string_view line = first_line(text);
    char separator = separator_of(line);
    if (names_separator(line)) {
        separator = line.size() > 4 ? line[4] : separator;
        text.remove_prefix(std::min(static_cast<std::size_t>(line.data() - text.data()) + line.size(), text.size()));
        line = first_line(text);
    }
    if (line.empty() || line.find(separator) == npos) {
        return false;
    }
    if (!columns.empty()) {
        return true;
    }
    // Any two words of such a table.
    int known = 0;
    std::string name;
    bool is_quoted = false;
    const auto take_name = [&] {
        const auto column = column_named(name);
        known += column && (column->meaning == Meaning::chainage || column->meaning == Meaning::deflection ||
                            column->meaning == Meaning::radius || column->meaning == Meaning::diameter ||
                            column->meaning == Meaning::pressure || column->meaning == Meaning::load)
                     ? 1
                     : 0;
        name.clear();
    };
    for (const char c : line) {
        is_quoted = is_quoted != (c == '"');
        if (c == separator && !is_quoted) {
            take_name();
        } else if (c != '"') {
            name += c;
        }
    }
    take_name();
    return known >= 2;
}

FwdFile read_fwd_csv(std::string_view text, const std::string& file, const ColumnMap& columns) {
    return Reader(text, file, columns).read();
}

} // namespace explore::data
