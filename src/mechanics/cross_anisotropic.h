// The stiffness of a cross-anisotropic solid whose axis of symmetry is vertical.
#pragma once

#include "mechanics/voigt.h"

#include <optional>
#include <string>

namespace pave::mechanics {

// E1: modulus in the plane of isotropy (horizontal), E3: vertical. n = E1/E3 = nu13/nu31.
struct CrossAnisotropy {
    double n = 1.0;
    double nu12 = 0.0;                 // in the plane
    double nu31 = 0.0;                 // horizontal strain from vertical load
    std::optional<double> shear_ratio; // G13/E3; without it 1/G13 = 1/E1 + (1 + 2 nu31)/E3
    bool modulus_is_vertical = false;  // which of E1, E3 the unit modulus of unit_stiffness() is

    // The compliance formulas give: nu13 = n nu31, L = 1/(1 - nu12^2 - 2 nu13 nu31 - 2 nu12 nu13 nu31),
    // D11 = E1 (1 - nu13 nu31) L, D33 = E3 (1 - nu12^2) L, D12 = E1 (nu12 + nu31 nu13) L,
    // D13 = E1 (nu31 + nu12 nu31) L, D1212 = E1/(2 (1 + nu12)), D1313 = D2323 = G13.
    // Dimensionless: the stiffness divided by the modulus named by modulus_is_vertical.
    Stiffness<6> unit_stiffness() const;

    enum class Variable { n, nu12, nu31, shear_ratio };
    // Derivative of unit_stiffness() with respect to one of its four numbers, exact.
    Stiffness<6> unit_stiffness_derivative(Variable variable) const;

    // The same in every direction, and the derivative of its unit_stiffness() by Poisson's ratio.
    static CrossAnisotropy isotropic(double nu) { return {.n = 1.0, .nu12 = nu, .nu31 = nu, .shear_ratio = {}}; }
    static Stiffness<6> isotropic_derivative(double nu) {
        return isotropic(nu).unit_stiffness_derivative(Variable::nu12) +
               isotropic(nu).unit_stiffness_derivative(Variable::nu31);
    }

    // Why the numbers are thermodynamically impossible (strain energy not positive), or "" when they are possible:
    // n > 0, |nu12| < 1, 1 - nu12 - 2 n nu31^2 > 0, G > 0.
    std::string impossible() const;
};

} // namespace pave::mechanics
