// What one more reading tells, against closed forms of its entropy.
#include "inference/information_gain.h"

#include "support/normal_matrix.h"

#include <cmath>
#include <functional>
#include <gtest/gtest.h>
#include <numbers>

using namespace explore;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr Index draws = 256, sampled = 64;

std::vector<Index> sample() {
    std::vector<Index> rows;
    for (Index i = 0; i < sampled; ++i) {
        rows.push_back(i * draws / sampled);
    }
    return rows;
}

double bits(const MatrixXd& points, const std::function<double(const VectorXd&)>& reading) {
    const auto rows = sample();
    VectorXd predicted(sampled);
    for (Index i = 0; i < sampled; ++i) {
        predicted[i] = reading(points.row(rows[static_cast<std::size_t>(i)]).transpose());
    }
    return inference::information_gain(points, rows, predicted);
}

MatrixXd normal(std::uint64_t seed, Index columns) {
    return test::normal_matrix(pave::RandomStream(seed, 0), draws, columns, 0);
}

constexpr double entropy_of_noise = 2.0470956; // 0.5 log2(2 pi e)

} // namespace

TEST(InformationGain, OfALinearReadingOfANormalPosteriorIsThatOfTheVariances) {
    for (const double s : {0.3, 1.0, 4.0, 20.0}) {
        for (std::uint64_t seed = 1; seed <= 5; ++seed) {
            const double found =
                bits(normal(seed, 2), [&](const VectorXd& p) { return s * (0.6 * p[0] - 0.8 * p[1]); });
            EXPECT_NEAR(found, 0.5 * std::log2(1.0 + s * s), 0.15) << s << ", seed " << seed;
        }
    }
}

TEST(InformationGain, OfAReadingThatDoesNotSeeTheUnknownsIsNone) {
    EXPECT_NEAR(bits(normal(1, 3), [](const VectorXd&) { return 7.0; }), 0.0, 1e-3); // the noise has seven values here
}

// Where a wide distribution is uniform its entropy is the logarithm of its width.
TEST(InformationGain, OfAUniformRidgeIsThatOfItsWidth) {
    MatrixXd points(draws, 1);
    for (Index i = 0; i < draws; ++i) {
        points(i, 0) = static_cast<double>((i * 197) % draws) / draws; // in no order
    }
    EXPECT_NEAR(bits(points, [](const VectorXd& p) { return 60.0 * p[0]; }), std::log2(60.0) - entropy_of_noise, 0.15);
}

// Two modes far apart, within which the reading is the same: one bit, which of them. Their variance would say 5.3.
TEST(InformationGain, OfTwoModesIsWhichOfThem) {
    MatrixXd points = normal(3, 1);
    for (Index i = 0; i < draws; ++i) {
        points(i, 0) = 0.01 * points(i, 0) + (i % 3 == 0 || i % 7 == 0 ? 1.0 : -1.0);
    }
    double high = 0.0;
    for (const Index i : sample()) {
        high += points(i, 0) > 0.0;
    }
    EXPECT_NEAR(high / sampled, 0.43, 0.06); // of which 0.99 bits
    EXPECT_NEAR(bits(points, [](const VectorXd& p) { return p[0] > 0.0 ? 40.0 : 0.0; }), 1.0, 0.25);
}

// A ridge on which the reading depends by the square of what is free: to first order about the middle it tells
// nothing, about a flank too much. z^2 of a standard normal z by numerical integration of its density with the noise.
TEST(InformationGain, OfACurvedRidgeIsThatOfItsDistribution) {
    constexpr double scale = 5.0, step = 0.01;
    double entropy = 0.0;
    for (double y = -6.0; y < 150.0; y += step) {
        double density = 0.0;
        for (double z = -6.0; z < 6.0; z += 0.02) {
            density += 0.02 * std::exp(-0.5 * z * z - 0.5 * std::pow(y - scale * z * z, 2)) / (2.0 * std::numbers::pi);
        }
        entropy -= density > 0.0 ? step * density * std::log2(density) : 0.0;
    }
    const double found = bits(normal(4, 1), [](const VectorXd& p) { return scale * p[0] * p[0]; });
    EXPECT_NEAR(found, entropy - entropy_of_noise, 0.5) << entropy - entropy_of_noise;
}
