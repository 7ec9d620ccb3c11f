// Dynatest's older .fwd, edition R80: lines of 80 columns.
//
//     R80    102    ROAD A                                          1: edition
//     70103300        69994.3703111  1                              2
//     150   0 200 300 600 90012001500  5.91  0.00  7.87 ...         3: plate radius and offsets in mm, 4 columns each;
//                                                                      then the same in inches, 6 columns each
//     *                                                             ... the rest of the header: the first and the last
//                                                                      station in lines 6 and 7, sensors from line 10
//                                                                      on
//     G0000001+48.9739425+2.5873408999.9                            position of the next station
//     S    20.00  8.800  3  0I20933   48   37   32                  station, air, surface and asphalt temperature in C,
//                                                                      I, a digit, the time hhmm; then in Fahrenheit
//     821 141  95  72  48  37  28  21                               drop: pressure in kPa, deflections in um, 4 columns
//                                                                      each; with decimals, as some write them, parted
//                                                                      by blanks or not at all
//
// Source: the layout of public files and of a public writer of them; what the three temperatures are is read off the
// latter and not documented.
#pragma once

#include "data/fwd.h"

namespace explore::data {

bool recognises_fwd_r80(std::string_view text, const ColumnMap& columns);

// Throws pave::Error: file, line, found, allowed.
FwdFile read_fwd_r80(std::string_view text, const std::string& file, const ColumnMap& columns);

inline constexpr FwdFormat fwd_r80 = {"Dynatest R80 .fwd", "the first line begins with R80", recognises_fwd_r80,
                                      read_fwd_r80};

} // namespace explore::data
