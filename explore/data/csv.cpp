#include "data/csv.h"

#include "base/text.h"
#include "data/near_file.h"

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>

namespace explore::data {

std::vector<CsvRow> parse_csv(std::string_view text, const std::string& file, char separator, Comments comments) {
    if (text.starts_with("\xef\xbb\xbf")) {
        text.remove_prefix(3);
    }
    std::vector<CsvRow> rows;
    int line = 1;
    std::size_t i = 0;
    while (i < text.size()) {
        if (text[i] == '#' && (comments == Comments::anywhere)) {
            i = std::min(text.find('\n', i), text.size() - 1) + 1;
            ++line;
            continue;
        }
        CsvRow row{line, {""}};
        bool row_is_blank = true;
        for (bool in_row = true; in_row;) {
            if (i >= text.size()) {
                break;
            }
            const char c = text[i];
            if (c == '"' && row.cells.back().empty()) {
                const int opened = line;
                ++i;
                for (;; ++i) {
                    if (i >= text.size()) {
                        throw pave::Error({.file = file, .line = opened}, "a quoted cell is never closed", {},
                                          "a closing \" before the end of the file");
                    }
                    if (text[i] == '"') {
                        if (i + 1 < text.size() && text[i + 1] == '"') {
                            ++i;
                        } else {
                            break;
                        }
                    }
                    line += text[i] == '\n' ? 1 : 0;
                    row.cells.back() += text[i];
                }
                ++i;
                row_is_blank = false;
            } else if (c == separator) {
                row.cells.emplace_back();
                row_is_blank = false;
                ++i;
            } else if (c == '\n') {
                in_row = false;
                ++line;
                ++i;
            } else {
                if (c != '\r') {
                    row.cells.back() += c;
                    row_is_blank = row_is_blank && (c == ' ' || c == '\t');
                }
                ++i;
            }
        }
        if (!row_is_blank) {
            rows.push_back(std::move(row));
        }
    }
    return rows;
}

namespace {

// The first line that is neither blank nor a comment.
std::string_view header_line(std::string_view text) {
    while (!text.empty()) {
        const std::size_t end = std::min(text.find('\n'), text.size());
        const std::string_view line = text.substr(0, end);
        if (!line.starts_with('#') && line.find_first_not_of(" \t\r") != std::string_view::npos) {
            return line;
        }
        text.remove_prefix(std::min(end + 1, text.size()));
    }
    return text;
}

// Which of these characters the line has most of, quoted cells aside; of as many the first.
char most_frequent(std::string_view line, std::string_view characters) {
    std::vector<int> counts(characters.size(), 0);
    bool quoted = false;
    for (const char c : line) {
        quoted = quoted != (c == '"');
        const std::size_t at = characters.find(c);
        if (!quoted && at != std::string_view::npos) {
            ++counts[at];
        }
    }
    return characters[static_cast<std::size_t>(std::max_element(counts.begin(), counts.end()) - counts.begin())];
}

// The cell with a full stop in place of its one comma, where that makes it a number.
std::optional<std::string> with_full_stop(std::string_view cell) {
    const std::size_t comma = cell.find(',');
    if (comma == std::string_view::npos || cell.find(',', comma + 1) != std::string_view::npos) {
        return std::nullopt;
    }
    std::string number(cell);
    number[comma] = '.';
    return number_or_nothing(number) ? std::optional(number) : std::nullopt;
}

} // namespace

CsvTable parse_table(std::string_view text, const std::string& file) {
    if (text.starts_with("\xef\xbb\xbf")) {
        text.remove_prefix(3);
    }
    CsvTable table;
    const std::string_view first = header_line(text);
    constexpr std::string_view announced = "sep=";
    constexpr std::string_view separators = ",;\t|";
    const bool is_announced = first.starts_with(announced) && first.size() > announced.size() &&
                              separators.find(first[announced.size()]) != std::string_view::npos &&
                              first.find_first_not_of(" \t\r", announced.size() + 1) == std::string_view::npos;
    table.separator = is_announced ? first[announced.size()] : most_frequent(first, separators);
    table.rows = parse_csv(text, file, table.separator);
    if (is_announced) {
        table.rows.erase(table.rows.begin());
    }
    std::size_t full_stops = 0; // numbers with either; the rarer is the mistake
    std::size_t commas = 0;
    for (std::size_t r = 1; r < table.rows.size(); ++r) {
        for (const std::string& cell : table.rows[r].cells) {
            const std::string_view bare = trimmed(cell);
            full_stops += number_or_nothing(bare) && bare.find('.') != std::string_view::npos ? 1 : 0;
            commas += with_full_stop(bare) ? 1 : 0;
        }
    }
    table.decimal_comma = table.separator != ',' && commas > full_stops;
    return table;
}

double CsvTable::number(std::string_view cell, const pave::Place& place) const {
    if (!decimal_comma) {
        return finite_number(cell, place);
    }
    if (cell.find('.') != std::string_view::npos) {
        throw pave::Error(place, "a full stop among numbers with decimal commas", "\"" + std::string(cell) + "\"",
                          "one decimal sign in a file");
    }
    const auto converted = with_full_stop(cell);
    return finite_number(converted ? std::string_view(*converted) : cell, place);
}

std::string csv_cell(std::string_view text) {
    if (text.find_first_of(",\"\r\n") == std::string_view::npos && !text.starts_with('#')) {
        return std::string(text);
    }
    std::string cell = "\"";
    for (const char c : text) {
        cell += c;
        if (c == '"') {
            cell += c;
        }
    }
    return cell + "\"";
}

std::string_view trimmed(std::string_view cell) {
    const auto first = cell.find_first_not_of(" \t");
    const auto last = cell.find_last_not_of(" \t");
    return first == std::string_view::npos ? std::string_view{} : cell.substr(first, last - first + 1);
}

namespace {

// Of a code point of two bytes in UTF-8; others stay.
unsigned lower_letter(unsigned letter) {
    const auto lies = [&](unsigned first, unsigned last) { return letter >= first && letter <= last; };
    if ((lies(0xc0, 0xde) && letter != 0xd7) || (lies(0x391, 0x3a9) && letter != 0x3a2) || lies(0x410, 0x42f)) {
        return letter + 0x20;
    }
    if (lies(0x400, 0x40f)) {
        return letter + 0x50;
    }
    if ((lies(0x100, 0x12f) || lies(0x132, 0x137) || lies(0x14a, 0x177)) && letter % 2 == 0) {
        return letter + 1;
    }
    return (lies(0x139, 0x148) || lies(0x179, 0x17e)) && letter % 2 == 1 ? letter + 1 : letter;
}

} // namespace

std::string lower_case(std::string_view text) {
    std::string out(text);
    for (std::size_t i = 0; i < out.size(); ++i) {
        const auto c = static_cast<unsigned char>(out[i]);
        if (c < 0x80U) {
            out[i] = static_cast<char>(std::tolower(c));
        } else if ((c & 0xe0U) == 0xc0U && i + 1 < out.size()) { // of two bytes: Latin, Greek, Cyrillic
            const unsigned letter = lower_letter((c & 0x1fU) << 6U | (static_cast<unsigned char>(out[i + 1]) & 0x3fU));
            out[i] = static_cast<char>(0xc0U | letter >> 6U);
            out[++i] = static_cast<char>(0x80U | (letter & 0x3fU));
        }
    }
    return out;
}

namespace {

std::optional<double> parsed(std::string_view cell) {
    double result = 0.0;
    const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), result);
    return error == std::errc() && end == cell.data() + cell.size() ? std::optional(result) : std::nullopt;
}

[[noreturn]] void complain_of(std::string_view cell, const pave::Place& place) {
    throw pave::Error(place, "not a number", "\"" + std::string(cell) + "\"", "a finite decimal number");
}

} // namespace

double any_number(std::string_view cell, const pave::Place& place) {
    const auto result = parsed(cell);
    if (!result) {
        complain_of(cell, place);
    }
    return *result;
}

std::optional<double> number_or_nothing(std::string_view cell) {
    const auto result = parsed(cell);
    return result && std::isfinite(*result) ? result : std::nullopt;
}

double finite_number(std::string_view cell, const pave::Place& place) {
    const auto result = number_or_nothing(cell);
    if (!result) {
        complain_of(cell, place);
    }
    return *result;
}

namespace {

std::string with_plain_blanks(std::string_view text) {
    std::string out;
    out.reserve(text.size());
    for (std::size_t i = 0; i < text.size();) {
        std::size_t length = 0;
        if (static_cast<unsigned char>(text[i]) >= 0x80U) {
            for (const std::string_view blank : {"\u00a0", "\u2007", "\u2009", "\u202f", "\u3000"}) {
                length = text.substr(i).starts_with(blank) ? blank.size() : length;
            }
        }
        out += length > 0 ? ' ' : text[i];
        i += std::max<std::size_t>(length, 1);
    }
    return out;
}

} // namespace

std::string read_file(const std::string& file, std::string_view what, Encoding encoding) {
    const std::string problem = "cannot read this " + std::string(what);
    std::error_code error;
    const auto status = std::filesystem::status(file, error);
    if (error) {
        throw pave::Error({.file = file}, problem + near_file_words(file), error.message());
    }
    if (!std::filesystem::is_regular_file(status)) { // opening a pipe would wait, reading a device may never end
        throw pave::Error({.file = file}, problem,
                          std::filesystem::is_directory(status) ? "a folder" : "a pipe or a device", "a regular file");
    }
    std::ifstream stream(file, std::ios::binary);
    if (!stream) {
        throw pave::Error({.file = file}, problem, std::strerror(errno));
    }
    std::ostringstream stored;
    stored << stream.rdbuf();
    std::string text = stored.str();
    if (encoding == Encoding::of_instruments) {
        text = pave::utf16_to_utf8(std::move(text));
        std::replace(text.begin(), text.end(), '\0', ' ');
        text = pave::to_utf8(std::move(text));
        if (text.starts_with("\xef\xbb\xbf")) {
            text.erase(0, 3);
        }
        text = with_plain_blanks(text);
    }
    if (encoding == Encoding::bytes) {
        return text;
    }
    if (text.find('\n') == std::string::npos) {
        std::replace(text.begin(), text.end(), '\r', '\n');
    }
    if (const std::size_t at = pave::first_not_utf8(text); at != std::string::npos) {
        const auto line = 1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(at), '\n');
        throw pave::Error({.file = file, .line = static_cast<int>(line)}, "this is not text in UTF-8",
                          text.substr(at, 1).find('\0') == 0 ? "a byte that is zero" : text.substr(at, 1),
                          "text in UTF-8");
    }
    return text;
}

bool is_same_file(const std::string& a, const std::string& b) {
    const std::filesystem::path one(a);
    const std::filesystem::path other(b);
    std::error_code error;
    return one.lexically_normal() == other.lexically_normal() || std::filesystem::equivalent(one, other, error);
}

} // namespace explore::data
