#include "inference/information_gain.h"

#include <Eigen/QR>

#include <algorithm>
#include <cmath>
#include <limits>

namespace explore::inference {
namespace {

// The entropy of values with standard normal noise, less that of the noise [nats].
double entropy_with_noise(const Eigen::VectorXd& values) {
    // The middles of seven equal parts of a normal distribution, scaled to have variance 1.
    constexpr double noise[] = {-1.6076, -0.8685, -0.4017, 0.0, 0.4017, 0.8685, 1.6076};
    // A kernel about each value, as wide as the noise and the distance to its neighbours are: of tails as of modes that
    // are apart.
    constexpr double width = 0.8; // of the distance to the neighbour of the number below
    const Eigen::Index n = values.size();
    const auto neighbour = static_cast<Eigen::Index>(std::lround(std::sqrt(static_cast<double>(n))));
    Eigen::ArrayXd variance(n);
    for (Eigen::Index i = 0; i < n; ++i) {
        Eigen::ArrayXd distance = (values.array() - values[i]).abs();
        std::nth_element(distance.begin(), distance.begin() + neighbour, distance.end());
        variance[i] = 1.0 + std::pow(width * distance[neighbour], 2);
    }
    const Eigen::ArrayXd height = -0.5 * variance.log();
    double sum = 0.0;
    for (Eigen::Index i = 0; i < n; ++i) {
        for (const double e : noise) {
            Eigen::ArrayXd exponent = height - 0.5 * (values.array() - values[i] - e).square() / variance;
            exponent[i] = -std::numeric_limits<double>::infinity();
            const double largest = exponent.maxCoeff();
            sum += largest + std::log((exponent - largest).exp().sum() / static_cast<double>(n - 1));
        }
    }
    return -sum / static_cast<double>(n * static_cast<Eigen::Index>(std::size(noise))) - 0.5;
}

} // namespace

double information_gain(const Eigen::MatrixXd& draws, const std::vector<Eigen::Index>& sample,
                        const Eigen::VectorXd& predicted) {
    const Eigen::MatrixXd sampled = draws(sample, Eigen::all);
    const Eigen::MatrixXd off = sampled.rowwise() - sampled.colwise().mean();
    const Eigen::VectorXd slope = off.colPivHouseholderQr().solve((predicted.array() - predicted.mean()).matrix());
    const double nats =
        entropy_with_noise(draws * slope) + entropy_with_noise(predicted) - entropy_with_noise(off * slope);
    return std::max(0.0, nats / std::log(2.0));
}

} // namespace explore::inference
