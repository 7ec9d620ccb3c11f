// Averages over models that may lack something, against draws from their priors weighed by their likelihoods.
#include "diagnose/model_average.h"

#include "support/normal_matrix.h"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>

using namespace explore::diagnose;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr Index parameters = 2;
constexpr Index lacking = 2;
constexpr Index readings = 5;

struct Weighed {
    double log_evidence, mean, deviation;
};

// By importance sampling from the prior.
Weighed drawn(const Slopes& slopes, const VectorXd& none, const MatrixXd& reach) {
    const pave::RandomStream random(7, 1);
    constexpr std::uint64_t draws = 400'000;
    double sum = 0.0;
    double first = 0.0;
    double second = 0.0;
    for (std::uint64_t i = 0; i < draws; ++i) {
        VectorXd at(slopes.at.size());
        for (Index k = 0; k < parameters; ++k) {
            at[k] = 0.5 + std::sqrt(1.0 / 12.0) * random.normal(10 * i + static_cast<std::uint64_t>(k));
        }
        VectorXd further(none.size());
        for (Index k = 0; k < none.size(); ++k) {
            further[k] = random.normal(10 * i + 5 + static_cast<std::uint64_t>(k));
        }
        at.tail(none.size()) = none + reach * further;
        const VectorXd z = slopes.residuals + slopes.rows * (at - slopes.at);
        const double weight = std::exp(-0.5 * z.squaredNorm());
        const double output = slopes.outputs[0] + slopes.output_rows.row(0).dot(at - slopes.at);
        sum += weight;
        first += weight * output;
        second += weight * output * output;
    }
    const double mean = first / sum;
    return {std::log(sum / draws), mean, std::sqrt(second / sum - mean * mean)};
}

Slopes some_slopes(Index coordinates) {
    const pave::RandomStream random(3, 0);
    return {.at = VectorXd::LinSpaced(coordinates, 0.3, 0.6),
            .residuals = test::normal_matrix(random, readings, 1, 0),
            .rows = 2.0 * test::normal_matrix(random, readings, coordinates, 100),
            .outputs = VectorXd::Constant(1, 0.7),
            .output_rows = test::normal_matrix(random, 1, coordinates, 200)};
}

} // namespace

TEST(ModelAverage, SaysWhatWeighedDrawsSay) {
    const Slopes slopes = some_slopes(parameters + lacking);
    const VectorXd none = VectorXd::Constant(lacking, 0.5);
    MatrixXd reach(lacking, lacking);
    reach << 0.4, 0.0, 0.25, 0.3;
    for (const double strength : {0.3, 1.0}) {
        const Said said = say(slopes, parameters, none, strength * reach);
        const Weighed expected = drawn(slopes, none, strength * reach);
        EXPECT_NEAR(said.log_evidence, expected.log_evidence, 0.03);
        EXPECT_NEAR(said.mean[0], expected.mean, 0.02 * expected.deviation);
        EXPECT_NEAR(said.deviation[0], expected.deviation, 0.02 * expected.deviation);
        EXPECT_NEAR(said.left, (slopes.residuals + slopes.rows * (said.best - slopes.at)).squaredNorm(), 1e-9);
    }
}

TEST(ModelAverage, AModelThatLacksNothingHasItsParametersAlone) {
    const Slopes slopes = some_slopes(parameters);
    const Said said = say(slopes, parameters, VectorXd(0), MatrixXd(0, 0));
    const Weighed expected = drawn(slopes, VectorXd(0), MatrixXd(0, 0));
    EXPECT_NEAR(said.log_evidence, expected.log_evidence, 0.03);
    EXPECT_NEAR(said.mean[0], expected.mean, 0.02 * expected.deviation);
    EXPECT_NEAR(said.deviation[0], expected.deviation, 0.02 * expected.deviation);
}

// What is said does not depend on where a linear model was linearised.
TEST(ModelAverage, IsTheSameFromEveryPoint) {
    const Slopes slopes = some_slopes(parameters + lacking);
    Slopes moved = slopes;
    const VectorXd step = VectorXd::LinSpaced(parameters + lacking, -0.2, 0.1);
    moved.at += step;
    moved.residuals += slopes.rows * step;
    moved.outputs += slopes.output_rows * step;
    const VectorXd none = VectorXd::Constant(lacking, 0.5);
    const MatrixXd reach = 0.3 * MatrixXd::Identity(lacking, lacking);
    const Said a = say(slopes, parameters, none, reach);
    const Said b = say(moved, parameters, none, reach);
    EXPECT_NEAR(a.log_evidence, b.log_evidence, 1e-9);
    EXPECT_NEAR(a.mean[0], b.mean[0], 1e-9);
    EXPECT_NEAR((a.best - b.best).norm(), 0.0, 1e-9);
}

TEST(ModelAverage, QuantilesOfAMixtureAreThoseOfDraws) {
    const std::vector<double> weights{0.7, 0.2, 0.1};
    const std::vector<double> means{1.0, 3.0, -4.0};
    const std::vector<double> deviations{0.5, 1.0, 0.0};
    const pave::RandomStream random(11, 0);
    constexpr std::size_t draws = 200'000;
    std::vector<double> values(draws);
    for (std::size_t i = 0; i < draws; ++i) {
        const std::size_t of = i % 10 < 7 ? 0 : i % 10 < 9 ? 1 : 2;
        values[i] = means[of] + deviations[of] * random.normal(i);
    }
    std::sort(values.begin(), values.end());
    for (const double p : {0.025, 0.3, 0.5, 0.975}) {
        const double expected = values[static_cast<std::size_t>(p * draws)];
        EXPECT_NEAR(mixture_quantile(weights, means, deviations, p), expected, 0.02) << p;
    }
}
