// The tables of the Long-Term Pavement Performance (LTPP) database, exported as CSV, each in a file of its own. The
// file to name is MON_DEFL_DROP_DATA; three others are looked for beside it, under its name with that of the table in
// it replaced, whatever the case: "section 12 MON_DEFL_DROP_DATA.csv", "section 12 MON_DEFL_LOC_INFO.csv". Used here:
//
//     MON_DEFL_DROP_DATA    the station (below), DROP_NO, DROP_LOAD: the peak pressure under the plate in kPa,
//                           PEAK_DEFL_1, _2, ... in um; an empty one was not read
//     MON_DEFL_LOC_INFO     the station, CONFIGURATION_NO; may be there: AIR_TEMP_TEST, PVMT_SURF_TEMP in degrees
//     Celsius MON_DEFL_DEV_CONFIG   CONFIGURATION_NO, PLATE_RADIUS in mm MON_DEFL_DEV_SENSORS  CONFIGURATION_NO,
//     SENSOR_NO, CENTER_OFFSET in mm, negative behind the plate
//
// A station is what has the same STATE_CODE, SHRP_ID, TEST_DATE, TEST_TIME, DEFL_UNIT_ID, LANE_NO and POINT_LOC, the
// last its metres along the section; DEFL_UNIT_ID and TEST_TIME may be missing. Columns in any order; the others are
// passed over. Source: the LTPP data dictionary and the Federal Highway Administration's introduction to the database
// (FHWA-RD-03-088, chapter 9).
#pragma once

#include "data/fwd.h"

namespace explore::data {

bool recognises_fwd_ltpp(std::string_view text, const ColumnMap& columns);

// Throws pave::Error: file, line, column, found, allowed. A station that the other tables do not know is returned as
// unusable.
FwdFile read_fwd_ltpp(std::string_view text, const std::string& file, const ColumnMap& columns);

inline constexpr FwdFormat fwd_ltpp = {"LTPP tables (CSV)",
                                       "MON_DEFL_DROP_DATA with the columns POINT_LOC, DROP_LOAD, PEAK_DEFL_1, ...; "
                                       "three more tables beside it",
                                       recognises_fwd_ltpp, read_fwd_ltpp};

} // namespace explore::data
