// SI inside, named units at the edges: a quantity in a file carries its unit, and this is the one place that converts.
#pragma once

namespace pave::unit {

inline constexpr double mm = 1e-3;          // m
inline constexpr double um = 1e-6;          // m
inline constexpr double kPa = 1e3;          // Pa
inline constexpr double MPa = 1e6;          // Pa
inline constexpr double kN = 1e3;           // N
inline constexpr double ms = 1e-3;          // s
inline constexpr double microstrain = 1e-6; // -

inline constexpr double gravity = 9.81;           // m/s2
inline constexpr double reference_pressure = 1e5; // Pa, the pa of Uzan's law

} // namespace pave::unit
