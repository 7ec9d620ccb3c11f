// A space that displacements may be looked for in.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace pave::fe {

// Few displacement fields, and the Gauss points of stress-dependent layers that stand for all of them.
struct Subspace {
    Eigen::MatrixXd modes; // free unknowns x modes
    struct Point {
        int gauss = 0;      // number in the model
        double share = 0.0; // its weight there, of the volume that it has in the model
    };
    std::vector<Point> points;
};

} // namespace pave::fe
