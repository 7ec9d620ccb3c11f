// The levels of load that the drops of a station make, and the drop that seats the plate: see deflection_bowl.h.
#pragma once

#include "data/fwd.h"

namespace explore::data {

using Level = std::vector<const FwdDrop*>;

// By rising pressure; the drops of a level in the order of the station.
std::vector<Level> levels_of(std::vector<const FwdDrop*> drops);
// Median, kPa.
double pressure_of(const Level& level);

// Where it reads; the centre is 0.
double place_of(const FwdReading& reading);

// Whether the first of these drops seats the plate. scatter: of ln(deflection / pressure) at the centre over drops;
// resolution_um: steps of the file.
bool first_is_seating(const std::vector<const FwdDrop*>& drops, bool first_of_two_seats, double scatter,
                      double resolution_um);

} // namespace explore::data
