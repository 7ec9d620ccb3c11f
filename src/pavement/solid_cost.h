// What a run of a three-dimensional model asks for, known from its mesh.
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

} // namespace pave::pavement
