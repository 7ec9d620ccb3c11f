#include "optimise/linear_rows.h"

namespace explore::optimise {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

LinearRows::LinearRows(const Sample& here, const MatrixXd& curvature) : here_(here), curvature_(curvature) {
    std::vector<char> is_limit(static_cast<std::size_t>(here.residuals.size()), 0);
    for (const Index row : here.limit_rows) {
        is_limit[static_cast<std::size_t>(row)] = 1;
    }
    std::vector<Index> always;
    for (Index i = 0; i < here.residuals.size(); ++i) {
        if (is_limit[static_cast<std::size_t>(i)] == 0) {
            always.push_back(i);
        }
    }
    residuals_ = here.residuals(always);
    jacobian_ = here.jacobian(always, Eigen::all);
}

double LinearRows::half(const VectorXd& d) const {
    double sum = (residuals_ + jacobian_ * d).squaredNorm();
    if (here_.limits.size() > 0) {
        sum += (here_.limits + here_.limit_jacobian * d).cwiseMax(0.0).squaredNorm();
    }
    if (curvature_.size() > 0) {
        sum += d.dot(curvature_ * d);
    }
    return 0.5 * sum;
}

VectorXd LinearRows::lowest(double damping, const VectorXd& low, const VectorXd& high) const {
    const Index count = here_.limits.size();
    std::vector<char> counts(static_cast<std::size_t>(count));
    for (Index i = 0; i < count; ++i) {
        counts[static_cast<std::size_t>(i)] = here_.limits[i] > 0.0 ? 1 : 0;
    }
    VectorXd d;
    constexpr int most = 20;
    for (int round = 0; round <= most; ++round) {
        d = quadratic(damping, counts).lowest(low, high);
        bool changed = false;
        for (Index i = 0; i < count; ++i) {
            const char now = here_.limits[i] + here_.limit_jacobian.row(i) * d > 0.0 ? 1 : 0;
            changed |= now != counts[static_cast<std::size_t>(i)];
            counts[static_cast<std::size_t>(i)] = now;
        }
        if (!changed) {
            break;
        }
    }
    return d;
}

Quadratic LinearRows::quadratic(double damping, const std::vector<char>& counts) const {
    std::vector<Index> limits;
    for (std::size_t i = 0; i < counts.size(); ++i) {
        if (counts[i] != 0) {
            limits.push_back(static_cast<Index>(i));
        }
    }
    const auto more = static_cast<Index>(limits.size());
    MatrixXd rows(jacobian_.rows() + more, jacobian_.cols());
    VectorXd right(rows.rows());
    rows.topRows(jacobian_.rows()) = jacobian_;
    right.head(jacobian_.rows()) = residuals_;
    if (more > 0) {
        rows.bottomRows(more) = here_.limit_jacobian(limits, Eigen::all);
        right.tail(more) = here_.limits(limits);
    }
    const Quadratic plain = Quadratic::of(rows, right, damping);
    return curvature_.size() > 0 ? plain.curved(curvature_) : plain;
}

} // namespace explore::optimise
