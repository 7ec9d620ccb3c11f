// The files that falling weight deflectometers write.
#include "base/error.h"
#include "data/deflection_bowl.h"
#include "data/fwd.h"
#include "support/folder.h"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <numbers>

using namespace explore;

namespace {

std::vector<data::FwdStation> read(const std::string& text, const char* name) {
    const std::string file = test::own_folder() + name;
    std::ofstream(file, std::ios::binary) << text;
    return data::read_fwd(file).stations;
}

std::string complaint(const std::string& text, const char* name) {
    try {
        read(text, name);
    } catch (const pave::Error& error) {
        return error.what();
    }
    return "";
}

const std::string f25_head = "5001,25.10,1,40, 3, 1,\"made for a test\"\r\n"
                             "5010,0,0,0,0,0,0,0,3,0\r\n"
                             "5020,   150,     0,   200,N0    ,   300,N0    \r\n"
                             "5021,   300,     0,     0,N0    ,   400,N0    \r\n"
                             "5030,\"Smith, John\"\r\n"
                             "5301,0,1,4,3,  31.500,1,1,\"L1 \",1991,06,05,20,07\r\n" // at the end of the survey
                             "5302,0,0,0,1,0,0,0,0,\"closing\"\r\n"
                             "5303,0, 24.0, 27.0, 25.0\r\n"
                             "5041,\"no comment\"\r\n";

const std::string f25_body = "5280,0,400743,+52.0,+5.0,3.7\r\n"
                             "5301,1,1,4,3,   1.250,1,1,\"R  \",1991,06,05,19,07\r\n"
                             "5303,1, 68.0, 77.0, 50.0\r\n"
                             "   1,  0574,   434,   396,     0,   375, 29.75\r\n"
                             "   2,   700,   530,   480,     0,   455\r\n"
                             "5185,3,60\r\n"
                             "1001,0.1,0.2,0.3\r\n"
                             "5301,1,1,4,5,    1000,1,1,\"R  \",1991,06,05,19,12\r\n"
                             "5303,0, 18.0, 22.17.7\r\n" // as real files have them
                             "   1,   580,   300,   250,     0,   200\r\n\x1a";

const std::string pddx = "[Pavement Deflection Data Exchange File]\n"
                         "PDDXVersionNumber = 1.0\n"
                         "DelimiterSymbol = ;\n"
                         "DecimalSymbol = ,\n"
                         "[Units]\n"
                         "LoadPlateRadiusUnits = millimeter\n"
                         "LoadUnits = kilo-Newton\n"
                         "DeflectionUnits = mils\n"
                         "TemperatureUnits = Fahrenheit\n"
                         "SensorLocationUnits = inches\n"
                         "TestLocationUnits = kilometer;meter;meter\n"
                         "[Device Configuration]\n"
                         "LoadPlateRadius = 150\n"
                         "NumberOfDeflectionSensors = 3\n"
                         "DeflectionSensorXAxisDistances = 0; 12; 0\n"
                         "DeflectionSensorYAxisDistances = 0; 0; 24\n"
                         "TemperatureSensorUse = air;surface\n"
                         "[Location Identification]\n"
                         "SiteName = [somewhere] = here\n"
                         "[Test Location 1]\n"
                         "TestLocation = 0,125;0;0\n"
                         "TestLane = R1\n"
                         "TestTemperatures = 50;77\n"
                         "NumberOfDrops = 2\n"
                         "DropData_1 = 40,5; 10; 8; 6,5\n"
                         "DropData_2 = 50; 12; 10; 8\n";

} // namespace

TEST(F25, GivesStationsDropsAndSensors) {
    const auto stations = read(f25_head + f25_body, "a.f25");
    ASSERT_EQ(stations.size(), 2U); // the head's own station has no drops
    EXPECT_EQ(stations[0].lane, "R");
    EXPECT_DOUBLE_EQ(*stations[0].chainage_m, 1250.0); // 1.250 km
    EXPECT_DOUBLE_EQ(*stations[0].surface_C, 25.0);    // 77 F
    EXPECT_DOUBLE_EQ(*stations[0].air_C, 10.0);        // 50 F
    EXPECT_EQ(stations[0].line, 13);
    ASSERT_EQ(stations[0].drops.size(), 2U);
    const data::FwdDrop& drop = stations[0].drops[0];
    EXPECT_EQ(drop.number, 1);
    EXPECT_EQ(drop.radius_mm, 150.0);
    EXPECT_EQ(drop.pressure_kPa, 574.0);
    ASSERT_EQ(drop.readings.size(), 3U); // what follows the last sensor is none
    EXPECT_EQ(drop.readings[1].offset_mm, 200.0);
    EXPECT_EQ(drop.readings[1].deflection_um, 396.0);
    EXPECT_EQ(drop.readings[2].offset_mm, 500.0); // x = 300, y = 400
    EXPECT_EQ(drop.readings[2].deflection_um, 375.0);
    EXPECT_DOUBLE_EQ(*stations[1].chainage_m, 304.8); // 1000 feet
    EXPECT_FALSE(stations[1].surface_C || stations[1].air_C);
}

TEST(F25, ReadsTimeAndPosition) {
    const auto stations = read(f25_head + f25_body, "a.f25");
    EXPECT_EQ(stations[0].date, "1991-06-05");
    EXPECT_EQ(stations[0].time, "19:07");
    EXPECT_EQ(stations[0].latitude, 52.0);
    EXPECT_EQ(stations[0].longitude, 5.0);
    EXPECT_FALSE(stations[1].latitude); // it has none of its own
}

TEST(F25, WhatIsMissingCostsThatReadingAndNothingElse) {
    const std::string head = "5001,25\n5020, 150, 0, 200, 300\n5021, 300, 0, N0, N0\n";
    const std::string station = "5301,1,1,4,2, 205,1,1,\"R\"\n";
    for (const char* nil : {"N0", "", "nan", "-", "N/A", "x"}) {
        const auto stations = read(head + station + "5303,0,N0,nan,-\n1, 600, 500, " + nil + ", 300\n", "a.f25");
        ASSERT_EQ(stations[0].drops[0].readings.size(), 2U) << nil;
        EXPECT_EQ(stations[0].drops[0].readings[1].offset_mm, 300.0);
        EXPECT_FALSE(stations[0].asphalt_C || stations[0].surface_C || stations[0].air_C);
    }
    // A line that ends early, a zero byte in a serial number.
    EXPECT_EQ(read(head + station + "1, 600, 500\n", "a.f25")[0].drops[0].readings.size(), 1U);
    const std::string zeros = std::string("5002,\"") + '\0' + '\0' + "\"\n";
    EXPECT_EQ(read("5001,25\n" + zeros + head.substr(8) + station + "1, 600, 500, 400, 300\n", "a.f25").size(), 1U);
    // A station without a place, by number or by unit, keeps its drops.
    for (const char* line :
         {"5301,1,1,4,2, N0,1,1,\"R\"\n", "5301,1,1,4,12, 205,1,1,\"R\"\n", "5301,1,1,4,3e86, 1,1,1\n", "5301\n"}) {
        const auto stations = read(head + line + "1, 600, 500, 400, 300\n", "a.f25");
        ASSERT_EQ(stations.size(), 1U);
        EXPECT_FALSE(stations[0].chainage_m) << line;
        EXPECT_EQ(stations[0].remarks.size(), 1U) << line;
    }
    // The radius from the diameter.
    EXPECT_EQ(read("5001,25\n5020, N0, 0, 200\n5021, 450, 0, 0\n" + station + "1, 600, 500, 400\n", "a.f25")[0]
                  .drops[0]
                  .radius_mm,
              225.0);
}

TEST(F25, SensorsBehindThePlateKeepTheirSide) {
    const auto stations = read("5001,25\n5020, 150, -200, 0, 200\n5021, 300, 0, 0, 0\n5301,1,1,4,2, 205,1,1,\"R\"\n"
                               "1, 600, 70, 500, 71\n",
                               "a.f25");
    EXPECT_EQ(stations[0].drops[0].readings[0].offset_mm, -200.0);
}

TEST(F25, SaysWhatIsWrongAndWhere) {
    EXPECT_NE(complaint(f25_head, "a.f25").find("no drops"), std::string::npos);
    EXPECT_NE(complaint("5001,25\n 1, 574, 434\n", "a.f25").find("before any station"), std::string::npos);
    const std::string sensor = complaint("5001,25\n5020, 150, N0, far\n", "a.f25");
    EXPECT_NE(sensor.find(":2"), std::string::npos) << sensor;
}

TEST(Pddx, GivesStationsDropsAndSensorsInItsOwnUnits) {
    const auto stations = read(pddx, "a.ddx");
    ASSERT_EQ(stations.size(), 1U);
    EXPECT_EQ(stations[0].lane, "R1");
    EXPECT_DOUBLE_EQ(*stations[0].chainage_m, 125.0);
    EXPECT_DOUBLE_EQ(*stations[0].air_C, 10.0);
    EXPECT_DOUBLE_EQ(*stations[0].surface_C, 25.0);
    ASSERT_EQ(stations[0].drops.size(), 2U);
    const data::FwdDrop& drop = stations[0].drops[0];
    EXPECT_DOUBLE_EQ(drop.radius_mm, 150.0);
    EXPECT_NEAR(drop.pressure_kPa, 40.5 / (std::numbers::pi * 0.15 * 0.15), 1e-9);
    ASSERT_EQ(drop.readings.size(), 3U);
    EXPECT_NEAR(drop.readings[1].offset_mm, 304.8, 1e-9);
    EXPECT_NEAR(drop.readings[2].offset_mm, 609.6, 1e-9);
    EXPECT_NEAR(drop.readings[0].deflection_um, 254.0, 1e-9); // 10 mils
    EXPECT_NEAR(drop.readings[2].deflection_um, 165.1, 1e-9);
}

TEST(Pddx, SaysWhatIsWrongAndWhere) {
    const auto with = [](std::string_view old, std::string_view now) {
        std::string text = pddx;
        text.replace(text.find(old), old.size(), now);
        return complaint(text, "a.ddx");
    };
    EXPECT_NE(with("kilo-Newton", "stone").find("unknown unit"), std::string::npos);
    const std::string distances = with("= 0; 12; 0\n", "= 0; 12; 24; 36; 48\n");
    EXPECT_NE(distances.find("5 distances, 3 sensors (line 14), 3 deflections"), std::string::npos) << distances;
    EXPECT_NE(with("LoadPlateRadius = 150", "Radius = 150").find("LoadPlateRadius"), std::string::npos);
    EXPECT_NE(with("[Units]", "[Units").find("never closed"), std::string::npos);
}

TEST(Pddx, WhatIsMissingCostsThatReadingAndNothingElse) {
    const auto with = [](std::string_view old, std::string_view now) {
        std::string text = pddx;
        text.replace(text.find(old), old.size(), now);
        return read(text, "a.ddx")[0];
    };
    EXPECT_EQ(with("50; 12; 10; 8", "50; 12").drops[1].readings.size(), 1U); // a short line
    EXPECT_NEAR(with("50; 12; 10; 8", "50; N/A; 10; 8").drops[1].readings[0].deflection_um, 254.0, 1e-9);
    EXPECT_TRUE(std::isnan(with("50; 12; 10; 8", "-; 12; 10; 8").drops[1].pressure_kPa));
    EXPECT_TRUE(std::isnan(with("50; 12; 10; 8", "50; 12; 10; 8; 7").drops[1].pressure_kPa)); // one too many: which?
    EXPECT_FALSE(with("0,125", "somewhere").chainage_m);
}

TEST(Pddx, TheLoadCellMayBeCountedAmongTheDistances) {
    std::string text = pddx;
    text.replace(text.find("= 0; 12; 0\n"), 11, "= 0; 0; 12; 24\n");
    text.replace(text.find("= 0; 0; 24\n"), 11, "= 0; 0; 0\n");
    const std::string file = test::own_folder() + "a.ddx";
    std::ofstream(file) << text;
    const data::FwdFile read = data::read_fwd(file);
    ASSERT_EQ(read.stations[0].drops[0].readings.size(), 3U);
    EXPECT_EQ(read.stations[0].drops[0].readings[0].offset_mm, 0.0);
    EXPECT_NEAR(read.stations[0].drops[0].readings[2].offset_mm, 609.6, 1e-9);
    ASSERT_EQ(read.remarks.size(), 1U);
    EXPECT_NE(read.remarks[0].find("line 15 has 4 distances, line 14 states 3 sensors"), std::string::npos)
        << read.remarks[0];
}

TEST(Pddx, PoundsOfForceHaveManyNames) {
    for (const char* name : {"pounds-force", "pound-force", "lbs", "lbf", "lb", "Pounds Force"}) {
        std::string text = pddx;
        text.replace(text.find("kilo-Newton"), 11, name);
        // 40.5 lbf = 40.5 x 4.4482216 N
        EXPECT_NEAR(read(text, "a.ddx")[0].drops[0].pressure_kPa, 0.0405 * 4.4482216 / (std::numbers::pi * 0.15 * 0.15),
                    1e-6)
            << name;
    }
}

namespace {

// The four tables, in the form of an export: another order of columns and other columns too, a sensor behind the plate,
// an identifier that one table writes 06 and another 6.
struct LtppTables {
    std::string drops = "SHRP_ID,STATE_CODE,CONSTRUCTION_NO,LANE_NO,TEST_DATE,TEST_TIME,DEFL_UNIT_ID,POINT_LOC,DROP_NO,"
                        "DROP_HEIGHT,DROP_LOAD,PEAK_DEFL_1,PEAK_DEFL_2,PEAK_DEFL_3,NON_DECREASING_DEFL,RECORD_STATUS\n"
                        "1253,6,1,F3,5/15/2003 0:00,935,51,15.2,1,2,602,410,305,298,,E\n"
                        "1253,6,1,F3,5/15/2003 0:00,935,51,15.2,2,2,597,405,300,,,E\n"
                        "1253,6,1,F3,5/15/2003 0:00,940,51,30.5,1,2,601,420,310,300,,E\n"
                        "1253,6,1,F3,5/15/2003 0:00,945,51,45.7,1,2,601,420,310,300,,E\n";
    std::string places = "STATE_CODE,SHRP_ID,LANE_NO,TEST_DATE,TEST_TIME,DEFL_UNIT_ID,POINT_LOC,CONFIGURATION_NO,"
                         "PVMT_SURF_TEMP,AIR_TEMP_TEST\n"
                         "06,1253,F3,5/15/2003 0:00,0935,51,15.2,1001,31.5,24\n"
                         "06,1253,F3,5/15/2003 0:00,0945,51,45.7,1002,,24\n";
    std::string devices = "CONFIGURATION_NO,NO_ACTIVE_DEFLECTORS,PLATE_RADIUS\n1001,3,150\n";
    std::string sensors = "CONFIGURATION_NO,SENSOR_NO,CENTER_OFFSET,CENTER_OFFSET_FLAG\n"
                          "1001,1,0,\n1001,2,305,\n1001,3,-305,\n";

    std::vector<data::FwdStation> stations() const {
        const std::string folder = test::own_folder();
        for (const auto& [name, text] :
             {std::pair{"a mon_defl_loc_info.CSV", places}, std::pair{"a MON_DEFL_DEV_CONFIG.csv", devices},
              std::pair{"a MON_DEFL_DEV_SENSORS.csv", sensors}}) {
            std::filesystem::remove(folder + name);
            if (!text.empty()) {
                std::ofstream(folder + name, std::ios::binary) << text;
            }
        }
        return read(drops, "a MON_DEFL_DROP_DATA.csv");
    }
    std::string complaint() const {
        try {
            stations();
        } catch (const pave::Error& error) {
            return error.what();
        }
        return "";
    }
};

} // namespace

TEST(Ltpp, JoinsTheFourTables) {
    const auto stations = LtppTables().stations();
    ASSERT_EQ(stations.size(), 3U);
    EXPECT_EQ(stations[0].name, "6-1253 5/15/2003");
    EXPECT_EQ(stations[0].lane, "F3");
    EXPECT_DOUBLE_EQ(*stations[0].chainage_m, 15.2);
    EXPECT_DOUBLE_EQ(*stations[0].surface_C, 31.5);
    EXPECT_DOUBLE_EQ(*stations[0].air_C, 24.0);
    EXPECT_EQ(stations[0].line, 2);
    ASSERT_EQ(stations[0].drops.size(), 2U);
    const data::FwdDrop& drop = stations[0].drops[0];
    EXPECT_EQ(drop.radius_mm, 150.0);
    EXPECT_EQ(drop.pressure_kPa, 602.0);
    ASSERT_EQ(drop.readings.size(), 3U);
    EXPECT_EQ(drop.readings[2].offset_mm, -305.0); // behind the plate
    EXPECT_EQ(drop.readings[2].deflection_um, 298.0);
    EXPECT_EQ(stations[0].drops[1].readings.size(), 2U); // one was not read
    const auto bowl = data::bowls_of(stations[0]);
    ASSERT_TRUE(bowl);
    EXPECT_EQ(bowl->bowl().readings.size(), 2U);
}

TEST(Ltpp, AStationTheOtherTablesDoNotKnowIsSaidAndStopsNothing) {
    const auto stations = LtppTables().stations();
    ASSERT_EQ(stations.size(), 3U);
    EXPECT_NE(data::bowls_of(stations[1]).failure().reason.find("MON_DEFL_LOC_INFO"), std::string::npos);
    EXPECT_NE(data::bowls_of(stations[2]).failure().reason.find("configuration 1002"), std::string::npos);
}

TEST(Ltpp, SectionsAndDatesStayApart) {
    LtppTables tables;
    tables.drops += "0501,6,1,F3,5/16/2003 0:00,935,51,15.2,1,2,601,420,310,300,,E\n";
    const auto stations = tables.stations();
    ASSERT_EQ(stations.size(), 4U);
    EXPECT_EQ(stations[0].profile, "6-1253 5/15/2003");
    EXPECT_EQ(stations[3].profile, "6-0501 5/16/2003");
}

TEST(Ltpp, DropsThatTheDatabaseFlagsAreLeftOut) {
    LtppTables tables;
    tables.drops.replace(tables.drops.find("405,300,,,E"), 11, "3,300,,1,D ");
    const auto stations = tables.stations();
    EXPECT_EQ(stations[0].drops[0].flag, "");
    EXPECT_EQ(stations[0].drops[1].flag, "RECORD_STATUS D");
    const auto bowls = data::bowls_of(stations[0]);
    ASSERT_TRUE(bowls);
    EXPECT_EQ(bowls->bowl().drops, std::vector{1});
    ASSERT_EQ(bowls->left_out.size(), 1U);
    EXPECT_EQ(bowls->left_out[0].why, data::LeftOut::flagged);
    tables.drops.replace(tables.drops.find("1,D "), 3, "1,E");
    EXPECT_EQ(tables.stations()[0].drops[1].flag, "NON_DECREASING_DEFL 1");
}

TEST(Ltpp, WhatIsMissingCostsThatReadingAndNothingElse) {
    LtppTables tables;
    tables.drops.replace(tables.drops.find("597"), 3, "N/A");
    EXPECT_TRUE(std::isnan(tables.stations()[0].drops[1].pressure_kPa));
    tables.drops += "1253,6,1,F3,5/15/2003 0:00,935,51,15.2,3,2,602,410\n"; // a short line
    EXPECT_EQ(tables.stations()[0].drops[2].readings.size(), 1U);
}

TEST(Ltpp, SaysWhatIsWrongAndWhere) {
    LtppTables alone;
    alone.sensors.clear();
    EXPECT_NE(alone.complaint().find("MON_DEFL_DEV_SENSORS"), std::string::npos) << alone.complaint();
    LtppTables nameless;
    nameless.devices.replace(nameless.devices.find("PLATE_RADIUS"), 12, "RADIUS");
    EXPECT_NE(nameless.complaint().find("PLATE_RADIUS"), std::string::npos) << nameless.complaint();
    LtppTables half;
    half.sensors.replace(half.sensors.find("1001,2"), 6, "1001,2.5");
    EXPECT_NE(half.complaint().find("whole number"), std::string::npos) << half.complaint();
}

TEST(FwdFile, OfNoKnownFormatIsMetWithTheSignsOfAllThatAre) {
    const std::string text = complaint("hello\n", "a.txt");
    EXPECT_NE(text.find("F25"), std::string::npos);
    EXPECT_NE(text.find("PDDX"), std::string::npos);
}
