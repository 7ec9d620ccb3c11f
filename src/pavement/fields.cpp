#include "pavement/fields.h"

#include "fe/solver.h"

namespace pave::pavement {
namespace {

Eigen::Vector3d in_space(const auto& at) {
    if constexpr (std::decay_t<decltype(at)>::RowsAtCompileTime == 2) {
        return {at[0], 0.0, at[1]};
    } else {
        return at;
    }
}

// Values at the nodes from those at the Gauss points: nodes x points.
template <class Element>
Eigen::Matrix<double, Element::nodes, Element::gauss> extrapolation() {
    Eigen::Matrix<double, Element::nodes, Element::gauss> weights;
    const auto positions = Element::gauss_positions();
    for (int i = 0; i < Element::nodes; ++i) {
        for (int g = 0; g < Element::gauss; ++g) {
            weights(i, g) = 1.0;
            for (int d = 0; d < Element::dim; ++d) {
                weights(i, g) *= (1.0 + 3.0 * positions[static_cast<std::size_t>(g)][d] * Element::local[i][d]) / 2.0;
            }
        }
    }
    return weights;
}

} // namespace

template <class Element>
Fields fields_of(const fe::Model<Element>& model, const std::vector<fe::LayerMaterial>& layers,
                 const fe::Solution<Element>& solution) {
    constexpr int N = Element::voigt;
    const auto at_nodes = extrapolation<Element>();
    std::vector<int> elements; // those that end
    Fields f;
    f.nodes = Element::nodes;
    for (int e = 0; e < model.elements(); ++e) {
        const auto& endless = model.topology->endless;
        if (endless.empty() || endless[static_cast<std::size_t>(e)] == 0) {
            elements.push_back(e);
            f.layer.push_back(model.topology->layer[static_cast<std::size_t>(e)]);
        }
    }
    const Eigen::Index points = static_cast<Eigen::Index>(elements.size()) * Element::nodes;
    f.position.resize(3, points);
    f.displacement.resize(3, points);
    f.strain.setZero(6, points);
    f.stress.setZero(6, points);
    for (auto* numbers : {&f.theta, &f.tau, &f.horizontal_modulus, &f.vertical_modulus}) {
        numbers->resize(points);
    }
    for (std::size_t n = 0; n < elements.size(); ++n) {
        const int e = elements[n];
        const auto& layer = layers[static_cast<std::size_t>(f.layer[n])];
        const auto moved = model.gather(e, solution.displacement.data());
        Eigen::Matrix<double, N, Element::gauss> strain;
        for (int g = 0; g < Element::gauss; ++g) {
            strain.col(g) = Element::strain(
                model.points[static_cast<std::size_t>(e) * Element::gauss + static_cast<std::size_t>(g)], moved);
        }
        const Eigen::Matrix<double, N, Element::nodes> strain_there = strain * at_nodes.transpose();
        const Eigen::Matrix<double, N, Element::nodes> stress_there =
            solution.stress.middleCols(static_cast<Eigen::Index>(e) * Element::gauss, Element::gauss) *
            at_nodes.transpose();
        for (int i = 0; i < Element::nodes; ++i) {
            const Eigen::Index k = static_cast<Eigen::Index>(n) * Element::nodes + i;
            const Eigen::Vector3d at = in_space(model.coordinates[static_cast<std::size_t>(e)].col(i).eval());
            f.position.col(k) = at;
            f.displacement.col(k) = in_space(moved.template segment<Element::dim>(Element::dim * i).eval());
            f.strain.col(k).template head<N>() = strain_there.col(i);
            f.stress.col(k).template head<N>() = stress_there.col(i);
            const auto invariants =
                mechanics::invariants<N>(layer.template initial_stress<N>(at[2]) + stress_there.col(i));
            f.theta[k] = invariants.theta;
            f.tau[k] = invariants.tau;
            const mechanics::Stiffness<6> compliance = fe::local_stiffness(layer, at, invariants).inverse();
            double modulus = 0.0;
            if (const material::Energy* energy = layer.law->energy()) {
                const mechanics::Voigt<N> whole = layer.template initial_stress<N>(at[2]) + stress_there.col(i);
                const mechanics::Stiffness<N> own =
                    fe::local_factor(layer, at) * compliance.template topLeftCorner<N, N>();
                modulus = energy->secant(layer.parameters, whole.dot(own * whole)).value;
            } else {
                modulus = layer.law->modulus(layer.parameters, invariants).value;
            }
            f.horizontal_modulus[k] = modulus / compliance(0, 0);
            f.vertical_modulus[k] = modulus / compliance(2, 2);
        }
    }
    return f;
}

template Fields fields_of(const fe::Model<fe::AxisymmetricQ8>&, const std::vector<fe::LayerMaterial>&,
                          const fe::Solution<fe::AxisymmetricQ8>&);
template Fields fields_of(const fe::Model<fe::Hex20>&, const std::vector<fe::LayerMaterial>&,
                          const fe::Solution<fe::Hex20>&);

} // namespace pave::pavement
