// What a falling weight deflectometer (FWD) measured along a road, whatever file it came from.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace explore::data {

struct FwdReading {
    double offset_mm = 0.0;     // from the centre of the plate
    double deflection_um = 0.0; // peak, positive down
};

struct FwdDrop {
    int number = 0;
    double radius_mm = 0.0;    // of the plate
    double pressure_kPa = 0.0; // peak, uniform under the plate
    std::vector<FwdReading> readings;
};

// The drops at one place. Values are as the file states them, sensible or not: bowl_of (deflection_bowl.h) judges.
struct FwdStation {
    std::string name;
    std::string lane; // may be empty
    double chainage_m = 0.0;
    std::optional<double> air_C{}, surface_C{}; // temperatures
    std::vector<FwdDrop> drops{};
    std::string file;
    int line = 0;           // of its first drop
    std::string unusable{}; // why nothing can be made of it; "": something can
};

// A file format. A new one is a file of its own and a line in fwd_formats().
struct FwdFormat {
    std::string_view name;
    std::string_view sign; // by which it is known, in words
    bool (*recognises)(std::string_view text);
    std::vector<FwdStation> (*read)(std::string_view text, const std::string& file);
};
std::span<const FwdFormat> fwd_formats();

// Stations of a file, in its order. Throws pave::Error for a file of no known format or one that cannot be read.
std::vector<FwdStation> read_fwd(const std::string& file);

} // namespace explore::data
