// Gauss-Legendre quadrature on [-1, 1].
#pragma once

#include <utility>

namespace pave::fe {

// Position and weight: exact for polynomials up to degree five.
inline constexpr std::pair<double, double> three_points[] = {
    {-0.7745966692414834, 5.0 / 9.0}, {0.0, 8.0 / 9.0}, {0.7745966692414834, 5.0 / 9.0}};

} // namespace pave::fe
