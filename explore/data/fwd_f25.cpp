#include "data/fwd_f25.h"

#include "data/csv.h"
#include "data/fwd_lines.h"
#include "data/fwd_values.h"

#include <algorithm>
#include <array>
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
constexpr int history_line = 5185;
constexpr int first_sample = 1001;

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

// The content of one line, and where it stands.
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

struct DropSensor {
    std::size_t at; // of its deflection in a drop
    double x_mm, y_mm;
};

// A time history and whose it is.
struct HistoryBlock {
    std::vector<std::string> station; // what follows the number of a line 5301
    int drop = 0;
    std::size_t samples = 0;
    int line = 0;
    FwdHistory history{};
};

class F25Reader {
public:
    explicit F25Reader(std::string file) : file_(std::move(file)) {}

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
        if (!histories_.empty() &&
            *id == first_sample + static_cast<int>(histories_.back().history.pressure_kPa.size()) &&
            histories_.back().history.pressure_kPa.size() < histories_.back().samples) {
            take_sample(line);
            return;
        }
        if (*id > file_line && *id < position_line && stations_.empty() && is_new_ && *id != history_line) {
            is_open_ = is_new_ = false; // the place where the survey ended, which is among the lines of the header
        }
        if (*id == plate_and_x) {
            take_plate(line);
        } else if (*id == diameter_and_y) {
            for (DropSensor& sensor : sensors_) {
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
        } else if (*id == history_line) {
            begin_history(line);
        } else if (*id >= 1 && *id <= last_drop) {
            take_drop(line, *id);
        }
    }

    FwdFile file() && {
        close_station();
        give_histories();
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
        return static_cast<std::size_t>(std::count_if(sensors_.begin(), sensors_.end(), [&](const DropSensor& sensor) {
            return line.reading(sensor.at).has_value();
        }));
    }

    // A station without drops is one that nothing can be made of.
    void close_station() {
        if (is_open_ && is_new_) {
            station_.unusable = no_drops;
            add_station();
        }
    }

    void add_station() {
        stations_.push_back(station_);
        station_lines_.push_back(station_cells_);
    }

    // Which station and drop it is of, how many samples, the time between them [us], where they are: in the lines that
    // follow (-1) or in a binary file.
    void begin_history(const Line& line) {
        std::vector<std::string> cells(line.cells.begin() + 1, line.cells.end());
        while (!cells.empty() && cells.back().empty()) {
            cells.pop_back();
        }
        constexpr std::size_t own = 4;
        std::array<double, own> numbers{};
        for (std::size_t i = 0; i < own; ++i) {
            const auto number = cells.size() > own ? measured(cells[cells.size() - own + i]) : std::nullopt;
            if (!number) {
                leave_history_out(
                    line.number,
                    "it does not say of which drop it is, how many samples it has or how far apart they are");
                return;
            }
            numbers[i] = *number;
        }
        const auto [drop, samples, step, position] = numbers;
        constexpr double most_samples = 4000.0; // so that their numbers are below those of objects
        if (position != -1.0) {
            leave_history_out(line.number, "it is in a binary file beside this one, which is not read");
        } else if (!(drop >= 1.0 && drop <= last_drop && samples >= 1.0 && samples < most_samples && step > 0.0)) {
            leave_history_out(line.number, fmt::format("{:g} samples {:g} us apart of drop {:g}", samples, step, drop));
        } else {
            cells.resize(cells.size() - own);
            histories_.push_back({.station = cells,
                                  .drop = static_cast<int>(drop),
                                  .samples = static_cast<std::size_t>(samples),
                                  .line = line.number});
            histories_.back().history.step_ms = 1e-3 * step;
            for (const DropSensor& sensor : sensors_) {
                histories_.back().history.offsets_mm.push_back(offset_mm(sensor));
            }
        }
    }

    void leave_history_out(int line, const std::string& why) {
        remarks_.push_back(fmt::format("{}, line {}: this time history is left out: {}", file_, line, why));
    }

    void take_sample(const Line& line) {
        FwdHistory& history = histories_.back().history;
        history.pressure_kPa.push_back(line.reading(1).value_or(NAN));
        for (const DropSensor& sensor : sensors_) {
            history.deflection_um.push_back(line.reading(sensor.at).value_or(NAN));
        }
    }

    // A history may stand before or behind the drops of its station.
    void give_histories() {
        for (HistoryBlock& block : histories_) {
            const auto is_own = [&](const std::vector<std::string>& station) {
                return std::equal(station.begin(),
                                  station.begin() +
                                      static_cast<std::ptrdiff_t>(std::min(station.size(), block.station.size())),
                                  block.station.begin());
            };
            FwdDrop* drop = nullptr;
            for (std::size_t s = 0; s < stations_.size(); ++s) {
                for (FwdDrop& own : stations_[s].drops) {
                    drop = own.number == block.drop && is_own(station_lines_[s]) ? &own : drop;
                }
            }
            const auto& pressures = block.history.pressure_kPa;
            if (drop == nullptr) {
                leave_history_out(block.line, fmt::format("the file has no drop {} at its station", block.drop));
            } else if (pressures.size() < block.samples) {
                leave_history_out(block.line,
                                  fmt::format("it ends after {} of {} samples", pressures.size(), block.samples));
            } else if (std::any_of(pressures.begin(), pressures.end(), [](double p) { return std::isnan(p); })) {
                leave_history_out(block.line, "a sample has no pressure");
            } else {
                drop->history = std::move(block.history);
            }
        }
    }

    // Behind the plate is where x is negative.
    static double offset_mm(const DropSensor& sensor) {
        return std::copysign(std::hypot(sensor.x_mm, sensor.y_mm), sensor.x_mm);
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
        station_cells_.assign(line.cells.begin() + 1, line.cells.end());
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
        for (const DropSensor& sensor : sensors_) {
            const double offset = offset_mm(sensor);
            if (const auto deflection = line.reading(sensor.at)) {
                drop.readings.push_back({offset, *deflection});
            } else {
                drop.not_read_mm.push_back(offset);
            }
        }
        say_what_has_no_place(line);
        if (is_new_) {
            station_.line = line.number;
            add_station();
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
                std::any_of(sensors_.begin(), sensors_.end(), [&](const DropSensor& sensor) { return sensor.at == i; });
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
    std::vector<DropSensor> sensors_;
    std::pair<std::string, std::string> position_; // of the next station: latitude, longitude
    FwdStation station_;
    bool is_open_ = false;     // there is a station
    bool is_new_ = false;      // without a drop so far
    bool has_said_so_ = false; // of readings without a place
    std::vector<FwdStation> stations_;
    std::vector<std::string> station_cells_;              // of the line 5301, without its number
    std::vector<std::vector<std::string>> station_lines_; // those of stations_
    std::vector<HistoryBlock> histories_;
    std::vector<std::string> remarks_;
};

} // namespace

bool recognises_fwd_f25(std::string_view text, const ColumnMap& /*columns*/) {
    return trimmed(text.substr(0, text.find('\n'))).starts_with("5001,");
}

FwdFile read_fwd_f25(std::string_view text, const std::string& file, const ColumnMap& /*columns*/) {
    constexpr char end_of_file = '\x1a'; // of old systems
    text = text.substr(0, text.find(end_of_file));
    F25Reader reader(file);
    for_each_line(text, [&](std::string_view line, int number) {
        if (!trimmed(line).empty()) {
            reader.take({cells_of(line), file, number});
        }
    });
    return std::move(reader).file();
}

} // namespace explore::data
