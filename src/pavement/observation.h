// Sensors as linear functionals of a finite element solution.
#pragma once

#include "fe/model.h"
#include "pavement/section.h"

namespace pave::pavement {

// A reading: weights on the free unknowns, or (stresses) weights on the load stress of Gauss points, each contracted
// with a direction. Signs are those of Quantity.
template <class Element>
struct Observation {
    struct AtPoint {
        int point; // Gauss point of the model
        double weight;
        typename Element::Stress direction;
    };
    std::vector<std::pair<int, double>> on_displacement; // (unknown, weight)
    std::vector<AtPoint> on_stress;

    double of_displacement(const double* u) const {
        double value = 0.0;
        for (const auto& [unknown, weight] : on_displacement) {
            value += weight * u[unknown];
        }
        return value;
    }
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

// `chosen` tells which cells and Gauss points are read: the mesh itself, or the one that this is a motion of.
// Deflections and gauge strains come from the displacement itself. Strains and stresses at a point are interpolated
// from the Gauss points around it, where they are most accurate: cubic in each direction, within the layer (strains
// jump at interfaces; exactly on one, the layer below is read). A sensor with shares reads their weighted sum. Its gain
// is not part of the observation.
Observation<fe::AxisymmetricQ8> observe(const Sensor& sensor, const mesh::AxisymmetricMesh& mesh,
                                        const fe::Model<fe::AxisymmetricQ8>& model,
                                        const mesh::AxisymmetricMesh& chosen);
// Loads are symmetric to x = 0 and y = 0: a sensor on another side is read in the quarter that is modelled.
Observation<fe::Hex20> observe(const Sensor& sensor, const mesh::SolidMesh& mesh, const fe::Model<fe::Hex20>& model,
                               const mesh::SolidMesh& chosen);

} // namespace pave::pavement
