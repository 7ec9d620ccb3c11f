// What a survey says of its own answers: what is not determined, what a study's bounds do, whether a sensor or the
// section is wrong. Expected values are calculated by hand, as written beside them.
#include "analysis/road/road_statistics.h"
#include "analysis/survey/survey_findings.h"
#include "analysis/survey/survey_road.h"
#include "analysis/survey/survey_sensors.h"
#include "analysis/survey/survey_stations.h"
#include "base/error.h"
#include "base/random.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <functional>
#include <gtest/gtest.h>

using namespace explore;
using analysis::StationResult;
using analysis::SurveyResult;

// Built as one source with the other tests.
namespace survey_judgement {

namespace {

const std::vector<double> offsets_mm{0, 300, 450, 600, 900, 1200, 1500, 1800};

// A model with two numbers to find: ln(deflection) = a + b x, whose derivatives are 1 and x (in m).
StationResult station(int number, const std::vector<double>& measured_um) {
    StationResult s;
    s.station.name = "S" + std::to_string(number);
    s.station.chainage_m = 25.0 * number;
    auto& bowl = s.bowls.emplace().levels.emplace_back();
    bowl.radius_mm = 150.0;
    bowl.pressure_kPa = 700.0;
    bowl.drops = {1};
    const auto n = static_cast<Eigen::Index>(offsets_mm.size());
    Eigen::MatrixXd design(n, 2);
    Eigen::VectorXd log_um(n);
    for (Eigen::Index i = 0; i < n; ++i) {
        const auto k = static_cast<std::size_t>(i);
        bowl.readings.push_back({.offset_mm = offsets_mm[k], .deflection_um = measured_um[k]});
        design.row(i) << 1.0, offsets_mm[k] / 1000.0;
        log_um[i] = std::log(measured_um[k]);
    }
    s.indices = data::indices_of(bowl, 700.0);
    const Eigen::VectorXd found = (design.transpose() * design).inverse() * (design.transpose() * log_um);
    auto& fit = s.fit.emplace();
    fit.levels = {0};
    fit.best.unit = {0.5, 0.5};
    auto& e = fit.best.evaluation;
    const Eigen::VectorXd model = (design * found).array().exp();
    e.responses.assign(model.data(), model.data() + n);
    e.jacobian = model.asDiagonal() * design;
    fit.model_um = {e.responses};
    fit.parameters = {{.value = 10.0 + number, .low = 9.0, .high = 30.0, .determined = number % 3 != 0},
                      {.value = 1.0, .determined = false}};
    return s;
}

// A dozen stations: bowls that the model follows but for what `wrong` does at an offset, with errors of 0.4 %.
SurveyResult road(const std::function<double(double)>& wrong) {
    SurveyResult result;
    for (int i = 0; i < 12; ++i) {
        const pave::RandomStream random(4, static_cast<std::uint64_t>(i));
        std::vector<double> um;
        for (std::size_t k = 0; k < offsets_mm.size(); ++k) {
            um.push_back((450.0 + 10.0 * (i % 2)) * std::exp(-offsets_mm[k] / 800.0) * wrong(offsets_mm[k]) *
                         (1.0 + 0.004 * random.normal(k)));
        }
        result.stations.push_back(station(i, um));
    }
    result.common_pressure_kPa = 700.0;
    return result;
}

std::string findings(const SurveyResult& result) {
    return pave::join(analysis::findings_of(result), "\n");
}

bool holds(const std::string& text, std::string_view words) {
    return text.find(words) != std::string::npos;
}

} // namespace

// Twelve stations with levels of 400 and 700 kPa: the model 4 % below all readings of the one, 3 % above those of the
// other.
TEST(LoadResiduals, AreMediansOverTheStationsAndNameTheLaw) {
    SurveyResult result;
    for (int number = 0; number < 12; ++number) {
        StationResult s = station(number, std::vector<double>(offsets_mm.size(), 500.0));
        data::DeflectionBowl high = s.bowls->levels[0];
        s.bowls->levels[0].pressure_kPa = 400.0;
        s.bowls->levels.push_back(high);
        s.fit->levels = {0, 1};
        s.fit->model_um.assign(2, {});
        for (const data::BowlReading& reading : high.readings) {
            s.fit->model_um[0].push_back(0.96 * reading.deflection_um);
            s.fit->model_um[1].push_back(1.03 * reading.deflection_um);
        }
        result.stations.push_back(std::move(s));
    }
    result.load_residuals = analysis::load_residuals(result);
    ASSERT_EQ(result.load_residuals.size(), 2u);
    const auto& low = result.load_residuals[0];
    const auto& high = result.load_residuals[1];
    EXPECT_EQ(low.pressure_kPa, 400.0);
    EXPECT_NEAR(low.percent, -4.0, 1e-9);
    EXPECT_NEAR(high.percent, 3.0, 1e-9);
    EXPECT_NEAR(high.scatter_percent, 0.0, 1e-9);
    EXPECT_EQ(low.above, 0u);
    EXPECT_EQ(high.above, 12u);
    EXPECT_TRUE(low.one_sign && high.one_sign); // 2 / 2^12 of chance, twice
    const auto words = analysis::findings_of(result);
    EXPECT_TRUE(std::any_of(words.begin(), words.end(), [](const std::string& w) {
        return w.find("stiffens with load does that: try law = \"uzan\"") != std::string::npos;
    }));
    for (StationResult& s : result.stations) { // one level alone says nothing of load
        s.fit->levels = {0};
    }
    EXPECT_TRUE(analysis::load_residuals(result).empty());
}

TEST(JudgeSensors, OneThatAloneIsOffIsNamed) {
    auto result = road([](double x) { return x == 600.0 ? 1.12 : 1.0; });
    analysis::judge_sensors(result);
    ASSERT_TRUE(result.suspect);
    EXPECT_EQ(result.suspect->offset_mm, 600.0);
    EXPECT_FALSE(result.section_is_suspect);
    // The fit gives way: others are off as well, until it is left out.
    EXPECT_GE(std::count_if(result.residuals.begin(), result.residuals.end(), [](const auto& r) { return r.one_sign; }),
              3);
    EXPECT_EQ(analysis::left_over_without(result, 600.0), 0U);
    EXPECT_GE(*analysis::left_over_without(result, 900.0), 2U);
}

TEST(JudgeSensors, AWaveOverAllIsTheSections) {
    // What a layer more would do: the bowl curves otherwise everywhere.
    auto result = road([](double x) { return 1.0 + 0.06 * std::cos(x / 290.0); });
    analysis::judge_sensors(result);
    EXPECT_TRUE(result.section_is_suspect);
    EXPECT_FALSE(result.suspect);
    EXPECT_TRUE(holds(findings(result), "no single sensor explains that: the section (another layer"));
    // Another section that leaves what sensors err by settles it; one that leaves more does not.
    result.trials = {{.words = "a further layer",
                      .stations = 9,
                      .rms_percent = 0.4,
                      .rms_percent_of_study = 4.0,
                      .misfit_ratio = 0.01}};
    EXPECT_TRUE(holds(findings(result), "no single sensor explains that: the section is wrong"));
    result.trials[0].rms_percent = 2.0;
    EXPECT_FALSE(holds(findings(result), "the section is wrong"));
    // Errors alone: nothing.
    auto sound = road([](double) { return 1.0; });
    analysis::judge_sensors(sound);
    EXPECT_FALSE(sound.section_is_suspect || sound.suspect);
    EXPECT_EQ(sound.residuals.size(), offsets_mm.size());
    EXPECT_FALSE(holds(findings(sound), "one sign"));
}

TEST(Sections, PercentilesAreOfWhatIsDetermined) {
    auto result = road([](double) { return 1.0; });
    result.study.emplace().space.axes = {{.name = "a", .low = 1.0, .high = 50.0},
                                         {.name = "b", .low = 0.0, .high = 2.0}};
    const auto sections = analysis::road_sections(result);
    ASSERT_EQ(sections.size(), 1U);
    EXPECT_EQ(sections[0].fitted, 12U);
    // 8 of 12 are determined: 11, 12, 14, 15, 17, 18, 20, 21; the middle of them 16, of all 15.5.
    EXPECT_EQ(sections[0].parameters[0].stations, 8U);
    EXPECT_NEAR(sections[0].parameters[0].p50, 16.0, 1e-12);
    EXPECT_EQ(sections[0].parameters[1].stations, 0U);
}

TEST(Sections, ABoundOfManyStationsIsOneFinding) {
    auto result = road([](double) { return 1.0; });
    result.study.emplace().space.axes = {{.name = "a", .low = 1.0, .high = 50.0},
                                         {.name = "b", .low = 0.0, .high = 2.0}};
    for (std::size_t i = 0; i < 4; ++i) {
        result.stations[3 * i].fit->best.on_bound = {{0, true}};
    }
    result.stations[1].fit->best.on_bound = {{1, false}};
    EXPECT_TRUE(
        holds(findings(result), "a at its upper bound (50.00) at 4 of 12 stations: raise it, or the section is wrong."))
        << findings(result);
    EXPECT_FALSE(holds(pave::join(analysis::remarks_of(result, result.stations[3])), "bound"));
    EXPECT_TRUE(holds(pave::join(analysis::remarks_of(result, result.stations[1])), "b at its lower bound"));
    result.stations[9].fit->best.on_bound.clear(); // three of twelve are fewer than a third
    EXPECT_FALSE(holds(findings(result), "raise it"));
    EXPECT_TRUE(holds(pave::join(analysis::remarks_of(result, result.stations[3])), "a at its upper bound"));
}

TEST(Counts, StationsWithoutARatioAreCounted) {
    auto result = road([](double) { return 1.0; });
    for (auto& s : result.stations) { // 0 and 300 mm: nothing between the plate and 250 mm
        EXPECT_FALSE(s.ratio());
    }
    EXPECT_EQ(result.counts().no_ratio, 12U);
    EXPECT_EQ(result.counts().pass + result.counts().fail, 0U);
    result.stations[0].state = analysis::StationState::rejected;
    EXPECT_EQ(result.counts().no_ratio, 11U);
}

TEST(Temperatures, BeyondWhatBellsWasMadeWithAreRemarked) {
    SurveyResult result = road([](double) { return 1.0; });
    result.study.emplace().space.axes = {{.name = "a", .low = 1.0, .high = 50.0},
                                         {.name = "b", .low = 0.0, .high = 2.0}};
    result.reference_C = 20.0;
    auto& s = result.stations[0];
    s.station.surface_C = 53.0;
    s.asphalt = {46.0, analysis::TemperatureSource::bells3};
    s.asphalt_at_reference_MPa = 31000.0;
    const auto remarks = pave::join(analysis::remarks_of(result, s));
    EXPECT_TRUE(holds(remarks, "a surface of 53 C: BELLS3 was made with 0 to 40 C")) << remarks;
    EXPECT_TRUE(holds(remarks, "31000 MPa at 20 C are more than any asphalt has")) << remarks;
    EXPECT_TRUE(holds(findings(result), "At 1 of 12 stations the surface is colder than 0 or hotter than 40 C"));
    s.station.surface_C = 39.0;
    s.asphalt_at_reference_MPa = 9000.0;
    EXPECT_FALSE(holds(pave::join(analysis::remarks_of(result, s)), "BELLS3"));
    s.station.surface_C = 53.0; // measured in the asphalt: no matter of the formula
    s.asphalt->source = analysis::TemperatureSource::measured;
    EXPECT_FALSE(holds(pave::join(analysis::remarks_of(result, s)), "BELLS3"));
}

TEST(Lanes, ThatDifferInCaseOnlyAreOne) {
    data::FwdFile file;
    for (int i = 0; i < 6; ++i) {
        data::FwdStation s{.name = "S" + std::to_string(i),
                           .lane = i == 2 || i == 3 ? "k"
                                   : i == 5         ? "B"
                                                    : "K",
                           .file = "f"};
        s.chainage_m = 10.0 * i;
        s.drops.push_back(
            {.number = 1, .radius_mm = 150.0, .pressure_kPa = 700.0, .readings = {{0.0, 400.0}, {300.0, 200.0}}});
        file.stations.push_back(std::move(s));
    }
    const auto result = analysis::begin_survey({file}, std::nullopt, {});
    EXPECT_EQ(result.count([](const StationResult& s) { return s.station.lane == "K"; }), 5U);
    EXPECT_EQ(result.count([](const StationResult& s) { return s.station.lane == "B"; }), 1U);
    EXPECT_TRUE(holds(pave::join(result.remarks), "\"k\" is taken for lane \"K\": 2 stations"));
}

TEST(TargetLoad, IsNamedWhereALevelWasChosenByIt) {
    data::FwdFile file;
    for (int i = 0; i < 3; ++i) {
        data::FwdStation s{.name = "S" + std::to_string(i), .lane = {}, .file = "f"};
        s.chainage_m = 10.0 * i;
        for (int d = 0; d < 3; ++d) {
            s.drops.push_back({.number = d + 1,
                               .radius_mm = 150.0,
                               .pressure_kPa = 350.0 + 220.0 * d,
                               .readings = {{0.0, 200.0 + 130.0 * d}, {300.0, 100.0 + 65.0 * d}}});
        }
        file.stations.push_back(std::move(s));
    }
    analysis::SurveyOptions options;
    options.drops.target_force_kN = 40.0; // 566 kPa
    const auto result = analysis::begin_survey({file}, std::nullopt, options);
    EXPECT_TRUE(holds(findings(result), "At 3 of 3 stations the level nearest to 40 kN is used")) << findings(result);
    EXPECT_FALSE(holds(findings(result), "highest"));
    EXPECT_FALSE(holds(pave::join(analysis::remarks_of(result, result.stations[0])), "--target-load"));
    EXPECT_TRUE(holds(findings(analysis::begin_survey({file}, std::nullopt, {})), "the highest load is used"));
}

// (C^-1 + I)^-1 of numbers, and of a covariance that is all but singular.
TEST(RoadStatistics, AWellKnownUnknownIsNotMadeLessKnown) {
    const auto one = [](double value) { return Eigen::MatrixXd::Constant(1, 1, value); };
    EXPECT_NEAR(analysis::informed(one(1e-8), one(1e6))(0, 0), 1.0 / (1e8 + 1e6), 1e-20);
    EXPECT_NEAR(analysis::informed(one(4.0), one(0.5))(0, 0), 1.0 / 0.75, 1e-14);
    EXPECT_EQ(analysis::informed(one(0.0), one(3.0))(0, 0), 0.0);
    Eigen::MatrixXd c(2, 2);
    c << 1e-8, 2e-8, 2e-8, 4e-8 + 1e-20;
    const Eigen::MatrixXd information = Eigen::MatrixXd::Identity(2, 2) * 1e8;
    // Along (1, 2) the variance is 5e-8: 1 / (2e7 + 1e8); across it nothing.
    const Eigen::MatrixXd found = analysis::informed(c, information);
    EXPECT_NEAR(found.trace(), 1.0 / 1.2e8, 1e-13);
}

} // namespace survey_judgement
