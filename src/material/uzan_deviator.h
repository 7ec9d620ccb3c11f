// Uzan's law as published: E = k1 pa (thp/pa)^k2 (sd/pa)^k3 with the deviator stress sd = s1 - s3 of the triaxial test,
// here q = 3/sqrt(2) tau, which is the same there, and kept from zero: sd = sqrt(q^2 + floor^2).
// Source: Uzan (1985), Transportation Research Record 1022.
#pragma once

#include "material/law.h"

namespace pave::material {

const Law& uzan_deviator();

} // namespace pave::material
