// Dynatest's F25: lines of comma-separated values, each led by the number of what it holds. Used here:
//
//     5020, plate radius, x of sensor 1, 2, ...        mm; N0: no such sensor
//     5021, plate diameter, y of sensor 1, 2, ...      mm; N0 where 5020 places the sensor: 0
//     5280, -, time, latitude, longitude, ...          of the next station
//     5301, side, -, kind, unit, station, -, -, lane, year, month, day, hour, minute
//     5302, ..., comment
//     5303, 0: Celsius or 1: Fahrenheit, asphalt, surface, air
//     1 to 999: number of the drop, peak pressure in kPa, peak deflections in um
//
// The unit of a station: 2 m, 3 or 4 km, 5 feet, 6 yards, 7 to 9 miles; a station of kind 1 (a mere number) is taken
// for metres. Sensors at a negative x stand behind the plate. N0 is the format's own word for "not measured".
// Everything else (operator, time histories, what stands behind the last sensor of a drop) is passed over. Source: the
// manufacturer's description of file edition 25.
#pragma once

#include "data/fwd.h"

namespace explore::data {

bool recognises_fwd_f25(std::string_view text, const ColumnMap& columns);

// Throws pave::Error: file, line, found, allowed.
FwdFile read_fwd_f25(std::string_view text, const std::string& file, const ColumnMap& columns);

inline constexpr FwdFormat fwd_f25 = {"Dynatest F25", "the first line begins with 5001,", recognises_fwd_f25,
                                      read_fwd_f25};

} // namespace explore::data
