// The generic survey table, as a spreadsheet saves it: one line a drop, one column a sensor; # comments above the
// header.
//
//     station,lane,chainage_m,drop,radius_mm,pressure_kPa,surface_C,D0_um,D200_um,D300_um,D450_um
//     P1,L1,0,1,150,566,21.5,612,455,351,233
//
// Separated by commas, semicolons or tabs; decimal points or commas; in UTF-8, UTF-16 or Windows-1252. Columns in any
// order, with their units in their names (fwd_columns.h). Needed: a chainage; the radius or diameter of the plate; the
// pressure or the load; deflections. Lines of the same road or section, date, station, lane and chainage are drops of
// one station. A cell that holds no number costs what it would have said and nothing else.
#pragma once

#include "data/fwd.h"

namespace explore::data {

bool recognises_fwd_csv(std::string_view text, const ColumnMap& columns);

// Throws pave::Error for a header that cannot be used: file, line, column, found, allowed.
FwdFile read_fwd_csv(std::string_view text, const std::string& file, const ColumnMap& columns);

inline constexpr FwdFormat fwd_csv = {"survey table (CSV)",
                                      "a header, separated by commas, semicolons or tabs, with the columns chainage_m, "
                                      "radius_mm, pressure_kPa or load_kN, and deflections such as D0_um, D200_um",
                                      recognises_fwd_csv, read_fwd_csv};

} // namespace explore::data
