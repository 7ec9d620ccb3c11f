#include "external/outputs.h"

#include "base/error.h"
#include "base/text.h"
#include "data/csv.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <limits>
#include <map>
#include <sstream>
#include <stdexcept>

namespace explore::external {
namespace {

using Json = nlohmann::json;

// A reading that is not where it should be; becomes a Failure.
struct MissingReading : std::runtime_error {
    using std::runtime_error::runtime_error;
};

std::string text_of_output(const std::string& folder, const std::string& name) {
    const auto path = std::filesystem::path(folder) / name;
    std::error_code error;
    if (!std::filesystem::is_regular_file(path, error)) {
        throw MissingReading(fmt::format("the program wrote no {}", name));
    }
    std::ifstream stream(path, std::ios::binary);
    std::ostringstream text;
    text << stream.rdbuf();
    if (!stream) {
        throw MissingReading(fmt::format("{} cannot be read", name));
    }
    return text.str();
}

// As Fortran and C write them: 1.5, 1.5E+03, 1.5D+03, +2.
std::optional<double> number_of_program(std::string text) {
    std::replace(text.begin(), text.end(), 'D', 'e');
    std::replace(text.begin(), text.end(), 'd', 'e');
    const std::string_view bare = std::string_view(text).substr(text.starts_with('+') ? 1 : 0);
    double value = 0.0;
    const auto [end, error] = std::from_chars(bare.data(), bare.data() + bare.size(), value);
    return error == std::errc() && end == bare.data() + bare.size() ? std::optional(value) : std::nullopt;
}

double finite_of_program(const std::string& text, const std::string& label, const std::string& file) {
    const auto value = number_of_program(text);
    if (!value || !std::isfinite(*value)) {
        throw MissingReading(
            fmt::format("{} in {} is \"{}\", which is not a finite number", label, file, pave::printable(text, 40)));
    }
    return *value;
}

std::vector<std::string> lines_of_text(const std::string& text) {
    std::vector<std::string> lines;
    std::istringstream stream(text);
    for (std::string line; std::getline(stream, line);) {
        if (line.ends_with('\r')) {
            line.pop_back();
        }
        lines.push_back(std::move(line));
    }
    return lines;
}

std::vector<std::string> tokens_of(const std::string& line) {
    std::vector<std::string> tokens;
    constexpr std::string_view separators = " \t,;";
    for (std::size_t at = line.find_first_not_of(separators); at != std::string::npos;) {
        const std::size_t end = std::min(line.find_first_of(separators, at), line.size());
        tokens.push_back(line.substr(at, end - at));
        at = line.find_first_not_of(separators, end);
    }
    return tokens;
}

double read_line(const OutputFile& output, const std::string& text, const std::string& label) {
    const std::vector<std::string> lines = lines_of_text(text);
    const Line& wanted = *output.line;
    std::size_t index = wanted.number - 1; // without a marker
    if (!wanted.marker.empty()) {
        const auto holds = [&](const std::string& line) { return line.find(wanted.marker) != std::string::npos; };
        const auto first = std::find_if(lines.begin(), lines.end(), holds);
        const auto last = std::find_if(lines.rbegin(), lines.rend(), holds);
        if (first == lines.end()) {
            throw MissingReading(fmt::format("{} is missing: no line of {} holds \"{}\"", label, output.file,
                                             pave::printable(wanted.marker)));
        }
        index = wanted.number + static_cast<std::size_t>(wanted.last ? lines.rend() - last - 1 : first - lines.begin());
    }
    if (index >= lines.size()) {
        throw MissingReading(fmt::format("{} is missing: {} has {}, and line {} is wanted", label, output.file,
                                         pave::counted(lines.size(), "line", "lines"), index + 1));
    }
    const std::vector<std::string> tokens = tokens_of(lines[index]);
    if (output.column > tokens.size()) {
        throw MissingReading(fmt::format("{} is missing: line {} of {} has {}, and column {} is wanted", label,
                                         index + 1, output.file, pave::counted(tokens.size(), "column", "columns"),
                                         output.column));
    }
    return finite_of_program(tokens[output.column - 1], label, output.file);
}

// Whether a cell of this column says the same as the response.
bool matches(const std::string& column, const std::string& cell, const Wanted& w) {
    if (column == "name") {
        return cell == (w.output.empty() ? w.label : w.output);
    }
    if (column == "load") {
        return cell == w.load;
    }
    if (column == "quantity") {
        return cell == w.quantity;
    }
    const auto value = number_of_program(cell);
    if (column == "time_ms" && !w.time_ms) {
        return cell.empty();
    }
    const double own = column == "x_mm"       ? w.x_mm
                       : column == "y_mm"     ? w.y_mm
                       : column == "depth_mm" ? w.depth_mm
                       : column == "gauge_mm" ? w.gauge_mm
                                              : *w.time_ms;
    constexpr double digits = 1e-9;
    return value && std::abs(*value - own) <= digits * std::max(1.0, std::abs(own));
}

void read_table(const OutputFile& output, const std::string& text, const std::vector<Wanted>& wanted,
                const std::vector<char>& is_named, std::vector<double>& values) {
    data::CsvTable table;
    try {
        table = data::parse_table(text, output.file);
    } catch (const pave::Error& error) {
        throw MissingReading(error.what());
    }
    if (table.rows.empty()) {
        throw MissingReading(fmt::format("{} is empty", output.file));
    }
    const auto& header = table.rows[0].cells;
    const auto column_of = [&](const std::string& name) {
        const auto found = std::find_if(header.begin(), header.end(),
                                        [&](const std::string& cell) { return data::trimmed(cell) == name; });
        if (found == header.end()) {
            throw MissingReading(fmt::format("{} has no column {}", output.file, name));
        }
        return static_cast<std::size_t>(found - header.begin());
    };
    std::vector<std::size_t> keys;
    for (const std::string& name : output.by) {
        keys.push_back(column_of(name));
    }
    const std::size_t value = column_of(output.value_column);
    for (std::size_t i = 0; i < wanted.size(); ++i) {
        if (is_named[i] != 0) {
            continue;
        }
        for (std::size_t r = 1; r < table.rows.size(); ++r) {
            const auto& cells = table.rows[r].cells;
            bool same = cells.size() > value;
            for (std::size_t k = 0; k < keys.size() && same; ++k) {
                same = keys[k] < cells.size() &&
                       matches(output.by[k], std::string(data::trimmed(cells[keys[k]])), wanted[i]);
            }
            if (same) { // of two rows for one reading the later: a program that writes every step ends with it
                values[i] = finite_of_program(std::string(data::trimmed(cells[value])), wanted[i].label, output.file);
            }
        }
    }
}

double number_in_json(const Json& json, const std::string& label, const std::string& file) {
    if (!json.is_number() || !std::isfinite(json.get<double>())) {
        throw MissingReading(fmt::format("{} in {} is {}, which is not a finite number", label, file,
                                         pave::printable(json.dump(-1, ' ', true), 40)));
    }
    return json.get<double>();
}

void read_json(const OutputFile& output, const std::string& text, const std::vector<Wanted>& wanted,
               const std::vector<char>& is_named, std::vector<double>& values) {
    const Json all = Json::parse(text, nullptr, false);
    if (all.is_discarded()) {
        throw MissingReading(fmt::format("{} is not valid JSON", output.file));
    }
    const Json::json_pointer pointer(output.at);
    if (!all.contains(pointer)) {
        throw MissingReading(fmt::format("{} has nothing at {}", output.file, output.at));
    }
    const Json& there = all.at(pointer);
    if (output.reading) {
        values[*output.reading] = number_in_json(there, wanted[*output.reading].label, output.file);
        return;
    }
    std::vector<std::size_t> left;
    for (std::size_t i = 0; i < wanted.size(); ++i) {
        if (is_named[i] == 0) {
            left.push_back(i);
        }
    }
    if (there.is_object()) {
        for (const std::size_t i : left) {
            const auto& w = wanted[i];
            if (const auto found = there.find(w.output.empty() ? w.label : w.output); found != there.end()) {
                values[i] = number_in_json(*found, w.label, output.file);
            }
        }
        return;
    }
    if (!there.is_array() || there.size() != left.size()) {
        throw MissingReading(fmt::format("{} of {} is {}, where a list of {} is wanted",
                                         output.at.empty() ? "the whole" : output.at, output.file,
                                         there.is_array() ? fmt::format("a list of {}", there.size()) : "no list",
                                         pave::counted(left.size(), "reading", "readings")));
    }
    for (std::size_t k = 0; k < left.size(); ++k) {
        values[left[k]] = number_in_json(there[k], wanted[left[k]].label, output.file);
    }
}

} // namespace

std::optional<Line> line_of(const std::string& text) {
    Line line;
    std::string_view rest = data::trimmed(text);
    const auto take = [&](std::string_view word) {
        const bool found = rest.starts_with(word);
        if (found) {
            rest = data::trimmed(rest.substr(word.size()));
        }
        return found;
    };
    const auto [end, error] = std::from_chars(rest.data(), rest.data() + rest.size(), line.number);
    const bool has_number = error == std::errc();
    if (has_number) {
        rest = data::trimmed(rest.substr(static_cast<std::size_t>(end - rest.data())));
        if (line.number == 0 || rest.empty()) {
            return line.number == 0 ? std::nullopt : std::optional(line);
        }
    }
    if (!has_number && take("with ")) {
        line.number = 0;
    } else if (!take("after ")) {
        return std::nullopt;
    }
    line.last = take("last ");
    if (rest.size() < 3 || rest.front() != '\'' || rest.back() != '\'') {
        return std::nullopt;
    }
    line.marker = rest.substr(1, rest.size() - 2);
    return line;
}

const std::vector<std::string>& by_columns() {
    static const std::vector<std::string> all{"name", "load",     "quantity", "x_mm",
                                              "y_mm", "depth_mm", "gauge_mm", "time_ms"};
    return all;
}

pave::Outcome<std::vector<double>> read_outputs(const std::vector<OutputFile>& outputs,
                                                const std::vector<Wanted>& wanted, const std::string& folder) {
    std::vector<double> values(wanted.size(), std::numeric_limits<double>::quiet_NaN());
    std::vector<char> is_named(wanted.size(), 0);
    for (const OutputFile& output : outputs) {
        if (output.reading) {
            is_named[*output.reading] = 1;
        }
    }
    try {
        std::map<std::string, std::string> texts;
        for (const OutputFile& output : outputs) {
            auto text = texts.find(output.file);
            if (text == texts.end()) {
                text = texts.emplace(output.file, text_of_output(folder, output.file)).first;
            }
            if (output.line) {
                values[*output.reading] = read_line(output, text->second, wanted[*output.reading].label);
            } else if (!output.by.empty()) {
                read_table(output, text->second, wanted, is_named, values);
            } else {
                read_json(output, text->second, wanted, is_named, values);
            }
        }
    } catch (const MissingReading& missing) {
        return pave::Failure{pave::Status::failed, missing.what()};
    }
    for (std::size_t i = 0; i < values.size(); ++i) {
        if (std::isnan(values[i])) {
            std::vector<std::string> files;
            for (const OutputFile& output : outputs) {
                if (!output.reading && std::find(files.begin(), files.end(), output.file) == files.end()) {
                    files.push_back(output.file);
                }
            }
            return pave::Failure{pave::Status::failed,
                                 fmt::format("{} is missing in {}", wanted[i].label, pave::join(files))};
        }
    }
    return values;
}

Json outputs_json(const std::vector<OutputFile>& outputs) {
    Json all = Json::array();
    for (const OutputFile& o : outputs) {
        all.push_back({o.file, o.reading ? static_cast<std::int64_t>(*o.reading) : -1,
                       o.line ? Json::array({o.line->number, o.line->marker, o.line->last}) : Json(), o.column, o.by,
                       o.value_column, o.at});
    }
    return all;
}

std::vector<OutputFile> outputs_of(const Json& json) {
    std::vector<OutputFile> outputs;
    for (const Json& j : json) {
        OutputFile o{.file = j.at(0)};
        if (const auto reading = j.at(1).get<std::int64_t>(); reading >= 0) {
            o.reading = static_cast<std::size_t>(reading);
        }
        if (const Json& line = j.at(2); !line.is_null()) {
            o.line = Line{.number = line.at(0), .marker = line.at(1), .last = line.at(2)};
        }
        j.at(3).get_to(o.column);
        j.at(4).get_to(o.by);
        j.at(5).get_to(o.value_column);
        j.at(6).get_to(o.at);
        outputs.push_back(std::move(o));
    }
    return outputs;
}

Json wanted_json(const std::vector<Wanted>& wanted) {
    Json all = Json::array();
    for (const Wanted& w : wanted) {
        all.push_back({w.label, w.load, w.quantity, w.x_mm, w.y_mm, w.depth_mm, w.gauge_mm,
                       w.time_ms ? Json(*w.time_ms) : Json(), w.output});
    }
    return all;
}

std::vector<Wanted> wanted_of(const Json& json) {
    std::vector<Wanted> wanted;
    for (const Json& j : json) {
        Wanted w{.label = j.at(0), .load = j.at(1), .quantity = j.at(2)};
        w.x_mm = j.at(3);
        w.y_mm = j.at(4);
        w.depth_mm = j.at(5);
        w.gauge_mm = j.at(6);
        if (!j.at(7).is_null()) {
            w.time_ms = j.at(7).get<double>();
        }
        j.at(8).get_to(w.output);
        wanted.push_back(std::move(w));
    }
    return wanted;
}

} // namespace explore::external
