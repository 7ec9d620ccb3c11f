// Measurements of a falling weight deflectometer (FWD) along a road, whatever file they came from.
#pragma once

#include "data/csv.h"
#include "data/station_layers.h"

#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace explore::data {

struct FwdReading {
    double offset_mm = 0.0;     // from the centre of the plate; negative: behind it, on the other side
    double deflection_um = 0.0; // peak, positive down
};

// Load cell and sensors over the pulse of a drop.
struct FwdHistory {
    double step_ms = 0.0;
    std::vector<double> pressure_kPa{};  // of every sample, from time 0 on
    std::vector<double> offsets_mm{};    // of the sensors, as FwdReading's
    std::vector<double> deflection_um{}; // of every sample those of all sensors; not a number: not read
};

struct FwdDrop {
    int number = 0;
    double radius_mm = 0.0;            // of the plate; not a number: not stated
    double pressure_kPa = 0.0;         // peak, uniform under the plate; not a number: not measured
    std::vector<FwdReading> readings;  // those that were measured
    std::vector<double> not_read_mm{}; // offsets of the sensors that gave no number
    std::optional<double> force_kN{};  // where the file states a force: pressure_kPa is made of it
    std::optional<FwdHistory> history{};
    std::string flag{}; // why the file itself warns of this drop; "": it does not
    int line = 0;
};

// The drops at one place. Values are as the file states them, sensible or not: plausibility.h and deflection_bowl.h
// judge. What a file does not state, or not as a number, is not there; remarks say what could not be read.
struct FwdStation {
    std::string name;
    std::string profile{};              // what runs along the road on its own: a section, a date; may be empty
    std::string lane;                   // may be empty
    std::optional<double> chainage_m{}; // nothing: not to be read
    std::string date{}, time{};         // as the file writes them
    std::optional<double> air_C{}, surface_C{}, asphalt_C{}; // temperatures
    std::optional<double> latitude{}, longitude{};           // degrees, north and east positive
    std::string comment{};
    StationLayers layers{}; // that the file states, under its own names
    std::vector<FwdDrop> drops{};
    std::string file;
    int line = 0;                       // of its first drop
    std::string unusable{};             // why nothing can be made of it; "": something can
    std::vector<std::string> remarks{}; // of the reading, in words
};

struct FwdFile {
    std::vector<FwdStation> stations; // in its order
    std::vector<std::string> remarks; // of the file as a whole, in words
    std::vector<InputFile> inputs{};  // the file, and the tables beside it that were read
};

inline constexpr const char* no_drops = "it has no drops"; // FwdStation::unusable

// The file itself. Throws pave::Error where it holds no drops; allowed: what holds drops in its format, in words.
FwdFile with_drops(FwdFile read, const std::string& file, std::string_view allowed);

// A pressure that the file states counts before the force beside it; a station where they differ by more than 5 % is
// remarked.
void take_pressure(FwdDrop& drop, double pressure_kPa, std::string_view where, FwdStation& station);

// Latitude and longitude as the file states them, in degrees: taken where they lie on the globe; 0, 0 is what receivers
// write without a fix. Anything else that was written is remarked.
void set_position(FwdStation& station, std::string_view latitude, std::string_view longitude);
void set_position(FwdStation& station, std::optional<double> latitude, std::optional<double> longitude);

// For tables with names of their own: the name of a column as fwd_csv.h knows it -> the file's own name of it, or a
// number that holds for every line ("radius_mm" -> "150").
using ColumnMap = std::map<std::string, std::string>;

// A file format. A new one is a file of its own and a line in fwd_formats().
struct FwdFormat {
    std::string_view name;
    std::string_view sign; // by which it is known, in words
    bool (*recognises)(std::string_view text, const ColumnMap& columns);
    FwdFile (*read)(std::string_view text, const std::string& file, const ColumnMap& columns);
};
std::span<const FwdFormat> fwd_formats();

// Throws pave::Error for a file of no known format or one that cannot be read.
FwdFile read_fwd(const std::string& file, const ColumnMap& columns = {});
// Several. columns: as read_column_map takes them, or empty.
std::vector<FwdFile> read_fwd_files(const std::vector<std::string>& files, const std::string& columns);

// A column map from a list "load_kN = Force, D0_um = D1, radius_mm = 150" (comma or semicolon), or from a file with one
// such entry a line and # comments. Throws pave::Error.
ColumnMap read_column_map(const std::string& list_or_file);

} // namespace explore::data
