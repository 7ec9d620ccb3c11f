// The materials of the layers of a model as the solvers see them: law, parameters, initial stress.
#pragma once

#include "material/law.h"

#include <array>
#include <vector>

namespace pave::fe {

// A variation within a layer: its unit stiffness at a point is that of the law with p[parameter] replaced by
// p + size (target - p) w, or without a parameter the law's own times 1 + size w or, as a power, exp(size w); w is the
// weight at that point. parameter: one that the law's modulus does not depend on.
struct Field {
    using Shape = std::array<double, 4>; // numbers of the weight function
    std::optional<std::size_t> parameter;
    bool is_power = false;
    double target = 0.0; // SI
    double size = 0.0;
    double (*weight)(const Shape& shape, const Eigen::Vector3d& at) = nullptr; // at: x, y, z [m]
    Shape shape{};

    bool operator==(const Field&) const = default;
};

// One layer. Initial stress at depth z: vertical sv = top_stress + unit_weight (z - top), horizontal k0 sv + residual,
// all compression positive [Pa].
struct LayerMaterial {
    const material::Law* law = nullptr;
    std::vector<double> parameters; // SI, in the order of law->parameters()
    double top = 0.0;               // m
    double thickness = 0.0;         // m
    double top_stress = 0.0;        // Pa, weight of what lies above
    double unit_weight = 0.0;       // N/m3
    double k0 = 0.0;
    double residual_stress = 0.0; // Pa
    std::vector<Field> fields{};
    double damping_time = 0.0; // s, under a pulse: stress = E C (strain + damping_time d(strain)/dt)

    // C of a law that does not turn, without fields, and its derivative by a parameter.
    template <int N>
    mechanics::Stiffness<N> unit_stiffness() const {
        return law->unit_stiffness(parameters, {}).template topLeftCorner<N, N>();
    }
    template <int N>
    mechanics::Stiffness<N> unit_stiffness_rate(std::size_t parameter) const {
        return law->unit_stiffness_derivative(parameters, {}, parameter).template topLeftCorner<N, N>();
    }

    double vertical_stress(double z) const { return top_stress + unit_weight * (z - top); }
    double horizontal_stress(double z) const { return k0 * vertical_stress(z) + residual_stress; }

    template <int N>
    mechanics::Voigt<N> initial_stress(double z) const { // tension positive
        mechanics::Voigt<N> s = mechanics::Voigt<N>::Zero();
        s[0] = s[1] = -horizontal_stress(z);
        s[2] = -vertical_stress(z);
        return s;
    }
    // Change of the initial stress with the vertical stress.
    template <int N>
    mechanics::Voigt<N> initial_stress_of_weight(double vertical) const {
        mechanics::Voigt<N> s = mechanics::Voigt<N>::Zero();
        s[0] = s[1] = -k0 * vertical;
        s[2] = -vertical;
        return s;
    }
};

// A quantity the response is differentiated by.
struct Variation {
    enum class Kind {
        law_parameter,   // parameters[index] of the layer
        unit_weight,     // of the layer
        k0,              // of the layer
        residual_stress, // of the layer
        load_factor,     // a factor on the whole load
        pressure_shape,  // of the load
        field,           // size of fields[index] of the layer
        spring,          // stiffness of spring `index` of the model
        inertia,         // the factor on mass and damping under a pulse
        damping,         // the damping time of the layer
        time_shift,      // of what is read under a pulse; the solution does not depend on it
        duration,        // of the load, by its logarithm; the factors of its history stay
        motion           // of the mesh: number `index` of the motions given to the solver
    };
    Kind kind = Kind::law_parameter;
    int layer = 0;
    std::size_t index = 0;
    Eigen::VectorXd load_rate{}; // pressure_shape: of the load on every free unknown [N]
};

// The unit stiffness of a layer at a point and a stress state; its derivatives by that state, and at that state by a
// quantity of layer number `at_layer`.
mechanics::Stiffness<6> local_stiffness(const LayerMaterial& layer, const Eigen::Vector3d& at,
                                        mechanics::Invariants state);
material::UnitGradient local_stiffness_gradient(const LayerMaterial& layer, const Eigen::Vector3d& at,
                                                mechanics::Invariants state);
mechanics::Stiffness<6> local_stiffness_rate(const LayerMaterial& layer, int at_layer, const Eigen::Vector3d& at,
                                             mechanics::Invariants state, const Variation& variation);

// The factor of its fields without a parameter on the stiffness of a layer at a point, and the rate of the logarithm of
// that by a quantity of layer number `at_layer`.
double local_factor(const LayerMaterial& layer, const Eigen::Vector3d& at);
double local_factor_rate(const LayerMaterial& layer, int at_layer, const Eigen::Vector3d& at,
                         const Variation& variation);

// Derivative of the initial stress in layer `at` at depth z, where the mesh does not move.
template <int N>
mechanics::Voigt<N> initial_stress_rate(const std::vector<LayerMaterial>& layers, int at, double z,
                                        const Variation& variation) {
    double vertical = 0.0;
    double horizontal = 0.0;
    const LayerMaterial& layer = layers[at];
    switch (variation.kind) {
    case Variation::Kind::unit_weight:
        vertical = variation.layer == at  ? z - layer.top
                   : variation.layer < at ? layers[variation.layer].thickness
                                          : 0.0;
        horizontal = layer.k0 * vertical;
        break;
    case Variation::Kind::k0: horizontal = variation.layer == at ? layer.vertical_stress(z) : 0.0; break;
    case Variation::Kind::residual_stress: horizontal = variation.layer == at ? 1.0 : 0.0; break;
    default: break;
    }
    mechanics::Voigt<N> s = mechanics::Voigt<N>::Zero();
    s[0] = s[1] = -horizontal;
    s[2] = -vertical;
    return s;
}

// dE/dsigma, a vector in the Voigt order (tension positive stress).
template <int N>
mechanics::Voigt<N> modulus_gradient(const material::Modulus& m, mechanics::Invariants at,
                                     const mechanics::Voigt<N>& stress) {
    mechanics::Voigt<N> q = mechanics::Voigt<N>::Zero();
    q[0] = q[1] = q[2] = -m.d_theta;
    if (at.tau > 0.0) {
        q += (m.d_tau / at.tau) * mechanics::tau_times_gradient<N>(stress);
    }
    return q;
}

} // namespace pave::fe
