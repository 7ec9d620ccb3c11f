// A smooth quantity known at some points of a sample, at all of them: least squares by polynomials of second degree.
#pragma once

#include <Eigen/Core>
#include <optional>

namespace explore::landscape {

struct Smooth {
    Eigen::VectorXd values; // at every point requested
    double left = 0.0;      // root mean square of the values known, each against the surface made without it
};

// known: a row a point; values: there; wanted: a row a point among which the known ones lie. What leaves the range of
// the values by more than three times what is left is cut off. Nothing: fewer than four points a coefficient, of
// the first degree even.
std::optional<Smooth> smooth(const Eigen::MatrixXd& known, const Eigen::VectorXd& values,
                             const Eigen::MatrixXd& wanted);

} // namespace explore::landscape
