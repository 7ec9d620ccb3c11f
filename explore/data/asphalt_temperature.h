// How warm the asphalt was, and what its modulus would be at another temperature.
#pragma once

#include <optional>

namespace explore::data {

// The asphalt temperature that a file states, unless it is the 0 that writers put without a reading: beside a surface
// that is not near 0 too.
std::optional<double> measured_asphalt_C(std::optional<double> asphalt_C, std::optional<double> surface_C);

// BELLS3, for routine testing (the surface shaded for no more than a minute), in degrees Celsius:
//     T_d = 0.95 + 0.892 IR + (lg d - 1.25) (-0.448 IR + 0.621 A + 1.83 s(h, 15.5)) + 0.042 IR s(h, 13.5)
// d: depth in mm, IR: surface temperature, A: mean air temperature of the day before, h: hour of the day,
// s(h, c) = sin(2 pi (h - c) / 18) from c - 4.5 to c + 13.5 h (past midnight too), -1 at other hours (the guide's
// code). Lukanen, Stubstad and Briggs (2000), FHWA-RD-98-085.
double bells3(double surface_C, double air_of_day_before_C, double hour, double depth_mm);

// E(T_ref) / E(T) = 10^(-0.021 (T_ref - T)): the default slope of the same guide; mixes have -0.015 to -0.030.
double modulus_factor(double from_C, double to_C);
inline constexpr double modulus_slope = -0.021; // of lg E, per degree

} // namespace explore::data
