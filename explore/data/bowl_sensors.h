// Which sensors of a bowl contradict the others.
#pragma once

#include "data/deflection_bowl.h"

#include <map>

namespace explore::data {

// The offset of the reading that contradicts the most others, which is to be left out; nothing: none. Of two readings
// (all above zero, by offset) the outer one contradicts the inner one where it is more than a quarter larger. One that
// contradicts two or more is named; of a single pair the inner one, where it is less than a quarter of the outer one.
std::optional<double> most_contradicted(const std::map<double, BowlReading>& readings);

// Far sensors that may be nearly dead, in words: beyond 600 mm a deflection falls to less than a quarter of its
// neighbour's and faster than by the third power of the distance. A point load on a half-space falls by the first.
std::vector<std::string> faint_sensors(const std::vector<BowlReading>& readings);

} // namespace explore::data
