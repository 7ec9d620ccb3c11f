// Marginal likelihoods against integrals, and what noise of other kinds than stated is told by.
#include "diagnose/open_directions.h"
#include "hypotheses/evidence.h"
#include "hypotheses/hypothesis.h"
#include "hypotheses/noise_structure.h"
#include "inference/quantiles.h"

#include "support/formula.h"
#include "support/normal_matrix.h"

#include <cmath>
#include <gsl/gsl_cdf.h>
#include <gtest/gtest.h>
#include <numbers>

using namespace explore;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr hypotheses::NoisePrior as_stated{.as_stated = 1.0, .log_deviation = 0.35};

double cauchy(double u, double null, double typical) {
    const double scale = std::abs(typical - null);
    const auto cumulative = [&](double x) { return std::atan((x - null) / scale) / std::numbers::pi; };
    return 1.0 / (std::numbers::pi * scale * (1.0 + std::pow((u - null) / scale, 2))) /
           (cumulative(1.0) - cumulative(0.0));
}

// ln of the integral of exp(-(a - b u)^2 / 2) p(u) over the range.
double integral(double a, double b, double null, double typical) {
    constexpr int steps = 200'000;
    double sum = 0.0;
    for (int i = 0; i < steps; ++i) {
        const double u = (i + 0.5) / steps;
        sum += std::exp(-0.5 * std::pow(a - b * u, 2)) * cauchy(u, null, typical) / steps;
    }
    return std::log(sum);
}

// The same by Laplace's approximation.
double laplace(double a, double b, double null, double typical) {
    const double best = b < 1e-3 ? null : std::clamp(a / b, 0.0, 1.0);
    hypotheses::Prior prior{MatrixXd(0, 0), 0.0};
    prior.add_size(null, typical, best);
    prior.cut_off(best, 1.0 / std::sqrt(b * b + prior.precision(0, 0)));
    return hypotheses::evidence(std::pow(a - b * best, 2), 1, MatrixXd::Constant(1, 1, b), prior, as_stated).as_stated;
}

} // namespace

TEST(Evidence, OfASizeIsItsIntegral) {
    for (const double b : {60.0, 25.0}) {
        EXPECT_NEAR(laplace(0.7 * b, b, 0.5, 0.7), integral(0.7 * b, b, 0.5, 0.7), 0.05) << b;
        EXPECT_NEAR(laplace(0.52 * b, b, 0.5, 0.7), integral(0.52 * b, b, 0.5, 0.7), 0.1) << b;
        EXPECT_NEAR(laplace(0.3 * b, b, 0.0, 0.1), integral(0.3 * b, b, 0.0, 0.1), 0.1) << b; // on one side
    }
    // Where the data say nothing it is as probable as without it.
    EXPECT_NEAR(laplace(0.0, 1e-4, 0.5, 0.7), 0.0, 0.15);
    EXPECT_NEAR(laplace(0.0, 1e-4, 0.0, 0.1), 0.0, 0.15);
}

// n residuals of noise k: the integral over ln k by hand.
TEST(Evidence, AveragesOverTheSizeOfTheNoise) {
    constexpr Index n = 40;
    constexpr double sum = 2.25 * n;
    const hypotheses::NoisePrior prior{};
    const auto found = hypotheses::evidence(sum, n, MatrixXd(n, 0), hypotheses::Prior::of_parameters(0), prior);
    EXPECT_NEAR(found.as_stated, -0.5 * sum, 1e-9);
    double integral = 0.0;
    constexpr double step = 1e-4;
    for (double x = -2.0; x < 2.0; x += step) {
        integral += step *
                    std::exp(-n * x - 0.5 * sum * std::exp(-2.0 * x) - 0.5 * std::pow(x / prior.log_deviation, 2)) /
                    (prior.log_deviation * std::sqrt(2.0 * std::numbers::pi));
    }
    EXPECT_NEAR(found.any_size, std::log(integral), 1e-3);
    // The mode of the integrand: n = sum exp(-2 x) - x / deviation^2, at x = 0.3692. The prior pulls a little.
    EXPECT_NEAR(std::log(found.noise), 0.3692, 0.02); // the step of the sum
    EXPECT_NEAR(found.by_data, 1.5, 0.02);            // sqrt(sum / n): what these data alone say
    EXPECT_LT(found.noise_low, 1.5);
    EXPECT_GT(found.noise_high, 1.5);
    EXPECT_NEAR(found.log, std::log(0.5 * std::exp(found.as_stated - found.any_size) + 0.5) + found.any_size, 1e-9);
}

// The parameters' own determinant: two directions seen with 10 and 0.01 standard deviations across the box.
TEST(Evidence, CountsADirectionAsFarAsItIsSeen) {
    MatrixXd jacobian = MatrixXd::Zero(5, 2);
    jacobian(0, 0) = 10.0;
    jacobian(1, 1) = 0.01;
    const auto found = hypotheses::evidence(3.0, 5, jacobian, hypotheses::Prior::of_parameters(2), as_stated);
    EXPECT_NEAR(found.as_stated, -1.5 - 0.5 * std::log1p(100.0 / 12.0) - 0.5 * std::log1p(1e-4 / 12.0), 1e-9);
}

namespace {

constexpr Index loads = 4;
constexpr Index each = 8;
constexpr Index rows = loads * each;

hypotheses::LinearFit fit_of(const VectorXd& noise, const MatrixXd& jacobian) {
    return {noise - jacobian * jacobian.householderQr().solve(noise), jacobian};
}

// Readings of 2 % noise: the common error of a load moves each by 50 standard deviations times the share.
MatrixXd common_columns() {
    MatrixXd common = MatrixXd::Zero(rows, loads);
    for (Index i = 0; i < rows; ++i) {
        common(i, i / each) = 50.0;
    }
    return common;
}

std::vector<data::NoisePlace> places() {
    std::vector<data::NoisePlace> list;
    for (Index i = 0; i < rows; ++i) {
        list.push_back({.load = static_cast<int>(i / each), .quantity = 0, .x = 0.2 * static_cast<double>(i % each)});
    }
    return list;
}

const hypotheses::Counts counts{.readings = rows, .effects = 20, .channels = 8};

struct Compared {
    double stated, size, common, correlated, heavy; // logarithms of prior and evidence
};

Compared compare(const VectorXd& noise, std::uint64_t seed) {
    const pave::RandomStream random(seed, 5);
    const auto fit = fit_of(noise, 20.0 * test::normal_matrix(random, rows, 3, 0));
    const hypotheses::NoisePrior prior{};
    const auto plain = hypotheses::evidence(fit.residuals.squaredNorm(), rows, fit.jacobian,
                                            hypotheses::Prior::of_parameters(3), prior);
    const auto weighed = [&](const hypotheses::NoiseStructure& structure) {
        return structure.evidence.log + hypotheses::log_prior_of_structure(structure.key, counts);
    };
    const double independent = hypotheses::log_prior(hypotheses::Kind::noise, counts, 1, 0);
    return {plain.as_stated + independent, plain.any_size + independent,
            weighed(hypotheses::common_errors(fit, common_columns(), prior)),
            weighed(hypotheses::correlated_errors(fit, places(), prior)), weighed(hypotheses::heavy_tails(fit, prior))};
}

} // namespace

// Errors of 6 % that all readings of a load share: the range of their size holds it, and intervals are wider than those
// of independent errors. By hand, of a parameter that all readings follow alike (as they do the common error): n
// readings a load of deviation 1, each moved by 50 x 0.06 = 3: the mean of a load has variance 1 / 8 + 9, that of four
// loads a quarter, where independent errors leave 1 / 32: sqrt(73) times the deviation.
TEST(NoiseStructures, WidenIntervalsByWhatReadingsShare) {
    MatrixXd jacobian = MatrixXd::Constant(rows, 1, 20.0);
    const double independent = 1.0 / std::sqrt(20.0 * 20.0 * rows + 0.01 * 12.0);
    int held = 0;
    std::vector<double> wider;
    constexpr int trials = 20;
    for (int t = 0; t < trials; ++t) {
        const pave::RandomStream random(static_cast<std::uint64_t>(t) + 1, 0);
        const VectorXd noise = test::normal_matrix(random, rows, 1, 0) +
                               0.06 * common_columns() * test::normal_matrix(random, loads, 1, 1000);
        const auto found = hypotheses::common_errors(fit_of(noise, jacobian), common_columns(), {});
        held += found.low <= 0.06 && (found.high >= 0.06 || found.ends);
        wider.push_back(std::sqrt(found.covariance(0, 0)) / independent);
    }
    EXPECT_GE(held, trials - 3);
    std::sort(wider.begin(), wider.end());
    EXPECT_NEAR(wider[trials / 2], std::sqrt(73.0),
                4.0); // of three errors left the size is known within a factor of 1.5
}

namespace {

// Rows beside the derivatives, at the middle of the box, of this model with readings of its responses there.
MatrixXd open_rows(int dimension, const test::Formula::Model& model, const std::vector<double>& sigma_of) {
    const std::vector<double> unit(static_cast<std::size_t>(dimension), 0.5);
    const problem::Problem at_nothing =
        test::problem_of(dimension, test::Formula(model), std::vector<double>(sigma_of.size(), 0.0), 1.0);
    diagnose::Model fitted;
    fitted.unit = unit;
    fitted.evaluation = at_nothing.evaluate(unit, true, *at_nothing.function->make_workspace());
    fitted.residuals = at_nothing.residuals(fitted.evaluation);
    MatrixXd rows;
    run::Engine engine(at_nothing, nullptr, 0, {.threads = 1, .show_progress = false});
    engine.chain("", 1,
                 [&](run::Chain& chain) { rows = diagnose::rows_of_open_directions(at_nothing, fitted, 1.0, chain); });
    return rows;
}

} // namespace

TEST(OpenDirections, AreClosedWhereChi2RisesBeyondFirstOrder) {
    // chi2 = (400 (y - 1/2)^2)^2 = 1111 t^4, t in standard deviations of the box. The integral of exp(-chi2 / 2) is
    // that of a normal density with 1 + w = 2 pi (2 a^(1/4) / Gamma(1/4))^2 = 45, a = 1111 / 2.
    const auto quartic = [](const VectorXd& x, VectorXd& responses, MatrixXd& jacobian) {
        responses = VectorXd::Zero(2);
        responses << 100.0 * (x[0] - 0.5), 400.0 * std::pow(x[1] - 0.5, 2);
        jacobian = MatrixXd::Zero(2, 2);
        jacobian << 100.0, 0.0, 0.0, 800.0 * (x[1] - 0.5);
    };
    const MatrixXd rows = open_rows(2, quartic, {1.0, 1.0});
    ASSERT_EQ(rows.rows(), 1);
    EXPECT_NEAR(rows(0, 0), 0.0, 1e-6);
    const double weight = rows(0, 1) * rows(0, 1) / 12.0;
    EXPECT_GT(weight, 45.0 / 3.0);
    EXPECT_LT(weight, 45.0 * 3.0);
    // A valley that bends, along which the first parameter makes up for the second, stays open; so does what nothing
    // reads.
    const auto valley = [](const VectorXd& x, VectorXd& responses, MatrixXd& jacobian) {
        responses = VectorXd::Constant(1, 100.0 * (x[0] - 0.5 - std::pow(x[1] - 0.5, 2)));
        jacobian = MatrixXd::Zero(1, 3);
        jacobian << 100.0, -200.0 * (x[1] - 0.5), 0.0;
    };
    EXPECT_EQ(open_rows(3, valley, {1.0}).rows(), 0);
}

TEST(NoiseStructures, ArePreferredWhereTheyAre) {
    int stated = 0;
    int common = 0;
    int correlated = 0;
    int heavy = 0;
    constexpr int trials = 40;
    const double rare = hypotheses::log_prior(hypotheses::Kind::noise, counts, 1, 0) -
                        hypotheses::log_prior_of_structure("correlated", counts);
    for (int t = 0; t < trials; ++t) {
        const auto seed = static_cast<std::uint64_t>(t) + 1;
        const pave::RandomStream random(seed, 0);
        const VectorXd own = test::normal_matrix(random, rows, 1, 0);
        const auto plain = compare(own, seed);
        stated += plain.stated > std::max({plain.common, plain.correlated, plain.heavy});
        // 4 % of each load's readings in common.
        const VectorXd shared = test::normal_matrix(random, loads, 1, 1000);
        const auto tied = compare(own + 0.04 * common_columns() * shared, seed);
        common += tied.common > std::max({tied.stated, tied.size, tied.correlated, tied.heavy});
        // Neighbours at 200 mm tied by exp(-200/400).
        MatrixXd covariance = MatrixXd::Identity(rows, rows);
        for (Index i = 0; i < rows; ++i) {
            for (Index j = 0; j < rows; ++j) {
                covariance(i, j) = i / each == j / each ? std::exp(-0.5 * static_cast<double>(std::abs(i - j))) : 0.0;
            }
        }
        const MatrixXd root = covariance.llt().matrixL();
        const auto along = compare(root * own, seed);
        correlated += along.correlated + rare > std::max(along.stated, along.size); // by the data alone
        // Student's with three degrees of freedom.
        VectorXd tails = own;
        for (Index i = 0; i < rows; ++i) {
            tails[i] = gsl_cdf_tdist_Pinv(gsl_cdf_ugaussian_P(own[i]), 3.0);
        }
        const auto wild = compare(tails, seed);
        heavy += wild.heavy > wild.stated;
    }
    EXPECT_GE(stated, trials * 9 / 10);
    EXPECT_GE(common, trials * 7 / 10);
    EXPECT_GE(correlated, trials * 7 / 10);
    EXPECT_GE(heavy, trials / 2);
}

// The heavy tails of one point: n independent draws whose density is known, and no parameter.
TEST(NoiseStructures, OfHeavyTailsIsTheDensityOfStudent) {
    const VectorXd residuals{{0.3, -1.2, 6.0, 0.5, -0.1}};
    const auto found = hypotheses::heavy_tails({residuals, MatrixXd(5, 0)}, hypotheses::NoisePrior{});
    double expected = 0.0;
    for (const double z : residuals) {
        expected += std::log(3.0 / 8.0) - 2.5 * std::log1p(z * z / 4.0) + 0.5 * std::log(2.0 * std::numbers::pi);
    }
    EXPECT_NEAR(found.evidence.as_stated, expected, 1e-6);
}

TEST(Priors, ShareWhatIsProbableBeforehand) {
    const hypotheses::Counts counts{.readings = 30, .effects = 20, .channels = 8};
    using hypotheses::Kind;
    const auto p = [&](Kind kind, std::size_t variants, std::size_t bad) {
        return std::exp(hypotheses::log_prior(kind, counts, variants, bad));
    };
    double sum = p(Kind::none, 1, 0) + p(Kind::noise, 1, 0) + 20 * p(Kind::effect, 1, 0) +
                 190 * p(Kind::effects, 1, 0) + 8 * p(Kind::correction, 1, 0) + p(Kind::layout, 1, 0);
    double sets = 1.0; // of so many of 30 readings
    for (std::size_t bad = 1; bad <= 5; ++bad) {
        sets *= (31.0 - static_cast<double>(bad)) / static_cast<double>(bad);
        sum += sets * p(Kind::readings, 1, bad);
    }
    EXPECT_LT(sum, 1.0);
    EXPECT_GT(sum, 0.9);
    EXPECT_NEAR(p(Kind::effect, 4, 0), p(Kind::effect, 1, 0) / 4.0, 1e-12);
}
