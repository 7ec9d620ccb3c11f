// Rows as linear functions of a step, those of limits as far as they are beyond.
#pragma once

#include "optimise/local_search.h"
#include "optimise/quadratic.h"

namespace explore::optimise {

class LinearRows {
public:
    // Of a sample with derivatives. curvature: half of d.(curvature d) is added; empty: none. Both must outlive this.
    LinearRows(const Sample& here, const Eigen::MatrixXd& curvature);

    // Half of the sum of squares at that step.
    double half(const Eigen::VectorXd& d) const;

    // The lowest point between low and high, where damping / 2 |d|^2 is added: by ever other sets of limits that count,
    // until the set is that beyond which its own step leads.
    Eigen::VectorXd lowest(double damping, const Eigen::VectorXd& low, const Eigen::VectorXd& high) const;

private:
    Quadratic quadratic(double damping, const std::vector<char>& counts) const;

    const Sample& here_;
    const Eigen::MatrixXd& curvature_;
    Eigen::VectorXd residuals_; // without those of limits
    Eigen::MatrixXd jacobian_;
};

} // namespace explore::optimise
