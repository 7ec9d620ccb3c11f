// Noise of Student's t distribution: its rows by the density that GSL has, estimates by a search of that likelihood,
// errors and p-values by what such noise does when it is drawn.
#include "landscape/goodness.h"
#include "landscape/minima.h"
#include "problem/student.h"
#include "support/formula.h"

#include "base/random.h"

#include <Eigen/Dense>
#include <cmath>
#include <gsl/gsl_randist.h>
#include <gsl/gsl_sf_psi.h>
#include <gtest/gtest.h>

using namespace explore;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double degrees = 4.0;
constexpr double noise_sigma = 0.05;
constexpr Index count = 12;

// A level and a slope.
MatrixXd line() {
    MatrixXd x(count, 2);
    for (Index i = 0; i < count; ++i) {
        x.row(i) << 1.0, static_cast<double>(i) / static_cast<double>(count - 1);
    }
    return x;
}

struct Layout {
    double correlation_length = 0.0; // m
    double factor = 1.0;             // of every other reading
    double degrees_of_freedom = degrees;
};

problem::Problem line_problem(const VectorXd& y, const Layout& layout = {}) {
    problem::ParameterSpace space;
    for (const char* name : {"level", "slope"}) {
        space.axes.push_back({name, -1.0, 2.0, problem::Scale::linear, 0, 0.5});
    }
    std::vector<problem::Misfit::Term> terms;
    for (Index i = 0; i < y.size(); ++i) {
        terms.push_back({.response = static_cast<std::size_t>(i),
                         .measured = y[i],
                         .factor = i % 2 == 0 ? 1.0 : layout.factor,
                         .noise = {.absolute = noise_sigma,
                                   .correlation_length = layout.correlation_length,
                                   .degrees = layout.degrees_of_freedom},
                         .place = {.load = 0, .x = 0.1 * static_cast<double>(i)}});
    }
    const auto model = [x = line()](const VectorXd& p, VectorXd& r, MatrixXd& j) {
        r = x * p;
        j = x;
    };
    return {space, std::make_shared<test::Formula>(model), {problem::MisfitKind::noise, std::move(terms)}};
}

problem::Evaluation at(const problem::Problem& problem, const VectorXd& unit) {
    return problem.evaluate(std::vector<double>(unit.begin(), unit.end()), true, *problem.function->make_workspace());
}

landscape::Minimum fitted(const problem::Problem& problem) {
    run::Engine engine(problem, nullptr, 0, {.threads = 1, .show_progress = false});
    const auto ends = engine.search({{0.5, 0.5}}, *optimise::find_method("gauss-newton"),
                                    {.step_tolerance = 1e-9, .misfit_tolerance = 1e-14}, 0);
    return landscape::distinct_minima(*ends, problem)[0];
}

// The truth 0.4 + 0.3 x with small errors written out.
VectorXd readings() {
    VectorXd y = line() * Eigen::Vector2d(0.4, 0.3);
    for (Index i = 0; i < count; ++i) {
        y[i] += noise_sigma * std::sin(3.0 * static_cast<double>(i) + 1.0);
    }
    return y;
}

// The lowest of f in [low, high], where it has one minimum.
template <class F>
double lowest_at(const F& f, double low, double high) {
    for (int i = 0; i < 100; ++i) {
        const double a = low + (high - low) / 3.0;
        const double b = high - (high - low) / 3.0;
        (f(a) < f(b) ? high : low) = f(a) < f(b) ? b : a;
    }
    return 0.5 * (low + high);
}

// -ln likelihood by GSL's density.
double minus_log(const VectorXd& y, double level, double slope) {
    double sum = 0.0;
    const VectorXd z = (line() * Eigen::Vector2d(level, slope) - y) / noise_sigma;
    for (const double value : z) {
        sum -= std::log(gsl_ran_tdist_pdf(value, degrees));
    }
    return sum;
}

} // namespace

TEST(Student, RowsAreTheLogarithmOfTheDensity) {
    for (const double nu : {1.0, 4.0, 30.0}) {
        EXPECT_NEAR(problem::student_log_peak(nu), std::log(gsl_ran_tdist_pdf(0.0, nu)), 1e-12);
        for (const double z : {-300.0, -2.5, -1e-5, 0.3, 4.0}) {
            const double row = problem::student_row(z, nu);
            const double log = -2.0 * std::log(gsl_ran_tdist_pdf(z, nu) / gsl_ran_tdist_pdf(0.0, nu));
            EXPECT_NEAR(row * row, log, 1e-9 * (1.0 + log));
            EXPECT_EQ(std::signbit(row), std::signbit(z));
            const double step = 1e-6 * std::max(1.0, std::abs(z));
            EXPECT_NEAR(problem::student_row_slope(z, nu),
                        (problem::student_row(z + step, nu) - problem::student_row(z - step, nu)) / (2.0 * step), 1e-8);
            // Half the derivative of row^2 is that of weighted least squares.
            EXPECT_NEAR(row * problem::student_row_slope(z, nu), problem::student_weight(z, nu) * z,
                        1e-12 * std::abs(z));
        }
        EXPECT_NEAR(problem::student_row_slope(0.0, nu), std::sqrt((nu + 1.0) / nu), 1e-15);
        // Fisher's information: the mean of the square of d(ln density)/dz.
        double information = 0.0;
        constexpr double step = 0.01;
        for (double z = -2000.0; z < 2000.0; z += step) {
            information += step * gsl_ran_tdist_pdf(z, nu) * std::pow(problem::student_weight(z, nu) * z, 2);
        }
        EXPECT_NEAR(problem::student_information(nu), information, 1e-6);
    }
}

TEST(Student, DrawsHaveTheDistribution) {
    const pave::RandomStream random(3, 0);
    constexpr int draws = 40000;
    int beyond = 0; // the 5 % of GSL: |t| > 2.776 with 4 degrees of freedom
    for (int i = 0; i < draws; ++i) {
        const auto k = static_cast<std::uint64_t>(i);
        beyond +=
            std::abs(problem::student_draw(random.uniform(2 * k), random.uniform(2 * k + 1), 4.0)) > 2.776445 ? 1 : 0;
    }
    EXPECT_NEAR(beyond, 0.05 * draws, 4.0 * std::sqrt(0.05 * 0.95 * draws));
}

TEST(Student, AWrongReadingHardlyMovesTheAnswer) {
    VectorXd y = readings();
    const auto clean = fitted(line_problem(y)).evaluation.parameters;
    const auto normal = fitted(line_problem(y, {.degrees_of_freedom = 0.0})).evaluation.parameters;
    y[10] += 1.0; // 20 standard deviations
    const problem::Problem problem = line_problem(y);
    const auto found = fitted(problem).evaluation;
    const auto pulled = fitted(line_problem(y, {.degrees_of_freedom = 0.0})).evaluation.parameters;
    // The most likely line, by a search that knows no rows.
    const auto slope_of = [&](double level) {
        return lowest_at([&](double slope) { return minus_log(y, level, slope); }, 0.0, 0.6);
    };
    const double level = lowest_at([&](double l) { return minus_log(y, l, slope_of(l)); }, 0.2, 0.6);
    EXPECT_NEAR(found.parameters[0], level, 1e-6);
    EXPECT_NEAR(found.parameters[1], slope_of(level), 1e-6);
    // And it lies near that of the clean readings, where normal noise is pulled away.
    EXPECT_LT(std::abs(found.parameters[1] - clean[1]), noise_sigma);
    EXPECT_GT(std::abs(pulled[1] - normal[1]), 4.0 * noise_sigma);
    // Clean readings: close to least squares.
    for (std::size_t k = 0; k < 2; ++k) {
        EXPECT_NEAR(clean[k], normal[k], 0.3 * noise_sigma);
    }
    // log_density is GSL's, of the readings in SI; no priors.
    const double density = -minus_log(y, found.parameters[0], found.parameters[1]) - count * std::log(noise_sigma);
    EXPECT_NEAR(problem.log_density(found), density, 1e-9);
}

TEST(Student, DerivativesAreExactWithCorrelationAndWeights) {
    VectorXd y = readings();
    y[4] -= 0.4;
    const problem::Problem problem = line_problem(y, {.correlation_length = 0.3, .factor = 0.4});
    const VectorXd unit{{0.47, 0.41}};
    const MatrixXd j = problem.residual_jacobian(at(problem, unit));
    constexpr double step = 1e-5;
    for (Index k = 0; k < 2; ++k) {
        const VectorXd move = step * VectorXd::Unit(2, k);
        const VectorXd difference =
            (problem.residuals(at(problem, unit + move)) - problem.residuals(at(problem, unit - move))) / (2.0 * step);
        EXPECT_LT((j.col(k) - difference).lpNorm<Eigen::Infinity>(), 1e-6 * j.col(k).norm());
    }
}

TEST(Student, StandardErrorsAreThoseOfFishersInformation) {
    const problem::Problem problem = line_problem(readings());
    const auto local = landscape::analyse(fitted(problem), problem);
    ASSERT_FALSE(local.widened);
    const MatrixXd covariance =
        (degrees + 3.0) / (degrees + 1.0) * noise_sigma * noise_sigma * (line().transpose() * line()).inverse();
    for (Index k = 0; k < 2; ++k) {
        EXPECT_NEAR(3.0 * local.standard_error[static_cast<std::size_t>(k)], std::sqrt(covariance(k, k)), 1e-9);
    }
}

TEST(Student, WhatIsLeftOverHasItsMean) {
    // Without parameters that count: (nu + 1) (psi((nu + 1) / 2) - psi(nu / 2)) a reading, and the variance
    // (nu + 1)^2 (psi'(nu / 2) - psi'((nu + 1) / 2)), for 1 / (1 + z^2 / nu) is a beta variable.
    problem::Problem problem = line_problem(readings());
    const auto still = [](const VectorXd&, VectorXd& r, MatrixXd& j) {
        r = VectorXd::Zero(count);
        j = MatrixXd::Zero(count, 2);
    };
    problem.function = std::make_shared<test::Formula>(still);
    const double mean = (degrees + 1.0) * (gsl_sf_psi(0.5 * (degrees + 1.0)) - gsl_sf_psi(0.5 * degrees));
    const double variance =
        std::pow(degrees + 1.0, 2) * (gsl_sf_psi_1(0.5 * degrees) - gsl_sf_psi_1(0.5 * (degrees + 1.0)));
    const auto goodness = landscape::goodness_of(problem, at(problem, Eigen::Vector2d(0.5, 0.5)), 0.0, count);
    EXPECT_NEAR(goodness.expected, count * mean, 4.0 * std::sqrt(count * variance / 2000.0));
    EXPECT_EQ(goodness.p_value, 1.0);
}

TEST(Student, PValuesAreUniform) {
    constexpr int trials = 300;
    int low = 0;
    int lower_half = 0;
    int covered = 0;
    const VectorXd truth{{0.4, 0.3}};
    for (int trial = 0; trial < trials; ++trial) {
        const pave::RandomStream random(11, static_cast<std::uint64_t>(trial));
        VectorXd y = line() * truth;
        for (Index i = 0; i < count; ++i) {
            const auto k = static_cast<std::uint64_t>(i);
            // Normal over the root of a mean of squares: by definition, not by student_draw.
            double squares = 0.0;
            for (std::uint64_t m = 0; m < 4; ++m) {
                squares += std::pow(random.normal(100 + 4 * k + m), 2);
            }
            y[i] += noise_sigma * random.normal(k) / std::sqrt(squares / 4.0);
        }
        const problem::Problem problem = line_problem(y);
        const auto minimum = fitted(problem);
        const double p =
            landscape::goodness_of(problem, minimum.evaluation, std::pow(minimum.evaluation.misfit, 2), count - 2)
                .p_value;
        low += p < 0.1 ? 1 : 0;
        lower_half += p < 0.5 ? 1 : 0;
        const auto local = landscape::analyse(minimum, problem);
        covered += std::abs(minimum.evaluation.parameters[1] - truth[1]) < 1.96 * 3.0 * local.standard_error[1] ? 1 : 0;
    }
    EXPECT_NEAR(low, 0.1 * trials, 3.5 * std::sqrt(0.09 * trials));
    EXPECT_NEAR(lower_half, 0.5 * trials, 3.5 * std::sqrt(0.25 * trials));
    EXPECT_GT(covered, 0.9 * trials);
}
