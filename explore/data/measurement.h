// One measured reading as a file states it.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace explore::data {

enum class Dimension { length, strain, pressure };

struct Unit {
    std::string_view name;
    Dimension dimension;
    double to_si;
};
std::span<const Unit> units();

struct Measurement {
    std::string load;
    std::string quantity;
    double x_mm = 0.0, y_mm = 0.0, depth_mm = 0.0, gauge_mm = 0.0;
    double value = 0.0; // in `unit`
    Unit unit{};
    std::optional<double> sigma; // one standard deviation, in `unit`
    std::string file;
    int line = 0;
};

// Reads the measurement format of this project: RFC 4180 with a header
// load,quantity,x_mm,y_mm,depth_mm,gauge_mm,value,unit,sigma; lines that start with # are comments; sigma may be
// empty. Columns may come in any order; the ones named must all be there and no others. Throws pave::Error.
std::vector<Measurement> read_measurements(const std::string& file);

// The header line of that format.
std::string_view measurement_header();

} // namespace explore::data
