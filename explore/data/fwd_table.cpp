#include "data/fwd_table.h"

#include "data/csv.h"
#include "data/fwd_columns.h"

#include <algorithm>
#include <fmt/format.h>
#include <iterator>

namespace explore::data {
namespace {

constexpr std::array separators = {',', ';', '\t', '|'};
constexpr std::string_view wide_comma = "\uff0c";

// The row that begins at `at`, which moves behind it. A quote that never closes ends with the text.
std::vector<std::string> row_at(std::string_view text, std::size_t& at, char separator) {
    std::vector<std::string> cells(1);
    bool is_quoted = false;
    for (; at < text.size(); ++at) {
        const char c = text[at];
        if (c == '"') {
            is_quoted = !is_quoted;
        } else if (c == '\n' && !is_quoted) {
            ++at;
            break;
        } else if (c == separator && !is_quoted) {
            cells.emplace_back();
        } else if (c != '\r') {
            cells.back() += c;
        }
    }
    return cells;
}

struct Header {
    std::vector<std::string> cells{};
    std::size_t begin = 0, end = 0; // in the text
    std::size_t above = 0;          // lines before it that hold something
    char separator = ',';
    int known = 0; // columns
};

int known_columns_of(const std::vector<std::string>& cells, const ColumnMap& columns) {
    constexpr std::size_t looked_at = 500;
    int known = 0;
    for (std::size_t i = 0; i < std::min(cells.size(), looked_at); ++i) {
        const std::string& cell = cells[i];
        std::string name = lower_case(with_plain_letters(trimmed(cell)));
        std::replace(name.begin(), name.end(), '\n', ' ');
        const auto column = column_named(name);
        const bool is_mapped = std::any_of(columns.begin(), columns.end(), [&](const auto& entry) {
            return lower_case(with_plain_letters(entry.second)) == name;
        });
        known +=
            is_mapped || (column && (column->meaning == Meaning::chainage || column->meaning == Meaning::deflection ||
                                     column->meaning == Meaning::radius || column->meaning == Meaning::diameter ||
                                     column->meaning == Meaning::pressure || column->meaning == Meaning::load))
                ? 1
                : 0;
    }
    return known;
}

std::optional<Header> header_of(std::string_view text, const ColumnMap& columns) {
    constexpr int rows = 30;
    constexpr std::size_t head = 1U << 16U;
    text = text.substr(0, head);
    Header best;
    for (const char separator : separators) {
        std::size_t at = 0;
        std::size_t above = 0;
        for (int row = 0; row < rows && at < text.size(); ++row) {
            Header header{.begin = at, .above = above, .separator = separator};
            const bool is_comment = text[at] == '#';
            at += is_comment ? 1 : 0; // a header may look like a comment
            header.cells = row_at(text, at, separator);
            header.end = at;
            const bool is_blank = std::all_of(header.cells.begin(), header.cells.end(),
                                              [](const std::string& cell) { return trimmed(cell).empty(); });
            const bool names_separator = lower_case(header.cells[0]).starts_with("sep="); // of spreadsheets
            above += is_blank || is_comment || names_separator ? 0 : 1;
            row -= is_blank || is_comment ? 1 : 0;
            header.known = known_columns_of(header.cells, columns);
            if (header.known > best.known) {
                best = std::move(header);
            }
        }
    }
    return best.known >= 2 || (!columns.empty() && best.known > 0) ? std::optional(std::move(best)) : std::nullopt;
}

// A table whose cells full-width commas part, with commas.
std::string with_plain_commas(std::string_view text) {
    std::string out;
    for (std::size_t at = 0;;) {
        const std::size_t next = text.find(wide_comma, at);
        out += text.substr(at, next - at);
        if (next == std::string_view::npos) {
            return out;
        }
        out += ',';
        at = next + wide_comma.size();
    }
}

// Without what parts thousands for the eye: blanks and apostrophes between digits.
std::string without_blanks(std::string_view cell) {
    std::string out;
    const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
    for (std::size_t i = 0; i < cell.size();) {
        std::size_t length = 0;
        for (const std::string_view blank : {" ", "'", "\u2019"}) {
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

} // namespace

bool has_fwd_table(std::string_view text, const ColumnMap& columns) {
    return header_of(text, columns) || (text.substr(0, 1U << 16U).find(wide_comma) != std::string_view::npos &&
                                        header_of(with_plain_commas(text.substr(0, 1U << 16U)), columns));
}

std::optional<FwdTable> fwd_table(std::string_view text, const std::string& file, const ColumnMap& columns) {
    auto header = header_of(text, columns);
    std::string plain;
    if (!header && text.find(wide_comma) != std::string_view::npos) {
        plain = with_plain_commas(text);
        text = plain;
        header = header_of(text, columns);
    }
    if (!header) {
        return std::nullopt;
    }
    FwdTable table;
    table.separator = header->separator;
    table.above = header->above;
    table.lines.push_back(1 + static_cast<int>(std::count(
                                  text.begin(), text.begin() + static_cast<std::ptrdiff_t>(header->begin), '\n')));
    for (std::string& cell : header->cells) {
        std::replace(cell.begin(), cell.end(), '\n', ' ');
        cell = with_plain_letters(cell);
    }
    table.rows.push_back(std::move(header->cells));
    // The text that follows, in its lines.
    const auto before = static_cast<std::size_t>(
        std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(header->end), '\n'));
    const std::string rest = std::string(before, '\n') + std::string(text.substr(header->end));
    for (CsvRow& row : parse_csv(rest, file, table.separator, Comments::none)) {
        constexpr std::string_view end_of_file = "\x1a"; // of old systems
        const bool is_blank = std::all_of(row.cells.begin(), row.cells.end(), [&](const std::string& cell) {
            return trimmed(cell).empty() || trimmed(cell) == end_of_file;
        });
        const bool is_comment = row.cells[0].starts_with('#') && 2 * row.cells.size() <= table.rows[0].size();
        if (!is_blank && !is_comment) {
            table.rows.push_back(std::move(row.cells));
            table.lines.push_back(row.line);
        }
    }
    return table;
}

std::string with_plain_letters(std::string_view text) {
    std::string out;
    for (std::size_t i = 0; i < text.size();) {
        // U+FF01 to U+FF5E are EF BC 81 to EF BD 9E, in the order of ASCII from ! on.
        const auto byte = [&](std::size_t k) {
            return static_cast<unsigned char>(i + k < text.size() ? text[i + k] : 0);
        };
        const int code = (byte(1) - 0xbc) * 64 + byte(2) - 0x80;
        if (byte(0) == 0xefU && (byte(1) == 0xbcU || byte(1) == 0xbdU) && code >= 1 && code <= 0x5e) {
            out += static_cast<char>('!' + code - 1);
            i += 3;
        } else if (text.substr(i).starts_with("\u2212")) {
            out += '-';
            i += 3;
        } else {
            out += text[i++];
        }
    }
    return out;
}

void Decimals::look_at(std::string_view cell, int line, std::string_view column) {
    const std::string text = without_blanks(with_plain_letters(cell));
    const std::size_t comma = text.rfind(',');
    const std::size_t point = text.rfind('.');
    if (text.find_first_not_of("+-.,0123456789") != std::string::npos || (comma == point)) {
        return; // no number, or neither sign
    }
    const bool has_both = comma != std::string::npos && point != std::string::npos;
    const char last = has_both ? (comma > point ? ',' : '.') : comma != std::string::npos ? ',' : '.';
    Sight& sight = (!has_both && is_grouped(text, last) ? doubtful_ : seen_)[last == ',' ? 0 : 1];
    if (sight.line == 0) {
        sight = {line, std::string(column), std::string(cell)};
    }
}

char Decimals::sign(const std::string& file) const {
    const auto& [comma, point] = seen_;
    if (comma.line > 0 && point.line > 0) {
        const Sight& second = comma.line > point.line ? comma : point;
        const Sight& first = comma.line > point.line ? point : comma;
        throw pave::Error(
            {.file = file, .line = second.line, .key = second.column}, "decimal points and decimal commas in one table",
            fmt::format("\"{}\", and \"{}\" in line {}, {}", second.cell, first.cell, first.line, first.column),
            "one of them");
    }
    if (comma.line > 0 || point.line > 0) {
        return comma.line > 0 ? ',' : '.';
    }
    // "1,234": thousands where commas part the cells, decimals where they do not; "1.234" alone is a decimal point.
    return doubtful_[0].line > 0 && !comma_parts_cells_ ? ',' : '.';
}

std::string Decimals::doubt() const {
    const Sight& point = doubtful_[1];
    const bool is_told = seen_[0].line > 0 || seen_[1].line > 0 || doubtful_[0].line > 0 || comma_parts_cells_;
    return is_told || point.line == 0
               ? ""
               : fmt::format("line {}, {}: \"{}\": thousands or decimals? It is read with a decimal point", point.line,
                             point.column, point.cell);
}

std::string with_point(std::string_view cell, char decimal) {
    std::string text = without_blanks(with_plain_letters(cell));
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

} // namespace explore::data
