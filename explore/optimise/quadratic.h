// Linear least squares with bounds, the heart of a Gauss-Newton step.
#pragma once

#include <Eigen/Dense>

namespace explore::optimise {

// |root d + rest|^2 / 2 as a function of a step d: that of any number of rows in as many as there are unknowns, made by
// a QR decomposition with rows sorted and columns pivoted, which keeps the relative accuracy of rows of very unequal
// size (Powell and Reid 1969; Cox and Higham 1998, BIT 38). Normal equations would square that inequality.
struct Quadratic {
    Eigen::MatrixXd root; // n x n
    Eigen::VectorXd rest; // n

    // Of rows r + J d, and of damping / 2 |d|^2, which keeps directions that no row sees where they are. damping > 0.
    static Quadratic of(const Eigen::MatrixXd& jacobian, const Eigen::VectorXd& residuals, double damping);

    // The same with half of d.(curvature d) added: curvature is cut where the sum would not be convex.
    Quadratic curved(const Eigen::MatrixXd& curvature) const;

    // The d with low <= d <= high, low <= 0 <= high, that minimises it: a primal active set method.
    Eigen::VectorXd lowest(const Eigen::VectorXd& low, const Eigen::VectorXd& high) const;
};

} // namespace explore::optimise
