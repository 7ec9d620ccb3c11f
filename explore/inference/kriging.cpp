#include "inference/kriging.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace explore::inference {
namespace {

using Eigen::Index;

// Of the correlation: what rounding allows it to be inverted with.
constexpr double nugget = 1e-9;
constexpr double length_grid[] = {0.15, 0.25, 0.4, 0.65, 1.0, 1.6, 2.5, 4.0};
constexpr Index most_rows_for_lengths = 300;

Index terms_of(int degree, Index dimension) {
    return degree == 0 ? 1 : degree == 1 ? 1 + dimension : (1 + dimension) * (2 + dimension) / 2;
}

// The terms of the polynomial in the first row, below it their slopes by each coordinate where they are requested.
Eigen::MatrixXd polynomial(std::span<const double> x, int degree, bool with_slopes) {
    const auto d = static_cast<Index>(x.size());
    Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(with_slopes ? 1 + d : 1, terms_of(degree, d));
    rows(0, 0) = 1.0;
    if (degree > 0) {
        for (Index j = 0; j < d; ++j) {
            rows(0, 1 + j) = x[static_cast<std::size_t>(j)];
            if (with_slopes) {
                rows(1 + j, 1 + j) = 1.0;
            }
        }
    }
    Index term = 1 + d;
    for (Index j = 0; degree > 1 && j < d; ++j) {
        for (Index k = j; k < d; ++k, ++term) {
            rows(0, term) = x[static_cast<std::size_t>(j)] * x[static_cast<std::size_t>(k)];
            if (with_slopes) {
                rows(1 + j, term) += x[static_cast<std::size_t>(k)];
                rows(1 + k, term) += x[static_cast<std::size_t>(j)];
            }
        }
    }
    return rows;
}

// Covariances of the value at x, and below it of its slopes where they are requested, with the value at y and, where
// they are known, its slopes.
Eigen::MatrixXd covariances(std::span<const double> x, std::span<const double> y, const Eigen::VectorXd& lengths,
                            bool slopes_of_x, bool slopes_of_y) {
    const Index d = lengths.size();
    Eigen::VectorXd pull(d); // -(d/dx_j of the correlation) / the correlation
    double exponent = 0.0;
    for (Index j = 0; j < d; ++j) {
        const double h = x[static_cast<std::size_t>(j)] - y[static_cast<std::size_t>(j)];
        pull[j] = h / (lengths[j] * lengths[j]);
        exponent += h * pull[j];
    }
    const double correlation = std::exp(-0.5 * exponent);
    Eigen::MatrixXd block(slopes_of_x ? 1 + d : 1, slopes_of_y ? 1 + d : 1);
    block(0, 0) = correlation;
    if (slopes_of_y) {
        block.row(0).tail(d) = correlation * pull.transpose();
    }
    if (slopes_of_x) {
        block.col(0).tail(d) = -correlation * pull;
    }
    if (slopes_of_x && slopes_of_y) {
        block.bottomRightCorner(d, d) =
            correlation *
            (Eigen::MatrixXd(lengths.array().square().inverse().matrix().asDiagonal()) - pull * pull.transpose());
    }
    return block;
}

} // namespace

Kriging::Kriging(std::vector<KnownPoint> known) : known_(std::move(known)) {
    const auto count = static_cast<Index>(known_.size());
    const auto d = static_cast<Index>(known_[0].unit.size());
    const Index m = known_[0].values.size();
    const bool with_slopes = known_[0].slopes.size() > 0;
    rows_of_point_ = with_slopes ? 1 + d : 1;
    Eigen::MatrixXd values(count * rows_of_point_, m);
    for (Index p = 0; p < count; ++p) {
        const KnownPoint& point = known_[static_cast<std::size_t>(p)];
        values.row(p * rows_of_point_) = point.values.transpose();
        if (with_slopes) {
            values.middleRows(p * rows_of_point_ + 1, d) = point.slopes.transpose();
        }
    }
    constexpr Index rows_a_term = 3;
    degree_ = 2;
    while (degree_ > 0 && values.rows() < rows_a_term * terms_of(degree_, d)) {
        --degree_;
    }
    Eigen::MatrixXd terms(values.rows(), terms_of(degree_, d));
    for (Index p = 0; p < count; ++p) {
        terms.middleRows(p * rows_of_point_, rows_of_point_) =
            polynomial(known_[static_cast<std::size_t>(p)].unit, degree_, with_slopes);
    }
    trend_ = terms.colPivHouseholderQr().solve(values);
    rest_ = values - terms * trend_;
    lengths_ = Eigen::VectorXd::Ones(d);
    choose_lengths();
    if (factorise(known_.size(), rest_)) {
        return;
    }
    lengths_.setConstant(length_grid[0]);   // those that a part of the points allows, all of them may not
    if (!factorise(known_.size(), rest_)) { // sure of nothing
        factor_.compute(Eigen::MatrixXd(Eigen::MatrixXd::Identity(rest_.rows(), rest_.rows())));
        weights_ = Eigen::MatrixXd::Zero(rest_.rows(), m);
        scales_ = Eigen::VectorXd::Constant(m, std::numeric_limits<double>::infinity());
    }
}

Eigen::MatrixXd Kriging::correlations(std::size_t points) const {
    const auto count = static_cast<Index>(points);
    const bool with_slopes = rows_of_point_ > 1;
    Eigen::MatrixXd all(count * rows_of_point_, count * rows_of_point_);
    for (Index p = 0; p < count; ++p) {
        for (Index q = 0; q <= p; ++q) {
            all.block(p * rows_of_point_, q * rows_of_point_, rows_of_point_, rows_of_point_) =
                covariances(known_[static_cast<std::size_t>(p)].unit, known_[static_cast<std::size_t>(q)].unit,
                            lengths_, with_slopes, with_slopes);
        }
    }
    all.diagonal() *= 1.0 + nugget;
    return all;
}

bool Kriging::factorise(std::size_t points, const Eigen::MatrixXd& rest) {
    factor_.compute(correlations(points)); // reads the lower half
    if (factor_.info() != Eigen::Success) {
        return false;
    }
    weights_ = factor_.solve(rest);
    const auto n = static_cast<double>(rest.rows());
    const Eigen::VectorXd squares = (rest.array() * weights_.array()).colwise().sum().transpose() / n;
    const Eigen::VectorXd smallest = 1e-12 * ranges();
    scales_ = squares.cwiseMax(0.0).cwiseSqrt().cwiseMax(smallest).cwiseMax(std::numeric_limits<double>::min());
    likelihood_ = -2.0 * n * scales_.array().log().mean() -
                  2.0 * factor_.matrixLLT().diagonal().array().log().sum(); // times two, of one value on average
    return std::isfinite(likelihood_);
}

void Kriging::choose_lengths() {
    const Index fitting = std::max<Index>(1, most_rows_for_lengths / rows_of_point_);
    const std::size_t points = std::min(known_.size(), static_cast<std::size_t>(fitting));
    const Eigen::MatrixXd rest = rest_.topRows(static_cast<Index>(points) * rows_of_point_);
    double best = -std::numeric_limits<double>::infinity();
    for (int pass = 0; pass < 2; ++pass) {
        for (Index j = 0; j < lengths_.size(); ++j) {
            double chosen = lengths_[j];
            for (const double length : length_grid) {
                lengths_[j] = length;
                if (factorise(points, rest) && likelihood_ > best) {
                    best = likelihood_;
                    chosen = length;
                }
            }
            lengths_[j] = chosen;
        }
    }
}

Kriging::Answer Kriging::at(std::span<const double> unit, bool with_slopes) const {
    const auto d = static_cast<Index>(unit.size());
    const Index rows = with_slopes ? 1 + d : 1;
    Eigen::MatrixXd all(rows, weights_.rows());
    for (std::size_t p = 0; p < known_.size(); ++p) {
        all.middleCols(static_cast<Index>(p) * rows_of_point_, rows_of_point_) =
            covariances(unit, known_[p].unit, lengths_, with_slopes, rows_of_point_ > 1);
    }
    const Eigen::MatrixXd answer = polynomial(unit, degree_, with_slopes) * trend_ + all * weights_;
    const Eigen::VectorXd part = factor_.matrixL().solve(all.row(0).transpose());
    Answer result{.values = answer.row(0).transpose(),
                  .deviations = std::sqrt(std::max(nugget, 1.0 + nugget - part.squaredNorm())) * scales_,
                  .slopes = {}};
    if (with_slopes) {
        result.slopes = answer.bottomRows(d).transpose();
    }
    return result;
}

Eigen::VectorXd Kriging::ranges() const {
    Eigen::VectorXd low = known_[0].values, high = low;
    for (const KnownPoint& point : known_) {
        low = low.cwiseMin(point.values);
        high = high.cwiseMax(point.values);
    }
    return high - low;
}

double Kriging::squared_distance(std::span<const double> a, std::span<const double> b) const {
    double sum = 0.0;
    for (std::size_t j = 0; j < a.size(); ++j) {
        const double h = (a[j] - b[j]) / lengths_[static_cast<Index>(j)];
        sum += h * h;
    }
    return sum;
}

} // namespace explore::inference
