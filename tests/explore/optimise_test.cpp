#include "optimise/local_search.h"

#include "optimise/quadratic.h"

#include <gtest/gtest.h>

using namespace explore::optimise;

namespace {

// Rosenbrock's valley as residuals, moved into the unit cube: minimum 0 at (0.6, 0.6).
Answer rosenbrock(std::span<const double> u, Sample& sample) {
    const double x = 5.0 * u[0] - 2.0;
    const double y = 5.0 * u[1] - 2.0;
    sample.residuals.resize(2);
    sample.residuals << 10.0 * (y - x * x), 1.0 - x;
    sample.jacobian.resize(2, 2);
    sample.jacobian << -100.0 * x, 50.0, -5.0, 0.0;
    return Answer::computed;
}

} // namespace

TEST(EveryMethod, FindsTheMinimumOfACurvedValley) {
    for (const Method& method : methods()) {
        SCOPED_TRACE(method.name);
        const auto result = local_search(method, {0.2, 0.6}, rosenbrock,
                                         {.max_evaluations = 3000, .step_tolerance = 1e-9, .misfit_tolerance = 1e-14});
        const double near = method.name == "cobyla" ? 0.03 : 1e-3; // linear models creep along a curved valley
        EXPECT_NEAR(result.unit[0], 0.6, near);
        EXPECT_NEAR(result.unit[1], 0.6, near);
        EXPECT_LT(result.misfit, 10.0 * near);
    }
}

TEST(EveryMethod, StopsAtABoundWhereTheMinimumLiesOutside) {
    for (const Method& method : methods()) {
        SCOPED_TRACE(method.name);
        const Objective outside = [](std::span<const double> u, Sample& sample) {
            sample.residuals.resize(2);
            sample.residuals << u[0] - 1.3, 2.0 * (u[1] - 0.4);
            sample.jacobian.resize(2, 2);
            sample.jacobian << 1.0, 0.0, 0.0, 2.0;
            return Answer::computed;
        };
        const auto result = local_search(method, {0.1, 0.9}, outside,
                                         {.max_evaluations = 500, .step_tolerance = 1e-8, .misfit_tolerance = 1e-12});
        EXPECT_NEAR(result.unit[0], 1.0, 1e-4);
        EXPECT_NEAR(result.unit[1], 0.4, 1e-3);
    }
}

TEST(EveryMethod, IsLedAwayFromPointsWithoutAnAnswerAndNeverCounts0fThemAsBest) {
    for (const Method& method : methods()) {
        SCOPED_TRACE(method.name);
        const Objective holes = [](std::span<const double> u, Sample& sample) {
            for (const double x : u) {
                EXPECT_TRUE(x >= 0.0 && x <= 1.0);
            }
            if (u[0] + u[1] > 1.3) {
                return Answer::no_answer;
            }
            sample.residuals.resize(2);
            sample.residuals << u[0] - 0.9, u[1] - 0.35; // just inside the border
            sample.jacobian = Eigen::Matrix2d::Identity();
            return Answer::computed;
        };
        const auto result = local_search(method, {0.1, 0.1}, holes,
                                         {.max_evaluations = 300, .step_tolerance = 1e-7, .misfit_tolerance = 1e-10});
        ASSERT_FALSE(result.unit.empty());
        EXPECT_LE(result.unit[0] + result.unit[1], 1.3);
        EXPECT_LT(result.misfit, 0.05);
    }
}

TEST(LocalSearch, EndsWhenTheObjectiveSaysStop) {
    int calls = 0;
    const Objective stopping = [&](std::span<const double> u, Sample& sample) {
        return ++calls > 3 ? Answer::stop : rosenbrock(u, sample);
    };
    const auto result = local_search(*find_method("slsqp"), {0.2, 0.6}, stopping, {});
    EXPECT_TRUE(result.stopped);
    EXPECT_LE(calls, 5);
}

TEST(LocalSearch, HasAnEmptyPointWhenNothingHasAnAnswer) {
    const Objective nothing = [](std::span<const double>, Sample&) { return Answer::no_answer; };
    for (const Method& method : methods()) {
        EXPECT_TRUE(local_search(method, {0.5, 0.5}, nothing, {.max_evaluations = 40}).unit.empty());
    }
}

// y = a exp(-k t), read without error: the minimum is known.
TEST(GaussNewton, SavesDerivativesNearTheMinimum) {
    constexpr double truth[] = {0.7, 0.4};
    int with_derivatives = 0;
    int points = 0;
    const Objective decay = [&](std::span<const double> u, Sample& sample) {
        ++points;
        const bool asked = sample.wants_derivatives;
        with_derivatives += asked ? 1 : 0;
        sample.residuals.resize(6);
        sample.jacobian.resize(asked ? 6 : 0, asked ? 2 : 0);
        for (int i = 0; i < 6; ++i) {
            const double t = 0.5 * i;
            const double fall = std::exp(-3.0 * u[1] * t);
            sample.residuals[i] = 100.0 * (u[0] * fall - truth[0] * std::exp(-3.0 * truth[1] * t));
            if (asked) {
                sample.jacobian.row(i) << 100.0 * fall, -300.0 * t * u[0] * fall;
            }
        }
        return Answer::computed;
    };
    const Method& method = *find_method("gauss-newton");
    const std::vector<double> start = {0.6, 0.5};
    const auto exact = local_search(method, start, decay, {.enough = 1e-6});
    EXPECT_EQ(with_derivatives, points);
    with_derivatives = points = 0;
    const auto saving = local_search(method, start, decay, {.enough = 1e-6, .secant_below = INFINITY});
    EXPECT_EQ(with_derivatives, 1);
    EXPECT_LE(points, exact.evaluations + 2);
    for (int k = 0; k < 2; ++k) {
        EXPECT_NEAR(saving.unit[static_cast<std::size_t>(k)], truth[k], 1e-4);
    }
}

// Where the corrected derivatives mislead it asks for true ones.
TEST(GaussNewton, GetsThroughACurvedValleyWithCorrectedDerivatives) {
    const auto result = local_search(*find_method("gauss-newton"), {0.2, 0.6},
                                     [](std::span<const double> u, Sample& sample) {
                                         const bool asked = sample.wants_derivatives;
                                         const Answer answer = rosenbrock(u, sample);
                                         if (!asked) {
                                             sample.jacobian.resize(0, 0);
                                         }
                                         return answer;
                                     },
                                     {.max_evaluations = 300, .secant_below = INFINITY});
    EXPECT_NEAR(result.unit[0], 0.6, 1e-3);
    EXPECT_NEAR(result.unit[1], 0.6, 1e-3);
}

// y = a exp(-k t) against data that no decay follows: the least sum of squares is known from linear least squares in a,
// k by k.
TEST(GaussNewton, GivesUpASearchThatLeadsToNothingWorthHaving) {
    constexpr double data[] = {0.6, 0.6, 0.6, 0.0, 0.0, 0.6};
    const Objective decay = [&](std::span<const double> u, Sample& sample) {
        sample.residuals.resize(6);
        sample.jacobian.resize(6, 2);
        for (int i = 0; i < 6; ++i) {
            const double fall = std::exp(-u[1] * i);
            sample.residuals[i] = u[0] * fall - data[i];
            sample.jacobian.row(i) << fall, -u[0] * i * fall;
        }
        return Answer::computed;
    };
    double least = INFINITY; // half of the sum of squares
    for (double k = 0.0; k <= 1.0; k += 1e-3) {
        double product = 0.0, square = 0.0;
        for (int i = 0; i < 6; ++i) {
            product += std::exp(-k * i) * data[i];
            square += std::exp(-2.0 * k * i);
        }
        least = std::min(least, 0.5 * (4.0 * 0.36 - product * product / square));
    }
    const Method& method = *find_method("gauss-newton");
    const std::vector<double> start = {0.3, 0.6};
    const SearchResult all = local_search(method, start, decay, {});
    EXPECT_TRUE(all.converged);
    EXPECT_NEAR(0.5 * all.misfit * all.misfit, least, 1e-4 * least);
    const SearchResult lower = local_search(method, start, decay, {.worth = 0.5 * least});
    EXPECT_FALSE(lower.converged);
    EXPECT_LT(lower.evaluations, all.evaluations);
    const SearchResult higher = local_search(method, start, decay, {.worth = 1.01 * least});
    EXPECT_TRUE(higher.converged);
    EXPECT_EQ(higher.unit, all.unit);
}

namespace {

// One reading `weight` times as exact as two others: u1 = u0^2 by the first, u0 = 0.8 and u1 = 0.3 by the others.
Answer bent_valley(double weight, std::span<const double> u, Sample& sample) {
    sample.residuals.resize(3);
    sample.residuals << weight * (u[1] - u[0] * u[0]), 3.0 * (u[0] - 0.8), u[1] - 0.3;
    sample.jacobian.resize(3, 2);
    sample.jacobian << -2.0 * weight * u[0], weight, 3.0, 0.0, 0.0, 1.0;
    return Answer::computed;
}

// Its lowest sum of squares: u1 follows u0 by a linear equation, and u0 by a golden section.
double lowest_of_bent_valley(double weight) {
    const auto sum = [&](double x) {
        const double share = 1.0 / (1.0 + 1.0 / (weight * weight));
        return 9.0 * (x - 0.8) * (x - 0.8) + share * (x * x - 0.3) * (x * x - 0.3);
    };
    double low = 0.5, high = 1.0;
    const double golden = 0.5 * (std::sqrt(5.0) - 1.0);
    for (int i = 0; i < 60; ++i) {
        const double a = high - golden * (high - low);
        const double b = low + golden * (high - low);
        (sum(a) < sum(b) ? high : low) = sum(a) < sum(b) ? b : a;
    }
    return sum(0.5 * (low + high));
}

} // namespace

TEST(GaussNewton, FollowsTheValleyOfAReadingFarMoreExactThanTheOthers) {
    for (const double weight : {1.0, 1e2, 1e4, 1e6, 1e8}) {
        for (const std::vector<double>& start :
             {std::vector<double>{0.1, 0.9}, {0.9, 0.1}, {0.5, 0.5}, {0.05, 0.02}, {1.0, 1.0}}) {
            const auto found = local_search(
                *find_method("gauss-newton"), start,
                [&](std::span<const double> u, Sample& sample) { return bent_valley(weight, u, sample); }, {});
            EXPECT_TRUE(found.converged) << weight << ": " << found.ended;
            const double lowest = lowest_of_bent_valley(weight);
            EXPECT_NEAR(found.misfit * found.misfit, lowest, 1e-4 * lowest) << weight << " from " << start[0];
        }
    }
}

TEST(GaussNewton, HasNotConvergedWhereNoStepGivesWhatItsDerivativesPromise) {
    const auto found = local_search(*find_method("gauss-newton"), {0.3, 0.3},
                                    [](std::span<const double>, Sample& sample) {
                                        sample.residuals = Eigen::Vector2d(1.0, 1.0); // whatever the point
                                        sample.jacobian = Eigen::Matrix2d::Identity();
                                        return Answer::computed;
                                    },
                                    {});
    EXPECT_FALSE(found.converged) << found.ended;
}

// Rows of very unequal size: 1e9 (x + y - 0.7) = 0 and x - y = 0.1, so x = 0.4, y = 0.3; normal equations lose the
// second row.
TEST(Quadratic, KeepsSmallRowsBesideLargeOnes) {
    Eigen::MatrixXd rows(2, 2);
    rows << 1.0, -1.0, 1e9, 1e9;
    const Quadratic q = Quadratic::of(rows, Eigen::Vector2d(-0.1, -0.7e9), 1e-18);
    const Eigen::VectorXd wide = Eigen::Vector2d(10.0, 10.0);
    const Eigen::VectorXd free = q.lowest(-wide, wide);
    EXPECT_NEAR(free[0], 0.4, 1e-6);
    EXPECT_NEAR(free[1], 0.3, 1e-6);
    // With x held at 0.2 the large row decides.
    const Eigen::VectorXd held = q.lowest(-wide, Eigen::Vector2d(0.2, 10.0));
    EXPECT_EQ(held[0], 0.2);
    EXPECT_NEAR(held[1], 0.5, 1e-6);
}

// d.(A + C) d / 2 + g.d is lowest at -(A + C)^-1 g.
TEST(Quadratic, AddsCurvatureThatIsNotItsOwn) {
    Eigen::MatrixXd rows(3, 2);
    rows << 1.0, 0.5, -0.3, 1.2, 0.8, 0.1;
    const Eigen::Vector3d residuals(0.4, -0.2, 0.3);
    Eigen::MatrixXd more(2, 2);
    more << 0.3, -0.1, -0.1, 0.2;
    const Eigen::VectorXd wide = Eigen::Vector2d(10.0, 10.0);
    const Eigen::VectorXd found = Quadratic::of(rows, residuals, 1e-18).curved(more).lowest(-wide, wide);
    const Eigen::VectorXd wanted = -(rows.transpose() * rows + more).inverse() * (rows.transpose() * residuals);
    EXPECT_NEAR((found - wanted).norm(), 0.0, 1e-10);
}
