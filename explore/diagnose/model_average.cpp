#include "diagnose/model_average.h"

#include "inference/quantiles.h"

#include <algorithm>
#include <cmath>
#include <gsl/gsl_cdf.h>

namespace explore::diagnose {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

Said say(const Slopes& slopes, Index parameters, const VectorXd& none, const MatrixXd& reach) {
    const Index m = none.size();
    const Index n = parameters;
    // Parameters by their distance from the middle of the box, further coordinates by standard normal numbers.
    MatrixXd a(slopes.rows.rows(), n + m);
    MatrixXd h(slopes.output_rows.rows(), n + m);
    VectorXd now(n + m); // of those, where the slopes are
    a << slopes.rows.leftCols(n), slopes.rows.rightCols(m) * reach;
    h << slopes.output_rows.leftCols(n), slopes.output_rows.rightCols(m) * reach;
    now.head(n) = slopes.at.head(n).array() - 0.5;
    if (m > 0) {
        now.tail(m) = reach.fullPivLu().solve(VectorXd(slopes.at.tail(m) - none));
    }
    VectorXd precision = VectorXd::Ones(n + m);
    precision.head(n).setConstant(1.0 / inference::box_variance);
    const MatrixXd information = a.transpose() * a + MatrixXd(precision.asDiagonal());
    const Eigen::LLT<MatrixXd> llt(information);
    const VectorXd x = llt.solve(a.transpose() * (a * now - slopes.residuals));
    Said said;
    said.left = (slopes.residuals + a * (x - now)).squaredNorm();
    said.log_evidence = -0.5 * (said.left + x.dot(precision.cwiseProduct(x))) -
                        MatrixXd(llt.matrixL()).diagonal().array().log().sum() + 0.5 * precision.array().log().sum();
    said.mean = slopes.outputs + h * (x - now);
    said.deviation = (h * llt.solve(h.transpose())).diagonal().cwiseMax(0.0).cwiseSqrt();
    said.best = slopes.at;
    said.best.head(n) = x.head(n).array() + 0.5;
    if (m > 0) {
        said.best.tail(m) = none + reach * x.tail(m);
    }
    return said;
}

double mixture_quantile(const std::vector<double>& weights, const std::vector<double>& means,
                        const std::vector<double>& deviations, double p) {
    double low = INFINITY;
    double high = -INFINITY;
    for (std::size_t i = 0; i < weights.size(); ++i) {
        low = std::min(low, means[i] - 10.0 * deviations[i]);
        high = std::max(high, means[i] + 10.0 * deviations[i]);
    }
    constexpr int halvings = 60;
    for (int halving = 0; halving < halvings; ++halving) {
        const double middle = 0.5 * (low + high);
        double below = 0.0;
        for (std::size_t i = 0; i < weights.size(); ++i) {
            below += weights[i] * (deviations[i] > 0.0 ? gsl_cdf_ugaussian_P((middle - means[i]) / deviations[i])
                                                       : static_cast<double>(means[i] <= middle));
        }
        (below < p ? low : high) = middle;
    }
    return 0.5 * (low + high);
}

} // namespace explore::diagnose
