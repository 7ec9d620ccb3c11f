// A law times a smooth factor of the stress state, for what the law itself does not say.
#pragma once

#include "material/law.h"

namespace pave::material {

// E = E_law exp(g(ln thp) + h(ln(tau/pa + 1))), pa = 100 kPa, thp the smooth floor of theta with delta = 5 kPa and no
// part of shear. g and h are piecewise cubic (Hermite) through values at places, their slopes those of the neighbouring
// values (Catmull and Rom 1974, in Barnhill and Riesenfeld, Computer Aided Geometric Design), and constant beyond the
// outermost places: once differentiable, and what the values are linear in.
inline constexpr std::size_t most_places = 6; // of g, and of h

// The parameters of the corrected law are those of the law, then g's places [Pa], rising, and values, then h's; a place
// that is not a number is not there, and what has no places is zero. The same object at every call.
const Law& corrected(const Law& law);

// Where g (of_shear: h) keeps place and value number i among the parameters of corrected(law).
std::size_t place_index(const Law& law, bool of_shear, std::size_t i);
std::size_t value_index(const Law& law, bool of_shear, std::size_t i);

} // namespace pave::material
