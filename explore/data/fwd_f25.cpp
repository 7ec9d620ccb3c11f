#include "data/fwd_f25.h"

#include "data/csv.h"
#include "data/fwd_lines.h"
#include "data/fwd_values.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fmt/format.h>

namespace explore::data {
namespace {

constexpr int file_line = 5001;
constexpr int plate_and_x = 5020;
constexpr int diameter_and_y = 5021;
constexpr int position_line = 5280;
constexpr int station_line = 5301;
constexpr int comment_line = 5302;
constexpr int temperature_line = 5303;
constexpr int last_drop = 999; // larger numbers are objects or samples of a time history

// Cells of one line; quotes keep commas in a text and end with the line.
std::vector<std::string> cells_of(std::string_view line) {
    std::vector<std::string> cells(1);
    bool is_quoted = false;
    for (const char c : line) {
        if (c == '"') {
            is_quoted = !is_quoted;
        } else if (c == ',' && !is_quoted) {
            cells.emplace_back();
        } else if (c != '\r') {
            cells.back() += c;
        }
    }
    for (std::string& cell : cells) {
        cell = std::string(trimmed(cell));
    }
    return cells;
}

// What one line holds, and where it stands.
struct Line {
    std::vector<std::string> cells;
    std::string file;
    int number = 0;

    pave::Place place(std::string_view what) const { return {.file = file, .line = number, .key = std::string(what)}; }
    const std::string& cell(std::size_t i, std::string_view what) const {
        if (i >= cells.size()) {
            throw pave::Error(place(what), "the line is too short", fmt::format("{} values", cells.size()),
                              fmt::format("at least {}", i + 1));
        }
        return cells[i];
    }
    double value(std::size_t i, std::string_view what) const { return finite_number(cell(i, what), place(what)); }
    // Of what was measured: nothing where the line is short, and for N0 and what else is not a number.
    std::optional<double> reading(std::size_t i) const { return i < cells.size() ? measured(cells[i]) : std::nullopt; }
    std::string text(std::size_t i) const { return i < cells.size() ? cells[i] : std::string(); }
    std::optional<int> id() const {
        int id = 0;
        const std::string& first = cells[0];
        const auto [end, error] = std::from_chars(first.data(), first.data() + first.size(), id);
        return error == std::errc() && end == first.data() + first.size() ? std::optional(id) : std::nullopt;
    }
};

// Metres in the unit of a station; nothing: unknown.
std::optional<double> station_unit(const Line& line) {
    if (line.reading(3) == 1.0) { // kind: metric, in metres
        return 1.0;
    }
    constexpr std::pair<double, double> units[] = {{2, 1.0},    {3, 1000.0},   {4, 1000.0},   {5, 0.3048},
                                                   {6, 0.9144}, {7, 1609.344}, {8, 1609.344}, {9, 1609.344}};
    const auto number = line.reading(4);
    for (const auto& [known, metres] : units) {
        if (number && *number == known) {
            return metres;
        }
    }
    return std::nullopt;
}

struct Sensor {
    std::size_t at; // of its deflection in a drop
    double x_mm, y_mm;
};

class Reader {
public:
    explicit Reader(std::string file) : file_(std::move(file)) {}

    void take(const Line& line) {
        const auto id = line.id();
        if (!id) {
            // Of a time history; or a drop whose number is not to be read.
            if (is_open_ && line.cells.size() > sensors_.size() && readings_of(line) + 1 >= sensors_.size() &&
                sensors_.size() > 1 && line.reading(1) && !line.reading(0)) {
                take_drop(line, std::nullopt);
            }
            return;
        }
        if (*id > file_line && *id < position_line && stations_.empty() && is_new_) {
            is_open_ = is_new_ = false; // the place where the survey ended, which is among the lines of the header
        }
        if (*id == plate_and_x) {
            take_plate(line);
        } else if (*id == diameter_and_y) {
            for (Sensor& sensor : sensors_) {
                sensor.y_mm = line.reading(sensor.at).value_or(0.0); // what is placed along the road stands on its line
            }
            if (const auto diameter = line.reading(1); diameter && !radius_mm_) {
                radius_mm_ = *diameter / 2.0;
            }
        } else if (*id == position_line) {
            position_ = {line.text(3), line.text(4)};
        } else if (*id == station_line) {
            begin_station(line);
        } else if (*id == comment_line && is_open_) {
            station_.comment = line.text(line.cells.size() - 1);
        } else if (*id == temperature_line && is_open_) {
            const bool fahrenheit = line.text(1) == "1";
            const auto temperature = [&](std::size_t i) -> std::optional<double> {
                const auto value = line.reading(i);
                return value && fahrenheit ? std::optional(celsius(*value)) : value;
            };
            station_.asphalt_C = temperature(2);
            station_.surface_C = temperature(3);
            station_.air_C = temperature(4);
        } else if (*id >= 1 && *id <= last_drop) {
            take_drop(line, *id);
        }
    }

    FwdFile file() && {
        close_station();
        return with_drops({std::move(stations_), std::move(remarks_)}, file_,
                          "after a line 5301 lines such as \"1, 574, 434, 396, ...\"");
    }

private:
    void take_plate(const Line& line) {
        radius_mm_ = line.reading(1);
        if (!radius_mm_ && !is_nil(line.cell(1, "plate radius"))) {
            line.value(1, "plate radius");
        }
        sensors_.clear();
        for (std::size_t i = 2; i < line.cells.size(); ++i) {
            if (const auto x = line.reading(i)) {
                sensors_.push_back({i, *x, 0.0});
            } else if (!is_nil(line.cells[i])) {
                remarks_.push_back(fmt::format("{}, line {}: \"{}\" is no place of a sensor, which is left out", file_,
                                               line.number, line.cells[i]));
            }
        }
        if (sensors_.empty()) {
            throw pave::Error(line.place("x of the sensors"), "there is no sensor", {}, "distances in mm");
        }
    }

    std::size_t readings_of(const Line& line) const {
        return static_cast<std::size_t>(std::count_if(sensors_.begin(), sensors_.end(), [&](const Sensor& sensor) {
            return line.reading(sensor.at).has_value();
        }));
    }

    // A station without drops is one that nothing can be made of.
    void close_station() {
        if (is_open_ && is_new_) {
            station_.unusable = no_drops;
            stations_.push_back(station_);
        }
    }

    void begin_station(const Line& line) {
        close_station();
        const auto unit = station_unit(line);
        station_ = {.name = line.text(5), .lane = line.text(8), .file = file_};
        station_.chainage_m = unit ? chainage(line.text(5), *unit) : std::nullopt;
        if (!station_.chainage_m) {
            station_.remarks.push_back(unit ? fmt::format("line {}: \"{}\" is no chainage", line.number, line.text(5))
                                            : fmt::format("line {}: \"{}\" is no unit of a station: 2 (m), 3 or 4 "
                                                          "(km), 5 (feet), 6 (yards), 7 to 9 (miles)",
                                                          line.number, line.text(4)));
        }
        if (line.cells.size() > 11) {
            station_.date = fmt::format("{}-{}-{}", line.text(9), line.text(10), line.text(11));
        }
        if (line.cells.size() > 13) {
            station_.time = fmt::format("{}:{}", line.text(12), line.text(13));
        }
        station_.line = line.number;
        set_position(station_, position_.first, position_.second);
        position_ = {};
        is_open_ = true;
        is_new_ = true;
    }

    // number: nothing: not to be read.
    void take_drop(const Line& line, std::optional<int> number) {
        if (!is_open_) {
            throw pave::Error(line.place("drop"), "a drop before any station", {}, "a line 5301 before it");
        }
        if (sensors_.empty()) {
            throw pave::Error(line.place("drop"), "a drop before the places of the sensors", {},
                              "a line 5020 before it");
        }
        const std::size_t before = is_new_ ? 0 : stations_.back().drops.size();
        FwdDrop drop{.number = number.value_or(static_cast<int>(before) + 1),
                     .radius_mm = radius_mm_.value_or(NAN),
                     .pressure_kPa = line.reading(1).value_or(NAN),
                     .readings = {}};
        drop.line = line.number;
        for (const Sensor& sensor : sensors_) {
            // Behind the plate is where x is negative.
            const double offset = std::copysign(std::hypot(sensor.x_mm, sensor.y_mm), sensor.x_mm);
            if (const auto deflection = line.reading(sensor.at)) {
                drop.readings.push_back({offset, *deflection});
            } else {
                drop.not_read_mm.push_back(offset);
            }
        }
        say_what_has_no_place(line);
        if (is_new_) {
            station_.line = line.number;
            stations_.push_back(station_);
            is_new_ = false;
        }
        if (!number) {
            stations_.back().remarks.push_back(
                fmt::format("line {}: \"{}\" is not a drop number, which is counted as {}", line.number, line.text(0),
                            drop.number));
        }
        stations_.back().drops.push_back(std::move(drop));
    }

    // Readings behind those of the placed sensors; one may be a temperature that writers add.
    void say_what_has_no_place(const Line& line) {
        std::size_t without = 0;
        std::size_t among = 0; // the placed ones
        for (std::size_t i = 2; i < line.cells.size(); ++i) {
            const bool is_placed =
                std::any_of(sensors_.begin(), sensors_.end(), [&](const Sensor& sensor) { return sensor.at == i; });
            without += !is_placed && line.reading(i) ? 1 : 0;
            among += !is_placed && line.reading(i) && i < sensors_.back().at ? 1 : 0;
        }
        if ((without > 1 || among > 0) && !has_said_so_) {
            has_said_so_ = true;
            remarks_.push_back(
                fmt::format("{}, line {}: a drop has {} readings more than line 5020 places sensors; they "
                            "are not used",
                            file_, line.number, without));
        }
    }

    std::string file_;
    std::optional<double> radius_mm_;
    std::vector<Sensor> sensors_;
    std::pair<std::string, std::string> position_; // of the next station: latitude, longitude
    FwdStation station_;
    bool is_open_ = false;     // there is a station
    bool is_new_ = false;      // without a drop so far
    bool has_said_so_ = false; // of readings without a place
    std::vector<FwdStation> stations_;
    std::vector<std::string> remarks_;
};

} // namespace

bool recognises_fwd_f25(std::string_view text, const ColumnMap& /*columns*/) {
    return trimmed(text.substr(0, text.find('\n'))).starts_with("5001,");
}

FwdFile read_fwd_f25(std::string_view text, const std::string& file, const ColumnMap& /*columns*/) {
    constexpr char end_of_file = '\x1a'; // of old systems
    text = text.substr(0, text.find(end_of_file));
    Reader reader(file);
    for_each_line(text, [&](std::string_view line, int number) {
        if (!trimmed(line).empty()) {
            reader.take({cells_of(line), file, number});
        }
    });
    return std::move(reader).file();
}

} // namespace explore::data
