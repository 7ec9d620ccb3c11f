#include "pavement/section.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace pave::pavement {

double Load::circle_radius() const {
    return type == LoadType::plate ? radius : std::sqrt(force / (std::numbers::pi * pressure));
}

double Case::depth() const {
    double depth = 0.0;
    for (const Layer& layer : layers) {
        depth += layer.thickness;
    }
    return depth;
}

double Case::default_extent() const {
    double extent = std::max(4.0, 2.0 * depth());
    for (const Sensor& sensor : sensors) {
        extent = std::max(extent, 2.0 * std::hypot(sensor.x, sensor.y));
    }
    return extent;
}

} // namespace pave::pavement
