// What is known besides the readings: priors by the closed form of linear Gaussian inference, constraints by
// projection, ties by the section written out.
#include "landscape/prior_influence.h"
#include "landscape/readings_alone.h"
#include "optimise/local_search.h"
#include "support/formula.h"

#include "base/expression.h"

#include <Eigen/Dense>
#include <gsl/gsl_cdf.h>
#include <gtest/gtest.h>

using namespace explore;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double sigma = 0.05;

// Five readings of three parameters, the third of which hardly shows.
MatrixXd readings_of_three() {
    MatrixXd a(5, 3);
    a << 1.0, 0.3, 0.01, 0.4, 1.0, 0.02, 0.7, 0.6, -0.01, 0.2, -0.5, 0.015, 1.1, 0.1, 0.0;
    return a;
}

test::Formula linear(const MatrixXd& a) {
    return test::Formula([a](const VectorXd& x, VectorXd& responses, MatrixXd& jacobian) {
        responses = a * x;
        jacobian = a;
    });
}

problem::Problem linear_problem(const std::vector<double>& measured) {
    return test::problem_of(3, linear(readings_of_three()), measured, sigma).in_units_of_noise();
}

landscape::Minimum minimum_of(run::Engine& engine, const problem::Problem& problem) {
    const auto ends = engine.search({{0.5, 0.5, 0.5}}, *optimise::find_method("gauss-newton"),
                                    {.step_tolerance = 1e-9, .misfit_tolerance = 1e-14}, 0);
    return landscape::distinct_minima(*ends, problem)[0];
}

const std::vector<double> measured{0.55, 0.62, 0.68, -0.13, 0.49};

} // namespace

TEST(Priors, GiveTheMeanAndTheCovarianceOfLinearGaussianInference) {
    problem::Problem problem = linear_problem(measured);
    problem.space.axes[2].prior = {.mean = 0.3, .sd = 0.1};
    problem.space.axes[0].prior = {.mean = 0.5, .sd = 0.2};
    run::Engine engine(problem, nullptr, 0, {.threads = 1, .show_progress = false});
    const auto found = minimum_of(engine, problem);
    // Precision A'A / sigma^2 + P, mean from the normal equations.
    const MatrixXd a = readings_of_three();
    MatrixXd precision = a.transpose() * a / (sigma * sigma);
    precision(2, 2) += 1.0 / 0.01;
    precision(0, 0) += 1.0 / 0.04;
    VectorXd right = a.transpose() * VectorXd::Map(measured.data(), 5) / (sigma * sigma);
    right[2] += 0.3 / 0.01;
    right[0] += 0.5 / 0.04;
    const VectorXd mean = precision.llt().solve(right);
    const MatrixXd covariance = precision.inverse();
    const auto local = landscape::analyse(found, problem);
    for (Index k = 0; k < 3; ++k) {
        EXPECT_NEAR(found.unit[static_cast<std::size_t>(k)], mean[k], 1e-7);
        if (!local.widened) {
            EXPECT_NEAR(local.standard_error[static_cast<std::size_t>(k)], std::sqrt(covariance(k, k)), 1e-7);
        }
    }
    EXPECT_EQ(local.degrees_of_freedom, 5 + 2 - 3);
}

TEST(Priors, OnALogarithmicAxisAreNormalInTheLogarithm) {
    problem::Axis axis{"k1", 100.0, 10000.0, problem::Scale::log, 0, 1000.0, problem::Prior{.mean = 1000.0, .sd = 0.2}};
    EXPECT_NEAR(axis.pull(1000.0 * std::exp(0.3)), 1.5, 1e-12);
    const double step = 1e-6;
    EXPECT_NEAR(axis.d_pull(),
                (axis.pull(axis.physical(0.4 + step)) - axis.pull(axis.physical(0.4 - step))) / (2 * step), 1e-6);
}

TEST(Priors, ShareAndConflictHaveTheirClosedForm) {
    problem::Problem problem = linear_problem(measured);
    problem.space.axes[2].prior = {.mean = 0.3, .sd = 0.1};
    run::Engine engine(problem, nullptr, 0, {.threads = 1, .show_progress = false});
    auto found = minimum_of(engine, problem);
    ASSERT_TRUE(landscape::find_alone(engine, problem, found, 1000));
    const auto acceptance = landscape::acceptance_of(problem, found);
    ASSERT_TRUE(acceptance && !acceptance->widened);
    const auto influence = landscape::prior_influence(problem, *acceptance, found);
    ASSERT_TRUE(influence);
    const MatrixXd a = readings_of_three();
    const MatrixXd alone = a.transpose() * a / (sigma * sigma);
    MatrixXd both = alone;
    both(2, 2) += 1.0 / 0.01;
    for (Index k = 0; k < 3; ++k) { // Schur complements, the others known by their box too
        std::vector<Index> others;
        for (Index i = 0; i < 3; ++i) {
            if (i != k) {
                others.push_back(i);
            }
        }
        const auto information = [&](const MatrixXd& h) {
            const MatrixXd rest = h(others, others) + 12.0 * MatrixXd::Identity(2, 2);
            const VectorXd across = h(others, std::vector<Index>{k});
            return h(k, k) - across.dot(rest.inverse() * across);
        };
        const double share = 1.0 - information(alone) / information(both);
        EXPECT_NEAR(influence->share[static_cast<std::size_t>(k)], share, 1e-6) << k;
    }
    EXPECT_EQ(influence->only, std::vector<std::size_t>{2}); // 0.01 to 0.02 a box: next to nothing against 0.05
    EXPECT_EQ(influence->degrees_of_freedom, 0);             // no reading sees the third: nothing to contradict
}

TEST(Priors, ThatContradictTheReadingsAreFound) {
    // One parameter, read four times: estimate 0.6 +- sigma / 2, prior 0.2 +- 0.1.
    const MatrixXd a = MatrixXd::Ones(4, 1);
    problem::Problem problem = test::problem_of(1, linear(a), {0.58, 0.62, 0.61, 0.59}, sigma).in_units_of_noise();
    problem.space.axes[0].prior = {.mean = 0.2, .sd = 0.1};
    run::Engine engine(problem, nullptr, 0, {.threads = 1, .show_progress = false});
    const auto ends = engine.search({{0.5}}, *optimise::find_method("gauss-newton"), {.step_tolerance = 1e-9}, 0);
    auto found = landscape::distinct_minima(*ends, problem)[0];
    ASSERT_TRUE(landscape::find_alone(engine, problem, found, 1000));
    landscape::Acceptance acceptance{.noise_is_stated = true, .threshold = 3.84};
    const auto influence = landscape::prior_influence(problem, acceptance, found);
    const double statistic = 0.4 * 0.4 / (0.1 * 0.1 + sigma * sigma / 4.0);
    EXPECT_NEAR(influence->statistic, statistic, 0.005);
    EXPECT_NEAR(influence->p_value, gsl_cdf_chisq_Q(statistic, 1.0), 1e-3);
    EXPECT_NEAR(influence->readings_want[0], 0.6, 1e-3); // the search ends within 0.005 of chi2
    EXPECT_TRUE(influence->only.empty());
}

namespace {

// p0 + p1 <= bound, or == bound.
class Sum final : public problem::Limit {
public:
    Sum(double bound, bool equality) : bound_(bound), equality_(equality) {}
    std::string text() const override { return "p0 + p1 <= bound"; }
    bool is_equality() const override { return equality_; }
    double value(std::span<const double> p, std::span<const double>) const override {
        return (p[0] + p[1] - bound_) / tolerance;
    }
    Eigen::RowVectorXd gradient(std::span<const double>, std::span<const double>, const MatrixXd&) const override {
        return Eigen::RowVector2d(1.0, 1.0) / tolerance;
    }
    static constexpr double tolerance = 1e-4;

private:
    double bound_;
    bool equality_;
};

problem::Problem limited(const MatrixXd& a, const std::vector<double>& values, double bound, bool equality) {
    problem::Problem problem = test::problem_of(2, linear(a), values, sigma).in_units_of_noise();
    problem.limits.push_back(std::make_shared<Sum>(bound, equality));
    return problem;
}

} // namespace

TEST(Limits, EndEverySearchWhereThePlaneIsNearest) {
    MatrixXd a(3, 2);
    a << 1.0, 0.2, 0.3, 0.9, -0.4, 0.5;
    const std::vector<double> values{0.8, 0.9, 0.1}; // wanted without the limit: a sum of 1.35
    // The minimum on the plane, by a Lagrange multiplier: x - C 1 (1'x - bound) / (1' C 1), C = (A'A)^-1.
    const MatrixXd c = (a.transpose() * a).inverse();
    const VectorXd free = c * a.transpose() * VectorXd::Map(values.data(), 3);
    const Eigen::Vector2d ones(1.0, 1.0);
    ASSERT_GT(free.sum(), 1.1);
    for (const bool equality : {false, true}) {
        const double bound = equality ? 1.5 : 0.9;
        const VectorXd nearest = free - c * ones * (free.sum() - bound) / ones.dot(c * ones);
        const problem::Problem problem = limited(a, values, bound, equality);
        run::Engine engine(problem, nullptr, 0, {.threads = 1, .show_progress = false});
        // An equality is a penalty to SLSQP and COBYLA, which end near the plane but not at the lowest point of it.
        std::vector<std::string_view> methods{"gauss-newton"};
        if (!equality) {
            methods.insert(methods.end(), {"slsqp", "cobyla"});
        }
        for (const std::string_view method : methods) {
            for (const std::vector<double>& start : {std::vector<double>{0.1, 0.1}, {0.9, 0.95}}) {
                const auto ends = engine.search({start}, *optimise::find_method(method),
                                                {.max_evaluations = 300, .step_tolerance = 1e-9}, 0);
                const auto& end = ends->at(0);
                EXPECT_NEAR(end.search.unit[0], nearest[0], 2e-4) << method << " from " << start[0];
                EXPECT_NEAR(end.search.unit[1], nearest[1], 2e-4) << method << " from " << start[0];
                EXPECT_EQ(problem.active_limits(end.evaluation).size(), 1U);
                if (method == "gauss-newton") { // the limit is part of its steps
                    EXPECT_LE(end.search.evaluations, 8);
                }
            }
        }
    }
    // One that the readings do not press against changes nothing.
    const problem::Problem problem = limited(a, values, 1.9, false);
    run::Engine engine(problem, nullptr, 0, {.threads = 1, .show_progress = false});
    const auto ends = engine.search({{0.1, 0.1}}, *optimise::find_method("gauss-newton"), {.step_tolerance = 1e-9}, 0);
    EXPECT_NEAR(ends->at(0).search.unit[0], free[0], 1e-7);
    EXPECT_TRUE(problem.active_limits(ends->at(0).evaluation).empty());
}

TEST(Expression, ReadsNamesWithHyphensStopsAndBlanks) {
    const std::vector<std::string> known{"base.k1", "base.k10", "fine-grained base.k1", "load.force_kN"};
    const pave::Expression e("0.5 * base.k10 + fine-grained base.k1 - 1e-1 * min(base.k1, 2)", known);
    EXPECT_EQ(e.reads(), (std::vector<std::string>{"base.k10", "fine-grained base.k1", "base.k1"}));
    EXPECT_NEAR(e.value({10.0, 3.0, 7.0}), 0.5 * 10.0 + 3.0 - 0.1 * 2.0, 1e-12);
    EXPECT_NEAR(pave::Expression("2 ^ 3", {}).value({}), 8.0, 1e-12);
    for (const char* wrong : {"base.k2 * 2", "base.k1 +", "", "base.k1 = 3", "1, 2", "base.k1 base.k10", "foo(1)"}) {
        EXPECT_THROW(pave::Expression(wrong, known), std::invalid_argument) << wrong;
    }
}
