// Uzan's law in the octahedral form, cross-anisotropic:
//     E = k1 pa (thp/pa)^k2 (tau/pa + 1)^k3,   thp = (theta + sqrt(theta^2 + 4 (delta^2 + eta^2 tau^2))) / 2
// Source: Uzan (1985) with the octahedral shear stress; equation 1 of Kathirgamanathan and Vignarajah. thp is a smooth
// floor of theta: equal to it in compression, positive in tension.
#pragma once

#include "base/units.h"
#include "material/stress_dependent.h"

#include <cmath>

namespace pave::material {

// Stress as the formula sees it: E = k1 pa exp(k2 confinement + k3 distortion).
struct UzanStress {
    double thp, tau; // Pa
    double confinement = std::log(thp / unit::reference_pressure);
    double distortion = std::log1p(tau / unit::reference_pressure);

    double factor(double k2, double k3) const { return std::exp(k2 * confinement + k3 * distortion); }
    // Of a value that is proportional to the factor.
    double by_thp(double value, double k2) const { return value * k2 / thp; }
    double by_tau(double value, double k3) const { return value * k3 / (tau + unit::reference_pressure); }
};

// k3.
ParameterInfo distortion_info(std::string_view meaning);

const Law& uzan();

} // namespace pave::material
