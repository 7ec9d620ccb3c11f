// The files that falling weight deflectometers write.
#include "base/error.h"
#include "data/deflection_bowl.h"
#include "data/fwd.h"
#include "support/folder.h"

#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <numbers>

using namespace explore;

namespace {

std::vector<data::FwdStation> read(const std::string& text, const char* name) {
    const std::string file = test::own_folder() + name;
    std::ofstream(file, std::ios::binary) << text;
    return data::read_fwd(file);
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
    EXPECT_DOUBLE_EQ(stations[0].chainage_m, 1250.0); // 1.250 km
    EXPECT_DOUBLE_EQ(*stations[0].surface_C, 25.0);   // 77 F
    EXPECT_DOUBLE_EQ(*stations[0].air_C, 10.0);       // 50 F
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
    EXPECT_DOUBLE_EQ(stations[1].chainage_m, 304.8); // 1000 feet
    EXPECT_FALSE(stations[1].surface_C || stations[1].air_C);
}

TEST(F25, SaysWhatIsWrongAndWhere) {
    EXPECT_NE(complaint(f25_head, "a.f25").find("no drops"), std::string::npos);
    const std::string short_drop = complaint(f25_head + "5301,1,1,4,3, 1.2,1,1,\"R\"\n 1, 574, 434\n", "a.f25");
    EXPECT_NE(short_drop.find(":11"), std::string::npos) << short_drop;
    EXPECT_NE(short_drop.find("too short"), std::string::npos) << short_drop;
    const std::string word = complaint(f25_head + "5301,1,1,4,3, x,1,1,\"R\"\n", "a.f25");
    EXPECT_NE(word.find("station"), std::string::npos) << word;
    EXPECT_NE(complaint("5001,25\n 1, 574, 434\n", "a.f25").find("before any station"), std::string::npos);
    EXPECT_NE(complaint("5001,25\n5301,1,1,4,12, 1.2,1,1,\"R\"\n", "a.f25").find("unknown unit"), std::string::npos);
    // A number that no unit has: found by the fuzzer, on its way into an integer.
    EXPECT_NE(complaint("5001,25\n5301,1,1,4,3e86, 1.2,1,1,\"R\"\n", "a.f25").find("unknown unit"), std::string::npos);
}

TEST(Pddx, GivesStationsDropsAndSensorsInItsOwnUnits) {
    const auto stations = read(pddx, "a.ddx");
    ASSERT_EQ(stations.size(), 1U);
    EXPECT_EQ(stations[0].lane, "R1");
    EXPECT_DOUBLE_EQ(stations[0].chainage_m, 125.0);
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
    EXPECT_NE(with("DropData_2 = 50; 12; 10; 8", "DropData_2 = 50; 12").find("wrong number of values"),
              std::string::npos);
    EXPECT_NE(with("Sensors = 3", "Sensors = 4").find("not one distance a sensor"), std::string::npos);
    EXPECT_NE(with("LoadPlateRadius = 150", "Radius = 150").find("LoadPlateRadius"), std::string::npos);
    EXPECT_NE(with("0,125", "somewhere").find("TestLocation"), std::string::npos);
    EXPECT_NE(with("[Units]", "[Units").find("never closed"), std::string::npos);
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
    EXPECT_DOUBLE_EQ(stations[0].chainage_m, 15.2);
    EXPECT_DOUBLE_EQ(*stations[0].surface_C, 31.5);
    EXPECT_DOUBLE_EQ(*stations[0].air_C, 24.0);
    EXPECT_EQ(stations[0].line, 2);
    ASSERT_EQ(stations[0].drops.size(), 2U);
    const data::FwdDrop& drop = stations[0].drops[0];
    EXPECT_EQ(drop.radius_mm, 150.0);
    EXPECT_EQ(drop.pressure_kPa, 602.0);
    ASSERT_EQ(drop.readings.size(), 3U);
    EXPECT_EQ(drop.readings[2].offset_mm, 305.0); // behind the plate, as far from its centre
    EXPECT_EQ(drop.readings[2].deflection_um, 298.0);
    EXPECT_EQ(stations[0].drops[1].readings.size(), 2U); // one was not read
    const auto bowl = data::bowl_of(stations[0]);
    ASSERT_TRUE(bowl);
    EXPECT_EQ(bowl->readings.size(), 2U);
}

TEST(Ltpp, AStationTheOtherTablesDoNotKnowIsSaidAndStopsNothing) {
    const auto stations = LtppTables().stations();
    ASSERT_EQ(stations.size(), 3U);
    EXPECT_NE(data::bowl_of(stations[1]).failure().reason.find("MON_DEFL_LOC_INFO"), std::string::npos);
    EXPECT_NE(data::bowl_of(stations[2]).failure().reason.find("configuration 1002"), std::string::npos);
}

TEST(Ltpp, SaysWhatIsWrongAndWhere) {
    LtppTables alone;
    alone.sensors.clear();
    EXPECT_NE(alone.complaint().find("MON_DEFL_DEV_SENSORS"), std::string::npos) << alone.complaint();
    LtppTables word;
    word.drops.replace(word.drops.find("597"), 3, "5x7");
    EXPECT_NE(word.complaint().find(":3: DROP_LOAD"), std::string::npos) << word.complaint();
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
