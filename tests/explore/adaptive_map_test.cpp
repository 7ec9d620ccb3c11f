// Adaptive maps of landscapes that are known from formulas.
#include "landscape/adaptive_map.h"
#include "search/neighbours.h"
#include "support/formula.h"

#include <algorithm>
#include <gtest/gtest.h>
#include <numeric>

using namespace explore;

namespace {

// A curved valley of four parameters: readings 20 (x0 - (x1 - 1/2)^2 - 0.4), x2 - 0.6, x3 - 0.3 and a slope.
problem::Problem valley(double failing = 0.0) {
    const auto model = [](const Eigen::VectorXd& x, Eigen::VectorXd& r, Eigen::MatrixXd& j) {
        r.resize(4);
        r << 20.0 * (x[0] - (x[1] - 0.5) * (x[1] - 0.5) - 0.4), 3.0 * (x[2] - 0.6), 3.0 * (x[3] - 0.3),
            0.3 * (x[1] - 0.2);
        j = Eigen::MatrixXd::Zero(4, 4);
        j(0, 0) = 20.0;
        j(0, 1) = -40.0 * (x[1] - 0.5);
        j(1, 2) = j(2, 3) = 3.0;
        j(3, 1) = 0.3;
    };
    return test::problem_of(4, test::Formula(model, failing), {0.0, 0.0, 0.0, 0.5}, 1.0);
}

landscape::AdaptiveMap map_of(const problem::Problem& problem, int points, std::uint64_t seed, int threads = 0) {
    run::Engine engine(problem, nullptr, 0, {.threads = threads, .show_progress = false});
    auto map = landscape::adaptive_map(engine, problem, points, seed, threads);
    EXPECT_TRUE(map.has_value());
    return *map;
}

std::size_t below(const std::vector<problem::Evaluation>& evaluations, double misfit) {
    return static_cast<std::size_t>(
        std::count_if(evaluations.begin(), evaluations.end(), [&](const auto& e) { return e.misfit < misfit; }));
}

} // namespace

TEST(Neighbours, AreThoseOfACompleteSearch) {
    const auto points = map_of(valley(), 400, 1).design.points;
    const search::Neighbours tree(points);
    for (std::size_t i = 0; i < points.size(); i += 7) {
        std::vector<std::pair<double, std::size_t>> all;
        for (std::size_t j = 0; j < points.size(); ++j) {
            double sum = 0.0;
            for (std::size_t k = 0; k < 4; ++k) {
                sum += (points[i][k] - points[j][k]) * (points[i][k] - points[j][k]);
            }
            all.emplace_back(std::sqrt(sum), j);
        }
        std::sort(all.begin(), all.end());
        const auto near = tree.nearest(points[i], 9);
        ASSERT_EQ(near.size(), 9U);
        for (std::size_t k = 0; k < near.size(); ++k) {
            EXPECT_EQ(near[k].point, all[k].second);
            EXPECT_NEAR(near[k].distance, all[k].first, 1e-12);
        }
    }
    EXPECT_EQ(tree.nearest(points[0], 1000).size(), points.size());
}

TEST(AdaptiveMap, HasMorePointsInTheValleyThanASampleThatFillsTheBox) {
    const problem::Problem problem = valley();
    constexpr int points = 2000;
    run::Engine engine(problem, nullptr, 0, {.threads = 0, .show_progress = false});
    const auto even = *engine.evaluate(search::sobol(problem.space, points, 1));
    const auto map = map_of(problem, points, 1);
    ASSERT_EQ(map.evaluations.size(), static_cast<std::size_t>(points));
    ASSERT_EQ(map.design.points.size(), static_cast<std::size_t>(points));
    std::printf("  below 0.6: %zu of the adaptive map, %zu of the sample\n", below(map.evaluations, 0.6),
                below(even, 0.6));
    EXPECT_GT(below(map.evaluations, 0.6), 3 * below(even, 0.6));
    for (const auto& unit : map.design.points) {
        for (const double u : unit) {
            EXPECT_GE(u, 0.0);
            EXPECT_LE(u, 1.0);
        }
    }
}

// The share that the map gives is checked by many more draws than it had.
TEST(AdaptiveMap, SaysHowMuchOfTheBoxItKnows) {
    int within = 0;
    constexpr int trials = 20;
    for (std::uint64_t seed = 1; seed <= trials; ++seed) {
        const problem::Problem problem = valley(seed % 2 == 0 ? 0.0 : 0.1);
        const auto map = map_of(problem, 600, seed);
        const auto& e = map.explored;
        EXPECT_EQ(e.checks, 60U);
        EXPECT_LT(e.low, static_cast<double>(e.predicted) / 60.0 + 1e-12);
        EXPECT_GT(e.high, static_cast<double>(e.predicted) / 60.0 - 1e-12);
        auto points = map.design.points;
        auto evaluations = map.evaluations;
        points.resize(540); // without the checks
        evaluations.resize(540);
        search::Design more{"", {}};
        const pave::RandomStream random(seed, 77);
        for (std::uint64_t k = 0; k < 5000; ++k) {
            more.points.push_back({random.uniform(4 * k), random.uniform(4 * k + 1), random.uniform(4 * k + 2),
                                   random.uniform(4 * k + 3)});
        }
        run::Engine engine(problem, nullptr, 0, {.threads = 0, .show_progress = false});
        const auto truth = *engine.evaluate(more);
        const auto predicted = landscape::predict(more.points, points, evaluations, 0);
        double share = 0.0;
        for (std::size_t i = 0; i < truth.size(); ++i) {
            share += landscape::is_predicted(predicted[i], truth[i]) ? 1.0 / static_cast<double>(truth.size()) : 0.0;
        }
        within += share >= e.low && share <= e.high ? 1 : 0;
    }
    EXPECT_GE(within, 17); // 19 of 20 on average
}

TEST(AdaptiveMap, IsTheSameForAnyNumberOfThreads) {
    const problem::Problem problem = valley(0.2);
    const auto one = map_of(problem, 500, 3, 1);
    const auto two = map_of(problem, 500, 3, 2);
    EXPECT_EQ(one.design.points, two.design.points);
    EXPECT_EQ(one.explored.predicted, two.explored.predicted);
}
