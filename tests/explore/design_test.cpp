// Lives and overlays of linear layers on a half-space, whose runs take no time.
#include "analysis/design.h"
#include "analysis/design_overlay.h"
#include "base/random.h"
#include "study/values.h"
#include "support/layered_study.h"

#include <cmath>
#include <gtest/gtest.h>

using namespace explore;

namespace {

const std::string criteria =
    "[[criteria]]\nname = \"rutting\"\nlaw = \"austroads-subgrade\"\naxle = \"wheel\"\ntraffic_per_year = 1e5\n"
    "passed = 1e6\ngrowth = 0.03\n"
    "[[criteria]]\nname = \"cracking\"\nlaw = \"asphalt-institute-fatigue\"\naxle = \"wheel\"\n"
    "traffic_per_year = 1e5\npassed = 1e6\ngrowth = 0.03\n";

analysis::DesignResult designed(const study::Study& study, double years = 20.0) {
    analysis::Session session({.threads = 1, .show_progress = false});
    auto result = analysis::design(session, study, {.years = years, .settings = {.explore = 32, .verify = 6}});
    EXPECT_TRUE(result.has_value() && !result->failed());
    return *result;
}

// The lives at moduli that are stated, top to bottom [MPa].
std::vector<double> lives_at(const study::Study& study, const std::vector<double>& moduli, double added_mm) {
    const auto list = study::criteria_of(study);
    const analysis::CriticalPlaces places = analysis::critical_places(study, list);
    std::vector<analysis::Life> lives;
    for (std::size_t i = 0; i < list.size(); ++i) {
        lives.emplace_back(places.study, list[i], places.candidates[i]);
    }
    auto logs = analysis::lives_with_overlay({.study = places.study, .lives = lives, .required = {}}, moduli, added_mm);
    for (double& life : logs) {
        life = std::exp(life);
    }
    return logs;
}

} // namespace

TEST(Traffic, GrowsByCompoundInterest) {
    study::Criterion c;
    c.traffic_per_year = 1000.0;
    c.growth = 0.1;
    EXPECT_NEAR(c.traffic_of(2.0), 2100.0, 1e-9); // 1000 + 1100
    EXPECT_NEAR(c.years_of(2100.0), 2.0, 1e-12);
    c.growth = 0.0;
    EXPECT_NEAR(c.years_of(c.traffic_of(7.5)), 7.5, 1e-12);
    c.growth = -0.1; // 10000 in all
    EXPECT_TRUE(std::isinf(c.years_of(10001.0)));
}

// By the guides' laws at the strains of the answer, worked out here.
TEST(Design, LivesAreThoseOfTheStrains) {
    const auto result = designed(test::layered_study(test::layered_bowl(), criteria));
    ASSERT_EQ(result.criteria.size(), 2U);
    const auto& rutting = result.criteria[0];
    EXPECT_NEAR(rutting.allowable.best / std::pow(9150.0 / rutting.strain.best, 7.0), 1.0, 1e-9);
    const double years = std::log(1.0 + 0.03 * (rutting.allowable.best - 1e6) / 1e5) / std::log(1.03);
    EXPECT_NEAR(rutting.years.best, std::max(0.0, years), 1e-6);
    const auto& cracking = result.criteria[1];
    const double modulus = result.answer.minima[0].evaluation.parameters[0] * 145.0377;
    const double factor = std::pow(10.0, 4.84 * (11.0 / 15.5 - 0.69));
    EXPECT_NEAR(cracking.allowable.best /
                    (0.07958 * factor * std::pow(1e-6 * cracking.strain.best, -3.291) * std::pow(modulus, -0.854)),
                1.0, 1e-4);
    EXPECT_GT(cracking.strain.best, 20.0);
    for (const auto& c : result.criteria) {
        EXPECT_LT(c.allowable.low, c.allowable.best);
        EXPECT_GT(c.allowable.high, c.allowable.best);
        EXPECT_LE(c.allowable.wide_low, c.allowable.low);
        EXPECT_GE(c.allowable.wide_high, c.allowable.high);
    }
    EXPECT_NEAR(result.criteria[0].governs + result.criteria[1].governs, 1.0, 1e-12);
    // Under the middle of a single wheel, at the interface.
    EXPECT_NEAR(rutting.place.x_mm, 0.0, 1e-9);
    EXPECT_NEAR(rutting.place.depth_mm, 500.0, 1e-9);
    EXPECT_NEAR(cracking.place.depth_mm, 150.0, 0.02);
}

// A run of its own with that thickness lasts, and with 2 mm less it does not.
TEST(Design, OverlayLastsItsTraffic) {
    const study::Study study = test::layered_study(test::layered_bowl(), criteria);
    const auto result = designed(study, 60.0);
    ASSERT_TRUE(result.overlay && result.overlay->best && result.overlay->reliable);
    const double best = *result.overlay->best;
    EXPECT_GT(best, 0.0);
    EXPECT_GE(*result.overlay->reliable, best);
    EXPECT_GE(*result.overlay->high, *result.overlay->reliable - 1.0);
    EXPECT_LE(*result.overlay->low, best);
    const auto& moduli = result.answer.minima[0].evaluation.parameters;
    const auto shortfall = [&](double added) {
        const auto lives = lives_at(study, moduli, added);
        double least = INFINITY;
        for (std::size_t i = 0; i < lives.size(); ++i) {
            least = std::min(least, lives[i] / result.criteria[i].required);
        }
        return least;
    };
    EXPECT_GE(shortfall(best), 1.0);
    EXPECT_LT(shortfall(best - 2.0), 1.0);
    EXPECT_NEAR(result.criteria[0].required, 1e6 + 1e5 * (std::pow(1.03, 60.0) - 1.0) / 0.03, 1.0);
}

// Other layers, other errors: the truth lies in the range in nearly all cases (95 % of 12, less three: p = 0.002).
TEST(Design, RangesHoldTheTruth) {
    const study::Study truth = test::layered_study(test::layered_bowl(), criteria);
    const problem::Problem problem = study::make_prediction_problem(truth);
    const std::vector<std::string> x{"0", "200", "300", "600", "900", "1500"};
    const pave::RandomStream random(7, 1);
    int held = 0;
    int all = 0;
    std::uint64_t next = 0;
    constexpr int cases = 12;
    for (int c = 0; c < cases; ++c) {
        std::vector<double> unit(3);
        for (double& u : unit) {
            u = 0.3 + 0.4 * random.uniform(1000 + next++);
        }
        const auto there = problem.evaluate(unit, false, *problem.function->make_workspace());
        ASSERT_TRUE(there.converged());
        std::string bowl;
        for (std::size_t i = 0; i < x.size(); ++i) {
            const double mm = 1e3 * there.responses[i];
            bowl += fmt::format("fwd,deflection,{},0,0,0,{:.6f},mm,{:.6f}\n", x[i],
                                mm * (1.0 + 0.02 * random.normal(next++)), 0.02 * mm);
        }
        const auto result = designed(test::layered_study(bowl, criteria));
        const auto lives = lives_at(truth, there.parameters, 0.0);
        for (std::size_t i = 0; i < lives.size(); ++i) {
            ++all;
            held += lives[i] >= result.criteria[i].allowable.low && lives[i] <= result.criteria[i].allowable.high;
        }
    }
    EXPECT_EQ(all, 2 * cases);
    EXPECT_GE(held, all - 4);
}

// Without an error of the readings there is no range, and the best set is still said.
TEST(Design, SaysWhyThereIsNoRange) {
    const auto result = designed(test::layered_study("fwd,deflection,0,0,0,0,0.43,mm,\n"
                                                     "fwd,deflection,300,0,0,0,0.32,mm,\n"
                                                     "fwd,deflection,900,0,0,0,0.17,mm,\n",
                                                     criteria));
    EXPECT_FALSE(result.no_range.empty());
    EXPECT_TRUE(std::isnan(result.criteria[0].years.low));
    EXPECT_GT(result.criteria[0].allowable.best, 0.0);
}
