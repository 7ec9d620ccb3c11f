// E = m pa ((theta^2 + R J2 + delta^2)/pa^2)^lambda with J2 = 3/2 tau^2 and R = 6 (1 + nu)/(1 - 2 nu): the one way in
// which the modulus of an isotropic material with constant Poisson's ratio may depend on stress without any closed
// cycle of stress making or eating work, for theta^2 + R J2 is in proportion to the energy of that stress at a modulus
// of 1. It stiffens in tension as in compression. Source: Lade and Nelson (1987).
#pragma once

#include "material/law.h"

namespace pave::material {

const Law& lade_nelson();

} // namespace pave::material
