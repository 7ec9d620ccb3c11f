#include "landscape/prediction_error.h"

#include <cmath>
#include <limits>

namespace explore::landscape {

double prediction_error(const Eigen::VectorXd& gradient, const Minimum& minimum, const problem::Problem& problem,
                        const LocalAnalysis& local) {
    constexpr double infinity = std::numeric_limits<double>::infinity();
    if (!(local.noise > 0.0)) {
        return infinity;
    }
    Eigen::MatrixXd j = problem.information_jacobian(minimum.evaluation);
    for (const Eigen::Index row : problem.limit_rows()) { // as in analyse(): no reading
        j.row(row).setZero();
    }
    const Eigen::JacobiSVD<Eigen::MatrixXd> svd(j, Eigen::ComputeThinU | Eigen::ComputeFullV);
    const auto& s = svd.singularValues();
    const std::vector<char> is_seen = seen(j, svd.matrixV());
    Eigen::VectorXd row = Eigen::VectorXd::Zero(j.rows()); // g' J^+
    for (Eigen::Index k = 0; k < gradient.size(); ++k) {
        const double along = gradient.dot(svd.matrixV().col(k));
        if (k < s.size() && is_seen[static_cast<std::size_t>(k)] != 0) {
            row += along / s[k] * svd.matrixU().col(k);
        } else if (std::abs(along) > 1e-6 * gradient.norm()) {
            return infinity;
        }
    }
    if (!local.noise_is_stated) {
        return local.noise * row.norm();
    }
    const double wider = local.widening;
    return wider * row.cwiseProduct(problem.noise(minimum.evaluation)).norm();
}

} // namespace explore::landscape
