// FWD files and what is read off a deflection bowl. Expected values are calculated by hand, as written beside them.
#include "data/deflection_bowl.h"
#include "study/problems.h"
#include "study/station.h"
#include "support/folder.h"

#include "base/error.h"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>

using namespace explore;
using data::FwdStation;

namespace {

// The bowl of the level that counts.
pave::Outcome<data::DeflectionBowl> main_bowl(const FwdStation& s, const data::DropChoice& choice = {}) {
    const auto bowls = data::bowls_of(s, choice);
    return bowls ? pave::Outcome(bowls->bowl()) : pave::Outcome<data::DeflectionBowl>(bowls.failure());
}

std::vector<std::string> remarks(const FwdStation& s) {
    const auto bowls = data::bowls_of(s);
    return bowls ? bowls->remarks : std::vector<std::string>{};
}

// One drop at 600 kPa on a plate of 150 mm radius.
FwdStation station(std::vector<data::FwdReading> readings) {
    data::FwdDrop drop;
    drop.number = 1;
    drop.radius_mm = 150.0;
    drop.pressure_kPa = 600.0;
    drop.readings = std::move(readings);
    FwdStation s;
    s.name = "S";
    s.chainage_m = 0.0;
    s.drops.push_back(std::move(drop));
    return s;
}

std::string rejection(const FwdStation& s) {
    const auto bowl = main_bowl(s);
    return bowl ? "none" : bowl.failure().reason;
}

} // namespace

TEST(DeflectionBowl, RatioAtASensor) {
    // 300 um / 500 um: at the limit, which passes.
    const auto bowl = main_bowl(station({{0, 500}, {250, 300}, {600, 100}}));
    ASSERT_TRUE(bowl) << bowl.failure().reason;
    EXPECT_EQ(bowl->deflection_ratio(), 0.6);
    EXPECT_FALSE(!bowl->has_sensor_at(250));
    EXPECT_GE(*bowl->deflection_ratio(), data::deflection_ratio_limit);
}

TEST(DeflectionBowl, RatioBetweenSensors) {
    // CAPTIF pavement 1 (grids/captif-p1-fwd.csv): 738 um (282/738)^(50/250) = 738 um exp(-0.2 0.96208) = 608.83 um;
    // over 1062 um: 0.57328.
    const auto bowl = main_bowl(station({{0, 1062}, {200, 738}, {450, 282}, {600, 165}}));
    ASSERT_TRUE(bowl) << bowl.failure().reason;
    EXPECT_TRUE(!bowl->has_sensor_at(250));
    EXPECT_NEAR(*bowl->at(250), 608.83, 0.01);
    EXPECT_NEAR(*bowl->deflection_ratio(), 0.57328, 1e-5);
}

TEST(DeflectionBowl, NoRatioWithoutSensorsAroundTheOffset) {
    for (const auto& readings : {std::vector<data::FwdReading>{{0, 500}, {300, 200}},
                                 {{0, 500}, {150, 400}, {300, 200}}, // at the edge of the plate
                                 {{0, 500}, {200, 300}}}) {
        const auto bowl = main_bowl(station(readings));
        ASSERT_TRUE(bowl) << bowl.failure().reason;
        EXPECT_FALSE(bowl->deflection_ratio());
    }
}

namespace {

data::FwdDrop drop(int number, double pressure_kPa, double d0_um, double d250_um) {
    data::FwdDrop drop = station({{0, d0_um}, {250, d250_um}}).drops[0];
    drop.number = number;
    drop.pressure_kPa = pressure_kPa;
    return drop;
}

} // namespace

TEST(DeflectionBowl, CombinesTheDropsNearTheHighestPressure) {
    FwdStation s = station({});
    s.drops = {drop(1, 400, 999, 998), // seats the plate
               drop(2, 560, 448, 280), drop(3, 600, 492, 330)};
    auto bowl = main_bowl(s);
    ASSERT_TRUE(bowl) << bowl.failure().reason;
    EXPECT_EQ(bowl->drops, (std::vector{2, 3}));
    EXPECT_EQ(bowl->pressure_kPa, 580.0);
    // (448 x 580/560 + 492 x 580/600) / 2 = (464 + 475.6) / 2; (290 + 319) / 2
    EXPECT_NEAR(bowl->d0_um(), 469.8, 1e-9);
    EXPECT_NEAR(*bowl->at(250), 304.5, 1e-9);
    // Of three, the mean; drops 3 and 4 are at 580 kPa now: (448 + 492 + 461) / 3, (280 + 330 + 305) / 3.
    s.drops[1].pressure_kPa = s.drops[2].pressure_kPa = 580;
    s.drops.push_back(drop(4, 580, 461, 305));
    bowl = main_bowl(s);
    ASSERT_TRUE(bowl) << bowl.failure().reason;
    EXPECT_NEAR(bowl->d0_um(), 467.0, 1e-9);
    EXPECT_NEAR(*bowl->at(250), 305.0, 1e-9);
}

TEST(DeflectionBowl, SaysWhyReadingsCannotBeRight) {
    // Sensors are good to 2 um + 2 % each: 300 um and 312 um to 8 and 8.2 um; 50 um more are not.
    EXPECT_EQ(rejection(station({{0, 500}, {200, 300}, {300, 350}, {600, 90}})),
              "the deflection rises from 300 um at 200 mm to 350 um at 300 mm");
    EXPECT_EQ(rejection(station({{0, 500}, {200, 300}, {300, 312}, {600, 90}})), "none");
    EXPECT_EQ(rejection(station({{200, 300}, {300, 200}})), "no reading at the centre of the load (D0)");
    EXPECT_EQ(rejection(station({})), "no reading at the centre of the load (D0)");
    FwdStation s = station({{0, 500}, {300, 200}});
    s.drops[0].pressure_kPa = -600;
    EXPECT_EQ(rejection(s), "drop 1: a pressure of -600 kPa");
    s.drops[0].pressure_kPa = NAN;
    EXPECT_EQ(rejection(s), "drop 1: its load was not measured");
    s = station({{0, 500}, {300, 200}});
    s.drops.push_back(s.drops[0]);
    EXPECT_EQ(rejection(s), "drop 1 appears twice");
    s.drops[1].number = 2;
    s.drops[1].radius_mm = 225;
    EXPECT_EQ(rejection(s), "plates of radius 150 and 225 mm");
}

TEST(DeflectionBowl, WhatCannotBeOfOneSensorCostsThatSensor) {
    const auto offsets = [](const FwdStation& s) {
        std::vector<double> mm;
        const auto bowl = main_bowl(s);
        for (const auto& r : bowl->readings) {
            mm.push_back(r.offset_mm);
        }
        return mm;
    };
    using Mm = std::vector<double>;
    FwdStation s = station({{0, 110}, {900, 67}, {1800, 0}});
    EXPECT_EQ(offsets(s), (Mm{0, 900}));
    EXPECT_EQ(remarks(s),
              std::vector<std::string>{"the sensor at 1800 mm reads 0.0 um, next to nothing, and is left out"});
    s = station({{0, 110}, {300, 12}, {900, 67}, {1800, 20}});
    EXPECT_EQ(offsets(s), (Mm{0, 900, 1800})); // 12 < 67 / 4
    EXPECT_EQ(remarks(s),
              std::vector<std::string>{
                  "the sensor at 300 mm reads 12.0 um, which the sensors beside it contradict, and is left out"});
    EXPECT_EQ(offsets(station({{0, 500}, {900, -1}})), (Mm{0}));
    // A rise within what two sensors are good to stays: 36.2 to 39.7 um, 2.7 + 2.8 um.
    s = station({{0, 56}, {450, 36.2}, {600, 39.7}, {900, 30}});
    EXPECT_EQ(offsets(s), (Mm{0, 450, 600, 900}));
    ASSERT_EQ(remarks(s).size(), 1U);
    EXPECT_NE(remarks(s)[0].find("rises from 36.2 um at 450 mm to 39.7 um at 600 mm, within"), std::string::npos);
    // Beyond that, at the end.
    EXPECT_EQ(offsets(station({{0, 56}, {450, 36}, {600, 30}, {900, 45}})), (Mm{0, 450, 600}));
}

TEST(DeflectionBowl, TheSidesOfThePlateAreNotAveraged) {
    FwdStation s = station({{-200, 0.1}, {0, 115}, {200, 71}, {300, 57}});
    EXPECT_EQ(main_bowl(s)->at(200), 71.0);
    EXPECT_EQ(remarks(s),
              std::vector<std::string>{"the sensor at -200 mm reads 0.1 um, next to nothing, and is left out"});
    s = station({{-200, 90}, {0, 115}, {200, 71}, {300, 57}});
    EXPECT_EQ(main_bowl(s)->at(200), 71.0);
    ASSERT_EQ(remarks(s).size(), 1U);
    EXPECT_NE(remarks(s)[0].find("-200 mm reads 90.0 um, the one at 200 mm 71.0 um"), std::string::npos)
        << remarks(s)[0];
    EXPECT_TRUE(remarks(station({{-200, 73}, {0, 115}, {200, 71}, {300, 57}})).empty()); // they agree
    // The one ahead is dead: the one behind stands in, when it may.
    s = station({{-200, 70}, {0, 115}, {200, 0}, {300, 57}});
    EXPECT_EQ(main_bowl(s)->at(200), 70.0);
    EXPECT_EQ(remarks(s).size(), 2U);
    EXPECT_FALSE(main_bowl(station({{-200, 40}, {0, 115}, {200, 0}, {300, 57}}))->has_sensor_at(200));
}

namespace {

FwdStation with_drops(const std::vector<std::pair<double, double>>& pressure_and_d0) {
    FwdStation s = station({});
    s.drops.clear();
    for (const auto& [pressure, d0] : pressure_and_d0) {
        data::FwdDrop drop;
        drop.number = static_cast<int>(s.drops.size()) + 1;
        drop.radius_mm = 150;
        drop.pressure_kPa = pressure;
        drop.readings = {{0, d0}, {300, d0 / 2}};
        s.drops.push_back(drop);
    }
    return s;
}

using Numbers = std::vector<int>;

Numbers left_out(const FwdStation& s, data::LeftOut why, const data::DropChoice& choice = {}) {
    Numbers numbers;
    const auto bowls = data::bowls_of(s, choice);
    for (const auto& drop : bowls->left_out) {
        if (drop.why == why) {
            numbers.push_back(drop.number);
        }
    }
    return numbers;
}

} // namespace

TEST(Drops, ASeatingDropIsLeftOut) {
    using data::LeftOut;
    for (const double seating : {993.0, 500.0}) { // higher or lower than the test
        const FwdStation s = with_drops({{seating, 148}, {822, 114.5}, {820, 115.8}});
        EXPECT_EQ(left_out(s, LeftOut::seating), Numbers{1});
        EXPECT_EQ(main_bowl(s)->drops, (Numbers{2, 3}));
        EXPECT_EQ(main_bowl(s, {.target_pressure_kPa = seating}).failure().reason,
                  fmt::format("no drop near {:.0f} kPa but drop 1, which seats the plate (--drops 1 takes it): of the "
                              "others the nearest has 821 kPa",
                              seating));
    }
    // At the pressure of the test: 8 % more than three that agree.
    EXPECT_EQ(left_out(with_drops({{700, 540}, {700, 500}, {700, 502}}), LeftOut::seating), Numbers{1});
    EXPECT_EQ(left_out(with_drops({{700, 510}, {700, 500}, {700, 502}}), LeftOut::seating), Numbers{});
    EXPECT_EQ(left_out(with_drops({{700, 540}, {700, 500}, {700, 560}}), LeftOut::seating), Numbers{}); // none agree
    EXPECT_EQ(left_out(with_drops({{500, 400}, {700, 560}, {900, 720}}), LeftOut::seating), Numbers{}); // three levels
}

TEST(Drops, OfTwoTheFirstSeatsWhereItDoesSoElsewhere) {
    const FwdStation s = with_drops({{985, 177}, {821, 141}});
    EXPECT_EQ(main_bowl(s)->drops, Numbers{1});
    EXPECT_EQ(main_bowl(s, {.first_of_two_seats = true})->drops, Numbers{2});
    EXPECT_EQ(main_bowl(with_drops({{830, 142}, {821, 141}}), {.first_of_two_seats = true})->drops, (Numbers{1, 2}));
}

TEST(Drops, LevelsAndWhichCounts) {
    const FwdStation s = with_drops({{721, 66}, {982, 89}, {1258, 104}, {1555, 117}});
    auto bowls = data::bowls_of(s);
    ASSERT_EQ(bowls->levels.size(), 4U);
    EXPECT_EQ(bowls->bowl().drops, Numbers{4});
    EXPECT_EQ(main_bowl(s, {.target_pressure_kPa = 700})->drops, Numbers{1});
    // 70 kN on 0.0706858 m2 = 990 kPa
    EXPECT_EQ(main_bowl(s, {.target_force_kN = 70})->drops, Numbers{2});
    EXPECT_EQ(main_bowl(s, {.target_pressure_kPa = 300}).failure().reason,
              "no drop near 300 kPa: the nearest has 721 kPa");
    EXPECT_EQ(main_bowl(s, {.numbers = {1, 3}})->drops, Numbers{3});
    EXPECT_EQ(left_out(s, data::LeftOut::not_chosen, {.numbers = {1, 3}}), (Numbers{2, 4}));
    EXPECT_NE(main_bowl(s, {.numbers = {7}}).failure().reason.find("none of the drops"), std::string::npos);
}

TEST(Drops, RepeatsGiveTheirScatter) {
    // ln(510/490) = 0.0400: standard deviation of two 0.0400/sqrt(2) = 0.02829, at both sensors.
    const auto bowls = data::bowls_of(with_drops({{700, 490}, {700, 510}}));
    EXPECT_NEAR(*bowls->bowl().readings[0].scatter, std::log(510.0 / 490.0) / std::sqrt(2.0), 1e-12);
    EXPECT_NEAR(*data::repeatability({&bowls->bowl()}), 0.02829, 1e-5);
    const auto one = data::bowls_of(with_drops({{700, 490}}));
    EXPECT_FALSE(data::repeatability({&one->bowl()}));
    // A drop that its repeats contradict is left out: 600 against a median of 499.5.
    const FwdStation odd = with_drops({{700, 500}, {700, 499}, {700, 600}});
    EXPECT_EQ(left_out(odd, data::LeftOut::contradicted), Numbers{3});
    EXPECT_NEAR(main_bowl(odd)->d0_um(), 499.5, 1e-9);
    EXPECT_EQ(main_bowl(odd)->drops, (Numbers{1, 2}));
}

TEST(Plausibility, NamesTheSlip) {
    const auto reason = [](double radius, double pressure, std::optional<double> force, double d0) {
        FwdStation s = station({{0, d0}, {300, d0 / 2}, {600, d0 / 4}});
        s.drops[0].radius_mm = radius;
        s.drops[0].pressure_kPa = pressure;
        s.drops[0].force_kN = force;
        return rejection(s);
    };
    EXPECT_EQ(reason(150, 0.707, {}, 500), "drop 1: a pressure of 0.707 kPa: MPa in a kPa column?");
    EXPECT_EQ(reason(150, 7.2, {}, 500), "drop 1: a pressure of 7.2 kPa: kgf/cm2 or bar in a kPa column?");
    // 5000 kgf = 49 kN = 694 kPa; 5000 lbf = 22 kN = 315 kPa
    EXPECT_EQ(reason(150, 70736, 5000.0, 500),
              "drop 1: a pressure of 70736 kPa (5000 kN on this plate): kgf or lbf in a kN column?");
    EXPECT_EQ(reason(150, 7e5, 49480.0, 500),
              "drop 1: a pressure of 700000 kPa (49480 kN on this plate): N in a kN column?");
    EXPECT_EQ(reason(150, 9903, 700.0, 500),
              "drop 1: a pressure of 9903 kPa (700 kN on this plate): kPa in a kN column?");
    EXPECT_EQ(reason(0.15, 700, {}, 500), "drop 1: a plate of radius 0.15 mm: radius in m?");
    EXPECT_EQ(reason(0.3, 700, {}, 500), "drop 1: a plate of radius 0.3 mm: radius (or diameter) in m?");
    EXPECT_EQ(reason(300, 700, {}, 500), "drop 1: a plate of radius 300 mm: the diameter in place of the radius?");
    EXPECT_EQ(reason(150, 700, {}, 5e5),
              "drop 1: a deflection of 500000 um at the centre: micrometres in a _mm column?");
    EXPECT_EQ(reason(150, 700, {}, 2e4),
              "drop 1: a deflection of 20000 um at the centre: mils or hundredths of a mm in a _mm column?");
    EXPECT_EQ(reason(150, 700, {}, 0.5), "drop 1: a deflection of 0.5 um at the centre: millimetres in a _um column?");
    FwdStation inches = station({{0, 500}, {12, 300}, {24, 200}, {60, 50}});
    EXPECT_EQ(rejection(inches), "drop 1: the farthest sensor at 60 mm: offsets in inches or offsets in cm?");
    // One drop out of two.
    FwdStation two = with_drops({{700, 500}, {0.7, 500}});
    EXPECT_EQ(main_bowl(two)->drops, Numbers{1});
    EXPECT_EQ(left_out(two, data::LeftOut::implausible), Numbers{2});
}

namespace {

// One layer under a plate, to the end of [data].
std::string soil_study(const std::string& law) {
    return R"(schema = 1
[[layers]]
name = "soil"
thickness_mm = 1500
density_kg_m3 = 1900
k0 = 0.5
)" + law + R"(
[[loads]]
name = "fwd"
type = "plate"
radius_mm = 150
pressure_kPa = 600
[data]
misfit = "relative"
)";
}

} // namespace

// The study takes the station's plate, pressure, sensors and deflections; unless it states where the wall stands, the
// wall makes room for the farthest sensor (README: the most of 4 m, twice the depth, twice the farthest sensor).
TEST(StationStudy, TakesLoadAndDeflectionsOfTheStation) {
    const std::string file = test::own_folder() + "station.toml";
    std::ofstream(file) << soil_study("law = \"linear\"\nmodulus_MPa = 60\npoisson = 0.4") << R"(files = ["nowhere.csv"]
[[parameters]]
name = "soil.modulus_MPa"
min = 20
max = 300
)";
    const study::Study survey = study::load_survey_study(file);
    FwdStation s = station({{0, 500}, {300, 200}, {2500, 20}});
    s.drops[0].radius_mm = 225;
    s.drops[0].pressure_kPa = 300;
    const auto bowl = main_bowl(s);
    ASSERT_TRUE(bowl) << bowl.failure().reason;
    const study::Study study = study::station_study(survey, s, {&*bowl}, 0.02);
    EXPECT_DOUBLE_EQ(study.model.loads[0].radius, 0.225);
    EXPECT_DOUBLE_EQ(study.model.loads[0].pressure, 300e3);
    EXPECT_DOUBLE_EQ(study.model.settings.extent, 5.0);
    const problem::Problem problem = study::make_problem(study);
    ASSERT_EQ(problem.readings(), 3U);
    EXPECT_DOUBLE_EQ(problem.measured(1), 200e-6);
    // All deflections doubled: relative residuals of 1.
    problem::Evaluation doubled;
    doubled.responses = {1000e-6, 400e-6, 40e-6};
    EXPECT_NEAR(problem.misfit(doubled), std::sqrt(3.0), 1e-12);
    // Another pressure is another study, for the run store.
    s.drops[0].pressure_kPa = 301;
    const auto other = main_bowl(s);
    EXPECT_NE(study::station_study(survey, s, {&*other}, 0.02).hash, study.hash);
    // Of 200 um by one drop: sqrt((0.02 x 200)^2 + 1 + 2^2) = 4.5826 um.
    EXPECT_NEAR(study.readings[1].noise.deviation(study.readings[1].measured()), 4.5826e-6, 1e-10);
    // Two levels: a load each.
    const study::Study both = study::station_study(survey, s, {&*bowl, &*other}, 0.02);
    ASSERT_EQ(both.model.loads.size(), 2U);
    EXPECT_EQ(both.model.loads[1].name, "fwd 301 kPa");
    EXPECT_EQ(both.measured().size(), 6U);
    EXPECT_EQ(both.readings[3].load, "fwd 301 kPa");
}

TEST(StationStudy, PutsTheLevelsOfAStressDependentSectionOnOnePath) {
    const std::string file = test::own_folder() + "levels.toml";
    const auto survey_of = [&](const std::string& law) {
        std::ofstream(file) << soil_study(law);
        return study::load_survey_study(file);
    };
    FwdStation s = station({{0, 500}, {300, 200}});
    s.drops[0].radius_mm = 225;
    const auto level = [&](double pressure_kPa) {
        s.drops[0].pressure_kPa = pressure_kPa;
        return *main_bowl(s);
    };
    const data::DeflectionBowl low = level(300);
    const data::DeflectionBowl high = level(500);
    const data::DeflectionBowl middle = level(400);
    const auto paths = [&](const std::string& law) {
        return path_of_each(study::station_study(survey_of(law), s, {&low, &high, &middle}, 0.02).model);
    };
    EXPECT_EQ(paths("law = \"k-theta\"\nk1 = 1000\nk2 = 0.4\nn = 1\npoisson_12 = 0.35\npoisson_31 = 0.35"),
              (std::vector{1, 1, 1}));
    EXPECT_EQ(paths("law = \"linear\"\nmodulus_MPa = 60\npoisson = 0.4"), (std::vector{0, 1, 2}));
}
