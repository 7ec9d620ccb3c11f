// E = k1 pa (thp/pa)^k2: stiffens with confinement, does not see shear. Source: Hicks and Monismith (1971).
#pragma once

#include "material/law.h"

namespace pave::material {

const Law& k_theta();

} // namespace pave::material
