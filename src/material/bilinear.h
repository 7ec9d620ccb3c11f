// The modulus of a fine-grained subgrade as two straight lines over the deviator stress (Thompson and Robnett 1979,
// Transportation Engineering Journal 105).
#pragma once

#include "material/law.h"

namespace pave::material {

const Law& bilinear();

} // namespace pave::material
