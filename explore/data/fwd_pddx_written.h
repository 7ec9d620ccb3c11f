// Stations as AASHTO's Pavement Deflection Data Exchange (fwd_pddx.h), whatever file they came from.
#pragma once

#include "data/fwd.h"

namespace explore::data {

// The text of files, in the order of their first stations. A file has one plate, one date and one profile, so stations
// that differ in these are parted. Units: kPa (kN where every drop states a force), um, mm, m, degrees Celsius; numbers
// with all their digits, so that reading gives them back. Of a station: chainage (its name, where it has none), lane,
// time, position, comment, temperatures and all drops with what was read; not its name beside a chainage, the
// thicknesses it states, time histories. Stations without drops are left out.
std::vector<std::string> pddx_of(std::span<const FwdFile> files);

} // namespace explore::data
