#include "data/fwd.h"

#include "data/csv.h"
#include "data/fwd_csv.h"
#include "data/fwd_f25.h"
#include "data/fwd_kuab.h"
#include "data/fwd_lines.h"
#include "data/fwd_ltpp.h"
#include "data/fwd_pddx.h"
#include "data/fwd_primax.h"
#include "data/fwd_r80.h"

#include <algorithm>
#include <filesystem>

namespace explore::data {

std::span<const FwdFormat> fwd_formats() {
    static constexpr FwdFormat all[] = {
        fwd_f25, fwd_pddx, fwd_ltpp, fwd_primax, fwd_kuab, fwd_r80, fwd_csv,
    };
    return all;
}

FwdFile with_drops(FwdFile read, const std::string& file, std::string_view allowed) {
    if (read.stations.empty()) {
        throw pave::Error({.file = file}, "the file holds no drops", {}, std::string(allowed));
    }
    return read;
}

FwdFile read_fwd(const std::string& file, const ColumnMap& columns) {
    const std::string text = read_file(file, "FWD file", Encoding::of_instruments);
    std::string signs;
    for (const FwdFormat& format : fwd_formats()) {
        if (format.recognises(text, columns)) {
            FwdFile read = format.read(text, file, columns);
            read.inputs.insert(read.inputs.begin(), {file, text});
            return read;
        }
        signs += (signs.empty() ? "" : "; ") + std::string(format.name) + ": " + std::string(format.sign);
    }
    throw pave::Error({.file = file}, "this is not an FWD file of a known format", {}, signs);
}

ColumnMap read_column_map(const std::string& list_or_file) {
    std::error_code error;
    const bool is_file = std::filesystem::exists(list_or_file, error) || list_or_file.find('=') == std::string::npos;
    std::string text = is_file ? read_file(list_or_file, "list of columns", Encoding::of_instruments) : list_or_file;
    if (!is_file) {
        std::replace_if(
            text.begin(), text.end(), [](char c) { return c == ',' || c == ';'; }, '\n');
    }
    ColumnMap map;
    for_each_line(text, [&](std::string_view line, int number) {
        const std::string_view entry = trimmed(line);
        if (entry.empty() || entry[0] == '#') {
            return;
        }
        const pave::Place place =
            is_file ? pave::Place{.file = list_or_file, .line = number} : pave::Place{.key = "--columns"};
        const std::size_t equals = entry.find('=');
        if (equals == std::string_view::npos || trimmed(entry.substr(0, equals)).empty() ||
            trimmed(entry.substr(equals + 1)).empty()) {
            throw pave::Error(place, "this is no entry of a list of columns", "\"" + std::string(entry) + "\"",
                              "a column as this program names it = the file's own name of it, or a number: "
                              "load_kN = Force, D0_um = D1, radius_mm = 150");
        }
        const std::string name(trimmed(entry.substr(0, equals)));
        if (!map.try_emplace(name, trimmed(entry.substr(equals + 1))).second) {
            throw pave::Error(place, "this column stands twice", "\"" + name + "\"", "each once");
        }
    });
    return map;
}

std::vector<FwdFile> read_fwd_files(const std::vector<std::string>& files, const std::string& columns) {
    const ColumnMap map = columns.empty() ? ColumnMap{} : read_column_map(columns);
    std::vector<FwdFile> read;
    read.reserve(files.size());
    for (const std::string& file : files) {
        read.push_back(read_fwd(file, map));
    }
    return read;
}

} // namespace explore::data
