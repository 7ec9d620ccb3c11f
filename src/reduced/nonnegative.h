// Least squares with non-negative unknowns.
#pragma once

#include <Eigen/Core>

namespace pave::reduced {

// x >= 0 with |a x - b| <= tolerance |b| and few positive entries, at most `most`: the active set method of Lawson and
// Hanson (Solving Least Squares Problems, 1974, chapter 23), ended as soon as the tolerance is met.
Eigen::VectorXd nonnegative_least_squares(const Eigen::MatrixXd& a, const Eigen::VectorXd& b, double tolerance,
                                          int most);

} // namespace pave::reduced
