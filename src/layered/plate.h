// A concrete slab as an infinite thin elastic plate on a foundation, under a uniform pressure q on a circle of radius
// a.
//
// With Hankel's transform of the plate equation D (d2/dr2 + 1/r d/dr)^2 w + p_f = q,
//     dense liquid (Winkler, Westergaard 1926), p_f = k w, l^4 = D/k:
//         w(r) = (q/k) (a/l) int_0^inf J0(t r/l) J1(t a/l) / (1 + t^4) dt
//     elastic solid (Hogg 1938), of modulus E and Poisson's ratio nu, C = E/(2 (1 - nu^2)), l^3 = D/C:
//         w(r) = (q a/C) int_0^inf J0(t r/l) J1(t a/l) / (t (1 + t^3)) dt
// Under a point load P these are P/(8 k l^2) and P/(3 sqrt(3) C l) at r = 0.
#pragma once

namespace pave::layered {

enum class Foundation { dense_liquid, elastic_solid };

// The deflection at a distance [m] for a foundation of k = 1 Pa/m or C = 1 Pa and a pressure of 1 Pa. radius: of the
// circle, stiffness: the radius of relative stiffness l, both in m and positive. Errors below 1e-8 of the deflection
// under the load.
double plate_deflection(Foundation foundation, double radius, double distance, double stiffness);

// D [N m] of a slab of thickness h: E h^3 / (12 (1 - nu^2)).
double flexural_rigidity(double modulus, double thickness, double poisson);

} // namespace pave::layered
