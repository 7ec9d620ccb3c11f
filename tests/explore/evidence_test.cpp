// Evidence of corrections on linear problems.
#include "diagnose/evidence.h"

#include "support/normal_matrix.h"

#include <cmath>
#include <gtest/gtest.h>

using namespace explore;
using namespace explore::diagnose;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr Index rows = 25;

// Two parameters that are followed, three channels of four coefficients.
struct World {
    MatrixXd jacobian;
    std::vector<MatrixXd> changes;
    explicit World(std::uint64_t seed) {
        const pave::RandomStream random(seed, 0);
        jacobian = 30.0 * test::normal_matrix(random, rows, 2, 0);
        for (std::uint64_t c = 0; c < 3; ++c) {
            changes.push_back(5.0 * test::normal_matrix(random, rows, 4, 1000 * (c + 1)));
        }
    }
    inference::Nuisance nuisance() const { return {jacobian, {0.5, 0.5}, VectorXd::Zero(rows)}; }
};

} // namespace

// One coefficient: the likelihood of w ~ N(0, 1 + s^2 a^2), largest where s^2 a^2 = w^2 - 1.
TEST(ChannelEvidence, OfOneCoefficientHasItsClosedForm) {
    const VectorXd direction = VectorXd::LinSpaced(rows, 1.0, 2.0).normalized();
    constexpr double length = 8.0;
    const ChannelEvidence evidence(length * direction);
    for (const double w : {0.5, 1.5, 3.0, 6.0}) {
        VectorXd z = w * direction;
        z += 0.7 * (VectorXd::Unit(rows, 0) - direction[0] * direction); // orthogonal to it: says nothing
        const auto found = evidence.estimate(z, false, rows);
        if (w <= 1.0) {
            EXPECT_EQ(found.strength, 0.0);
            EXPECT_EQ(found.log_ratio, 0.0);
        } else {
            EXPECT_NEAR(found.strength / (std::sqrt(w * w - 1.0) / length), 1.0, 0.05) << w;
            EXPECT_NEAR(found.log_ratio, (w * w - 1.0 - std::log(w * w)) / 2.0, 0.002) << w;
        }
    }
}

// Against the densities of the multivariate normal distribution, and of Student's where the noise is unknown: that of
// z over its length is proportional to |V|^(-1/2) (z' V^-1 z)^(-n/2).
TEST(ChannelEvidence, RatioIsThatOfTheDensities) {
    const World world(3);
    const pave::RandomStream random(4, 0);
    const VectorXd z = test::normal_matrix(random, rows, 1, 0);
    const ChannelEvidence evidence(world.changes[0]);
    for (const double s : {0.05, 0.3, 1.0}) {
        const MatrixXd v = MatrixXd::Identity(rows, rows) +
                           s * s * world.changes[0] * prior_correlation(4) * world.changes[0].transpose();
        const double quadratic = z.dot(v.ldlt().solve(z));
        const double determinant = std::log(v.determinant());
        EXPECT_NEAR(evidence.log_ratio(z, s, false, rows), (z.squaredNorm() - quadratic - determinant) / 2.0, 1e-9);
        EXPECT_NEAR(evidence.log_ratio(z, s, true, rows),
                    -(rows * std::log(quadratic / z.squaredNorm()) + determinant) / 2.0, 1e-9);
        EXPECT_NEAR(evidence.log_ratio(10.0 * z, s, true, rows), evidence.log_ratio(z, s, true, rows), 1e-9);
    }
}

TEST(PriorCorrelation, FallsEvenlyFromPlaceToPlace) {
    const MatrixXd c = prior_correlation(4);
    EXPECT_EQ(c(0, 0), 1.0);
    EXPECT_EQ(c(1, 2), neighbour_correlation);
    EXPECT_NEAR(c(3, 0), std::pow(neighbour_correlation, 3), 1e-15);
}

// Under noise alone p is at most 0.05 in 5 % of cases: of 60, in no more than 9 (one of a thousand worlds would have
// more).
TEST(TestChannels, NoiseAloneIsSignificantAsOftenAsStated) {
    const World world(5);
    for (const bool estimated : {false, true}) {
        int significant = 0;
        int low = 0;
        constexpr int cases = 60;
        for (std::uint64_t k = 0; k < cases; ++k) {
            const pave::RandomStream random(100 + k, estimated ? 1 : 0);
            const VectorXd noise = (estimated ? 7.0 : 1.0) * test::normal_matrix(random, rows, 1, 0);
            double p = 1.0;
            for (const auto& test : test_channels(noise, world.changes, {}, world.nuisance(), estimated, 1)) {
                p = std::min(p, test.p_familywise);
            }
            significant += p < 0.05 ? 1 : 0;
            low += p < 0.3 ? 1 : 0;
        }
        EXPECT_LE(significant, 9) << estimated;
        EXPECT_NEAR(low, 0.3 * cases, 11) << estimated;
    }
}

TEST(TestChannels, FindsTheChannelAndThenTheOtherOne) {
    const World world(6);
    int first = 0;
    int second = 0;
    int third = 0;
    constexpr int cases = 15;
    for (std::uint64_t k = 0; k < cases; ++k) {
        const pave::RandomStream random(500 + k, 0);
        const VectorXd a{{0.6, 0.5, 0.4, 0.3}};
        const VectorXd b{{-0.2, 0.3, 0.3, -0.3}};
        const VectorXd residuals = test::normal_matrix(random, rows, 1, 0) + world.changes[1] * a +
                                   world.changes[2] * b + 0.7 * world.jacobian.col(0);
        const auto largest = [](const std::vector<ChannelTest>& tests) {
            return std::max_element(tests.begin(), tests.end(),
                                    [](const auto& x, const auto& y) { return x.log_ratio < y.log_ratio; }) -
                   tests.begin();
        };
        const auto alone = test_channels(residuals, world.changes, {}, world.nuisance(), false, 1);
        first += largest(alone) == 1 && alone[1].p_familywise < 0.05 ? 1 : 0;
        std::vector<Accepted> accepted{{1, alone[1].strength}};
        const auto next = test_channels(residuals, world.changes, accepted, world.nuisance(), false, 1);
        EXPECT_EQ(next[1].log_ratio, 0.0); // it is in the model
        second += largest(next) == 2 && next[2].p_familywise < 0.05 ? 1 : 0;
        accepted.push_back({2, next[2].strength});
        estimate_strengths(residuals, world.changes, accepted, world.nuisance(), false);
        const auto rest = test_channels(residuals, world.changes, accepted, world.nuisance(), false, 1);
        third += rest[0].p_familywise < 0.05 ? 1 : 0;
    }
    EXPECT_GE(first, 13);
    EXPECT_GE(second, 13);
    EXPECT_LE(third, 3);
}

// What parameters follow is no evidence: a correction that does the same as they do is invisible.
TEST(TestChannels, WhatParametersFollowIsTakenOut) {
    World world(7);
    world.changes[0] = world.jacobian * MatrixXd::Ones(2, 4);
    const auto tests =
        test_channels(world.jacobian * VectorXd::Constant(2, 1.0), world.changes, {}, world.nuisance(), false, 1);
    for (const auto& test : tests) {
        EXPECT_LT(test.log_ratio, 1e-9);
    }
}
