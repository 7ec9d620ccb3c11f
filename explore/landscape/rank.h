// How many combinations of parameters readings determine.
#pragma once

#include <Eigen/SVD>

namespace explore::landscape {

// sensitivity: rows in standard deviations by unit coordinates. A direction counts when crossing the box along it moves
// the rows by two standard deviations or more.
inline int rank_of(const Eigen::MatrixXd& sensitivity) {
    constexpr double determined = 2.0;
    const Eigen::JacobiSVD<Eigen::MatrixXd> svd(sensitivity);
    return static_cast<int>((svd.singularValues().array() >= determined).count());
}

} // namespace explore::landscape
