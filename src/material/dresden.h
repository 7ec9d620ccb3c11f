// The Dresden model: E = (q pa + c pa (sigma3/pa)^q1) (sigma1/pa)^q2 + d, sigma1 and sigma3 the largest and the
// smallest principal stress (Wellner and Gleitz; Werkmeister 2003; without its stress-dependent Poisson's ratio).
//
// In triaxial compression sigma1 = (theta + 2 q)/3 and sigma3 = (theta - q)/3 with q = 3 tau / sqrt 2; these are taken
// for every state, so that the law depends on the invariants alone. Where sigma3 would be in tension it has a smooth
// floor.
#pragma once

#include "material/law.h"

namespace pave::material {

const Law& dresden();

} // namespace pave::material
