// The motion of the surface of a stack of isotropic layers under a vertical pulse on a circle: what finite elements in
// steps of time are checked against.
//
// Fourier transform in time, Hankel transform in the distance, and in each layer the downward and upward P and SV waves
// of the potentials phi and psi,
//     u_r = -k (phi + psi') J1(k r),    u_z = (phi' + k^2 psi) J0(k r),
//     sigma_zz = ((2 mu k^2 - rho w^2) phi + 2 mu k^2 psi') J0,   sigma_rz = -mu k (2 phi' + (2 k^2 - w^2/cs^2) psi)
//     J1,
// whose amplitudes follow from the surface, the interfaces and the bottom: W. T. Thomson (1950), "Transmission of
// elastic waves through a stratified solid medium"; E. Kausel, "Fundamental Solutions in Elastodynamics" (2006),
// chapter 10. The frequency has an imaginary part (Kausel and Roesset 1992, "Frequency domain analysis of undamped
// systems"), so that what comes before and after the window fades. Damping: stress = D (strain + damping_time
// d(strain)/dt).
#pragma once

#include <span>
#include <vector>

namespace pave::reference {

struct MovingLayer {
    double thickness;    // m; ignored for the last layer of a stack on a half-space
    double modulus;      // Pa
    double poisson;      // -
    double density;      // kg/m3
    double damping_time; // s
    // Share of the modulus that fades, and its time of relaxation [s]: E(t) = E (1 - share + share exp(-t/time)).
    double fading_share = 0.0;
    double fading_time = 1.0;
};

// Deflections [m, down] at the radii (a row each) and times (not above `window`) under sin^2(pi t / duration) times
// the pressure [Pa] on a circle. The error is some 1e-3 of the largest.
std::vector<std::vector<double>> layered_pulse(std::span<const MovingLayer> layers, bool half_space, double radius,
                                               double pressure, double duration, std::span<const double> radii,
                                               std::span<const double> times);

} // namespace pave::reference
