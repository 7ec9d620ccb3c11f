#include "data/fwd_ltpp.h"

#include "data/csv.h"
#include "data/fwd_values.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fmt/format.h>
#include <map>
#include <span>
#include <unordered_map>

namespace explore::data {
namespace {

constexpr std::string_view drop_table = "MON_DEFL_DROP_DATA";
constexpr std::string_view configuration_column[] = {"CONFIGURATION_NO"};
constexpr std::string_view station_columns[] = {"STATE_CODE",   "SHRP_ID", "TEST_DATE", "TEST_TIME",
                                                "DEFL_UNIT_ID", "LANE_NO", "POINT_LOC"};

// A table with named columns.
class Table {
public:
    Table(std::string_view text, std::string file)
        : file_(std::move(file)),
          rows_(parse_csv(text, file_, separator_of(text))) {
        if (rows_.empty()) {
            throw pave::Error({.file = file_}, "the table is empty", {}, "a header and at least one row");
        }
        for (std::size_t i = 0; i < rows_[0].cells.size(); ++i) {
            columns_.try_emplace(lower_case(trimmed(rows_[0].cells[i])), i);
        }
    }

    std::size_t rows() const { return rows_.size() - 1; }
    bool has(std::string_view column) const { return columns_.contains(lower_case(column)); }
    pave::Place place(std::size_t row, std::string_view column) const {
        return {.file = file_, .line = rows_[row + 1].line, .key = std::string(column)};
    }
    std::string_view cell(std::size_t row, std::string_view column) const {
        const auto at = columns_.find(lower_case(column));
        if (at == columns_.end()) {
            throw pave::Error({.file = file_, .line = rows_[0].line, .key = std::string(column)}, "column missing", {},
                              "the columns of the LTPP database under their own names");
        }
        const auto& cells = rows_[row + 1].cells;
        return at->second < cells.size() ? trimmed(cells[at->second]) : std::string_view{}; // a short line
    }
    int line(std::size_t row) const { return rows_[row + 1].line; }
    // The measured value; nothing: the column is not there, or something else stands in it.
    std::optional<double> reading(std::size_t row, std::string_view column) const {
        return has(column) ? measured(cell(row, column)) : std::nullopt;
    }
    // A whole number from 1 on.
    int number(std::size_t row, std::string_view column) const {
        const double value = finite_number(cell(row, column), place(row, column));
        if (!(value >= 1.0 && value <= 1e6) || value != std::floor(value)) {
            throw pave::Error(place(row, column), "not a whole number", fmt::format("{:g}", value), "1, 2, 3, ...");
        }
        return static_cast<int>(value);
    }
    // The key by which rows of two tables belong together: 6 and 06 and 6.0 are one number.
    std::string key(std::size_t row, std::span<const std::string_view> columns) const {
        std::string out;
        for (const std::string_view column : columns) {
            const std::string_view text = has(column) ? cell(row, column) : std::string_view{};
            const bool plain = text.find_first_not_of("+-.0123456789") == std::string_view::npos;
            const auto number = plain ? number_or_nothing(text) : std::nullopt;
            out += number ? fmt::format("{}", *number) : lower_case(text);
            out += '\n';
        }
        return out;
    }
    std::unordered_map<std::string, std::size_t> index(std::span<const std::string_view> columns) const {
        std::unordered_map<std::string, std::size_t> found;
        for (std::size_t r = 0; r < rows(); ++r) {
            found.try_emplace(key(r, columns), r);
        }
        return found;
    }

private:
    // Of the two that tables come with, the one that stands in the header.
    static char separator_of(std::string_view text) {
        const std::string_view header = text.substr(0, text.find('\n'));
        return std::count(header.begin(), header.end(), ';') > std::count(header.begin(), header.end(), ',') ? ';'
                                                                                                             : ',';
    }

    std::string file_;
    std::vector<CsvRow> rows_;
    std::map<std::string, std::size_t> columns_;
};

// Another table, from the folder of the first; read: takes it up.
Table table_beside(const std::string& file, std::string_view table, std::vector<InputFile>& read) {
    const std::filesystem::path path(file);
    std::string name = lower_case(path.filename().string());
    const std::size_t at = name.find(lower_case(drop_table));
    name =
        at == std::string::npos ? lower_case(table) + ".csv" : name.replace(at, drop_table.size(), lower_case(table));
    const auto folder = path.has_parent_path() ? path.parent_path() : std::filesystem::path(".");
    std::error_code unreadable;
    for (const auto& entry : std::filesystem::directory_iterator(folder, unreadable)) {
        if (lower_case(entry.path().filename().string()) == name) {
            const std::string found = entry.path().string();
            read.push_back({found, read_file(found, "LTPP table", Encoding::of_instruments)});
            return {read.back().bytes, found};
        }
    }
    throw pave::Error({.file = file}, fmt::format("the table {} is not beside it", table), {},
                      fmt::format("a file {} in the same folder", name));
}

// The objections of the database's own checks to a drop; "": none. Records pass levels A to E; what stopped before E
// failed a check.
std::string flag_of(const Table& drops, std::size_t r) {
    const std::string status = lower_case(drops.has("RECORD_STATUS") ? drops.cell(r, "RECORD_STATUS") : "");
    if (status.size() == 1 && status[0] >= 'a' && status[0] <= 'd') {
        return fmt::format("RECORD_STATUS {}", drops.cell(r, "RECORD_STATUS"));
    }
    const auto rises = drops.reading(r, "NON_DECREASING_DEFL");
    return rises && *rises != 0.0 ? fmt::format("NON_DECREASING_DEFL {:g}", *rises) : "";
}

struct NumberedSensor {
    int number = 0;
    double offset_mm = 0.0; // negative: behind the plate
};

struct Configuration {
    double radius_mm = 0.0;
    std::vector<NumberedSensor> sensors;
};

std::map<std::string, Configuration> read_configurations(const std::string& file, std::vector<InputFile>& read) {
    std::map<std::string, Configuration> found;
    const Table devices = table_beside(file, "MON_DEFL_DEV_CONFIG", read);
    for (std::size_t r = 0; r < devices.rows(); ++r) {
        devices.cell(r, "PLATE_RADIUS"); // the column must be there
        found[devices.key(r, configuration_column)].radius_mm = devices.reading(r, "PLATE_RADIUS").value_or(NAN);
    }
    const Table sensors = table_beside(file, "MON_DEFL_DEV_SENSORS", read);
    for (std::size_t r = 0; r < sensors.rows(); ++r) {
        sensors.cell(r, "CENTER_OFFSET");
        if (const auto offset = sensors.reading(r, "CENTER_OFFSET")) {
            found[sensors.key(r, configuration_column)].sensors.push_back({sensors.number(r, "SENSOR_NO"), *offset});
        }
    }
    return found;
}

} // namespace

bool recognises_fwd_ltpp(std::string_view text, const ColumnMap& /*columns*/) {
    const std::string header = lower_case(text.substr(0, text.find('\n')));
    const auto holds = [&](std::string_view column) { return header.find(column) != std::string::npos; };
    return holds("point_loc") && holds("drop_load") && holds("peak_defl_1");
}

FwdFile read_fwd_ltpp(std::string_view text, const std::string& file, const ColumnMap& /*columns*/) {
    const Table drops(text, file);
    FwdFile result;
    const Table places = table_beside(file, "MON_DEFL_LOC_INFO", result.inputs);
    const auto place_of = places.index(station_columns);
    const auto configurations = read_configurations(file, result.inputs);

    auto& stations = result.stations;
    std::vector<const Configuration*> configuration_of; // null: not known
    std::unordered_map<std::string, std::size_t> known;
    for (std::size_t r = 0; r < drops.rows(); ++r) {
        const std::string key = drops.key(r, station_columns);
        const auto [at, is_new] = known.try_emplace(key, stations.size());
        if (is_new) {
            const std::string_view date = drops.cell(r, "TEST_DATE");
            FwdStation station{.name = {}, .lane = std::string(drops.cell(r, "LANE_NO")), .file = file};
            station.date = std::string(date.substr(0, date.find_first_of(" T")));
            station.name = fmt::format("{}-{} {}", drops.cell(r, "STATE_CODE"), drops.cell(r, "SHRP_ID"), station.date);
            station.profile = station.name;
            station.time = drops.has("TEST_TIME") ? std::string(drops.cell(r, "TEST_TIME")) : "";
            station.line = drops.line(r);
            station.chainage_m = drops.reading(r, "POINT_LOC");
            if (!station.chainage_m) {
                station.remarks.push_back(
                    fmt::format("line {}: POINT_LOC \"{}\" is no chainage", station.line, drops.cell(r, "POINT_LOC")));
            }
            const Configuration* configuration = nullptr;
            if (const auto place = place_of.find(key); place == place_of.end()) {
                station.unusable = "MON_DEFL_LOC_INFO does not know this station";
            } else {
                station.air_C = places.reading(place->second, "AIR_TEMP_TEST");
                station.surface_C = places.reading(place->second, "PVMT_SURF_TEMP");
                const auto found = configurations.find(places.key(place->second, configuration_column));
                if (found == configurations.end() || found->second.sensors.empty()) {
                    station.unusable =
                        fmt::format("no plate and sensors of configuration {} in MON_DEFL_DEV_CONFIG and _DEV_SENSORS",
                                    places.cell(place->second, "CONFIGURATION_NO"));
                } else {
                    configuration = &found->second;
                }
            }
            stations.push_back(std::move(station));
            configuration_of.push_back(configuration);
        }
        FwdStation& station = stations[at->second];
        const int counted = static_cast<int>(station.drops.size()) + 1;
        const auto number = drops.reading(r, "DROP_NO");
        const bool is_whole = number && *number >= 1.0 && *number <= 1e6 && *number == std::floor(*number);
        FwdDrop drop{.number = is_whole ? static_cast<int>(*number) : counted,
                     .pressure_kPa = drops.reading(r, "DROP_LOAD").value_or(NAN),
                     .readings = {}};
        drop.line = drops.line(r);
        if (const std::string flag = flag_of(drops, r); !flag.empty()) {
            drop.flag = flag;
        }
        if (const Configuration* configuration = configuration_of[at->second]) {
            drop.radius_mm = configuration->radius_mm;
            for (const NumberedSensor& sensor : configuration->sensors) {
                if (const auto deflection = drops.reading(r, fmt::format("PEAK_DEFL_{}", sensor.number))) {
                    drop.readings.push_back({sensor.offset_mm, *deflection});
                } else {
                    drop.not_read_mm.push_back(sensor.offset_mm);
                }
            }
        }
        station.drops.push_back(std::move(drop));
    }
    if (stations.empty()) {
        throw pave::Error({.file = file}, "the file holds no drops", "a header and no rows", "at least one row");
    }
    return result;
}

} // namespace explore::data
