// What a further reading would tell: of loads whose numbers are sought, too.
#include "analysis/common/candidate_readings.h"
#include "analysis/unique/unique.h"
#include "pavement/effects/effect.h"
#include "study/candidates.h"
#include "study/problems.h"
#include "study/variants.h"
#include "support/layered_study.h"

#include <algorithm>
#include <gtest/gtest.h>

using namespace explore;

namespace {

const std::string pressure = "[[parameters]]\nname = \"fwd.pressure_kPa\"\nmin = 300\nmax = 1300\n";

std::size_t candidate(const study::Study& list, const std::string& load, double x_mm) {
    for (std::size_t i = 0; i < list.readings.size(); ++i) {
        if (list.readings[i].load == load && list.readings[i].quantity == "deflection" &&
            list.readings[i].x_mm == x_mm) {
            return i;
        }
    }
    ADD_FAILURE() << load << " at " << x_mm;
    return 0;
}

} // namespace

// A sensor that reads under two loads may stand elsewhere, or have a gain of its own; one that reads once may as well
// be wrong that once.
TEST(Variants, AreThePlaceAndTheGainOfAnInstrumentThatReadsTwice) {
    const auto count = [](const study::Study& study, std::string_view effect) {
        const auto list = study::variants(study, {});
        return std::count_if(list.begin(), list.end(), [&](const study::Variant& variant) {
            return variant.applied.effect->name == effect && variant.on == "every deflection at 300 mm";
        });
    };
    std::string under_both = test::layered_bowl() + test::layered_bowl();
    for (std::size_t at = test::layered_bowl().size(); (at = under_both.find("fwd", at)) != std::string::npos;) {
        under_both.replace(at, 3, "wheel");
    }
    const study::Study once = test::layered_study(test::layered_bowl());
    const study::Study twice = test::layered_study(under_both);
    for (const char* effect : {"sensor-gain", "sensor-position"}) {
        EXPECT_EQ(count(once, effect), 0) << effect;
        EXPECT_EQ(count(twice, effect), 1) << effect;
    }
}

// In a linear section a deflection is proportional to the pressure: under half as much again it is 1.5 times that of
// the load itself, whatever the load's own pressure is at the time; d(ln deflection)/d(ln pressure) = 1.
TEST(TheLoadRaised, FollowsWhatIsSoughtOfTheLoad) {
    const study::Study list = study::candidates(test::layered_study(test::layered_bowl(), pressure));
    const std::string raised = "fwd at 150 % of the pressure";
    const std::size_t own = candidate(list, "fwd", 450.0);
    const std::size_t more = candidate(list, raised, 450.0);
    const problem::Problem problem = study::make_prediction_problem(list);
    const auto workspace = problem.function->make_workspace();
    for (const double kPa : {500.0, 900.0}) {
        const auto there =
            problem.evaluate(problem.space.unit(std::vector<double>{3500.0, 320.0, 80.0, kPa}), true, *workspace);
        ASSERT_TRUE(there.converged());
        EXPECT_NEAR(there.responses[more] / there.responses[own], 1.5, 1e-9);
        EXPECT_NEAR(there.jacobian(static_cast<Eigen::Index>(more), 3) * kPa / there.responses[more], 1.0, 1e-6);
    }
}

TEST(TheLoadRaised, HasTheRadiusThatIsSought) {
    const study::Study list = study::candidates(
        test::layered_study(test::layered_bowl(), "[[parameters]]\nname = \"fwd.radius_mm\"\nmin = 100\nmax = 200\n"));
    const problem::Problem problem = study::make_prediction_problem(list);
    const auto there = problem.evaluate(problem.space.unit(std::vector<double>{3500.0, 320.0, 80.0, 140.0}), true,
                                        *problem.function->make_workspace());
    ASSERT_TRUE(there.converged());
    EXPECT_NEAR(there.responses[candidate(list, "fwd at 150 % of the pressure", 450.0)] /
                    there.responses[candidate(list, "fwd", 450.0)],
                1.5, 1e-9);
}

TEST(TheLoadRaised, IsKnownWhereTheLoadIs) {
    const study::Study list = study::candidates(test::layered_study(test::layered_bowl()));
    EXPECT_TRUE(list.model.ties.empty());
}

// Of the moduli and the pressure only ratios can be known from deflections and strains, which go with pressure over
// modulus: no multiple of that pressure tells its size. (A stress goes with the pressure and the ratios of the moduli:
// it does.)
TEST(TheMostInformativeReading, IsNotPromisedToTellAPressureThatItIsAMultipleOf) {
    analysis::Session session({.threads = 1, .show_progress = false});
    const auto result = analysis::unique(session, test::layered_study(test::layered_bowl(), pressure),
                                         {.settings = {.explore = 16, .verify = 4}});
    ASSERT_TRUE(result && !result->next.effects.empty());
    for (const auto& effect : result->next.effects) {
        const auto& reading = result->next.candidates[effect.candidate];
        if (reading.load.starts_with("fwd") && reading.quantity != "stress_zz") {
            EXPECT_GT(effect.parameters[3], 0.9) << reading.words();
        }
    }
}
