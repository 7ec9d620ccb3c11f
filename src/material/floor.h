// The smooth floor of theta: equal to it in compression, positive in tension.
//
//     thp = (theta + sqrt(theta^2 + 4 (delta^2 + eta^2 tau^2))) / 2
#pragma once

#include "mechanics/voigt.h"

#include <cmath>

namespace pave::material {

// thp and the square root in it [Pa], without cancellation in tension.
struct Floor {
    double root;
    double thp;
    double d_theta; // of thp
    double d_tau;
    // delta: Pa. eta: shear counts so much.
    Floor(double delta, double eta, mechanics::Invariants at) {
        const double c = delta * delta + eta * eta * at.tau * at.tau;
        root = std::sqrt(at.theta * at.theta + 4.0 * c);
        thp = at.theta >= 0.0 ? (at.theta + root) / 2.0 : 2.0 * c / (root - at.theta);
        d_theta = thp / root;
        d_tau = 2.0 * eta * eta * at.tau / root;
    }
    // thp by delta, and by eta.
    double by_delta(double delta) const { return 2.0 * delta / root; }
    double by_eta(double eta, double tau) const { return 2.0 * eta * tau * tau / root; }
};

} // namespace pave::material
