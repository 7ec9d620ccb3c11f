// The text files of KUAB deflectometers: lines led by a letter.
//
//     IKUAB FWD FILE    : road.fwd
//     IDate Created     : 12/04/2016
//     IPlate Radius     : 15.0 (cm)
//     ISensor Distance  : 0.0 20.0 30.0 45.0 60.0 90.0 120.0 (cm)
//     HLane             : LHS
//     J    Dist Imp  Load   D0   D1   D2   D3   D4   D5   D6  Air  Pav  Emod    Time       names
//     J       m num    kN   My   My   My   My   My   My   My    C    C   MPa hh:mm:ss      units; My: um
//     D 200 2 41.5 388 184 124 71 51 26 19 30 31 0032.96315 03213.82190 13:56:00
//
// Behind the temperatures a line may hold a modulus, then latitude and longitude as ddmm.mmm and dddmm.mmm (south and
// west with a minus sign), then the time; those are known by their form. Lines of one distance after another are drops
// of one station. Source: the layout of public files and readers.
#pragma once

#include "data/fwd.h"

namespace explore::data {

bool recognises_fwd_kuab(std::string_view text, const ColumnMap& columns);

// Throws pave::Error: file, line, found, allowed.
FwdFile read_fwd_kuab(std::string_view text, const std::string& file, const ColumnMap& columns);

inline constexpr FwdFormat fwd_kuab = {"KUAB .fwd", "the first line begins with IKUAB FWD FILE", recognises_fwd_kuab,
                                       read_fwd_kuab};

} // namespace explore::data
