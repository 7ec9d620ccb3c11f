// Outputs of a sample under loads that no reading has: a surface through few runs, or runs at the draws.
#include "analysis/sample/sample.h"
#include "base/random.h"
#include "study/problems.h"
#include "support/layered_study.h"

#include <cmath>
#include <gtest/gtest.h>

using namespace explore;

namespace {

const std::string outputs =
    "[[outputs]]\nname = \"strain\"\nload = \"wheel\"\nquantity = \"strain_zz\"\ndepth_mm = 520\n"
    "[[outputs]]\nname = \"bottom\"\nload = \"wheel\"\nquantity = \"strain_xx\"\n"
    "depth_mm = 149\n"
    "[[outputs]]\nname = \"own\"\nload = \"fwd\"\nquantity = \"deflection\"\nx_mm = 450\n";

analysis::SampleResult sampled(const study::Study& study) {
    analysis::Session session({.threads = 1, .show_progress = false});
    auto result = analysis::sample(session, study, {.any_model = true, .samples = 800, .confirm = 200});
    EXPECT_TRUE(result.has_value());
    return *result;
}

// Every output at a draw by a run of all loads.
std::vector<double> by_a_run(const study::Study& study, const std::vector<double>& unit) {
    const problem::Problem problem = study::make_prediction_problem(study);
    const auto there = problem.evaluate(unit, false, *problem.function->make_workspace());
    std::vector<double> values;
    for (const std::size_t row : study.outputs()) {
        values.push_back(there.responses[row]);
    }
    return values;
}

} // namespace

TEST(OutputsUnderOtherLoads, AreWhatRunsGiveToTheErrorThatIsStated) {
    const study::Study study = test::layered_study(test::layered_bowl(), outputs);
    const auto result = sampled(study);
    ASSERT_TRUE(result.surface);
    EXPECT_EQ(result.besides.size(), 2U);
    EXPECT_LE(result.surface->runs, 20U);
    ASSERT_EQ(result.outputs.size(), 3U);
    std::vector<double> squares(3, 0.0);
    int compared = 0;
    for (std::size_t i = 5; i < result.draws.size(); i += 17) {
        ASSERT_EQ(result.draws[i].outputs.size(), 3U);
        const auto exact = by_a_run(study, result.draws[i].unit);
        for (std::size_t o = 0; o < 3; ++o) {
            squares[o] += std::pow(result.draws[i].outputs[o] - exact[o], 2);
        }
        ++compared;
    }
    for (std::size_t o = 0; o < 3; ++o) {
        const double off = std::sqrt(squares[o] / compared);
        EXPECT_LE(off, 0.06 * result.outputs[o].sd) << o;
    }
    EXPECT_LE(std::sqrt(squares[2] / compared), 1e-12); // under the load of the readings nothing is interpolated
    for (std::size_t o = 0; o < 2; ++o) {               // six checks tell an error to about a factor
        EXPECT_LE(std::sqrt(squares[o] / compared), 3.0 * result.surface->error[o] + 1e-9);
    }
}

// The pressure of the other load has a sharp bend where the draws lie: no surface of second degree follows it.
TEST(OutputsUnderOtherLoads, AreRunsWhereNoSurfaceHolds) {
    const study::Study study =
        test::layered_study(test::layered_bowl(), outputs + "[[parameters]]\nname = \"wheel.pressure_kPa\"\n"
                                                            "equals = \"300 + 40 * abs(subgrade.modulus_MPa - 80)\"\n");
    const auto result = sampled(study);
    EXPECT_FALSE(result.surface);
    std::size_t with = 0;
    for (const auto& draw : result.draws) {
        if (!draw.outputs.empty()) {
            const auto exact = by_a_run(study, draw.unit);
            for (std::size_t o = 0; o < 3; ++o) {
                EXPECT_NEAR(draw.outputs[o], exact[o], 1e-9 * std::abs(exact[o]) + 1e-15);
            }
            ++with;
        }
    }
    EXPECT_EQ(with, 200U);
}

// Draws of equal shares of normal distributions.
namespace {

std::vector<double> draws_about(const std::vector<double>& centres, double deviation, std::size_t count) {
    const pave::RandomStream random(11, 3);
    std::vector<double> units;
    for (std::size_t i = 0; i < count; ++i) {
        units.push_back(centres[i % centres.size()] + deviation * random.normal(i));
    }
    return units;
}

std::size_t count_of_modes(const std::vector<double>& units) {
    return analysis::modes_of(units, std::vector<double>(units.size(), 1.0)).size();
}

} // namespace

TEST(SeparateValues, AreAsManyAsThereAreHoweverWideTheyLieApart) {
    std::vector<double> seven;
    for (int i = 0; i < 7; ++i) {
        seven.push_back((i + 0.5) / 7.0);
    }
    const auto units = draws_about(seven, 0.008, 1400);
    const auto modes = analysis::modes_of(units, std::vector<double>(units.size(), 1.0));
    ASSERT_EQ(modes.size(), 7U);
    for (std::size_t i = 0; i < 7; ++i) {
        EXPECT_NEAR(modes[i].centre, seven[i], 0.004);
        EXPECT_NEAR(modes[i].share, 1.0 / 7.0, 0.005);
    }
}

TEST(SeparateValues, AreOneWhereOneDistributionMakesThem) {
    for (const std::size_t count : {200U, 400U, 1000U, 4000U}) {
        EXPECT_EQ(count_of_modes(draws_about({0.4}, 0.07, count)), 1U) << count;
        EXPECT_EQ(count_of_modes(draws_about({0.4, 0.5}, 0.07, count)), 1U) << count; // 1.4 deviations: one top
        std::vector<double> even;
        const pave::RandomStream random(5, count);
        for (std::size_t i = 0; i < count; ++i) {
            even.push_back(random.uniform(i));
        }
        EXPECT_EQ(count_of_modes(even), 1U) << count;
    }
}
