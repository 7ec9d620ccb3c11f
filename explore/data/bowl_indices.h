// The trade's indices of a deflection bowl, besides the deflections.
//
//     SCI  = D0 - D300      surface curvature index: the bound layers
//     BDI  = D300 - D600    base damage index
//     BCI  = D600 - D900    base curvature index: the top of the subgrade
//     AREA = 150 mm (1 + 2 D300/D0 + 2 D600/D0 + D900/D0)     AASHTO Guide (1993), its 12 in taken as 300 mm
//     RoC  = L^2 / (2 D0 (1 - D200/D0)), L = 200 mm           radius of curvature; Horak (2008), J. SAICE 50(2)
//     E0   = 2 (1 - nu^2) p a / D0                            surface moduli: of the half-space that deflects as much
//     E(r) = (1 - nu^2) p a^2 / (r D(r)), r >= 2 a            Boussinesq; Ullidtz (1987), Pavement Analysis; nu = 0.35
//
//     Evd  = 1.5 p a / D0                                     light deflectometers, of a plate that spreads stiffly:
//                                                             22.5 / D0 [mm] for 100 kPa on 150 mm (TP BF-StB B 8.3)
//
// p: pressure, a: radius of the plate. Deflections between sensors as in deflection_bowl.h.
#pragma once

#include "data/deflection_bowl.h"

namespace explore::data {

inline constexpr double surface_modulus_poisson = 0.35;

struct SurfaceModulus {
    double offset_mm = 0.0;
    double modulus_MPa = 0.0;
};

struct BowlIndices {
    double d0_um = 0.0;
    std::optional<double> sci_um{}, bdi_um{}, bci_um{}; // nothing: no sensors from which to tell
    std::optional<double> area_mm{};
    std::optional<double> curvature_radius_m{};
    std::optional<double> evd_MPa{};              // where there is no sensor but the centre, and no more than 20 kN
    std::vector<SurfaceModulus> surface_moduli{}; // by offset, the centre first
};

// pressure_kPa: that the deflections are scaled to, in proportion.
BowlIndices indices_of(const DeflectionBowl& bowl, double pressure_kPa);

} // namespace explore::data
