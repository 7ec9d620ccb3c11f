// The posterior by sequential Monte Carlo against densities whose moments, weights and evidence are known.
#include "landscape/posterior.h"
#include "landscape/smooth.h"
#include "support/formula.h"

#include <cmath>
#include <gtest/gtest.h>
#include <numbers>

using namespace explore;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using test::Formula;

namespace {

landscape::Posterior sample(const problem::Problem& problem, int particles, std::uint64_t seed = 1, int threads = 0,
                            int rounds = 1) {
    run::Engine engine(problem, nullptr, 0, {.threads = threads, .show_progress = false});
    auto result =
        landscape::posterior(engine, problem, {.particles = particles, .rounds = rounds, .show_progress = false}, seed);
    EXPECT_TRUE(result.has_value());
    EXPECT_EQ(result->reason, "");
    return *result;
}

std::vector<double> coordinate(const landscape::Posterior& posterior, std::size_t k) {
    std::vector<double> values;
    for (const auto& draw : posterior.draws) {
        values.push_back(draw.unit[k]);
    }
    return values;
}

// r = A x, in units of its noise.
problem::Problem linear(const MatrixXd& a, const std::vector<double>& measured, double sigma) {
    const auto model = [a](const VectorXd& x, VectorXd& r, MatrixXd& j) {
        r = a * x;
        j = a;
    };
    return test::problem_of(static_cast<int>(a.cols()), Formula(model), measured, sigma).in_units_of_noise();
}

MatrixXd draws_of_numbers(Index rows, Index columns, std::uint64_t seed) {
    const pave::RandomStream stream(seed, 0x905ULL);
    MatrixXd a(rows, columns);
    for (Index i = 0; i < a.size(); ++i) {
        a.data()[i] = stream.normal(static_cast<std::uint64_t>(i));
    }
    return a;
}

// The evidence of the linear model inside a box of volume 1 that cuts nothing off: the integral of the Gaussian
// likelihood, (2 pi)^((d - n)/2) sigma^(d - n) |A'A|^(-1/2) exp(-S / 2 sigma^2), S the least sum of squares.
double linear_evidence(const MatrixXd& a, const VectorXd& y, double sigma) {
    const VectorXd best = a.colPivHouseholderQr().solve(y);
    const double s = (a * best - y).squaredNorm() / (sigma * sigma);
    const double d = static_cast<double>(a.cols()) - static_cast<double>(a.rows());
    return 0.5 * d * std::log(2.0 * std::numbers::pi) + d * std::log(sigma) -
           0.5 * std::log((a.transpose() * a).determinant()) - 0.5 * s;
}

} // namespace

TEST(Posterior, GaussianInFiveDimensions) {
    const MatrixXd a = MatrixXd::Identity(5, 5) + 0.2 * draws_of_numbers(5, 5, 3);
    const VectorXd truth = (VectorXd(5) << 0.45, 0.5, 0.55, 0.5, 0.4).finished();
    const VectorXd y = a * truth;
    const double sigma = 0.02;
    const MatrixXd covariance = sigma * sigma * (a.transpose() * a).inverse();
    ASSERT_LT(covariance.diagonal().cwiseSqrt().maxCoeff(), 0.07); // the box cuts nothing off
    const auto posterior = sample(linear(a, {y.begin(), y.end()}, sigma), 1000);
    for (std::size_t k = 0; k < 5; ++k) {
        const auto i = static_cast<Index>(k);
        const double sd = std::sqrt(covariance(i, i));
        const auto m = landscape::marginal(coordinate(posterior, k), posterior.descent);
        EXPECT_NEAR(m.mean, truth[i], 0.1 * sd);
        EXPECT_NEAR(m.sd, sd, 0.07 * sd);
        EXPECT_NEAR(m.q025, truth[i] - 1.96 * sd, 0.2 * sd);
        EXPECT_NEAR(m.q975, truth[i] + 1.96 * sd, 0.2 * sd);
        EXPECT_LT(m.rhat, 1.02);
        EXPECT_GT(m.ess, 400.0);
        for (std::size_t l = 0; l < k; ++l) {
            const auto j = static_cast<Index>(l);
            EXPECT_NEAR(landscape::weighted_correlation(coordinate(posterior, k), coordinate(posterior, l),
                                                        posterior.descent.weight),
                        covariance(i, j) / std::sqrt(covariance(i, i) * covariance(j, j)), 0.08);
        }
    }
    EXPECT_NEAR(posterior.log_evidence, linear_evidence(a, y, sigma), 0.1);
    EXPECT_LT(posterior.log_evidence_error, 0.1);
}

TEST(Posterior, EvidenceOfMoreReadingsThanParameters) {
    const MatrixXd a = draws_of_numbers(9, 3, 11);
    const VectorXd y = a * VectorXd::Constant(3, 0.5) + 0.05 * draws_of_numbers(9, 1, 12);
    const auto posterior = sample(linear(a, {y.begin(), y.end()}, 0.05), 1000);
    EXPECT_NEAR(posterior.log_evidence, linear_evidence(a, y, 0.05), 0.1);
}

// Further draws of the same particles: as many more are worth, so means lie as much closer to those of the closed form.
TEST(Posterior, RoundsAreWorthAsManyDraws) {
    const MatrixXd a = MatrixXd::Identity(3, 3) + 0.2 * draws_of_numbers(3, 3, 5);
    const VectorXd y = a * VectorXd::Constant(3, 0.5);
    const double sigma = 0.03;
    const MatrixXd covariance = sigma * sigma * (a.transpose() * a).inverse();
    const problem::Problem problem = linear(a, {y.begin(), y.end()}, sigma);
    constexpr int rounds = 8;
    double squares = 0.0; // of the errors of means, in units of what draws of this number would have, independent
    for (std::uint64_t seed = 1; seed <= 6; ++seed) {
        const auto posterior = sample(problem, 100, seed, 0, rounds);
        ASSERT_EQ(posterior.draws.size(), 400U * rounds);
        ASSERT_EQ(posterior.descent.size(), 400U * rounds);
        for (std::size_t k = 0; k < 3; ++k) {
            const auto i = static_cast<Index>(k);
            const auto m = landscape::marginal(coordinate(posterior, k), posterior.descent);
            squares += std::pow(m.mean - 0.5, 2) / covariance(i, i) * 400.0 * rounds / 18.0;
            EXPECT_NEAR(m.sd, std::sqrt(covariance(i, i)), 0.06 * m.sd);
            EXPECT_GT(m.ess, 1000.0);
        }
    }
    EXPECT_LT(squares, 3.0); // 8 if draws of one particle said the same thing
}

TEST(Smooth, SecondDegreeIsExactAndWhatIsLeftIsThatOfFitsWithoutTheirPoint) {
    const MatrixXd points = draws_of_numbers(60, 3, 21);
    const auto parabola = [](const auto& p) { return 1.0 + p[0] - 2.0 * p[1] * p[2] + 0.5 * p[2] * p[2]; };
    VectorXd values(60);
    for (Index i = 0; i < 60; ++i) {
        values[i] = parabola(points.row(i));
    }
    const auto exact = landscape::smooth(points.topRows(50), values.head(50), points);
    ASSERT_TRUE(exact);
    EXPECT_LT(exact->left, 1e-12);
    EXPECT_LT((exact->values - values).cwiseAbs().head(50).maxCoeff(), 1e-12);
    const VectorXd noisy = values + 0.1 * draws_of_numbers(60, 1, 22);
    double squares = 0.0;
    for (Index out = 0; out < 60; ++out) {
        MatrixXd rest(59, 3);
        VectorXd of(59);
        rest << points.topRows(out), points.bottomRows(59 - out);
        of << noisy.head(out), noisy.tail(59 - out);
        MatrixXd widened(59, 10);
        VectorXd at(10);
        const auto terms = [](const auto& p) {
            return VectorXd{
                {1.0, p[0], p[1], p[2], p[0] * p[0], p[0] * p[1], p[0] * p[2], p[1] * p[1], p[1] * p[2], p[2] * p[2]}};
        };
        for (Index i = 0; i < 59; ++i) {
            widened.row(i) = terms(rest.row(i));
        }
        at = terms(points.row(out));
        squares += std::pow(noisy[out] - at.dot(widened.colPivHouseholderQr().solve(of)), 2);
    }
    EXPECT_NEAR(landscape::smooth(points, noisy, points)->left, std::sqrt(squares / 60.0), 1e-10);
    EXPECT_FALSE(landscape::smooth(points.topRows(15), values.head(15), points)); // 4 coefficients of the first degree
}

// A parabola: x1 = 2 u, x2 = b u^2 + v and three more, u and v normal with given moments. Means, deviations: those of
// the normal and of its square.
TEST(Posterior, CurvedValleyInFiveDimensions) {
    const double su = 0.1;    // of x0 about 0.5
    const double bend = 12.0; // x1 = 0.3 + bend (x0 - 0.5)^2 + v
    const double sv = 0.01;
    const auto model = [=](const VectorXd& x, VectorXd& r, MatrixXd& j) {
        r = VectorXd::Zero(5);
        j = MatrixXd::Zero(5, 5);
        const double u = x[0] - 0.5;
        r[0] = u / su;
        j(0, 0) = 1.0 / su;
        r[1] = (x[1] - 0.3 - bend * u * u) / sv;
        j(1, 0) = -2.0 * bend * u / sv;
        j(1, 1) = 1.0 / sv;
        for (Index k = 2; k < 5; ++k) {
            r[k] = (x[k] - 0.5) / 0.05;
            j(k, k) = 1.0 / 0.05;
        }
    };
    // The box holds x0 within 2.41 deviations: bend u^2 + 0.3 < 1.
    const double limit = std::sqrt(0.7 / bend) / su;
    const auto posterior =
        sample(test::problem_of(5, Formula(model), std::vector<double>(5, 0.0), 1.0).in_units_of_noise(), 1000);
    // A normal cut off at +-limit; the edge is soft by sv, which moves nothing here.
    const double inside = std::erf(limit / std::numbers::sqrt2);
    const double density = std::exp(-0.5 * limit * limit) / std::sqrt(2.0 * std::numbers::pi);
    const double second = 1.0 - 2.0 * limit * density / inside; // of u / su
    const double fourth = 3.0 * second - 2.0 * limit * limit * limit * density / inside;
    const auto first = landscape::marginal(coordinate(posterior, 0), posterior.descent);
    EXPECT_NEAR(first.mean, 0.5, 0.1 * su);
    EXPECT_NEAR(first.sd, su * std::sqrt(second), 0.06 * su);
    const auto curved = landscape::marginal(coordinate(posterior, 1), posterior.descent);
    const double sd = bend * su * su * std::sqrt(fourth - second * second);
    EXPECT_NEAR(curved.mean, 0.3 + bend * su * su * second, 0.1 * sd);
    EXPECT_NEAR(curved.sd, sd, 0.1 * sd);
    EXPECT_NEAR(
        landscape::weighted_correlation(coordinate(posterior, 0), coordinate(posterior, 1), posterior.descent.weight),
        0.0, 0.1);
    // The product of the widths, and what is inside.
    EXPECT_NEAR(posterior.log_evidence, std::log(su * sv * std::pow(0.05, 3) * inside), 0.1);
}

// x0 has the residuals s (x - a)(x - b) and t (x - a): two minima 20 deviations apart, of unequal weight; the other
// four are normal. The weights by quadrature along x0.
TEST(Posterior, TwoModesTwentyDeviationsApart) {
    const double a = 0.3, b = 0.7, s = 125.0, t = 2.0;
    const auto model = [=](const VectorXd& x, VectorXd& r, MatrixXd& j) {
        r = VectorXd::Zero(6);
        j = MatrixXd::Zero(6, 5);
        r[0] = s * (x[0] - a) * (x[0] - b);
        j(0, 0) = s * (2.0 * x[0] - a - b);
        r[5] = t * (x[0] - a);
        j(5, 0) = t;
        for (Index k = 1; k < 5; ++k) {
            r[k] = (x[k] - 0.5) / 0.03;
            j(k, k) = 1.0 / 0.03;
        }
    };
    double left = 0.0, all = 0.0;
    for (int i = 0; i < 100'000; ++i) {
        const double x = (i + 0.5) / 100'000;
        const double p = std::exp(-0.5 * (std::pow(s * (x - a) * (x - b), 2) + std::pow(t * (x - a), 2)));
        left += x < 0.5 ? p : 0.0;
        all += p;
    }
    const auto problem = test::problem_of(5, Formula(model), std::vector<double>(6, 0.0), 1.0).in_units_of_noise();
    for (const std::uint64_t seed : {1, 2}) {
        const auto posterior = sample(problem, 500, seed);
        const auto x = coordinate(posterior, 0);
        const double share = static_cast<double>(std::count_if(x.begin(), x.end(), [](double v) { return v < 0.5; })) /
                             static_cast<double>(x.size());
        EXPECT_NEAR(share, left / all, 0.05);
        EXPECT_LT(landscape::marginal(x, posterior.descent).rhat, landscape::most_rhat);
        EXPECT_NEAR(posterior.log_evidence,
                    std::log(all / 100'000 * std::pow(0.03 * std::sqrt(2.0 * std::numbers::pi), 4)) -
                        3.0 * std::log(2.0 * std::numbers::pi),
                    0.2);
    }
}

// What is at the edge: half a normal. And a third of the box without an answer, which has no likelihood.
TEST(Posterior, BoundsAndHoles) {
    const auto model = [](const VectorXd& x, VectorXd& r, MatrixXd& j) {
        r = x / 0.1;
        j = MatrixXd::Identity(2, 2) / 0.1;
    };
    const auto full =
        sample(test::problem_of(2, Formula(model), std::vector<double>(2, 0.0), 1.0).in_units_of_noise(), 1000);
    const auto m = landscape::marginal(coordinate(full, 0), full.descent);
    EXPECT_NEAR(m.mean, 0.1 * std::sqrt(2.0 / std::numbers::pi), 0.005); // of half a normal
    EXPECT_NEAR(m.q50, 0.0674, 0.005);
    EXPECT_NEAR(full.log_evidence, std::log(0.1 * 0.1 / 4.0), 0.1);
    EXPECT_EQ(full.answered, 1.0);
    const auto holes = sample(
        test::problem_of(2, Formula(model, 1.0 / 3.0), std::vector<double>(2, 0.0), 1.0).in_units_of_noise(), 1000);
    EXPECT_NEAR(holes.answered, 2.0 / 3.0, 0.03);
    EXPECT_NEAR(holes.log_evidence, std::log(2.0 / 3.0 * 0.1 * 0.1 / 4.0), 0.12);
}

TEST(Posterior, NoAnswerAnywhereIsSaid) {
    const auto model = [](const VectorXd& x, VectorXd& r, MatrixXd& j) {
        r = x;
        j = MatrixXd::Identity(2, 2);
    };
    const auto problem = test::problem_of(2, Formula(model, 1.0), std::vector<double>(2, 0.0), 1.0).in_units_of_noise();
    run::Engine engine(problem, nullptr, 0, {.threads = 0, .show_progress = false});
    const auto result = landscape::posterior(engine, problem, {.particles = 100, .show_progress = false}, 1);
    ASSERT_TRUE(result.has_value());
    EXPECT_TRUE(result->draws.empty());
    EXPECT_NE(result->reason.find("injected"), std::string::npos);
}

TEST(Posterior, ThreadsDoNotChangeABit) {
    const MatrixXd a = draws_of_numbers(4, 3, 21);
    const VectorXd y = a * VectorXd::Constant(3, 0.5);
    const auto problem = linear(a, {y.begin(), y.end()}, 0.1);
    const auto one = sample(problem, 100, 5, 1);
    const auto two = sample(problem, 100, 5, 2);
    ASSERT_EQ(one.draws.size(), two.draws.size());
    for (std::size_t i = 0; i < one.draws.size(); ++i) {
        EXPECT_EQ(one.draws[i].unit, two.draws[i].unit);
        EXPECT_EQ(one.draws[i].log_likelihood, two.draws[i].log_likelihood);
    }
    EXPECT_EQ(one.log_evidence, two.log_evidence);
    EXPECT_NE(one.draws[0].unit, sample(problem, 100, 6, 1).draws[0].unit); // the seed does
}

// Marginals of draws that are known to be independent, or to come in families of ten.
TEST(Posterior, EffectiveDrawsOfFamilies) {
    const pave::RandomStream stream(7, 1);
    std::vector<double> values;
    landscape::Descent alone, families;
    for (int i = 0; i < 4000; ++i) {
        values.push_back(stream.normal(static_cast<std::uint64_t>(i / 10)));
        for (landscape::Descent* d : {&alone, &families}) {
            d->weight.push_back(1.0);
            d->population.push_back(i / 1000);
        }
        alone.ancestor.push_back(i);
        families.ancestor.push_back(i / 10);
    }
    EXPECT_NEAR(landscape::marginal(values, families).ess, 400.0, 60.0);
    for (int i = 0; i < 4000; ++i) {
        values[static_cast<std::size_t>(i)] = stream.normal(static_cast<std::uint64_t>(5000 + i));
    }
    const auto independent = landscape::marginal(values, families);
    EXPECT_NEAR(independent.ess, 4000.0, 800.0);
    EXPECT_LT(independent.rhat, 1.01);
    EXPECT_NEAR(independent.q025, -1.96, 0.13); // three standard errors
    for (int i = 0; i < 1000; ++i) {            // one population apart from the others
        values[static_cast<std::size_t>(i)] += 1.0;
    }
    EXPECT_GT(landscape::marginal(values, families).rhat, landscape::most_rhat);
}
