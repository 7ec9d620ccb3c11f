// Uzan's law in the octahedral form, cross-anisotropic:
//     E = k1 pa (thp/pa)^k2 (tau/pa + 1)^k3,   thp = (theta + sqrt(theta^2 + 4 (delta^2 + eta^2 tau^2))) / 2
// Source: Uzan (1985) with the octahedral shear stress; equation 1 of Kathirgamanathan and Vignarajah. thp is a smooth
// floor of theta: equal to it in compression, positive in tension.
#pragma once

#include "material/law.h"

namespace pave::material {

const Law& uzan();

} // namespace pave::material
