// Stress and strain as vectors, and the two invariants that granular materials react to.
//
// Order of components: xx, yy, zz, xz, yz, xy; strains carry engineering shear (gamma = 2 epsilon). An axisymmetric
// state uses the first four with x = radial, y = circumferential, z = depth. Tension is positive.
#pragma once

#include <Eigen/Dense>
#include <cmath>

namespace pave::mechanics {

template <int N>
using Voigt = Eigen::Matrix<double, N, 1>; // N = 4 axisymmetric, 6 three-dimensional
template <int N>
using Stiffness = Eigen::Matrix<double, N, N>;

// theta = s1 + s2 + s3, compression positive [Pa], and tau = octahedral shear stress [Pa].
struct Invariants {
    double theta = 0.0;
    double tau = 0.0;
};

template <class V>
double octahedral_shear(const V& s) {
    double shear = s[3] * s[3];
    if constexpr (V::RowsAtCompileTime == 6) {
        shear += s[4] * s[4] + s[5] * s[5];
    }
    const double a = s[0] - s[1];
    const double b = s[1] - s[2];
    const double c = s[2] - s[0];
    return std::sqrt(a * a + b * b + c * c + 6.0 * shear) / 3.0;
}

template <int N>
Invariants invariants(const Voigt<N>& stress) {
    return {-(stress[0] + stress[1] + stress[2]), octahedral_shear(stress)};
}

// The gradient of tau times tau with respect to the stress components: d(tau) = (tau_gradient . d(stress)) / tau.
// tau itself is not differentiable at zero; the product is (the deviator divided by three, shear twice).
template <int N>
Voigt<N> tau_times_gradient(const Voigt<N>& stress) {
    const double mean = (stress[0] + stress[1] + stress[2]) / 3.0;
    Voigt<N> gradient = stress * (2.0 / 3.0);
    for (int i = 0; i < 3; ++i) {
        gradient[i] = (stress[i] - mean) / 3.0;
    }
    return gradient;
}

} // namespace pave::mechanics
