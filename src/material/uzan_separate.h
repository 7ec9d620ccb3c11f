// Uzan's law in the octahedral form for each of three moduli of a cross-anisotropic solid, with k's of their own:
//     E3 (vertical), E1 (horizontal), G13 = k1 pa (thp/pa)^k2 (tau/pa + 1)^k3
// so that n = E1/E3 and G13/E3 follow stress too. n stays between two limits. Poisson's ratios are constant.
// Source: GT-PAVE (Tutumluer 1995; Tutumluer and Thompson, TRR 1577, 1997), which has the bulk and deviator stress.
#pragma once

#include "material/law.h"

namespace pave::material {

const Law& uzan_separate();

} // namespace pave::material
