#include "landscape/directions.h"

#include <Eigen/QR>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <limits>

namespace explore::landscape {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

Directions directions(const problem::Problem& problem, const Acceptance& acceptance, const Minimum& minimum) {
    Directions d;
    d.unit = minimum.unit;
    const auto& axes = problem.space.axes;
    const MatrixXd s = problem.information_jacobian(minimum.evaluation) / acceptance.noise();
    std::vector<Index> open;
    for (std::size_t k = 0; k < minimum.unit.size(); ++k) {
        if (s.col(static_cast<Index>(k)).norm() < 1.0) {
            d.dead.push_back(k);
        }
        if (!is_at_bound(minimum.unit[k])) {
            open.push_back(static_cast<Index>(k));
        }
    }
    if (open.empty()) {
        return d;
    }
    const auto n = static_cast<Index>(open.size());
    const MatrixXd part = s(Eigen::all, open);
    const Eigen::JacobiSVD<MatrixXd> svd(part, Eigen::ComputeThinU | Eigen::ComputeFullV);
    VectorXd values = VectorXd::Zero(n);
    values.head(svd.singularValues().size()) = svd.singularValues();
    // Half the box along a direction that no reading tells from none.
    const double unseen = 2.0 * std::sqrt(acceptance.threshold);
    for (Index i = 0; i < n; ++i) {
        VectorXd v = VectorXd::Zero(static_cast<Index>(axes.size()));
        v(open) = svd.matrixV().col(i);
        d.singular_values.push_back(values[i]);
        d.vectors.push_back(v);
        if (values[i] < unseen) {
            d.flat.push_back(static_cast<std::size_t>(i));
        }
    }
    MatrixXd columns = part;
    double smallest = std::numeric_limits<double>::infinity();
    for (Index k = 0; k < n; ++k) {
        smallest = std::min(smallest, columns.col(k).norm());
        columns.col(k).normalize();
    }
    if (smallest > 0.0) {
        VectorXd c = VectorXd::Zero(n);
        const Eigen::JacobiSVD<MatrixXd> correlation(columns);
        c.head(correlation.singularValues().size()) = correlation.singularValues();
        d.collinearity = 1.0 / std::max(c.minCoeff(), 1e-12);
    } else {
        d.collinearity = 1e12;
    }
    if (d.flat.empty()) {
        return d;
    }

    // The flat directions as moves of s(parameter): logarithms or values.
    const auto m = static_cast<Index>(d.flat.size());
    const auto stretch = [&](Index k) { // d s / d unit
        const problem::Axis& axis = axes[static_cast<std::size_t>(k)];
        return axis.scale == problem::Scale::log ? std::log(axis.high / axis.low) : axis.high - axis.low;
    };
    MatrixXd flat(n, m); // unit coordinates
    for (Index i = 0; i < m; ++i) {
        flat.col(i) = svd.matrixV().col(static_cast<Index>(d.flat[static_cast<std::size_t>(i)]));
    }
    // The parameters that stand for the flat directions: pivots of a rank-revealing factorisation.
    const MatrixXd flat_rows = flat.transpose();
    const Eigen::ColPivHouseholderQR<MatrixXd> qr(flat_rows);
    std::vector<Index> pivots;
    for (Index i = 0; i < m; ++i) {
        pivots.push_back(qr.colsPermutation().indices()[i]);
    }
    const MatrixXd pivot_part = flat(pivots, Eigen::all);
    const MatrixXd relation = flat * pivot_part.inverse(); // unit move of every parameter for that of the pivots
    // Covariance across the flat directions.
    MatrixXd spread = MatrixXd::Zero(n, n);
    for (Index i = 0; i < n; ++i) {
        if (values[i] >= unseen) {
            spread += svd.matrixV().col(i) * svd.matrixV().col(i).transpose() / (values[i] * values[i]);
        }
    }
    const double seen_share = 0.1; // of the largest move along the flat directions
    const double largest = flat.rowwise().norm().maxCoeff();
    for (Index i = 0; i < n; ++i) {
        const bool pivot = std::find(pivots.begin(), pivots.end(), i) != pivots.end();
        const bool moves = flat.row(i).norm() > seen_share * largest;
        if (pivot || moves) {
            d.free.push_back(static_cast<std::size_t>(open[static_cast<std::size_t>(i)]));
        }
        if (pivot || !moves) {
            continue;
        }
        Combination c;
        c.leading = static_cast<std::size_t>(open[static_cast<std::size_t>(i)]);
        VectorXd of_unit = VectorXd::Zero(n); // the combination's gradient by the unit coordinates
        of_unit[i] = stretch(open[static_cast<std::size_t>(i)]);
        for (Index p = 0; p < m; ++p) {
            const Index axis = open[static_cast<std::size_t>(pivots[static_cast<std::size_t>(p)])];
            const double ratio = relation(i, p) * stretch(open[static_cast<std::size_t>(i)]) / stretch(axis);
            if (std::abs(relation(i, p)) > 0.02) {
                c.others.push_back({static_cast<std::size_t>(axis), -ratio});
            }
            of_unit[pivots[static_cast<std::size_t>(p)]] -= ratio * stretch(axis);
        }
        c.standard_error = std::sqrt(std::max(0.0, of_unit.dot(spread * of_unit)));
        if (!c.others.empty()) {
            d.fixed.push_back(std::move(c));
        }
    }
    return d;
}

} // namespace explore::landscape
