// Ends of walks: where chi2 has risen by the threshold and no further, and what is met there and nowhere else.
#include "landscape/uniqueness.h"
#include "support/formula.h"

#include <cmath>
#include <gtest/gtest.h>

using namespace explore;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using landscape::BoundMet;
using landscape::WalkEnd;
using test::Formula;
using test::problem_of;

namespace {

constexpr double threshold = 3.841459; // 95 % of chi2 with one degree of freedom

landscape::Uniqueness analyse(const problem::Problem& problem, std::vector<std::size_t> outputs = {}) {
    run::Engine engine(problem, nullptr, 0, {.threads = 0, .show_progress = false});
    auto result = landscape::uniqueness({.fitted = problem,
                                         .everything = problem,
                                         .fitted_engine = engine,
                                         .everything_engine = engine,
                                         .outputs = std::move(outputs),
                                         .groups = {},
                                         .seed = 1},
                                        {.explore = 32, .verify = 4});
    EXPECT_TRUE(result.has_value());
    return *result;
}

// The residual of p0 grows from shallow to steep, that of p1 + p0 falls away: p1 gives way, up to its bound.
// Rise of chi2 with p0 held: (steep(p0)/s)^2 while p1 = 0.8 - 2 (p0 - 0.3) lies in the box, and from p0 = 0.7 on, where
// p1 would be negative, ((p1 - its own) / s)^2 more.
double steep(double p0) {
    const double off = p0 - 0.3;
    return off + 40.0 * off * off * off;
}
constexpr double sigma = 1.0;

problem::Problem curved() {
    const auto model = [](const VectorXd& x, VectorXd& r, MatrixXd& j) {
        r.resize(3);
        j = MatrixXd::Zero(3, 2);
        const double off = x[0] - 0.3;
        r << steep(x[0]), 20.0 * (x[1] + 2.0 * x[0]), 0.0;
        j(0, 0) = 1.0 + 120.0 * off * off;
        j(1, 0) = 40.0;
        j(1, 1) = 20.0;
    };
    return problem_of(2, Formula(model), {0.0, 20.0 * 1.4, 0.0}, sigma);
}

double rise_of_curved(double p0) {
    const double p1 = std::max(0.0, 1.4 - 2.0 * p0);
    return std::pow(steep(p0) / sigma, 2) + std::pow(20.0 * (p1 + 2.0 * p0 - 1.4) / sigma, 2);
}

// Where the rise is the threshold, by halving.
double end_between(double low, double high) {
    for (int i = 0; i < 100; ++i) {
        const double middle = 0.5 * (low + high);
        (rise_of_curved(middle) < threshold ? low : high) = middle;
    }
    return low;
}

} // namespace

TEST(EndOfAProfile, IsComputedAndNamesNoBoundThatIsMetBeyondIt) {
    const auto u = analyse(curved());
    const auto& p0 = u.parameters[0];
    const double expected = end_between(0.3, 1.0);
    ASSERT_LT(expected, 0.7); // p1 is still inside there
    EXPECT_EQ(p0.high_end, WalkEnd::threshold);
    EXPECT_NEAR(rise_of_curved(p0.high), threshold, 0.004);
    EXPECT_NEAR(p0.high, expected, 2e-4);
    EXPECT_TRUE(p0.high_bounds.empty());
    ASSERT_EQ(p0.high_set.size(), 2U);
    EXPECT_NEAR(p0.high_set[1], 1.4 - 2.0 * expected, 5e-3);
}

// The last step asks for more than the box has, and another reading is so precise that what pulls at the quantity there
// is many times as steep as the profile.
TEST(EndOfAProfile, CloseToABoundIsStillWhereTheRiseIsTheThreshold) {
    for (const double end : {0.9, 0.95, 0.97, 0.98, 0.99}) {
        for (const double precise : {3.0, 10.0, 30.0, 100.0, 300.0, 1000.0}) {
            const double slope = std::sqrt(threshold) / (end - 0.3);
            const auto model = [&](const VectorXd& x, VectorXd& r, MatrixXd& j) {
                r.resize(3);
                j = MatrixXd::Zero(3, 2);
                r << slope * (x[0] - 0.3), precise * (x[1] - 0.5 * x[0]), 0.0;
                j(0, 0) = slope;
                j(1, 0) = -0.5 * precise;
                j(1, 1) = precise;
            };
            const auto u = analyse(problem_of(2, Formula(model), {0.0, 0.0, 0.0}, sigma));
            EXPECT_NEAR(u.parameters[0].high, end, 2e-4) << precise;
            EXPECT_EQ(u.parameters[0].high_end, WalkEnd::threshold) << precise;
        }
    }
}

TEST(EndOfAProfile, OfAnOutputIsComputedToo) {
    // exp(3 p0) as an output of the same landscape: its end is that of p0.
    const auto model = [](const VectorXd& x, VectorXd& r, MatrixXd& j) {
        VectorXd r3;
        MatrixXd j3;
        const double off = x[0] - 0.3;
        r.resize(4);
        j = MatrixXd::Zero(4, 2);
        r << steep(x[0]), 20.0 * (x[1] + 2.0 * x[0]), 0.0, std::exp(3.0 * x[0]);
        j(0, 0) = 1.0 + 120.0 * off * off;
        j(1, 0) = 40.0;
        j(1, 1) = 20.0;
        j(3, 0) = 3.0 * r[3];
    };
    const auto u = analyse(problem_of(2, Formula(model), {0.0, 20.0 * 1.4, 0.0}, sigma), {3});
    ASSERT_EQ(u.outputs.size(), 1U);
    EXPECT_NEAR(rise_of_curved(std::log(u.outputs[0].high) / 3.0), threshold, 0.004);
    EXPECT_TRUE(u.outputs[0].high_bounds.empty());
}

TEST(EndOfAProfile, BeforeAJumpOfTheMisfitIsTheLastPointThatIsAccepted) {
    // chi2 rises by 100 at once where p0 passes 0.8.
    const auto model = [](const VectorXd& x, VectorXd& r, MatrixXd& j) {
        r.resize(3);
        j = MatrixXd::Zero(3, 2);
        r << x[0] - 0.5, x[1] - 0.5, x[0] > 0.8 ? 10.0 : 0.0;
        j(0, 0) = j(1, 1) = 1.0;
    };
    const auto u = analyse(problem_of(2, Formula(model), {0.0, 0.0, 0.0}, 0.3));
    EXPECT_LE(u.parameters[0].high, 0.8);
    EXPECT_GT(u.parameters[0].high, 0.79);
}

TEST(EndOfAProfile, BesideAHoleIsTheLastPointThatHasAnAnswer) {
    class Holed final : public problem::ForwardFunction {
    public:
        std::unique_ptr<Workspace> make_workspace() const override { return std::make_unique<Workspace>(); }
        pave::Outcome<problem::Prediction> evaluate(std::span<const double> x, bool, Workspace&) const override {
            if (x[0] > 0.7) {
                return pave::Failure{pave::Status::failed, "a hole"};
            }
            return problem::Prediction{{x[0], x[1]}, MatrixXd::Identity(2, 2), {}};
        }
    };
    auto problem = problem_of(2, Formula({}), {0.5, 0.5}, 0.3);
    problem.function = std::make_shared<Holed>();
    const auto u = analyse(problem);
    EXPECT_EQ(u.parameters[0].high_end, WalkEnd::hole);
    EXPECT_LE(u.parameters[0].high, 0.7);
    EXPECT_GT(u.parameters[0].high, 0.6);
}

// The best point lies on the bounds p1 = 0 and p2 = 0. Where p0 grows p1 leaves its bound and follows, p2 stays: the
// valley reaches to p0 = 1 on one side. On the other p1 cannot follow, and p0 falls to 0: a rise of less than 0.2
// either way.
TEST(ValleyThatIsWalked, GoesOnWhereABoundIsLeftOrMet) {
    const auto model = [](const VectorXd& x, VectorXd& r, MatrixXd& j) {
        r.resize(3);
        j = MatrixXd::Zero(3, 3);
        r << x[1] - (x[0] - 0.4), 0.5 * (x[0] - 0.2), 0.5 * (x[2] + 0.5);
        j(0, 0) = -1.0;
        j(0, 1) = 1.0;
        j(1, 0) = 0.5;
        j(2, 2) = 0.5;
    };
    const auto u = analyse(problem_of(3, Formula(model), {0.0, 0.0, 0.0}, 1.0));
    EXPECT_EQ(u.minima[0].on_bound, (std::vector<BoundMet>{{1, false}, {2, false}}));
    ASSERT_EQ(u.traces.size(), 2U);
    double lowest = 1.0;
    double highest = 0.0;
    for (const auto& trace : u.traces) {
        ASSERT_EQ(trace.limit_unit.size(), 3U);
        lowest = std::min(lowest, trace.limit_unit[0]);
        highest = std::max(highest, trace.limit_unit[0]);
    }
    EXPECT_LT(lowest, 1e-6);
    EXPECT_GT(highest, 1.0 - 1e-6);
}

TEST(ValleyThatIsWalked, EndsWhereChi2HasRisenByTheThreshold) {
    // p0 is seen by (p0 - 0.6) / 0.3, p1 follows it.
    const auto model = [](const VectorXd& x, VectorXd& r, MatrixXd& j) {
        r.resize(3);
        j = MatrixXd::Zero(3, 2);
        r << (x[0] - 0.6) / 0.3, 50.0 * (x[1] - x[0]), 0.0;
        j(0, 0) = 1.0 / 0.3;
        j(1, 0) = -50.0;
        j(1, 1) = 50.0;
    };
    auto problem = problem_of(2, Formula(model), {0.0, 0.0, 0.0}, 1.0);
    problem.space.axes[0].high = problem.space.axes[1].high = 1.2;
    const auto u = analyse(problem);
    ASSERT_EQ(u.traces.size(), 2U);
    for (const auto& trace : u.traces) {
        const double p0 = problem.space.physical(trace.limit_unit)[0];
        EXPECT_EQ(trace.end, WalkEnd::threshold);
        EXPECT_NEAR(std::pow((p0 - 0.6) / 0.3, 2), threshold, 0.01);
    }
}
