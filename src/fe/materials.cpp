#include "fe/materials.h"

#include <cmath>

namespace pave::fe {
namespace {

// The parameters at a point, and what the law's own unit stiffness is multiplied by there.
struct Local {
    std::vector<double> parameters;
    double factor = 1.0;
};

Local local_of(const LayerMaterial& layer, const Eigen::Vector3d& at) {
    Local local{.parameters = layer.parameters};
    for (const Field& field : layer.fields) {
        const double share = field.size * field.weight(field.shape, at);
        if (field.parameter) {
            double& p = local.parameters[*field.parameter];
            p += share * (field.target - p);
        } else {
            local.factor *= field.is_power ? std::exp(share) : 1.0 + share;
        }
    }
    return local;
}

} // namespace

mechanics::Stiffness<6> local_stiffness(const LayerMaterial& layer, const Eigen::Vector3d& at,
                                        mechanics::Invariants state) {
    const Local local = local_of(layer, at);
    return local.factor * layer.law->unit_stiffness(local.parameters, state);
}

material::UnitGradient local_stiffness_gradient(const LayerMaterial& layer, const Eigen::Vector3d& at,
                                                mechanics::Invariants state) {
    const Local local = local_of(layer, at);
    const auto gradient = layer.law->unit_stiffness_gradient(local.parameters, state);
    return {.d_theta = local.factor * gradient.d_theta, .d_tau = local.factor * gradient.d_tau};
}

double local_factor(const LayerMaterial& layer, const Eigen::Vector3d& at) {
    return local_of(layer, at).factor;
}

double local_factor_rate(const LayerMaterial& layer, int at_layer, const Eigen::Vector3d& at,
                         const Variation& variation) {
    if (variation.layer != at_layer || variation.kind != Variation::Kind::field) {
        return 0.0;
    }
    const Field& field = layer.fields[variation.index];
    const double weight = field.weight(field.shape, at);
    if (field.parameter) {
        return 0.0;
    }
    return field.is_power ? weight : weight / (1.0 + field.size * weight);
}

mechanics::Stiffness<6> local_stiffness_rate(const LayerMaterial& layer, int at_layer, const Eigen::Vector3d& at,
                                             mechanics::Invariants state, const Variation& variation) {
    using Kind = Variation::Kind;
    const bool own = variation.layer == at_layer;
    if (!own || (variation.kind != Kind::law_parameter && variation.kind != Kind::field)) {
        return mechanics::Stiffness<6>::Zero();
    }
    const Local local = local_of(layer, at);
    // How the parameter at the point follows the quantity: through the fields that come after it.
    const auto passed_on = [&](std::size_t parameter, std::size_t first) {
        double rate = 1.0;
        for (std::size_t i = first; i < layer.fields.size(); ++i) {
            const Field& field = layer.fields[i];
            if (field.parameter == parameter) {
                rate *= 1.0 - field.size * field.weight(field.shape, at);
            }
        }
        return rate;
    };
    if (variation.kind == Kind::law_parameter) {
        return local.factor * passed_on(variation.index, 0) *
               layer.law->unit_stiffness_derivative(local.parameters, state, variation.index);
    }
    const Field& field = layer.fields[variation.index];
    const double weight = field.weight(field.shape, at);
    if (!field.parameter) {
        return local.factor * local_factor_rate(layer, at_layer, at, variation) *
               layer.law->unit_stiffness(local.parameters, state);
    }
    double before = layer.parameters[*field.parameter];
    for (std::size_t i = 0; i < variation.index; ++i) {
        const Field& earlier = layer.fields[i];
        if (earlier.parameter == field.parameter) {
            before += earlier.size * earlier.weight(earlier.shape, at) * (earlier.target - before);
        }
    }
    return local.factor * weight * (field.target - before) * passed_on(*field.parameter, variation.index + 1) *
           layer.law->unit_stiffness_derivative(local.parameters, state, *field.parameter);
}

} // namespace pave::fe
