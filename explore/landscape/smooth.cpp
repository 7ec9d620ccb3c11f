#include "landscape/smooth.h"

#include <Eigen/QR>
#include <cmath>

namespace explore::landscape {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr Index points_a_coefficient = 4;

Index coefficients(Index dimension, int degree) {
    return degree == 1 ? 1 + dimension : (dimension + 1) * (dimension + 2) / 2;
}

MatrixXd powers(const MatrixXd& points, int degree) {
    const Index d = points.cols();
    MatrixXd all(points.rows(), coefficients(d, degree));
    all.col(0).setOnes();
    all.middleCols(1, d) = points;
    Index next = d + 1;
    for (Index a = 0; degree == 2 && a < d; ++a) {
        for (Index b = a; b < d; ++b) {
            all.col(next++) = points.col(a).cwiseProduct(points.col(b));
        }
    }
    return all;
}

} // namespace

std::optional<Smooth> smooth(const MatrixXd& known, const VectorXd& values, const MatrixXd& wanted) {
    const auto enough = [&](int degree) {
        return known.rows() >= points_a_coefficient * coefficients(known.cols(), degree);
    };
    if (!enough(1)) {
        return std::nullopt;
    }
    const int degree = enough(2) ? 2 : 1;
    const Eigen::RowVectorXd mean = known.colwise().mean();
    const Eigen::RowVectorXd spread =
        ((known.rowwise() - mean).colwise().norm() / std::sqrt(static_cast<double>(known.rows()))).cwiseMax(1e-12);
    const auto scaled = [&](const MatrixXd& points) {
        return powers((points.rowwise() - mean).array().rowwise() / spread.array(), degree);
    };
    const MatrixXd a = scaled(known);
    const Eigen::ColPivHouseholderQR<MatrixXd> qr(a);
    const VectorXd coefficients = qr.solve(values);
    const MatrixXd q = qr.householderQ() * MatrixXd::Identity(a.rows(), qr.rank());
    // A residual divided by 1 - h, h its leverage, is that of the fit without its point.
    const VectorXd without =
        (values - a * coefficients).cwiseQuotient(VectorXd::Ones(a.rows()) - q.rowwise().squaredNorm());
    Smooth result{.values = scaled(wanted) * coefficients,
                  .left = without.norm() / std::sqrt(static_cast<double>(a.rows()))};
    result.values =
        result.values.cwiseMax(values.minCoeff() - 3.0 * result.left).cwiseMin(values.maxCoeff() + 3.0 * result.left);
    return result;
}

} // namespace explore::landscape
