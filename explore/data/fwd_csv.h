// The generic survey table, as a spreadsheet saves it: RFC 4180, UTF-8, # comments, one line a drop, one column a
// sensor.
//
//     station,lane,chainage_m,drop,radius_mm,pressure_kPa,surface_C,D0_um,D200_um,D300_um,D450_um
//     P1,L1,0,1,150,566,21.5,612,455,351,233
//
// Columns in any order. Needed: chainage_m; radius_mm of the plate; pressure_kPa or load_kN (on the plate); deflections
// D<offset in mm>_um or _mm. May be there: station (a name; when missing, the chainage), lane, drop (a number; when
// missing, they are counted), air_C and surface_C. Lines of the same station, lane and chainage are drops of one
// station. An empty deflection: that sensor was not read.
#pragma once

#include "data/fwd.h"

namespace explore::data {

bool recognises_fwd_csv(std::string_view text);

// Throws pave::Error: file, line, column, found, allowed.
std::vector<FwdStation> read_fwd_csv(std::string_view text, const std::string& file);

inline constexpr FwdFormat fwd_csv = {"survey table (CSV)",
                                      "a header, separated by commas, with the columns chainage_m, radius_mm, "
                                      "pressure_kPa or load_kN, and deflections such as D0_um, D200_um",
                                      recognises_fwd_csv, read_fwd_csv};

} // namespace explore::data
