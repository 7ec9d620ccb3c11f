// A second method at minima: on a quadratic and on Rosenbrock's valley, whose minima are known.
#include "landscape/confirmation.h"
#include "support/formula.h"

#include <gtest/gtest.h>

using namespace explore;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using test::Formula;
using test::problem_of;

namespace {

problem::Problem rosenbrock() {
    // r = (10 (y - x^2), 1 - x), with its minimum at (1, 1), which is (0.75, 0.75) of the box from -2 to 2.
    return problem_of(2, Formula([](const VectorXd& u, VectorXd& r, MatrixXd& j) {
                          const VectorXd p = 4.0 * u.array() - 2.0;
                          r = VectorXd(2);
                          r << 10.0 * (p[1] - p[0] * p[0]), 1.0 - p[0];
                          j = MatrixXd(2, 2);
                          j << -80.0 * p[0], 40.0, -4.0, 0.0;
                      }),
                      std::vector<double>(2, 0.0), 1.0);
}

landscape::Minimum minimum_at(run::Engine& engine, const std::vector<double>& unit) {
    landscape::Minimum m;
    m.unit = unit;
    m.evaluation = engine.evaluate_one(unit);
    m.members = {0};
    m.lowest = m.highest = m.evaluation.parameters;
    return m;
}

} // namespace

TEST(Confirmation, AgreesAtAMinimumAndMovesWhatIsNone) {
    const auto problem = rosenbrock();
    run::Engine engine(problem, nullptr, 0, {.threads = 2, .show_progress = false});
    for (const std::string_view method : {"slsqp", "gauss-newton"}) {
        std::vector<landscape::Minimum> minima{minimum_at(engine, {0.75, 0.75}), minimum_at(engine, {0.6, 0.5})};
        const double before = minima[1].evaluation.misfit;
        ASSERT_TRUE(landscape::confirm(engine, problem, method, 1e-3, 1000, 0, minima));
        ASSERT_TRUE(minima[0].second && minima[1].second);
        EXPECT_TRUE(minima[0].second->agrees) << method;
        EXPECT_FALSE(minima[1].second->agrees) << method << ": a point on a slope";
        EXPECT_EQ(minima[1].second->misfit_before, before);
        EXPECT_LT(minima[1].evaluation.misfit, 0.5 * before);
        EXPECT_NE(landscape::confirmation_words(minima).find("do not agree"), std::string::npos);
    }
}

TEST(Confirmation, SlopesWithinNoiseAgree) {
    const auto problem = rosenbrock();
    run::Engine engine(problem, nullptr, 0, {.threads = 1, .show_progress = false});
    std::vector<landscape::Minimum> minima{minimum_at(engine, {0.755, 0.76})};
    const std::vector<double> unit = minima[0].unit;
    ASSERT_TRUE(landscape::confirm(engine, problem, "slsqp", 100.0, 1000, 0, minima));
    EXPECT_TRUE(minima[0].second->agrees);
    EXPECT_EQ(minima[0].unit, unit) << "what the noise does not tell apart stays";
}

TEST(Confirmation, KeepsToItsEvaluations) {
    const auto problem = rosenbrock();
    for (const int allowed : {0, 3, 4, 9, 40}) {
        run::Engine engine(problem, nullptr, 0, {.threads = 1, .show_progress = false});
        std::vector<landscape::Minimum> minima;
        for (const double x : {0.2, 0.3, 0.4, 0.5}) {
            minima.push_back(minimum_at(engine, {x, 0.9}));
        }
        ASSERT_TRUE(landscape::confirm(engine, problem, "slsqp", 1e-3, allowed, 0, minima));
        EXPECT_LE(engine.tally().computed, allowed);
        EXPECT_EQ(allowed >= 4, !landscape::confirmation_words(minima).empty()) << allowed;
    }
    EXPECT_EQ(landscape::confirming_evaluations(500), 100) << "a fifth";
}

TEST(Confirmation, IsNoneWhereTheSecondMethodHadNotEnded) {
    const auto problem = rosenbrock();
    run::Engine engine(problem, nullptr, 0, {.threads = 1, .show_progress = false});
    std::vector<landscape::Minimum> minima{minimum_at(engine, {0.75, 0.75})};
    ASSERT_TRUE(landscape::confirm(engine, problem, "slsqp", 1e-3, 1000, 0, minima));
    ASSERT_TRUE(minima[0].second->agrees);
    EXPECT_TRUE(minima[0].second->has_ended);
    EXPECT_NE(landscape::confirmation_words(minima).find("Two methods agree"), std::string::npos);
    minima[0].second->has_ended = false;
    minima[0].second->ended = "the limit of evaluations";
    const std::string words = landscape::confirmation_words(minima);
    EXPECT_EQ(words.find("agree"), std::string::npos) << words;
    EXPECT_NE(words.find("the limit of evaluations"), std::string::npos) << words;
}

// A stiff reading on top of the valley, and a point of the valley's floor that is not its lowest: the second method
// either gets lower or has not ended, but never takes a standstill for an end.
TEST(Confirmation, DoesNotTakeAStandstillInARavineForAnEnd) {
    for (const double stiff : {1e2, 1e4, 1e6}) {
        const auto problem = problem_of(2, Formula([stiff](const VectorXd& u, VectorXd& r, MatrixXd& j) {
                                            r = VectorXd(3);
                                            r << stiff * (u[1] - u[0] * u[0]), 3.0 * u[0], u[1];
                                            j = MatrixXd(3, 2);
                                            j << -2.0 * stiff * u[0], stiff, 3.0, 0.0, 0.0, 1.0;
                                        }),
                                        {0.0, 3.0 * 0.8, 0.3}, 0.02);
        run::Engine engine(problem, nullptr, 0, {.threads = 1, .show_progress = false});
        std::vector<landscape::Minimum> minima{minimum_at(engine, {0.4, 0.16})};
        ASSERT_TRUE(landscape::confirm(engine, problem, "slsqp", 0.02, 1000, 0, minima));
        EXPECT_FALSE(minima[0].second->agrees && minima[0].second->has_ended) << stiff;
    }
}
