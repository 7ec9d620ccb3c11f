// What a survey makes of the stations of its files before anything is fitted. Expected values are those of the
// stations, or calculated as written beside them.
#include "analysis/survey/survey_findings.h"
#include "analysis/survey/survey_road.h"
#include "analysis/survey/survey_stations.h"
#include "landscape/prediction_error.h"
#include "support/formula.h"

#include <cmath>
#include <gtest/gtest.h>

using namespace explore;

// Built as one source with the other tests.
namespace survey_runs {

namespace {

data::FwdStation station(double chainage_m, const std::string& date = "", const std::string& file = "road.csv") {
    data::FwdStation s;
    s.name = std::to_string(std::lround(chainage_m));
    s.chainage_m = chainage_m;
    s.date = date;
    s.file = file;
    data::FwdDrop drop;
    drop.number = 1;
    drop.radius_mm = 150.0;
    drop.pressure_kPa = 700.0;
    drop.readings = {{0, 500}, {200, 400}, {300, 330}, {600, 180}, {900, 110}};
    s.drops.push_back(std::move(drop));
    return s;
}

std::vector<std::string> profiles(std::vector<data::FwdStation> stations) {
    std::vector<std::string> names;
    for (const auto& s :
         analysis::begin_survey({{.stations = std::move(stations), .remarks = {}}}, std::nullopt, {}).stations) {
        names.push_back(s.station.profile);
    }
    return names;
}

using Names = std::vector<std::string>;

} // namespace

TEST(Runs, DatesThatLieOverEachOtherAreProfiles) {
    EXPECT_EQ(profiles({station(0, "a"), station(50, "a"), station(0, "b"), station(50, "b")}),
              (Names{"a", "a", "b", "b"}));
    EXPECT_EQ(profiles({station(0, "a"), station(50, "a"), station(100, "b"), station(150, "b")}),
              (Names{"", "", "", ""})); // a night
    EXPECT_EQ(profiles({station(0, "a"), station(50, "a"), station(50, "b")}),
              (Names{"a", "a", "b"})); // one station again
    EXPECT_EQ(profiles({station(0, "a 10:00"), station(50, "a 10:05"), station(25, "a 10:10")}), (Names{"", "", ""}));
    EXPECT_EQ(profiles({station(0, "a", "x/one.csv"), station(9, "a", "x/one.csv"), station(0, "a", "two.f25"),
                        station(9, "a", "two.f25")}),
              (Names{"one", "one", "two", "two"}));
}

TEST(Runs, TemperaturesAndClocks) {
    auto hot = station(0);
    hot.air_C = 66.0;
    hot.surface_C = 59.0; // roads are as hot, but this is the same line in Fahrenheit
    auto warm = station(9);
    warm.air_C = 999.0; // a mark
    warm.surface_C = 31.0;
    warm.time = "noon";
    const auto result = analysis::begin_survey({{.stations = {hot, warm}, .remarks = {}}}, std::nullopt,
                                               {.asphalt_thickness_mm = 100.0});
    const auto remarks = [&](std::size_t s) { return pave::join(result.stations[s].station.remarks, "\n"); };
    EXPECT_FALSE(result.stations[0].station.air_C || result.stations[0].station.surface_C);
    EXPECT_NE(remarks(0).find("air temperature of 66 C is not used: Fahrenheit"), std::string::npos) << remarks(0);
    EXPECT_NE(remarks(0).find("surface temperature of 59 C is not used: Fahrenheit"), std::string::npos) << remarks(0);
    EXPECT_FALSE(result.stations[1].station.air_C);
    EXPECT_EQ(result.stations[1].station.surface_C, 31.0);
    EXPECT_NE(remarks(1).find("\"noon\" is no time of day"), std::string::npos) << remarks(1);
}

TEST(Runs, WhyThereIsNoRatio) {
    auto far = station(0);
    far.drops[0].readings = {{0, 500}, {150, 450}, {300, 330}};
    auto near = station(9);
    near.drops[0].readings = {{0, 500}, {200, 400}};
    const auto result =
        analysis::begin_survey({{.stations = {far, near, station(20)}, .remarks = {}}}, std::nullopt, {});
    EXPECT_EQ(analysis::why_no_ratio(result.stations[0]),
              "no sensor between the edge of the plate (150 mm) and 250 mm");
    EXPECT_EQ(analysis::why_no_ratio(result.stations[1]), "no sensor at 250 mm or beyond");
    EXPECT_EQ(analysis::why_no_ratio(result.stations[2]), "");
}

TEST(RoadSections, RoundingPartsNoRoad) {
    std::vector<data::FwdStation> stations;
    for (int i = 0; i < 40; ++i) { // one bowl at loads that differ: D0 at the common load is the same but for rounding
        auto s = station(50.0 * i);
        const double factor = 1.0 + 0.002 * (i % 3);
        s.drops[0].pressure_kPa *= factor;
        s.drops[0].readings[0].deflection_um *= factor;
        stations.push_back(s);
    }
    const auto same = analysis::begin_survey({{.stations = stations, .remarks = {}}}, std::nullopt, {});
    EXPECT_EQ(analysis::road_sections(same).size(), 1U);
    for (std::size_t i = 20; i < 40; ++i) { // a step between two parts that do not vary is one
        stations[i].drops[0].readings[0].deflection_um *= 1.2;
    }
    const auto step = analysis::begin_survey({{.stations = stations, .remarks = {}}}, std::nullopt, {});
    EXPECT_EQ(analysis::road_sections(step).size(), 2U);
}

// Of y = A p with errors of one standard deviation s, a quantity g'p has the variance s^2 g' (A'A)^-1 g.
TEST(PredictionError, IsThatOfALinearModel) {
    Eigen::MatrixXd a(4, 2);
    a << 1.0, 0.2, 0.4, 1.1, 0.7, 0.9, 0.1, 0.3;
    const double s = 0.03;
    const Eigen::Vector2d p(0.4, 0.6);
    const Eigen::VectorXd y = a * p;
    const auto problem = test::problem_of(
        2, test::Formula([&](const Eigen::VectorXd& x, Eigen::VectorXd& responses, Eigen::MatrixXd& jacobian) {
            responses = a * x;
            jacobian = a;
        }),
        {y.begin(), y.end()}, s);
    landscape::Minimum best;
    best.unit = {p[0], p[1]};
    best.evaluation = problem.evaluate(best.unit, true, *problem.function->make_workspace());
    const auto local = landscape::analyse(best, problem);
    const Eigen::Matrix2d covariance = s * s * (a.transpose() * a).inverse();
    for (const Eigen::Vector2d& g :
         {Eigen::Vector2d(1.0, 0.0), Eigen::Vector2d(2.0, -3.0), Eigen::Vector2d(0.5, 0.5)}) {
        EXPECT_NEAR(landscape::prediction_error(g, best, problem, local), std::sqrt(g.dot(covariance * g)), 1e-12);
    }
    EXPECT_NEAR(landscape::prediction_error(Eigen::Vector2d(0.0, 1.0), best, problem, local), local.standard_error[1],
                1e-12);
    // What the readings do not see is not known: here p0 - p1.
    a.col(1) = a.col(0);
    best.evaluation = problem.evaluate(best.unit, true, *problem.function->make_workspace());
    const auto blind = landscape::analyse(best, problem);
    EXPECT_TRUE(std::isinf(landscape::prediction_error(Eigen::Vector2d(1.0, -1.0), best, problem, blind)));
    EXPECT_TRUE(std::isfinite(landscape::prediction_error(Eigen::Vector2d(1.0, 1.0), best, problem, blind)));
}

} // namespace survey_runs
