// The cost of a run of a finite element model, known from its mesh.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace pave::pavement {

// Both grow as the entries of a factor by nested dissection (George 1973), the number of unknowns to the power 4/3; the
// constants are measured on sections under dual wheels.
inline double solid_memory(double unknowns) { // bytes of a workspace
    return 400.0 * std::pow(unknowns, 4.0 / 3.0);
}
inline double solid_seconds(double unknowns, std::size_t steps = 0) { // of a run; steps: of a pulse
    constexpr double as_long_as_at_rest = 50.0;                       // so many of them take
    return 6e-6 * std::pow(unknowns, 4.0 / 3.0) * std::max(1.0, static_cast<double>(steps) / as_long_as_at_rest);
}

// Of the axisymmetric one, whose work is a constant number of factors: as unknowns to the power 3/2 (George 1973). The
// constants are measured on sections under a plate.
inline double axisymmetric_seconds(double unknowns, bool is_linear, std::size_t steps = 0) {
    constexpr double as_long_as_at_rest = 10.0; // so many steps of a pulse take
    return (is_linear ? 3e-8 : 1.4e-7) * std::pow(unknowns, 1.5) *
           std::max(1.0, static_cast<double>(steps) / as_long_as_at_rest);
}
// The cost of every derivative, as a share of a run.
inline constexpr double solid_derivative = 0.4;
inline constexpr double axisymmetric_derivative = 0.14;
// A load on linear layers, by transforms: of all its readings; every derivative takes as long again.
inline constexpr double layered_seconds = 5e-4;

} // namespace pave::pavement
