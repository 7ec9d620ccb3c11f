#include "problem/parameter_space.h"

#include <cmath>

namespace explore::problem {

double Axis::physical(double unit) const {
    if (unit <= 0.0) {
        return low;
    }
    if (unit >= 1.0) {
        return high;
    }
    return scale == Scale::log ? low * std::exp(unit * (std::log(high) - std::log(low))) : low + unit * (high - low);
}

double Axis::unit(double physical) const {
    return scale == Scale::log ? (std::log(physical) - std::log(low)) / (std::log(high) - std::log(low))
                               : (physical - low) / (high - low);
}

double Axis::d_physical(double unit) const {
    return scale == Scale::log ? physical(unit) * (std::log(high) - std::log(low)) : high - low;
}

double Axis::pull(double physical) const {
    return scale == Scale::log ? std::log(physical / prior->mean) / prior->sd : (physical - prior->mean) / prior->sd;
}

double Axis::d_pull() const {
    return (scale == Scale::log ? std::log(high) - std::log(low) : high - low) / prior->sd;
}

std::vector<double> ParameterSpace::physical(std::span<const double> unit) const {
    std::vector<double> values;
    for (std::size_t k = 0; k < axes.size(); ++k) {
        values.push_back(axes[k].physical(unit[k]));
    }
    return values;
}

std::vector<double> ParameterSpace::unit(std::span<const double> physical) const {
    std::vector<double> values;
    for (std::size_t k = 0; k < axes.size(); ++k) {
        values.push_back(axes[k].unit(physical[k]));
    }
    return values;
}

} // namespace explore::problem
