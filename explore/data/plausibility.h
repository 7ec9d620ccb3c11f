// Whether what a drop states can be true, before anything is made of it; and by which slip it may have come about.
//
// Ranges, wide enough for light and heavy deflectometers on anything from soil to airfield concrete:
//     radius of the plate      40 to 250 mm
//     pressure                 20 to 4000 kPa
//     deflection at the centre 5 um to 10 mm
//     farthest sensor          within 4 m; with four sensors or more beyond 250 mm
//     surface modulus          1 MPa to 100 GPa, E0 = 2 (1 - 0.35^2) pressure radius / D0 (Boussinesq)
#pragma once

#include "data/fwd.h"

namespace explore::data {

// Why it cannot be true, in words, with the likely slip as a question: "a pressure of 0.707 kPa: MPa in a kPa column?".
// Empty: it can.
std::string implausible(const FwdDrop& drop);

// Possible but uncommon values, where a slip would make them common: the same words, said and not acted upon. Empty:
// nothing. Common are plates of 90 to 230 mm, 200 to 2000 kPa or 20 kN and more (from 40 kPa on where
// there is no sensor but the centre: light deflectometers), and ground of less than 1000 MPa: the
// lowest surface modulus (1 - 0.35^2) pressure radius^2 / (r D(r)) from two radii on.
std::string doubtful(const FwdDrop& drop);

} // namespace explore::data
