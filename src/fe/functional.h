// Linear functionals of a finite element solution.
#pragma once

#include <Eigen/Core>
#include <utility>
#include <vector>

namespace pave::fe {

using Weights = std::vector<std::pair<int, double>>; // (free unknown, weight)

inline double weighted(const Weights& weights, const double* u) {
    double value = 0.0;
    for (const auto& [unknown, weight] : weights) {
        value += weight * u[unknown];
    }
    return value;
}

// Weights on the free unknowns, or (stresses) weights on the load stress of Gauss points, each contracted with a
// direction.
template <class Element>
struct Functional {
    struct AtPoint {
        int point; // Gauss point of the model
        double weight;
        typename Element::Stress direction;
    };
    Weights on_displacement;
    std::vector<AtPoint> on_stress;

    double of_displacement(const double* u) const { return weighted(on_displacement, u); }
    // stress: column point * stride + offset.
    template <class Stresses>
    double of_stress(const Stresses& stress, Eigen::Index stride, Eigen::Index offset) const {
        double value = 0.0;
        for (const auto& [point, weight, direction] : on_stress) {
            value += weight * direction.dot(stress.col(point * stride + offset));
        }
        return value;
    }
};

} // namespace pave::fe
