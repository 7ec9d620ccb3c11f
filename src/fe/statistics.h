// The effort of a run, and remarkable things about its end.
#pragma once

namespace pave::fe {

struct Statistics {
    int load_steps = 0;
    int newton_steps = 0; // of secant and hyperelastic
    int factorizations = 0;
    int iterations = 0;             // of conjugate gradients (3D)
    double residual_relative = 0.0; // |unbalanced force| / |load| at the end
    // Shares of the volume of the stress-dependent layers, weighted by the energy of the load stress.
    double tension_share = 0.0;  // theta < 0
    double unstable_share = 0.0; // d ln E / d ln stress >= 1 along proportional loading
    double limited_share = 0.0;  // modulus limit met
    // Of secant: negative second-order work for some strain, by more than a tenth of the modulus.
    double indefinite_share = 0.0;
    // Under a pulse: the error of the readings by the steps of time, of the largest of their kind; an estimate.
    double time_error = 0.0;
    // Under a pulse: what stress-dependent layers keep of their largest strain when it is over, though their stress
    // does not answer to it, both as roots of energy. Tangents along a path of stress that does not go back the way it
    // came leave some.
    double kept_share = 0.0;
};

} // namespace pave::fe
