// Where the sensors of deflectometers usually stand.
#pragma once

#include <vector>

namespace explore::data {

// Offsets from the centre of the plate [mm], nearest first: deflectometers of Dynatest, Grontmij and KUAB as roads are
// tested with them; inches are those of American ones.
const std::vector<std::vector<double>>& usual_layouts();

} // namespace explore::data
