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

std::vector<FwdStation> read(const std::string& text) {
    const std::string file = test::own_folder() + "survey.csv";
    std::ofstream(file) << text;
    return data::read_fwd(file);
}

// The message of the complaint about a file.
std::string complaint(const std::string& text) {
    try {
        read(text);
    } catch (const pave::Error& error) {
        return error.what();
    }
    return "none";
}

// One drop at 600 kPa on a plate of 150 mm radius.
FwdStation station(std::vector<data::FwdReading> readings) {
    return {.name = "S", .lane = "", .drops = {{1, 150.0, 600.0, std::move(readings)}}, .file = ""};
}

std::string rejection(const FwdStation& s) {
    const auto bowl = data::bowl_of(s);
    return bowl ? "none" : bowl.failure().reason;
}

} // namespace

TEST(FwdCsv, ReadsStationsDropsAndUnits) {
    const auto stations = read("\xef\xbb\xbf# a road\r\n"
                               "D200_um,chainage_m,station,lane,load_kN,radius_mm,D0_mm,surface_C\r\n"
                               "300,10.5,\"A, north\",L1,42.4115,150,0.5,21\r\n"
                               "\r\n"
                               ",20,B,L1,42.4115,150,0.6,\r\n"
                               "330,10.5,\"A, north\",L1,42.4115,150,0.55,22\r\n");
    ASSERT_EQ(stations.size(), 2U);
    const FwdStation& a = stations[0];
    EXPECT_EQ(a.name, "A, north");
    EXPECT_EQ(a.lane, "L1");
    EXPECT_EQ(a.chainage_m, 10.5);
    EXPECT_EQ(a.line, 3);
    EXPECT_EQ(a.surface_C, 21.0);
    EXPECT_FALSE(a.air_C);
    ASSERT_EQ(a.drops.size(), 2U); // not one after the other in the file
    EXPECT_EQ(a.drops[1].number, 2);
    // 42.4115 kN / (pi 0.15^2 m2) = 42.4115 / 0.0706858 kPa = 600.0 kPa
    EXPECT_NEAR(a.drops[0].pressure_kPa, 600.0, 0.001);
    ASSERT_EQ(a.drops[0].readings.size(), 2U);
    EXPECT_EQ(a.drops[0].readings[0].offset_mm, 0.0); // by offset, whatever the order of the columns
    EXPECT_EQ(a.drops[0].readings[0].deflection_um, 500.0);
    EXPECT_EQ(a.drops[0].readings[1].deflection_um, 300.0);
    EXPECT_EQ(stations[1].drops[0].readings.size(), 1U); // an empty cell: not read
    EXPECT_EQ(stations[1].line, 5);
}

TEST(FwdCsv, SaysWhatIsWrongAndWhere) {
    const std::string header = "chainage_m,radius_mm,pressure_kPa,D0_um\n";
    const auto expect = [](const std::string& text, const std::vector<std::string>& words) {
        const std::string message = complaint(text);
        for (const std::string& word : words) {
            EXPECT_NE(message.find(word), std::string::npos) << "'" << word << "' in: " << message;
        }
    };
    expect("x,y\n1,2\n", {"known format", "chainage_m", "D0_um"});
    expect("", {"known format"});
    expect("chainage_m;radius_mm;pressure_kPa;D0_um\n0;150;600;500\n", {"known format", "commas"});
    expect("chainage_m,radius_mm,pressure_kPa,D0\n0,150,600,500\n", {":1", "unknown column", "\"D0\"", "D0_um"});
    expect("chainage_m,radius_mm,pressure_kPa,D0_um,D0_mm\n", {":1", "twice", "D0_mm"});
    expect("chainage_m,pressure_kPa,D0_um\n", {":1", "radius_mm", "missing"});
    expect("chainage_m,radius_mm,D0_um\n", {"load", "neither", "pressure_kPa and load_kN"});
    expect("chainage_m,radius_mm,pressure_kPa,load_kN,D0_um\n", {"load", "once"});
    expect("chainage_m,radius_mm,pressure_kPa\n", {"no column of deflections"});
    expect(header, {"no stations"});
    expect(header + "0,150,600,500\n10,150,600\n", {":3", "cells", "3", "4"});
    expect(header + "0,150,600,about 500\n", {":2", "D0_um", "about 500", "finite"});
    expect(header + "nan,150,600,500\n", {":2", "chainage_m", "nan"});
    expect("chainage_m,drop,radius_mm,pressure_kPa,D0_um\n0,first,150,600,500\n", {":2", "drop", "first"});
}

TEST(FwdCsv, LeavesNonsenseToTheStation) {
    const auto stations =
        read("chainage_m,radius_mm,pressure_kPa,D0_um,D300_um\n0,150,0,500,200\n10,150,600,nan,200\n");
    ASSERT_EQ(stations.size(), 2U);
    EXPECT_EQ(rejection(stations[0]), "drop 1: a pressure of 0 kPa");
    EXPECT_EQ(rejection(stations[1]), "drop 1: a deflection of nan um at 0 mm");
}

TEST(DeflectionBowl, RatioAtASensor) {
    // 300 um / 500 um: at the limit, which passes.
    const auto bowl = data::bowl_of(station({{0, 500}, {250, 300}, {600, 100}}));
    ASSERT_TRUE(bowl) << bowl.failure().reason;
    EXPECT_EQ(bowl->deflection_ratio(), 0.6);
    EXPECT_FALSE(bowl->d250_is_interpolated);
    EXPECT_GE(*bowl->deflection_ratio(), data::deflection_ratio_limit);
}

TEST(DeflectionBowl, RatioBetweenSensors) {
    // CAPTIF pavement 1 (grids/captif-p1-fwd.csv): 738 um (282/738)^(50/250) = 738 um exp(-0.2 0.96208) = 608.83 um;
    // over 1062 um: 0.57328.
    const auto bowl = data::bowl_of(station({{0, 1062}, {200, 738}, {450, 282}, {600, 165}}));
    ASSERT_TRUE(bowl) << bowl.failure().reason;
    EXPECT_TRUE(bowl->d250_is_interpolated);
    EXPECT_NEAR(*bowl->d250_um, 608.83, 0.01);
    EXPECT_NEAR(*bowl->deflection_ratio(), 0.57328, 1e-5);
}

TEST(DeflectionBowl, NoRatioWithoutSensorsAroundTheOffset) {
    for (const auto& readings : {std::vector<data::FwdReading>{{0, 500}, {300, 200}},
                                 {{0, 500}, {150, 400}, {300, 200}}, // at the edge of the plate
                                 {{0, 500}, {200, 300}}}) {
        const auto bowl = data::bowl_of(station(readings));
        ASSERT_TRUE(bowl) << bowl.failure().reason;
        EXPECT_FALSE(bowl->deflection_ratio());
    }
}

TEST(DeflectionBowl, CombinesTheDropsNearTheHighestPressure) {
    FwdStation s = station({});
    s.drops = {{1, 150, 400, {{0, 999}, {250, 998}}}, // less than 0.9 x 600 kPa: does not count
               {2, 150, 560, {{0, 448}, {250, 280}}},
               {3, 150, 600, {{0, 492}, {250, 330}}}};
    auto bowl = data::bowl_of(s);
    ASSERT_TRUE(bowl) << bowl.failure().reason;
    EXPECT_EQ(bowl->drops, (std::vector{2, 3}));
    EXPECT_EQ(bowl->pressure_kPa, 580.0);
    // (448 x 580/560 + 492 x 580/600) / 2 = (464 + 475.6) / 2; (290 + 319) / 2
    EXPECT_NEAR(bowl->d0_um(), 469.8, 1e-9);
    EXPECT_NEAR(*bowl->d250_um, 304.5, 1e-9);
    // Of three, the middle one; drops 3 and 4 are at 580 kPa now.
    s.drops[1].pressure_kPa = s.drops[2].pressure_kPa = 580;
    s.drops.push_back({4, 150, 580, {{0, 700}, {250, 290}}});
    bowl = data::bowl_of(s);
    ASSERT_TRUE(bowl) << bowl.failure().reason;
    EXPECT_EQ(bowl->d0_um(), 492.0);
    EXPECT_EQ(*bowl->d250_um, 290.0);
}

TEST(DeflectionBowl, SaysWhyReadingsCannotBeRight) {
    EXPECT_EQ(rejection(station({{0, 500}, {200, 300}, {300, 310}, {600, 90}})),
              "the deflection rises from 300 um at 200 mm to 310 um at 300 mm");
    EXPECT_EQ(rejection(station({{0, 500}, {200, 300}, {300, 302}, {600, 90}})), "none"); // the sensors resolve 2 um
    EXPECT_EQ(rejection(station({{200, 300}, {300, 200}})), "no reading at the centre of the load (D0)");
    EXPECT_EQ(rejection(station({})), "no reading at the centre of the load (D0)");
    EXPECT_EQ(rejection(station({{0, 500}, {900, -1}})), "drop 1: a deflection of -1 um at 900 mm");
    FwdStation s = station({{0, 500}, {300, 200}});
    s.drops[0].pressure_kPa = -600;
    EXPECT_EQ(rejection(s), "drop 1: a pressure of -600 kPa");
    s.drops[0].pressure_kPa = NAN;
    EXPECT_EQ(rejection(s), "drop 1: a pressure of nan kPa");
    s = station({{0, 500}, {300, 200}});
    s.drops.push_back(s.drops[0]);
    EXPECT_EQ(rejection(s), "drop 1 stands twice");
    s.drops[1] = {2, 225, 600, s.drops[0].readings};
    EXPECT_EQ(rejection(s), "plates of radius 150 and 225 mm");
}

// The study takes the station's plate, pressure, sensors and deflections; unless it states where the wall stands, the
// wall makes room for the farthest sensor (README: the most of 4 m, twice the depth, twice the farthest sensor).
TEST(StationStudy, TakesLoadAndDeflectionsOfTheStation) {
    const std::string file = test::own_folder() + "station.toml";
    std::ofstream(file) << R"(schema = 1
[[layers]]
name = "soil"
thickness_mm = 1500
density_kg_m3 = 1900
k0 = 0.5
law = "linear"
modulus_MPa = 60
poisson = 0.4
[[loads]]
name = "fwd"
type = "plate"
radius_mm = 150
pressure_kPa = 600
[data]
files = ["nowhere.csv"]
misfit = "relative"
[[parameters]]
name = "soil.modulus_MPa"
min = 20
max = 300
)";
    const study::Study survey = study::load_survey_study(file);
    FwdStation s = station({{0, 500}, {300, 200}, {2500, 20}});
    s.drops[0].radius_mm = 225;
    s.drops[0].pressure_kPa = 300;
    const auto bowl = data::bowl_of(s);
    ASSERT_TRUE(bowl) << bowl.failure().reason;
    const study::Study study = study::station_study(survey, s, *bowl);
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
    EXPECT_NE(study::station_study(survey, s, *data::bowl_of(s)).hash, study.hash);
}
