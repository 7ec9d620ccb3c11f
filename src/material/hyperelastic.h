// Cross-anisotropic, with a strain that is a function of the stress alone:
//     strain = A stress / E,   E = k1 pa ((Q + delta^2)/pa^2)^(k/2),   Q = stress : A : stress
// with A the compliance of unit modulus and the whole stress, initial and of the load. It is the gradient of
//     Psi = pa / (k1 (2 - k)) ((Q + delta^2)/pa^2)^(1 - k/2),
// convex for k < 1: a closed cycle of stress leaves no strain and makes no work, and a section has one answer, in
// tension too. Moduli grow with stress to the power k; along a straight path from no stress the tangent modulus is
// E/(1 - k). delta keeps the modulus from zero without stress and the energy an energy.
// Sources: Houlsby, Amorosi and Rojas, Elastic moduli of soils dependent on pressure: a hyperelastic formulation,
// Geotechnique 55 (2005); the anisotropy within the invariant as in Cudny and Staszewska, A hyperelastic model for
// soils with stress-induced and inherent anisotropy, Acta Geotechnica 16 (2021), doi 10.1007/s11440-021-01159-z. With n
// = 1 the invariant is that of Lade and Nelson (1987): Q = (1 - 2 nu)/3 (theta^2 + R J2).
#pragma once

#include "material/law.h"

namespace pave::material {

const Law& hyperelastic();

} // namespace pave::material
