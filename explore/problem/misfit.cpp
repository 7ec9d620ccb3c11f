#include "problem/misfit.h"

#include <cmath>

namespace explore::problem {

Misfit::Misfit(MisfitKind kind, std::vector<double> measured, std::vector<double> scale)
    : kind_(kind),
      measured_(std::move(measured)),
      scale_(std::move(scale)) {}

Eigen::VectorXd Misfit::residuals(std::span<const double> responses) const {
    Eigen::VectorXd r(static_cast<Eigen::Index>(size()));
    for (std::size_t i = 0; i < size(); ++i) {
        r[static_cast<Eigen::Index>(i)] = kind_ == MisfitKind::log ? std::asinh(responses[i] / (2.0 * scale_[i])) -
                                                                         std::asinh(measured_[i] / (2.0 * scale_[i]))
                                                                   : (responses[i] - measured_[i]) / scale_[i];
    }
    return r;
}

Eigen::VectorXd Misfit::slopes(std::span<const double> responses) const {
    Eigen::VectorXd d(static_cast<Eigen::Index>(size()));
    for (std::size_t i = 0; i < size(); ++i) {
        d[static_cast<Eigen::Index>(i)] =
            kind_ == MisfitKind::log ? 1.0 / std::hypot(responses[i], 2.0 * scale_[i]) : 1.0 / scale_[i];
    }
    return d;
}

} // namespace explore::problem
