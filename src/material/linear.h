// Isotropic linear elasticity: E and Poisson's ratio.
#pragma once

#include "material/law.h"

namespace pave::material {

const Law& linear();

} // namespace pave::material
