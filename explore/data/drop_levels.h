// The levels of load that the drops of a station make, and the drop that seats the plate: see deflection_bowl.h.
#pragma once

#include "data/drop_agreement.h"
#include "data/fwd.h"

namespace explore::data {

using Level = std::vector<const FwdDrop*>;

// By rising pressure; the drops of a level in the order of the station.
std::vector<Level> levels_of(std::vector<const FwdDrop*> drops);
// Median, kPa.
double pressure_of(const Level& level);

// Where it reads; the centre is 0.
double place_of(const FwdReading& reading);
// Of a level, at its pressure. Of two sensors at one place a drop has one reading, their mean.
LevelReadings readings_of(const Level& level);

// Drops of a load that is misread: their deflections are those of more drops, the twin, under a pressure that is a
// fifth or more away.
struct MisreadLoad {
    Level drops, twin;
};
// Takes them out of the levels.
std::vector<MisreadLoad> take_out_misread_loads(std::vector<Level>& levels);

// Whether the first of these drops seats the plate. scatter: of ln(deflection / pressure) at the centre over drops;
// resolution_um: steps of the file.
bool first_is_seating(const std::vector<const FwdDrop*>& drops, bool first_of_two_seats, double scatter,
                      double resolution_um);

} // namespace explore::data
