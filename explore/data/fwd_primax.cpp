#include "data/fwd_primax.h"

#include "data/csv.h"
#include "data/fwd_lines.h"
#include "data/fwd_values.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace explore::data {
namespace {

class PrimaxReader {
public:
    explicit PrimaxReader(std::string file) : file_(std::move(file)) {}

    void take(std::string_view line, int number) {
        const auto cells = cells_between('\t', line);
        // Names are filled up with dots: "Chainage [m]...........".
        const std::string name = lower_case(cells[0].substr(0, cells[0].find_last_not_of('.') + 1));
        const std::string_view value = cells.size() > 1 ? cells[1] : std::string_view{};
        const std::string_view unit = unit_of(name);
        if (name.starts_with("date")) {
            date_ = value;
        } else if (name.starts_with("load plate radius")) {
            radius_mm_ = scaled(value, unit, number, "load plate radius").value_or(NAN);
        } else if (name.starts_with("radial offset")) {
            take_offsets(cells, unit, number);
        } else if (name.starts_with("chainage")) {
            begin_station(value, unit, number);
        } else if (name.starts_with("lane") && is_open_) {
            station_.lane = value;
        } else if (name.starts_with("remarks") && is_open_) {
            station_.comment = value;
        } else if (name.starts_with("position of drop") && is_open_) {
            latitude_.clear();
            longitude_.clear();
            for (const std::string_view cell : cells) {
                take_position(cell);
            }
            set_position(station_, latitude_, longitude_);
        } else if (name.starts_with("sequence") && is_open_) {
            for (const std::string_view cell : cells) {
                if (cell.starts_with("Time:")) {
                    station_.time = trimmed(cell.substr(5));
                }
            }
        } else if (name == "drop" && cells.size() > 1) {
            columns_.assign(cells.begin(), cells.end());
        } else if (!columns_.empty() && is_drop(cells)) {
            take_drop(cells, number);
        } else if (name.starts_with("$")) {
            columns_.clear();
        }
    }

    FwdFile file() && {
        close_station();
        return with_drops(std::move(result_), file_,
                          "after a line \"Chainage\" a line \"Drop D(1) ...\" and lines of numbers");
    }

private:
    // "[mm]" of a name; "": none.
    static std::string_view unit_of(std::string_view name) {
        const std::size_t open = name.find('[');
        const std::size_t close = name.find(']', open == std::string_view::npos ? 0 : open);
        return open == std::string_view::npos || close == std::string_view::npos
                   ? std::string_view{}
                   : name.substr(open + 1, close - open - 1);
    }
    // In mm; nothing: no number. Throws pave::Error for an unknown unit.
    std::optional<double> scaled(std::string_view value, std::string_view unit, int line, std::string_view what) const {
        const pave::Place place{.file = file_, .line = line, .key = std::string(what)};
        const auto factor = factor_of(length_units(), unit);
        if (!factor) {
            throw pave::Error(place, "unknown unit", "\"" + std::string(unit) + "\"", names_of(length_units()));
        }
        const auto number = measured_with_comma(value);
        return number ? std::optional(*number * *factor * 1e3) : std::nullopt;
    }

    // A line that begins with a number, or one as long whose number is not to be read.
    bool is_drop(const std::vector<std::string_view>& cells) const {
        const auto numbers = std::count_if(cells.begin(), cells.end(),
                                           [](std::string_view cell) { return measured_with_comma(cell).has_value(); });
        return measured_with_comma(cells[0]) || (2 * cells.size() > columns_.size() && numbers >= 3);
    }

    void take_offsets(const std::vector<std::string_view>& cells, std::string_view unit, int line) {
        offsets_mm_.clear();
        for (std::size_t i = 1; i < cells.size(); ++i) {
            offsets_mm_.push_back(scaled(cells[i], unit, line, "radial offset"));
            if (!offsets_mm_.back() && !is_nil(cells[i])) {
                result_.remarks.push_back(fmt::format("{}, line {}: \"{}\" is no place of a sensor, which is left out",
                                                      file_, line, cells[i]));
            }
        }
        while (!offsets_mm_.empty() && !offsets_mm_.back()) {
            offsets_mm_.pop_back();
        }
        if (std::find(offsets_mm_.begin(), offsets_mm_.end(), std::nullopt) != offsets_mm_.end()) {
            result_.remarks.push_back(
                fmt::format("{}, line {}: a sensor without a place is left out with its readings", file_, line));
        }
    }

    // A station without drops is one that nothing can be made of.
    void close_station() {
        if (is_open_ && is_new_) {
            station_.unusable = no_drops;
            result_.stations.push_back(station_);
        }
    }

    void begin_station(std::string_view value, std::string_view unit, int line) {
        close_station();
        station_ = {.name = std::string(value), .lane = {}, .date = date_, .file = file_};
        station_.line = line;
        const auto to_m = factor_of(length_units(), unit);
        station_.chainage_m = chainage(value, to_m.value_or(1.0));
        if (!to_m && !unit.empty()) {
            station_.remarks.push_back(fmt::format(
                "line {}: the unit \"{}\" of the chainage is not known: it is taken for metres", line, unit));
        }
        if (!station_.chainage_m) {
            station_.remarks.push_back(fmt::format("line {}: \"{}\" is no chainage", line, value));
        }
        is_open_ = true;
        is_new_ = true;
        columns_.clear();
    }

    void take_position(std::string_view cell) {
        constexpr std::string_view longitude = "Longitude:";
        constexpr std::string_view latitude = "Latitude:";
        if (cell.starts_with(longitude)) {
            longitude_ = cell.substr(longitude.size());
        } else if (cell.starts_with(latitude)) {
            latitude_ = cell.substr(latitude.size());
        }
    }

    void take_drop(const std::vector<std::string_view>& cells, int line) {
        const pave::Place place{.file = file_, .line = line, .key = "drop"};
        if (!is_open_) {
            throw pave::Error(place, "a drop before any station", {}, "a line \"Chainage\" before it");
        }
        if (offsets_mm_.empty() || !radius_mm_) {
            throw pave::Error(place, "a drop before the plate and the places of the sensors", {},
                              "lines \"Load plate radius\" and \"Radial offset\" before it");
        }
        const auto column = [&](std::string_view name) -> std::optional<double> {
            for (std::size_t i = 0; i < std::min(columns_.size(), cells.size()); ++i) {
                if (lower_case(columns_[i]) == name) {
                    return measured_with_comma(cells[i]);
                }
            }
            return std::nullopt;
        };
        if (is_new_) {
            station_.line = line;
            station_.air_C = column("air");
            station_.surface_C = column("sur.");
            station_.asphalt_C = column("man.");
            result_.stations.push_back(station_);
            is_new_ = false;
        }
        FwdStation& station = result_.stations.back();
        const auto number = measured_with_comma(cells[0]);
        FwdDrop drop{.number = number && *number >= 0.0 && *number < 1e6 ? static_cast<int>(*number)
                                                                         : static_cast<int>(station.drops.size()) + 1,
                     .radius_mm = *radius_mm_,
                     .pressure_kPa = NAN,
                     .readings = {}};
        drop.line = line;
        if (!number) {
            station.remarks.push_back(fmt::format("line {}: \"{}\" is not a drop number, which is counted as {}", line,
                                                  cells[0], drop.number));
        }
        if (const auto force = column("kn"); force && *force != 0.0) {
            drop.force_kN = force;
            drop.pressure_kPa = plate_pressure_kPa(*force, *radius_mm_);
        }
        if (const auto pressure = column("kpa"); pressure && *pressure != 0.0) {
            take_pressure(drop, *pressure, fmt::format("line {}", line), station);
        }
        for (std::size_t i = 0; i < offsets_mm_.size(); ++i) {
            if (!offsets_mm_[i]) {
                continue;
            }
            if (const auto deflection = column(fmt::format("d({})", i + 1))) {
                drop.readings.push_back({*offsets_mm_[i], *deflection});
            } else {
                drop.not_read_mm.push_back(*offsets_mm_[i]);
            }
        }
        station.drops.push_back(std::move(drop));
    }

    std::string file_;
    std::string date_;
    std::optional<double> radius_mm_;
    std::vector<std::optional<double>> offsets_mm_; // nothing: not stated
    std::string latitude_, longitude_;
    std::vector<std::string> columns_; // of the drops that follow; empty: none follow
    FwdStation station_;
    bool is_open_ = false; // there is a station
    bool is_new_ = false;  // without a drop so far
    FwdFile result_;
};

} // namespace

bool recognises_fwd_primax(std::string_view text, const ColumnMap& /*columns*/) {
    return lower_case(text.substr(0, 2000)).find("(c) road system") != std::string::npos;
}

FwdFile read_fwd_primax(std::string_view text, const std::string& file, const ColumnMap& /*columns*/) {
    PrimaxReader reader(file);
    for_each_line(text, [&](std::string_view line, int number) { reader.take(line, number); });
    return std::move(reader).file();
}

} // namespace explore::data
