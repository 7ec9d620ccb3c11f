// How a load acted over time, as a device recorded it.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace explore::data {

// The latest time of a history or a reading, from the zero of their clock in either direction.
inline constexpr double latest_ms = 1e4;

struct History {
    bool is_force = false;       // values in kN; else a pressure in kPa
    std::vector<double> time_ms; // increasing, at least two
    std::vector<double> values;  // at least one above zero
};

// Reads CSV with a header that has the columns time_ms and either force_kN or pressure_kPa; other columns may stand
// beside them, lines that start with # are comments. text: of a file that messages call `file`. Throws pave::Error.
History history_of(std::string_view text, const std::string& file);

} // namespace explore::data
