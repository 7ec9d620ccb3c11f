// The semi-analytic response of a stack of isotropic linear elastic layers, fully bonded, to a uniform vertical
// pressure on a circle: what finite elements are checked against.
//
// Sources: D. M. Burmister, "The general theory of stresses and displacements in layered soil systems" (1945);
// I. N. Sneddon, "Fourier Transforms" (1951), for the Hankel transform of the equations of elasticity; Y. H. Huang,
// "Pavement Analysis and Design", appendix B; G. Eason, B. Noble, I. N. Sneddon, "On certain integrals of
// Lipschitz-Hankel type involving products of Bessel functions" (1955), for the half-space under a circle.
//
// Accuracy: better than 1e-10 of the largest value of the same quantity at the same depth, at the surface, on the axis
// and at the edge of the circle too. Results far from the load that are much smaller than that lose digits.
// Limits: at z = 0 and r = radius, where the pressure jumps, stress and strain are the mean of their values on both
// sides. The work grows with (radius + r)/d, where d is z below the first interface and 2 h - z in a first layer of
// thickness h: below 10 ms up to (radius + r)/d = 100.
#pragma once

#include <span>

namespace pave::reference {

struct ElasticLayer {
    double thickness; // m; ignored for the last layer of a stack on a half-space
    double modulus;   // Pa
    double poisson;   // -; above -1, not above 0.5
};

enum class Floor {
    half_space,  // the last layer has no bottom
    rigid_rough, // u_r = u_z = 0 below the last layer
};

// z positive downwards; stress [Pa] and strain [-] positive in tension; displacement [m].
struct ElasticField {
    double u_z, u_r;
    double sigma_rr, sigma_tt, sigma_zz, sigma_rz;
    double eps_rr, eps_tt, eps_zz;
};

// layers: top to bottom. radius [m] and pressure [Pa] of the loaded circle. r [m] from its axis, z [m] below the
// surface. A depth within 1e-12 (relative) of an interface belongs to the layer below it, at a rigid floor to the last
// layer. Throws std::invalid_argument for a layer, a radius or a point that cannot be.
ElasticField multilayer_elastic(std::span<const ElasticLayer> layers, Floor floor, double radius, double pressure,
                                double r, double z);

} // namespace pave::reference
