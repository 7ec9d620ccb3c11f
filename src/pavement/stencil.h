// Difference quotients of fourth order by a parameter of a case.
#pragma once

#include "pavement/parameter.h"

#include <cmath>
#include <utility>
#include <vector>

namespace pave::pavement {

// Values at value + offset * step, their weights over the step.
using Stencil = std::vector<std::pair<int, double>>;
inline const Stencil central_4{{-2, 1.0 / 12}, {-1, -8.0 / 12}, {1, 8.0 / 12}, {2, -1.0 / 12}};
inline const Stencil forward_4{{0, -25.0 / 12}, {1, 48.0 / 12}, {2, -36.0 / 12}, {3, 16.0 / 12}, {4, -3.0 / 12}};
inline const Stencil backward_4{{0, 25.0 / 12}, {-1, -48.0 / 12}, {-2, 36.0 / 12}, {-3, -16.0 / 12}, {-4, 3.0 / 12}};

// File units. A size changes a response by a like amount all over its range, from a null at which it may be zero.
inline double step_of(const Case& values, const Parameter& parameter) {
    const double value = parameter.get(values);
    return 1e-3 * (parameter.in_effect ? parameter.high - parameter.low : value == 0.0 ? 1.0 : std::abs(value));
}

inline const Stencil& stencil_of(const Case& values, const Parameter& parameter) {
    const double value = parameter.get(values);
    const double reach = 2.0 * step_of(values, parameter);
    return value - reach < parameter.low ? forward_4 : value + reach > parameter.high ? backward_4 : central_4;
}

inline Case moved_by(const Case& values, const Parameter& parameter, double change) {
    Case moved = values;
    parameter.in(moved) = (parameter.get(values) + change) * parameter.to_si;
    return moved;
}

} // namespace pave::pavement
