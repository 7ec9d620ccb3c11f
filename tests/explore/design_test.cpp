// Lives and overlays of linear layers on a half-space, whose runs take no time.
#include "analysis/design/design.h"
#include "analysis/design/design_overlay.h"
#include "base/random.h"
#include "study/values.h"
#include "support/layered_study.h"

#include <algorithm>
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
        lives.emplace_back(places, list[i], places.candidates[i]);
    }
    auto logs = analysis::lives_with_overlay(places, lives, moduli, added_mm);
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

// Annex II of IRC:37-2018, example 3: 2500 vehicles a day in one direction, three quarters of them in the lane, 5.2
// axles each, 6 % growth, 20 years: 131 million axles. 190 mm of 3000 MPa on 480 mm of 200 MPa on 62 MPa, Poisson's
// ratio 0.35, wheels of 20 kN, 0.56 MPa and 310 mm apart: 146 microstrain in the asphalt, 243 on the subgrade.
TEST(Design, FindsTheStrainsOfAPublishedExample) {
    const auto layer = [](const std::string& name, const std::string& thickness, int modulus) {
        return fmt::format("[[layers]]\nname = \"{}\"\n{}density_kg_m3 = 2000\nk0 = 0.5\nlaw = \"linear\"\n"
                           "modulus_MPa = {}\npoisson = 0.35\n",
                           name, thickness, modulus);
    };
    const auto criterion = [](const std::string& law) {
        return fmt::format("[[criteria]]\nname = \"{0}\"\nlaw = \"{0}\"\naxle = \"axle\"\ngrowth = 0.06\n"
                           "traffic_per_year = {1}\n",
                           law, 365.0 * 2500.0 * 0.75 * 5.2);
    };
    const auto study = study::study_of(
        "schema = 1\n[section]\nbottom = \"half-space\"\n" + layer("asphalt", "thickness_mm = 190\n", 3000) +
            layer("granular", "thickness_mm = 480\n", 200) + layer("subgrade", "", 62) +
            "[[loads]]\nname = \"axle\"\ntype = \"dual-wheel\"\nforce_kN = 40\npressure_kPa = 560\n"
            "spacing_mm = 310\npatch = \"circle\"\n"
            "[[parameters]]\nname = \"subgrade.modulus_MPa\"\nmin = 31\nmax = 124\nscale = \"log\"\n" +
            "[[outputs]]\nname = \"d0\"\nload = \"axle\"\nquantity = \"deflection\"\n" + criterion("irc37-fatigue-90") +
            criterion("irc37-rutting-90"),
        "annex.toml", {});
    const auto list = study::criteria_of(study);
    const analysis::CriticalPlaces places = analysis::critical_places(study, list);
    const auto problem = study::make_prediction_problem(places.study);
    const std::vector<double> unit{0.5}; // 62 MPa
    const auto there = problem.evaluate(unit, false, *problem.function->make_workspace());
    ASSERT_TRUE(there.converged());
    const double printed[] = {146.0, 243.0};
    for (std::size_t l = 0; l < list.size(); ++l) {
        const analysis::Life life(places, list[l], places.candidates[l]);
        const auto at = life.critical(life.at(there.parameters), there.responses);
        EXPECT_NEAR(life.strain(at, there.responses), printed[l], 0.01 * printed[l]) << list[l].name;
        EXPECT_NEAR(list[l].traffic_of(20.0), 131e6, 0.5e6);
    }
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

namespace {

const std::string two_seasons =
    "[[seasons]]\nname = \"dry\"\nshare = 0.75\n"
    "[[seasons]]\nname = \"wet\"\nshare = 0.25\nasphalt_C = 35\ntested_C = 20\nfactors = { subgrade = 0.6 }\n";

} // namespace

TEST(Seasons, AsphaltSoftensByThePublishedSlope) {
    const auto seasons = study::seasons_of(test::layered_study(test::layered_bowl(), criteria + two_seasons));
    ASSERT_EQ(seasons.size(), 2U);
    EXPECT_EQ(seasons[0].factors, (std::vector<double>{1.0, 1.0, 1.0}));
    EXPECT_NEAR(seasons[1].factors[0], 0.484172, 1e-6); // 10^(-0.021 * 15)
    EXPECT_EQ(seasons[1].factors[2], 0.6);
}

// Miner: 1/N = 0.75/N(as read) + 0.25/N(softer), with each N from a study of its own without seasons.
TEST(Seasons, DamageAddsUp) {
    const study::Study plain = test::layered_study(test::layered_bowl(), criteria);
    const study::Study with = test::layered_study(test::layered_bowl(), criteria + two_seasons);
    const auto by_hand = [&](const std::vector<double>& moduli, double added) {
        std::vector<double> softer = moduli;
        softer[0] *= std::pow(10.0, -0.315);
        softer[2] *= 0.6;
        const auto dry = lives_at(plain, moduli, added);
        const auto wet = lives_at(plain, softer, added);
        return std::vector<double>{1.0 / (0.75 / dry[0] + 0.25 / wet[0]), 1.0 / (0.75 / dry[1] + 0.25 / wet[1])};
    };
    const std::vector<double> moduli{3500.0, 320.0, 80.0};
    for (const double added : {0.0, 60.0}) {
        const auto lives = lives_at(with, moduli, added);
        const auto expected = by_hand(moduli, added);
        EXPECT_NEAR(lives[0] / expected[0], 1.0, 1e-9);
        EXPECT_NEAR(lives[1] / expected[1], 1.0, 1e-9);
        EXPECT_LT(lives[0], 0.9 * lives_at(plain, moduli, added)[0]);
    }
    const auto result = designed(with);
    const auto expected = by_hand(result.answer.minima[0].evaluation.parameters, 0.0);
    for (std::size_t l = 0; l < expected.size(); ++l) {
        EXPECT_NEAR(result.criteria[l].allowable.best / expected[l], 1.0, 1e-6);
        EXPECT_LT(result.criteria[l].allowable.low, result.criteria[l].allowable.best);
    }
}

// Against differences of the life itself, with seasons and without.
TEST(Seasons, LivesHaveTheirDerivatives) {
    for (const std::string& seasons : {std::string(), two_seasons}) {
        const auto study = test::layered_study(test::layered_bowl(), criteria + seasons);
        const auto list = study::criteria_of(study);
        const analysis::CriticalPlaces places = analysis::critical_places(study, list);
        const auto problem =
            analysis::seasonal(study::make_noise_problem(places.study, study::Scope::everything), places);
        const auto workspace = problem.function->make_workspace();
        const std::vector<double> unit{0.5, 0.4, 0.6};
        const auto here = problem.evaluate(unit, true, *workspace);
        ASSERT_TRUE(here.converged());
        for (std::size_t l = 0; l < list.size(); ++l) {
            const analysis::Life life(places, list[l], places.candidates[l]);
            const std::size_t at = life.critical(life.at(here.parameters), here.responses);
            const Eigen::VectorXd gradient = life.gradient(at, unit, here);
            for (std::size_t k = 0; k < unit.size(); ++k) {
                constexpr double step = 1e-4;
                const auto life_at = [&](double move) {
                    std::vector<double> moved = unit;
                    moved[k] += move;
                    const auto there = problem.evaluate(moved, false, *workspace);
                    return life.log_repetitions(at, life.at(there.parameters), there.responses);
                };
                EXPECT_NEAR(gradient[static_cast<Eigen::Index>(k)], (life_at(step) - life_at(-step)) / (2.0 * step),
                            1e-3 * (1.0 + std::abs(gradient[static_cast<Eigen::Index>(k)])));
            }
        }
    }
}

// With that reading, of the value that the best set gives it, the range of ln(life) is what was said; to first order.
TEST(Design, NextReadingNarrowsTheLifeByWhatItSays) {
    const auto result = designed(test::layered_study(test::layered_bowl(), criteria));
    const auto step = std::find_if(result.next.begin(), result.next.end(),
                                   [](const auto& s) { return s.reading && s.reading->quantity != "deflection"; });
    ASSERT_NE(step, result.next.end());
    EXPECT_LT(step->left, 0.9);
    for (std::size_t i = 1; i < result.next.size(); ++i) {
        EXPECT_LE(result.next[i - 1].left, result.next[i].left);
    }
    EXPECT_TRUE(std::any_of(result.next.begin(), result.next.end(),
                            [](const auto& s) { return s.parameter == "asphalt.modulus_MPa"; }));
    const data::Reading& r = *step->reading;
    const auto more =
        test::layered_bowl() + fmt::format("{},{},{},{},{},{},{},{},{}\n", r.load, r.quantity, r.x_mm, r.y_mm,
                                           r.depth_mm, r.gauge_mm, r.value, r.unit.name, r.in_unit(r.noise.absolute));
    const auto with = designed(test::layered_study(more, criteria));
    const std::size_t first = &result.governing() - result.criteria.data();
    const auto width = [&](const analysis::DesignResult& of) {
        return std::log(of.criteria[first].allowable.high / of.criteria[first].allowable.low);
    };
    EXPECT_NEAR(width(with) / width(result), step->left, 0.15);
}

// What a law is not used for is no number; a law of one's own has no such limits.
TEST(Design, LivesBeyondTheirLawAreSaidToBe) {
    const auto laws = pave::pavement::criterion_laws();
    analysis::CriterionLife c;
    c.criterion.guide =
        &*std::find_if(laws.begin(), laws.end(), [](const auto& l) { return l.name == "austroads-subgrade"; });
    c.criterion.traffic_per_year = 1e6;
    c.criterion.passed = 5e4;
    EXPECT_EQ(analysis::repetitions_words(c, 2.6e7), "2.6e7");
    EXPECT_EQ(analysis::repetitions_words(c, 1e18), "> 1e9");
    EXPECT_EQ(analysis::repetitions_words(c, 2.1e4), "< 1e5");
    EXPECT_EQ(analysis::years_words(c, 2.1e4), "< 0.050"); // (1e5 - 5e4)/1e6
    EXPECT_EQ(analysis::years_words(c, 1e18), "> 200");
    c.criterion.traffic_per_year = 1e8; // 1e9 last 10 years
    EXPECT_EQ(analysis::years_words(c, 1e18), "> 10.0");
    c.criterion.guide = nullptr;
    EXPECT_EQ(analysis::repetitions_words(c, 1e11), "1e11");
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
