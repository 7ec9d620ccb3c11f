#include "hypotheses/evidence.h"

#include "inference/quantiles.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace explore::hypotheses {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

NoisePrior any_noise() {
    return {.as_stated = 0.0, .log_deviation = 2.0};
}

Prior Prior::of_parameters(Index count) {
    return {MatrixXd::Identity(count, count) / inference::box_variance,
            -0.5 * static_cast<double>(count) * std::log(inference::box_variance)};
}

namespace {

void append(MatrixXd& precision, const MatrixXd& more) {
    const Index before = precision.rows();
    MatrixXd both = MatrixXd::Zero(before + more.rows(), before + more.rows());
    both.topLeftCorner(before, before) = precision;
    both.bottomRightCorner(more.rows(), more.rows()) = more;
    precision = std::move(both);
}

double below(double z) {
    return 0.5 * std::erfc(-z / std::numbers::sqrt2);
}

} // namespace

void Prior::add_size(double null, double typical, double size) {
    const double scale = std::max(std::abs(typical - null), 1e-6);
    const auto cumulative = [&](double u) { return std::atan((u - null) / scale) / std::numbers::pi; };
    const double mass = cumulative(1.0) - cumulative(0.0);
    const double density = 1.0 / (std::numbers::pi * scale * mass);
    // So that cut off at the range it is a density: where the data say nothing, the hypothesis is as probable as
    // without it.
    const double sides = null <= 0.0 || null >= 1.0 ? 0.5 : 1.0;
    const double precision_there = 2.0 * std::numbers::pi * std::pow(sides * density, 2);
    append(precision, MatrixXd::Constant(1, 1, precision_there));
    const double away = (size - null) / scale;
    log_volume += std::log(density / (1.0 + away * away)) + 0.5 * std::log(2.0 * std::numbers::pi);
}

void Prior::add_layout(double null, double whole, double size) {
    constexpr double tolerance = 0.03; // of the largest move: 9 mm of 300 mm
    const double deviation = tolerance * std::abs(whole - null);
    add_normal(MatrixXd::Constant(1, 1, 1.0 / (deviation * deviation)), VectorXd::Constant(1, size - whole));
}

void Prior::cut_off(double size, double deviation) {
    const double inside = below((1.0 - size) / deviation) - below(-size / deviation);
    log_volume += std::log(std::max(inside, 1e-3));
}

void Prior::add_normal(const MatrixXd& more, const VectorXd& away) {
    append(precision, more);
    const MatrixXd root = more.llt().matrixL();
    log_volume += root.diagonal().array().log().sum() - 0.5 * away.dot(more * away);
}

double log_sum(const std::vector<double>& logarithms) {
    if (logarithms.empty()) {
        return -INFINITY;
    }
    const double most = *std::max_element(logarithms.begin(), logarithms.end());
    if (!std::isfinite(most)) {
        return most;
    }
    double sum = 0.0;
    for (const double value : logarithms) {
        sum += std::exp(value - most);
    }
    return most + std::log(sum);
}

Evidence evidence(double sum, Index rows, const MatrixXd& jacobian, const Prior& prior, const NoisePrior& noise,
                  double log_determinant) {
    const auto n = static_cast<double>(rows);
    const MatrixXd information = jacobian.transpose() * jacobian;
    // det(J'J/k^2 + P) = det(P) det(I + M/k^2), M = L^-1 J'J L^-T with P = L L'.
    const Eigen::LLT<MatrixXd> root(prior.precision);
    const MatrixXd half = root.matrixL().solve(information);
    const MatrixXd standard = root.matrixL().solve(half.transpose());
    VectorXd weights; // of no coordinates: none
    if (standard.cols() > 0) {
        weights = Eigen::SelfAdjointEigenSolver<MatrixXd>(standard, Eigen::EigenvaluesOnly).eigenvalues().cwiseMax(0.0);
    }
    const double log_prior_determinant = 2.0 * MatrixXd(root.matrixL()).diagonal().array().log().sum();
    const auto at = [&](double k) {
        const double k2 = k * k;
        return -n * std::log(k) - 0.5 * sum / k2 + prior.log_volume - 0.5 * log_determinant -
               0.5 * (log_prior_determinant + (weights.array() / k2).log1p().sum());
    };
    Evidence found;
    found.as_stated = at(1.0);
    constexpr double reach = 4.0; // standard deviations of the prior
    constexpr double step = 0.02;
    const int steps = static_cast<int>(std::ceil(reach * noise.log_deviation / step));
    // By the data alone, wherever that is.
    constexpr double farthest = 4.6; // a factor of a hundred
    const int data_steps = std::max(steps, static_cast<int>(farthest / step));
    std::vector<double> of_data;
    for (int i = -data_steps; i <= data_steps; ++i) {
        of_data.push_back(at(std::exp(i * step)));
    }
    std::vector<double> logarithms;
    double most = -INFINITY;
    for (int i = -steps; i <= steps; ++i) {
        const double x = i * step;
        const double z = x / noise.log_deviation;
        const double value = of_data[static_cast<std::size_t>(i + data_steps)] - 0.5 * z * z;
        logarithms.push_back(value);
        if (value > most) {
            most = value;
            found.noise = std::exp(x);
        }
    }
    found.any_size = log_sum(logarithms) + std::log(step / (noise.log_deviation * std::sqrt(2.0 * std::numbers::pi)));
    const double all_of_data = log_sum(of_data);
    found.by_data = std::exp(
        step * static_cast<double>(std::max_element(of_data.begin(), of_data.end()) - of_data.begin() - data_steps));
    double gone = 0.0;
    const double tail = 0.5 * (1.0 - 0.95);
    for (int i = -data_steps; i <= data_steps; ++i) {
        const double before = gone;
        gone += std::exp(of_data[static_cast<std::size_t>(i + data_steps)] - all_of_data);
        if (before < tail && gone >= tail) {
            found.noise_low = std::exp(i * step);
        }
        if (before < 1.0 - tail && gone >= 1.0 - tail) {
            found.noise_high = std::exp(i * step);
        }
    }
    found.log =
        noise.as_stated > 0.0
            ? log_sum({std::log(noise.as_stated) + found.as_stated, std::log(1.0 - noise.as_stated) + found.any_size})
            : found.any_size;
    return found;
}

} // namespace explore::hypotheses
