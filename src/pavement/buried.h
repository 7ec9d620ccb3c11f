// Whether an instrument is set into the road, or carried by a deflectometer or another device on its surface.
#pragma once

#include "pavement/device.h"

namespace pave::pavement {

inline bool is_buried(const Sensor& sensor) {
    return !(sensor.quantity == Quantity::deflection || is_of_device(sensor.quantity)) || sensor.depth > 0.0;
}

} // namespace pave::pavement
