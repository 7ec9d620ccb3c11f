// In how many steps load paths are followed. Reference: the same readings in 200 steps.
#include "analysis/common/load_steps.h"
#include "base/error.h"
#include "pavement/forward.h"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>

using namespace explore;

namespace {

// solver: lines of [solver]; share: the stated noise over each value.
study::Study study_with(const std::string& solver, double share, const std::vector<double>& values = {}) {
    const std::string text = R"(schema = 1
[[layers]]
name = "asphalt"
density_kg_m3 = 2300
k0 = 0.5
thickness_mm = 50
law = "linear"
modulus_MPa = 4500
poisson = 0.35
[[layers]]
name = "base"
density_kg_m3 = 2100
k0 = 0.4
thickness_mm = 220
law = "uzan"
k1 = 3000
k2 = 0.9
k3 = -0.3
n = 0.25
poisson_12 = 0.35
poisson_31 = 0.35
[[layers]]
name = "subgrade"
density_kg_m3 = 1800
k0 = 0.5
thickness_mm = 1500
law = "linear"
modulus_MPa = 75
poisson = 0.4
[[loads]]
name = "fwd"
type = "plate"
radius_mm = 150
pressure_kPa = 900
[mesh]
refine = 0.4
[data]
files = ["readings.csv"]
misfit = "weighted"
[[parameters]]
name = "base.k1"
min = 500
max = 9000
scale = "log"
[[parameters]]
name = "subgrade.modulus_MPa"
min = 30
max = 200
scale = "log"
)";
    const char* places[] = {"deflection,0,0,0",  "deflection,300,0,0", "deflection,900,0,0", "strain_zz,0,0,90",
                            "strain_zz,0,0,180", "strain_zz,0,0,265",  "strain_zz,0,0,400",  "strain_xx,0,0,49"};
    std::string csv = "load,quantity,x_mm,y_mm,depth_mm,gauge_mm,value,unit,sigma\n";
    for (std::size_t i = 0; i < std::size(places); ++i) {
        const double value = values.empty() ? 1.0 : values[i] * (i < 3 ? 1e3 : 1e6);
        csv += std::string("fwd,") + places[i] + ",0," + std::to_string(value) + (i < 3 ? ",mm," : ",microstrain,") +
               (share > 0.0 ? std::to_string(share * std::abs(value)) : "") + "\n";
    }
    return study::study_of(text + (solver.empty() ? "" : "[solver]\n" + solver + "\n"), "steps.toml",
                           {{"readings.csv", csv}});
}

std::vector<double> responses(study::Study study, int steps) {
    study.model.settings.solver.load_steps = steps;
    const pave::pavement::ForwardModel model(study.model);
    return model.run(study.model, {}, *model.make_workspace()).value().values;
}

// Of this noise, the largest error of a reading at the study's own values.
double largest_share(const study::Study& study, int steps, double noise) {
    const auto right = responses(study, 200);
    const auto found = responses(study, steps);
    double largest = 0.0;
    for (std::size_t i = 0; i < right.size(); ++i) {
        largest = std::max(largest, std::abs(found[i] / right[i] - 1.0) / noise);
    }
    return largest;
}

const std::vector<double>& truth() {
    static const std::vector<double> values = responses(study_with("", 0.01), 200);
    return values;
}

constexpr int by_default = 9;
constexpr int fewest = 5;

analysis::Session session() {
    return analysis::Session({.threads = 1, .show_progress = false});
}

} // namespace

TEST(LoadSteps, AreStatedByTheirNumberOrByTheOlderTolerance) {
    const auto steps_with = [](const std::string& solver) {
        const study::Study study = study_with(solver, 0.01);
        EXPECT_EQ(study.load_steps, solver.empty() ? study::LoadSteps::by_default : study::LoadSteps::stated);
        return study.model.settings.solver.load_steps;
    };
    EXPECT_EQ(steps_with(""), by_default);
    EXPECT_EQ(steps_with("load_steps = 31"), 31);
    EXPECT_EQ(steps_with("path_tolerance = 2e-3"), by_default);
    EXPECT_EQ(steps_with("path_tolerance = 2.5e-4"), 2 * by_default); // an eighth
    EXPECT_EQ(steps_with("path_tolerance = 1e-5"), 53);               // 9 x 200^(1/3) = 52.6
    EXPECT_THROW(steps_with("path_tolerance = 1e-5\nload_steps = 31"), pave::Error);
    EXPECT_THROW(steps_with("load_steps = 0"), pave::Error);
    // Another number is another study, for the run store.
    EXPECT_NE(study_with("load_steps = 31", 0.01).hash, study_with("load_steps = 32", 0.01).hash);
}

TEST(LoadSteps, LeaveATenthOfTheNoiseInEveryReading) {
    for (const double noise : {0.1, 0.005, 0.0001}) {
        const study::Study given = analysis::with_enough_load_steps(study_with("", noise, truth()), session());
        const int steps = given.model.settings.solver.load_steps;
        std::printf("  noise %.1f %%: %d steps, errors up to %.3f of it, in the default number %.3f\n", 100.0 * noise,
                    steps, largest_share(given, steps, noise), largest_share(given, by_default, noise));
        EXPECT_EQ(given.load_steps, study::LoadSteps::chosen);
        EXPECT_LT(largest_share(given, steps, noise), 0.12); // as an estimate is right
        EXPECT_TRUE(steps > by_default || largest_share(given, by_default, noise) < 0.12);
        // Fewer than the default only where they leave next to nothing, but five at least.
        EXPECT_GE(steps, fewest);
        EXPECT_TRUE(steps >= by_default || largest_share(given, steps, noise) < 0.024);
        // Once chosen, they stay; and so does what the study states.
        const study::Study again = analysis::with_enough_load_steps(given, session());
        EXPECT_EQ(again.model.settings.solver.load_steps, steps);
    }
    EXPECT_EQ(analysis::with_enough_load_steps(study_with("load_steps = 9", 0.001, truth()), session())
                  .model.settings.solver.load_steps,
              9);
    EXPECT_EQ(
        analysis::with_enough_load_steps(study_with("", 0.0, truth()), session()).model.settings.solver.load_steps,
        by_default); // without noise nothing says what is enough
}

TEST(LoadSteps, AreJudgedByTheirErrorAtTheAnswer) {
    constexpr double noise = 0.0005;
    constexpr int few = 4;
    const study::Study study = study_with("load_steps = 4", noise, truth());
    const problem::Problem problem = study::make_noise_problem(study, study::Scope::fitted);
    problem::Evaluation answer;
    answer.parameters = {3000, 75};
    answer.status = pave::Status::converged;
    answer.responses = responses(study, few);
    const auto error = analysis::path_error(study, problem, answer, 1.0);
    ASSERT_TRUE(error);
    const double share = largest_share(study, few, noise);
    std::printf("  %.3f of the noise, by the estimate %.3f\n", share, error->share);
    EXPECT_NEAR(error->share, share, 0.25 * share);
    EXPECT_TRUE(error->shows());
    EXPECT_LT(largest_share(study, error->enough(), noise), 0.12);
    const std::string words = analysis::path_words(study, error);
    EXPECT_NE(words.find("4 steps"), std::string::npos) << words;
    EXPECT_NE(words.find("load_steps = " + std::to_string(error->enough())), std::string::npos) << words;
    // Beside noise a thousand times as large nothing is said.
    const auto small = analysis::path_error(study, problem, answer, 1000.0);
    ASSERT_TRUE(small);
    EXPECT_FALSE(small->shows());
    EXPECT_EQ(analysis::path_words(study, small), "");
}

// Against 200 steps: half of the error to twice of it is said, and nothing where it is less than 1 %.
TEST(LoadSteps, OfAForwardRunSayWhatTheyLeave) {
    const study::Study study = study_with("", 0.01);
    const auto said = [&](int steps) {
        pave::pavement::Case at = study.model;
        at.settings.solver.load_steps = steps;
        pave::pavement::Response found;
        found.values = responses(study, steps);
        const auto warnings = analysis::with_path_warning(study, at, found)->warnings;
        return warnings.empty() ? "" : warnings[0];
    };
    const double left = largest_share(study, 2, 1.0);
    ASSERT_GT(left, 0.02);
    const std::string words = said(2);
    const auto about = words.find("about ");
    ASSERT_NE(about, std::string::npos) << words;
    const double percent = std::stod(words.substr(about + 6));
    EXPECT_GT(percent, 50.0 * left) << words;
    EXPECT_LT(percent, 200.0 * left) << words;
    EXPECT_TRUE(words.find("load_steps = ") != std::string::npos) << words;
    ASSERT_LT(largest_share(study, 40, 1.0), 0.005);
    EXPECT_EQ(said(40), "");
}
