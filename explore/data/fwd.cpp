#include "data/fwd.h"

#include "base/windows_1252.h"
#include "data/csv.h"
#include "data/fwd_csv.h"
#include "data/fwd_f25.h"
#include "data/fwd_kuab.h"
#include "data/fwd_lines.h"
#include "data/fwd_ltpp.h"
#include "data/fwd_pddx.h"
#include "data/fwd_places.h"
#include "data/fwd_primax.h"
#include "data/fwd_r80.h"
#include "data/fwd_table.h"
#include "data/fwd_values.h"
#include "data/workbook.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fmt/format.h>
#include <set>

namespace explore::data {

std::span<const FwdFormat> fwd_formats() {
    static constexpr FwdFormat all[] = {
        fwd_f25, fwd_pddx, fwd_ltpp, fwd_primax, fwd_kuab, fwd_r80, fwd_csv,
    };
    return all;
}

FwdFile with_drops(FwdFile read, const std::string& file, std::string_view allowed) {
    if (std::all_of(read.stations.begin(), read.stations.end(),
                    [](const FwdStation& s) { return s.drops.empty() && s.unusable == no_drops; })) {
        throw pave::Error({.file = file}, "the file holds no drops", {}, std::string(allowed));
    }
    return read;
}

void take_pressure(FwdDrop& drop, double pressure_kPa, std::string_view where, FwdStation& station) {
    if (drop.force_kN && !(std::abs(drop.pressure_kPa / pressure_kPa - 1.0) <= 0.05)) {
        station.remarks.push_back(
            fmt::format("{}: {:g} kN on this plate are {:.0f} kPa, the line states {:g} kPa, which "
                        "is taken",
                        where, *drop.force_kN, drop.pressure_kPa, pressure_kPa));
    }
    drop.pressure_kPa = pressure_kPa;
    drop.force_kN.reset();
}

void set_position(FwdStation& station, std::string_view latitude, std::string_view longitude) {
    const auto north = degrees(latitude);
    const auto east = degrees(longitude);
    for (const auto& [text, read] : {std::pair{latitude, north}, std::pair{longitude, east}}) {
        if (!read && !is_nil(text)) {
            station.remarks.push_back(fmt::format("\"{}\" is no position on the globe", text));
            return;
        }
    }
    set_position(station, north, east);
}

void set_position(FwdStation& station, std::optional<double> latitude, std::optional<double> longitude) {
    if (latitude == 0.0 && longitude == 0.0) {
        return;
    }
    const double north = latitude.value_or(0.0);
    const double east = longitude.value_or(0.0);
    if (std::abs(north) > 90.0 || std::abs(east) > 180.0) {
        station.remarks.push_back(fmt::format("latitude {:.10g}, longitude {:.10g} is no position on the globe in "
                                              "degrees{}",
                                              north, east,
                                              std::abs(north) > 200.0 ? ": degrees and minutes (ddmm.mmm)?" : ""));
        return;
    }
    station.latitude = latitude;
    station.longitude = longitude;
}

namespace {

// A text that holds no drops at all, in a sentence of its own.
void refuse_others(std::string_view text, const std::string& file) {
    if (trimmed(text).empty() || text.find_first_not_of(" \t\r\n") == std::string_view::npos) {
        throw pave::Error({.file = file}, "this file is empty", {}, "a file with FWD drops");
    }
    const std::string head = lower_case(text.substr(0, 1000));
    if (is_archive(text) ||
        text.starts_with("\xc3\x90\xc3\x8f\x11\xc3\xa0")) { // the signs of zip archives and of compound files
        throw pave::Error({.file = file}, "this is a workbook or another packed file, not text", {},
                          "a table saved as CSV by the spreadsheet");
    }
    if (head.find("<html") != std::string::npos || head.find("<table") != std::string::npos ||
        head.find("<?xml") != std::string::npos) {
        throw pave::Error({.file = file}, "this is a page (HTML or XML), whatever its name says", {},
                          "a table saved as CSV by the spreadsheet");
    }
}

// The first line that holds something, cut for a message.
std::string first_words(std::string_view text) {
    constexpr std::size_t shown = 60;
    text.remove_prefix(std::min(text.find_first_not_of(" \t\r\n"), text.size()));
    const std::string_view line = trimmed(text.substr(0, text.find_first_of("\r\n")));
    std::size_t end = std::min(shown, line.size());
    while (end < line.size() && (static_cast<unsigned char>(line[end]) & 0xc0U) == 0x80U) {
        ++end; // not inside a character
    }
    return "\"" + std::string(line.substr(0, end)) + (end < line.size() ? "...\"" : "\"");
}

// Letters beyond ASCII of Windows-1252 stand alone or in twos among others; in longer runs they are another encoding's,
// read as that.
bool is_misread(std::string_view text) {
    constexpr std::size_t long_run = 3;
    std::size_t letters = 0;
    std::size_t runs = 0;
    std::size_t run = 0;
    std::size_t longest = 0;
    for (std::size_t i = 0; i < text.size();) {
        const auto byte = static_cast<unsigned char>(text[i]);
        const std::size_t length = byte < 0x80U ? 1 : byte < 0xe0U ? 2 : byte < 0xf0U ? 3 : 4;
        if (byte < 0x80U) {
            run = 0;
        } else if (byte < 0xc4U || pave::is_of_windows_1252(text.substr(i, length))) {
            runs += run == 0 ? 1 : 0;
            ++letters;
            longest = std::max(longest, ++run);
        } else {
            return false; // beyond Windows-1252: the text was UTF-8
        }
        i += length;
    }
    return letters >= 2 && letters >= 2 * runs && longest >= long_run;
}

// A sensor that no station read is remarked once, one that others read at the station.
void say_what_was_not_read(FwdFile& file, const std::string& name) {
    std::set<double> read;
    std::set<double> silent;
    for (const FwdStation& station : file.stations) {
        for (const FwdDrop& drop : station.drops) {
            for (const FwdReading& reading : drop.readings) {
                read.insert(reading.offset_mm);
            }
            silent.insert(drop.not_read_mm.begin(), drop.not_read_mm.end());
        }
    }
    for (const double offset : silent) {
        if (!read.contains(offset)) {
            file.remarks.push_back(fmt::format("{}: the sensor at {:g} mm was never read", name, offset));
        }
    }
    for (FwdStation& station : file.stations) {
        for (FwdDrop& drop : station.drops) {
            drop.not_read_mm.erase(std::remove_if(drop.not_read_mm.begin(), drop.not_read_mm.end(),
                                                  [&](double offset) { return !read.contains(offset); }),
                                   drop.not_read_mm.end());
        }
    }
}

// Files of devices name their stations by their places: numbers in metres and sums in one file, as in a table.
void read_places(FwdFile& file, const std::string& name) {
    std::vector<std::string> cells;
    for (const FwdStation& s : file.stations) {
        if (s.chainage_m && *s.chainage_m != chainage(s.name, 1.0)) {
            return; // in another unit
        }
        cells.push_back(s.name);
    }
    const Places places(cells, {}, 1.0, false);
    if (places.remark().empty()) {
        return;
    }
    file.remarks.push_back(name + ": " + places.remark());
    for (FwdStation& s : file.stations) {
        s.chainage_m = s.chainage_m ? places.metres(s.name) : s.chainage_m;
    }
}

// The text of a file; of a workbook the first sheet that holds a survey table.
std::string text_of(const std::string& file, const ColumnMap& columns) {
    std::string text = read_file(file, "FWD file", Encoding::of_instruments);
    const auto sheets = is_archive(text) ? sheets_of(file) : std::nullopt;
    if (!sheets) {
        return text;
    }
    std::vector<std::string> names;
    for (const Sheet& sheet : *sheets) {
        if (has_fwd_table(sheet.csv, columns)) {
            return sheet.csv;
        }
        names.push_back(sheet.name);
    }
    throw pave::Error({.file = file}, "no sheet of this workbook holds a survey table", pave::join(names),
                      std::string(fwd_csv.sign) + " (--columns takes names of its own)");
}

constexpr const char* misread_words =
    "the letters beyond ASCII are neither UTF-8 nor Windows-1252 (GBK, Windows-1251?): "
    "texts come out wrong; a file saved "
    "as UTF-8 is read right";

} // namespace

FwdFile read_fwd(const std::string& file, const ColumnMap& columns) {
    const std::string text = text_of(file, columns);
    const bool misread = is_misread(text);
    refuse_others(text, file);
    std::string signs;
    const bool is_table = text.substr(0, text.find('\n')).find_first_of(",;\t|") != std::string::npos;
    for (const FwdFormat& format : fwd_formats()) {
        if (format.recognises(text, columns)) {
            FwdFile read = format.read(text, file, columns);
            read.inputs.insert(read.inputs.begin(), {file, text});
            if (misread) {
                read.remarks.push_back(file + ": " + misread_words);
            }
            if (!columns.empty() && format.name != fwd_csv.name) {
                read.remarks.push_back(
                    fmt::format("{}: --columns describes tables and is not used for {}", file, format.name));
            }
            say_what_was_not_read(read, file);
            if (format.name != fwd_csv.name) {
                read_places(read, file);
            }
            return read;
        }
        if (is_table && format.name == fwd_csv.name) {
            continue; // said first
        }
        signs += (signs.empty() ? "" : "; ") + std::string(format.name) + ": " + std::string(format.sign);
    }
    throw pave::Error({.file = file}, "this is not an FWD file of a known format",
                      first_words(text) +
                          (is_table ? "; no line of the first 30 names two columns of a survey table" : "") +
                          (misread ? std::string("; ") + misread_words : ""),
                      (is_table ? std::string(fwd_csv.sign) + " (--columns takes names of its own); " : "") + signs);
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
            throw pave::Error(place, "this column appears twice", "\"" + name + "\"", "each once");
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
