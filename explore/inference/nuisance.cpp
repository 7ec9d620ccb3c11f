#include "inference/nuisance.h"

#include <Eigen/SVD>
#include <algorithm>

namespace explore::inference {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

Nuisance::Nuisance(const MatrixXd& jacobian, const std::vector<double>& unit, const VectorXd& residuals) {
    const VectorXd pull = jacobian.transpose() * residuals; // the sum of squares falls against it
    MatrixXd open = jacobian;
    for (Index k = 0; k < open.cols(); ++k) {
        if (is_pressed(unit[static_cast<std::size_t>(k)], pull[k])) {
            open.col(k).setZero();
        }
    }
    constexpr double seen = 1.0;
    const Eigen::JacobiSVD<MatrixXd> svd(open, Eigen::ComputeThinU | Eigen::ComputeThinV);
    const auto rank = static_cast<Index>((svd.singularValues().array() >= seen).count());
    base_ = svd.matrixU().leftCols(rank);
    inverse_ =
        svd.matrixV().leftCols(rank) * svd.singularValues().head(rank).cwiseInverse().asDiagonal() * base_.transpose();
}

VectorXd Nuisance::beyond(const VectorXd& change) const {
    return change - base_ * (base_.transpose() * change);
}

std::vector<double> Nuisance::best_response(const std::vector<double>& unit, const VectorXd& residuals) const {
    const VectorXd step = inverse_ * residuals;
    std::vector<double> point = unit;
    for (std::size_t k = 0; k < point.size(); ++k) {
        point[k] = std::clamp(point[k] - step[static_cast<Index>(k)], 0.0, 1.0);
    }
    return point;
}

} // namespace explore::inference
