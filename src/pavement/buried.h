// Whether an instrument is set into the road, or carried by a deflectometer on its surface.
#pragma once

#include "pavement/section.h"

namespace pave::pavement {

inline bool is_buried(const Sensor& sensor) {
    return sensor.quantity != Quantity::deflection || sensor.depth > 0.0;
}

} // namespace pave::pavement
