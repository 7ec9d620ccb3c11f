#include "pavement/section.h"

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

} // namespace pave::pavement
