// Errors of a reduced model: a correction that predicts them, and the quality of its estimates.
#pragma once

#include "reduced/basis.h"
#include "reduced/reduced_load.h"

namespace pave::reduced {

// Readings of the full model and the reduced one at the same sample.
struct Comparison {
    std::vector<fe::LayerMaterial> layers;
    pavement::Load load;
    std::vector<double> full;
    pavement::LoadModel::Reading quick;
};

// Gives a basis its coordinates, correction, factor and floor, of a load of the case c that the runs are cases of.
// runs: the first `of_modes` are those that the modes are from, the others, one at least, were seen by neither the
// modes nor, for this, the correction. Returns what the largest error of a run is below at 95 of 100 of these others.
double calibrate(Basis& basis, const pavement::Case& c, int load, const std::vector<Comparison>& runs,
                 std::size_t of_modes, const ForEach& for_each);

} // namespace pave::reduced
