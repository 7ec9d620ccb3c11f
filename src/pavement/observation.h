// Sensors as linear functionals of a finite element solution.
#pragma once

#include "fe/functional.h"
#include "fe/model.h"
#include "pavement/section.h"

namespace pave::pavement {

// A reading; signs are those of Quantity.
template <class Element>
using Observation = fe::Functional<Element>;

// `chosen` tells which cells and Gauss points are read: the mesh itself, or the one that this is a motion of.
// Deflections and gauge strains come from the displacement itself. Strains and stresses at a point are interpolated
// from the Gauss points around it, where they are most accurate: cubic in each direction, within the layer (strains
// jump at interfaces; exactly on one, the layer below is read). In layers marked as `incompressible` the mean of the
// normal stresses is that of the polynomial that has the means of the cells around the point, likewise cubic; none: of
// no layer. A sensor with shares reads their weighted sum. Its gain
// is not part of the observation.
Observation<fe::AxisymmetricQ8> observe(const Sensor& sensor, const mesh::AxisymmetricMesh& mesh,
                                        const fe::Model<fe::AxisymmetricQ8>& model,
                                        const mesh::AxisymmetricMesh& chosen,
                                        const std::vector<bool>& incompressible = {});
// Loads are symmetric to x = 0 and y = 0: a sensor on another side is read in the quarter that is modelled.
Observation<fe::Hex20> observe(const Sensor& sensor, const mesh::SolidMesh& mesh, const fe::Model<fe::Hex20>& model,
                               const mesh::SolidMesh& chosen, const std::vector<bool>& incompressible = {});

} // namespace pave::pavement
