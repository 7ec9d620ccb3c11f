#include "data/csv.h"
#include "problem/misfit.h"
#include "problem/parameter_space.h"
#include "search/design.h"

#include "base/error.h"

#include <cmath>
#include <gtest/gtest.h>
#include <set>

using namespace explore;

TEST(ParameterSpace, MapsTheUnitCubeOntoTheBoxAndBack) {
    const problem::ParameterSpace space{
        {{"k1", 500, 8000, problem::Scale::log, 5, 2000}, {"k3", -1.5, 0, problem::Scale::linear, 3, -1}}};
    const std::vector<double> middle{0.5, 0.5};
    EXPECT_NEAR(space.physical(middle)[0], 2000.0, 1e-9); // the geometric mean
    EXPECT_NEAR(space.physical(middle)[1], -0.75, 1e-12);
    EXPECT_EQ(space.physical(std::vector<double>{0.0, 1.0}), (std::vector<double>{500.0, 0.0}));
    const auto back = space.unit(space.physical(std::vector<double>{0.3, 0.8}));
    EXPECT_NEAR(back[0], 0.3, 1e-12);
    EXPECT_NEAR(back[1], 0.8, 1e-12);
    for (const auto& axis : space.axes) {
        EXPECT_NEAR(axis.d_physical(0.4), (axis.physical(0.4 + 1e-6) - axis.physical(0.4 - 1e-6)) / 2e-6, 1e-4);
    }
}

TEST(Misfit, IsTheLogarithmFarAboveTheFloorAndFiniteAndMonotoneThroughZero) {
    const problem::Misfit misfit(problem::MisfitKind::log, {{0, 1.0, 1e-4}});
    const auto at = [&](double v) { return misfit.residuals(std::vector<double>{v})[0]; };
    EXPECT_NEAR(at(2.0), std::log(2.0), 1e-7);
    EXPECT_NEAR(at(0.5), std::log(0.5), 1e-7);
    EXPECT_EQ(at(1.0), 0.0);
    double last = at(-3.0);
    for (double v = -2.99; v < 3.0; v += 0.01) {
        EXPECT_GT(at(v), last);
        last = at(v);
    }
}

TEST(Misfit, HasTheSlopesOfItsResiduals) {
    for (const auto kind : {problem::MisfitKind::log, problem::MisfitKind::relative, problem::MisfitKind::weighted}) {
        const problem::Misfit misfit(kind, {{0, 1.0, 0.01}, {1, -0.2, 0.02}, {2, 0.003, 0.03, 1.7}});
        const std::vector<double> v{0.7, 0.01, -0.004};
        for (std::size_t i = 0; i < v.size(); ++i) {
            auto low = v;
            auto high = v;
            low[i] -= 1e-7;
            high[i] += 1e-7;
            const auto k = static_cast<Eigen::Index>(i);
            EXPECT_NEAR(misfit.slopes(v)[k], (misfit.residuals(high)[k] - misfit.residuals(low)[k]) / 2e-7, 1e-4);
        }
    }
}

TEST(FullGrid, HoldsEveryCombinationOnceAndBothEnds) {
    const problem::ParameterSpace space{{{"a", 0, 1, problem::Scale::linear, 3, 0.5},
                                         {"b", 1, 100, problem::Scale::log, 4, 10},
                                         {"c", 0, 2, problem::Scale::linear, 1, 0.5}}};
    EXPECT_EQ(search::full_grid_size(space), 12);
    const auto grid = search::full_grid(space);
    EXPECT_EQ(std::set<std::vector<double>>(grid.points.begin(), grid.points.end()).size(), 12U);
    EXPECT_EQ(grid.points.front(), (std::vector<double>{0.0, 0.0, 0.25})); // c is held at its own value
    EXPECT_EQ(grid.points.back(), (std::vector<double>{1.0, 1.0, 0.25}));
}

TEST(Sobol, FillsTheCubeEvenlyAndDependsOnTheSeedAlone) {
    problem::ParameterSpace space;
    space.axes.resize(4);
    const auto design = search::sobol(space, 512, 3);
    EXPECT_EQ(design.points, search::sobol(space, 512, 3).points);
    EXPECT_NE(design.points, search::sobol(space, 512, 4).points);
    // More points: the same beginning.
    EXPECT_EQ(design.points[100], search::sobol(space, 128, 3).points[100]);
    // In two dimensions each of 64 equal squares holds close to 8 of 512 points (a random sample: 8 +- 3).
    for (int a = 0; a < 4; ++a) {
        for (int b = 0; b < a; ++b) {
            std::vector<int> count(64, 0);
            for (const auto& p : design.points) {
                ++count[static_cast<int>(p[a] * 8) * 8 + static_cast<int>(p[b] * 8)];
            }
            EXPECT_GE(*std::min_element(count.begin(), count.end()), 3);
            EXPECT_LE(*std::max_element(count.begin(), count.end()), 14);
        }
    }
}

TEST(Csv, FollowsRfc4180) {
    const auto rows =
        data::parse_csv("\xef\xbb\xbf# a comment\r\na,\"b \"\"quoted\"\", and\ntwo lines\",\r\n\n1,2,3", "x.csv");
    ASSERT_EQ(rows.size(), 2U);
    EXPECT_EQ(rows[0].cells, (std::vector<std::string>{"a", "b \"quoted\", and\ntwo lines", ""}));
    EXPECT_EQ(rows[0].line, 2);
    EXPECT_EQ(rows[1].cells, (std::vector<std::string>{"1", "2", "3"}));
    EXPECT_EQ(rows[1].line, 5);
    EXPECT_THROW(data::parse_csv("a,\"never closed", "x.csv"), pave::Error);
    for (const std::string cell : {"plain", "with, comma", "with \"quotes\"", "two\nlines"}) {
        EXPECT_EQ(data::parse_csv(data::csv_cell(cell) + ",end\n", "x.csv")[0].cells[0], cell);
    }
}

TEST(Misfit, ComparesTheResponsesItNamesAndWeighsThem) {
    const problem::Misfit misfit(problem::MisfitKind::relative, {{3, 2.0, 2.0}, {1, 4.0, 4.0, 0.5}});
    const std::vector<double> responses{std::nan(""), 5.0, std::nan(""), 3.0};
    const auto r = misfit.residuals(responses);
    EXPECT_DOUBLE_EQ(r[0], 0.5);
    EXPECT_DOUBLE_EQ(r[1], 0.125);
    const auto d = misfit.slopes(responses);
    EXPECT_DOUBLE_EQ(d[0], 0.5);
    EXPECT_DOUBLE_EQ(d[1], 0.125);
}
