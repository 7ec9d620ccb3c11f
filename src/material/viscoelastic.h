// Linear viscoelasticity of an isotropic material with a Prony series and one Poisson's ratio, for bound layers under
// loads of a given duration:
//
//     E(t) = E0 (1 - sum of g_i (1 - exp(-t / (aT tau_i))))        ln aT = H/R (1/T - 1/T0), T in kelvin (Arrhenius)
#pragma once

#include "material/law.h"

namespace pave::material {

const Law& viscoelastic();

} // namespace pave::material
