// Indices of a bowl by the AASHTO Guide for Design of Pavement Structures (1993), part III, 5.3.4.
//
//     M_R  = 0.24 P / (r D(r))                              subgrade, of the first sensor at r >= 0.7 a_e
//     D0   = 1.5 p a (1 / (M_R sqrt(1 + (H/a)^2 (E_p/M_R)^(2/3))) + (1 - 1 / sqrt(1 + (H/a)^2)) / E_p)   gives E_p
//     a_e  = sqrt(a^2 + H^2 (E_p/M_R)^(2/3))
//     SN_eff = 0.0045 H [in] E_p[psi]^(1/3)
//     design M_R = C M_R, C = 0.33 at most
//
// P: load, p: pressure, a: radius of the plate, H: thickness of all layers above the subgrade. Made for flexible
// pavements under some 40 kN (9000 lbf); D0 is to be one at 20 C.
#pragma once

#include "data/deflection_bowl.h"

namespace explore::data {

inline constexpr double design_share = 0.33;

struct StructuralNumber {
    double subgrade_MPa = 0.0; // back-calculated; times design_share for the design
    double pavement_MPa = 0.0; // E_p
    double sn_eff = 0.0;
    double offset_mm = 0.0; // of the sensor that tells the subgrade
};
// d0_um: at the temperature of the guide; nothing: as it was measured. Nothing comes back where no sensor is far
// enough, or no E_p explains D0.
std::optional<StructuralNumber> structural_number(const DeflectionBowl& bowl, double thickness_mm,
                                                  std::optional<double> d0_um = {});

} // namespace explore::data
