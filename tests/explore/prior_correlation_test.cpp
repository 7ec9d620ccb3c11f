// Priors whose errors are correlated: mean, covariance and evidence of linear Gaussian inference in closed form.
#include "landscape/minima.h"
#include "support/formula.h"

#include <Eigen/Dense>
#include <cmath>
#include <gtest/gtest.h>
#include <numbers>

using namespace explore;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double sigma = 0.05;
const std::vector<double> measured{0.55, 0.62, 0.68, -0.13, 0.49};

MatrixXd readings_of_three() {
    MatrixXd a(5, 3);
    a << 1.0, 0.3, 0.01, 0.4, 1.0, 0.02, 0.7, 0.6, -0.01, 0.2, -0.5, 0.015, 1.1, 0.1, 0.0;
    return a;
}

// Priors 0.3 +- 0.02 and 0.5 +- 0.03 of the parameters 2 and 0, correlated by 0.8.
problem::Problem linear_problem() {
    const auto model = [a = readings_of_three()](const VectorXd& x, VectorXd& responses, MatrixXd& jacobian) {
        responses = a * x;
        jacobian = a;
    };
    auto problem = test::problem_of(3, test::Formula(model), measured, sigma).in_units_of_noise();
    problem.space.axes[2].prior = {.mean = 0.3, .sd = 0.02};
    problem.space.axes[0].prior = {.mean = 0.5, .sd = 0.03};
    problem.space.prior_correlations = {{.a = "p2", .b = "p0", .value = 0.8}};
    return problem;
}

MatrixXd prior_precision() {
    MatrixXd c(2, 2); // of the parameters 0 and 2
    c << 0.03 * 0.03, 0.8 * 0.03 * 0.02, 0.8 * 0.03 * 0.02, 0.02 * 0.02;
    const MatrixXd inverse = c.inverse();
    MatrixXd p = MatrixXd::Zero(3, 3);
    p(0, 0) = inverse(0, 0);
    p(0, 2) = p(2, 0) = inverse(0, 1);
    p(2, 2) = inverse(1, 1);
    return p;
}

} // namespace

TEST(PriorCorrelation, GivesMeanAndCovarianceOfLinearGaussianInference) {
    const problem::Problem problem = linear_problem();
    const auto at = [&](const VectorXd& unit) {
        return problem.evaluate(std::vector<double>(unit.begin(), unit.end()), true,
                                *problem.function->make_workspace());
    };
    // One step of Gauss and Newton, which ends a linear problem.
    const VectorXd middle = VectorXd::Constant(3, 0.5);
    const MatrixXd j = problem.residual_jacobian(at(middle));
    const VectorXd unit = middle - (j.transpose() * j).ldlt().solve(j.transpose() * problem.residuals(at(middle)));
    landscape::Minimum found;
    found.evaluation = at(unit);
    found.unit.assign(unit.begin(), unit.end());
    const MatrixXd a = readings_of_three();
    const MatrixXd precision = a.transpose() * a / (sigma * sigma) + prior_precision();
    VectorXd mean(3);
    mean << 0.5, 0.0, 0.3;
    const VectorXd right =
        a.transpose() * VectorXd::Map(measured.data(), 5) / (sigma * sigma) + prior_precision() * mean;
    const VectorXd expected = precision.llt().solve(right);
    const MatrixXd covariance = precision.inverse();
    const auto local = landscape::analyse(found, problem);
    ASSERT_FALSE(local.widened);
    for (Index k = 0; k < 3; ++k) {
        EXPECT_NEAR(found.unit[static_cast<std::size_t>(k)], expected[k], 1e-7);
        EXPECT_NEAR(local.standard_error[static_cast<std::size_t>(k)], std::sqrt(covariance(k, k)), 1e-7);
    }
}

TEST(PriorCorrelation, DensityIsThatOfTheBivariateNormal) {
    const problem::Problem problem = linear_problem();
    const std::vector<double> unit{0.47, 0.4, 0.31};
    const auto e = problem.evaluate(unit, false, *problem.function->make_workspace());
    const VectorXd off = readings_of_three() * VectorXd::Map(unit.data(), 3) - VectorXd::Map(measured.data(), 5);
    double expected =
        -0.5 * off.squaredNorm() / (sigma * sigma) - 5.0 * std::log(sigma * std::sqrt(2.0 * std::numbers::pi));
    const double x = (0.47 - 0.5) / 0.03;
    const double y = (0.31 - 0.3) / 0.02;
    expected += -0.5 * (x * x - 2.0 * 0.8 * x * y + y * y) / (1.0 - 0.8 * 0.8) -
                std::log(2.0 * std::numbers::pi * 0.03 * 0.02 * std::sqrt(1.0 - 0.8 * 0.8));
    EXPECT_NEAR(problem.log_density(e), expected, 1e-9); // the box is 10 standard deviations away
}

TEST(PriorCorrelation, AWrongReadingLeavesTheRowsOfPriorsAlone) {
    const problem::Problem problem = linear_problem();
    const auto e = problem.evaluate(std::vector<double>(3, 0.5), false, *problem.function->make_workspace());
    for (std::size_t i = 0; i < measured.size(); ++i) {
        auto wrong = e;
        wrong.responses[i] += sigma;
        const VectorXd change = problem.change_by(i);
        ASSERT_EQ(change.size(), static_cast<Index>(problem.rows()));
        EXPECT_LT((problem.residuals(wrong) - problem.residuals(e) - change).norm(), 1e-12);
    }
}
