#include "data/fwd_r80.h"

#include "data/csv.h"
#include "data/fwd_lines.h"
#include "data/fwd_values.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <utility>

namespace explore::data {
namespace {

constexpr int offsets_line = 3;
constexpr int header_lines = 9; // up to the load cell: the first and the last station are among them

constexpr std::size_t sensors = 7;
constexpr std::size_t width = 4; // columns of a field, whose number stands at its right

// Fields to the end of the line, without the blanks around them.
std::vector<std::string_view> fields_of(std::string_view line) {
    std::vector<std::string_view> fields;
    for (std::size_t at = 0; at < line.size(); at += width) {
        fields.push_back(trimmed(line.substr(at, width)));
    }
    return fields;
}

// Numbers with the same count of decimals that touch: "821.00115.20" after the two behind each point.
std::vector<std::string_view> split_decimals(std::string_view line) {
    constexpr std::size_t decimals = 2;
    std::vector<std::string_view> numbers;
    for (std::size_t begin = 0;;) {
        begin = line.find_first_not_of(" \t", begin);
        const std::size_t point = begin == std::string_view::npos ? begin : line.find('.', begin);
        if (point == std::string_view::npos) {
            return numbers;
        }
        const std::size_t end = std::min(point + 1 + decimals, line.size());
        numbers.push_back(line.substr(begin, end - begin));
        begin = end;
    }
}

class R80Reader {
public:
    explicit R80Reader(std::string file) : file_(std::move(file)) {}

    void take(std::string_view line, int number) {
        if (number == offsets_line) {
            take_offsets(line, number);
        }
        if (number <= header_lines) {
            return;
        }
        if (line.starts_with('G')) {
            take_position(line);
        } else if (line.starts_with('S')) {
            begin_station(line, number);
        } else if (is_open_ && !trimmed(line).empty() && (line[0] == ' ' || (line[0] >= '0' && line[0] <= '9'))) {
            take_drop(line, number);
        }
    }

    FwdFile file() && {
        close_station();
        return with_drops(std::move(result_), file_,
                          "after the header, lines S with a station and lines of pressure and deflections");
    }

private:
    void take_offsets(std::string_view line, int number) {
        // Some writers leave out the blanks before the radius: the fields are counted from its end.
        const pave::Place place{.file = file_, .line = number, .key = "plate radius and offsets"};
        const std::size_t begin = std::min(line.find_first_not_of(' '), line.size());
        const std::size_t end = std::min(line.find(' ', begin), line.size());
        radius_mm_ = measured(line.substr(begin, end - begin));
        for (const std::string_view field : fields_of(line.substr(end, sensors * width))) {
            if (const auto mm = measured(field)) {
                offsets_mm_.push_back(*mm);
            } else if (!field.empty()) {
                throw pave::Error(place, "not a number", "\"" + std::string(field) + "\"", "mm in fields of 4 columns");
            }
        }
        if (offsets_mm_.empty()) {
            throw pave::Error(place, "there is no sensor", {}, "mm in fields of 4 columns");
        }
    }

    // G, seven digits, latitude and longitude each with its sign, the height.
    void take_position(std::string_view line) {
        const std::size_t first = line.find_first_of("+-", 1);
        const std::size_t second = first == std::string_view::npos ? first : line.find_first_of("+-", first + 1);
        if (second == std::string_view::npos) {
            return;
        }
        std::string_view longitude = trimmed(line.substr(second));
        longitude = longitude.ends_with("999.9") ? longitude.substr(0, longitude.size() - 5) : longitude; // no height
        latitude_ = line.substr(first, second - first);
        longitude_ = longitude;
    }

    // A station without drops is one that nothing can be made of.
    void close_station() {
        if (is_open_ && is_new_) {
            station_.unusable = no_drops;
            result_.stations.push_back(station_);
        }
    }

    void begin_station(std::string_view line, int number) {
        close_station();
        const std::string_view where = trimmed(line.substr(1, 9));
        station_ = {.name = std::string(where), .lane = {}, .chainage_m = chainage(where, 1.0), .file = file_};
        if (!station_.chainage_m) {
            station_.remarks.push_back(fmt::format("line {}: \"{}\" is no chainage", number, where));
        }
        const std::string_view rest = line.substr(std::min<std::size_t>(line.size(), 10));
        const std::size_t mark = rest.find('I');
        const auto temperatures = words_of(rest.substr(0, mark));
        const auto temperature = [&](std::size_t i) {
            return i < temperatures.size() ? measured(temperatures[i]) : std::nullopt;
        };
        station_.air_C = temperature(0);
        station_.surface_C = temperature(1);
        station_.asphalt_C = temperature(2);
        if (mark != std::string_view::npos) {
            station_.time = std::string(trimmed(rest.substr(std::min(mark + 2, rest.size()), 4)));
        }
        station_.line = number;
        set_position(station_, std::exchange(latitude_, {}), std::exchange(longitude_, {}));
        is_open_ = true;
        is_new_ = true;
    }

    void take_drop(std::string_view line, int number) {
        const std::size_t n = offsets_mm_.size() + 1;
        auto values = words_of(line);
        std::string padded;
        if (line.find('.') != std::string_view::npos) {
            values = values.size() >= n ? values : split_decimals(line);
        } else {
            // The last number ends a field; what is missing before the first are blanks that a writer left out.
            const std::size_t length = line.find_last_not_of(' ') + 1;
            padded = std::string((width - length % width) % width, ' ') + std::string(line.substr(0, length));
            values = fields_of(padded);
        }
        const auto value = [&](std::size_t i) { return i < values.size() ? measured(values[i]) : std::nullopt; };
        if (is_new_) {
            station_.line = number;
            result_.stations.push_back(station_);
            is_new_ = false;
        }
        FwdStation& station = result_.stations.back();
        FwdDrop drop{.number = static_cast<int>(station.drops.size()) + 1,
                     .radius_mm = radius_mm_.value_or(NAN),
                     .pressure_kPa = value(0).value_or(NAN),
                     .readings = {}};
        drop.line = number;
        for (std::size_t i = 1; i < n; ++i) {
            if (const auto deflection = value(i)) {
                drop.readings.push_back({offsets_mm_[i - 1], *deflection});
            } else {
                drop.not_read_mm.push_back(offsets_mm_[i - 1]);
            }
        }
        station.drops.push_back(std::move(drop));
    }

    std::string file_;
    std::optional<double> radius_mm_;
    std::vector<double> offsets_mm_;
    std::string latitude_, longitude_; // of the next station
    FwdStation station_;
    bool is_open_ = false; // there is a station
    bool is_new_ = false;  // without a drop so far
    FwdFile result_;
};

} // namespace

bool recognises_fwd_r80(std::string_view text, const ColumnMap& /*columns*/) {
    return text.starts_with("R80");
}

FwdFile read_fwd_r80(std::string_view text, const std::string& file, const ColumnMap& /*columns*/) {
    constexpr char end_of_file = '\x1a'; // of old systems
    R80Reader reader(file);
    for_each_line(text.substr(0, text.find(end_of_file)),
                  [&](std::string_view line, int number) { reader.take(line, number); });
    return std::move(reader).file();
}

} // namespace explore::data
