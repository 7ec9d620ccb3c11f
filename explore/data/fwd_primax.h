// The text files of Primax deflectometers (RoSy, Sweco: "ROAD SYSTEM"): sections $1, $2, $3, values parted by tabs.
//
//     (c) ROAD SYSTEM 2016, Metric
//     $1   Load plate radius [mm].   150
//          Radial offset [cm].....   0   20   30 ...        negative: behind the plate
//     $2   Chainage [m]...........   0
//          Position of Drop:  Longitude: 2°35'14.4270"E   Latitude: 48°58'26.1930"N
//     $3   Sequence: 1/1   No. of drops: 3   Fallheight: 0   Time: 09:31
//          Drop  D(1)  D(2) ...  kPa  kN  Air  Sur.  Man.  Pulse time
//          1     148.4 88.5 ...  993  70.2 8.6  2.9   0.0   25.40
//
// Deflections in um. Writers that leave the pressure out write 0 there; the force then counts. Time histories are
// passed over. Source: the layout of public files and of public readers and writers of them.
#pragma once

#include "data/fwd.h"

namespace explore::data {

bool recognises_fwd_primax(std::string_view text, const ColumnMap& columns);

// Throws pave::Error: file, line, found, allowed.
FwdFile read_fwd_primax(std::string_view text, const std::string& file, const ColumnMap& columns);

inline constexpr FwdFormat fwd_primax = {"Primax (RoSy, Sweco) .fwd", "a line \"(c) ROAD SYSTEM\" near the beginning",
                                         recognises_fwd_primax, read_fwd_primax};

} // namespace explore::data
