// Faults of the files of deflectometers: a missing value costs a reading, a drop or a station, at its own place, and is
// said.
#include "base/error.h"
#include "data/deflection_bowl.h"
#include "data/fwd.h"
#include "support/folder.h"

#include <cmath>
#include <fstream>
#include <gtest/gtest.h>

using namespace explore;

// Built as one source with the other tests.
namespace fwd_faults {

namespace {

data::FwdFile read(const std::string& text) {
    const std::string file = test::own_folder() + "road.fwd";
    std::ofstream(file, std::ios::binary) << text;
    return data::read_fwd(file);
}

std::string changed(std::string text, std::string_view old, std::string_view now) {
    text.replace(text.find(old), old.size(), now);
    return text;
}

bool says(const std::vector<std::string>& list, std::string_view words) {
    return pave::join(list, "\n").find(words) != std::string::npos;
}

// "0=500 200=400"
std::string readings_of(const data::FwdDrop& drop) {
    std::string words;
    for (const auto& r : drop.readings) {
        words += (words.empty() ? "" : " ") + std::to_string(std::lround(r.offset_mm)) + "=" +
                 std::to_string(std::lround(r.deflection_um));
    }
    return words;
}

const std::string f25 = "5001,25.60,1,40, 3, 1,\"made for a test\"\n"
                        "5020,   150,     0,   200,   300,   600,N0    \n"
                        "5021,   300,     0,     0,     0,     0,N0    \n"
                        "5301,0,1,3,3, 0.100,1,1,R       ,2024,05,14,07,30\n"
                        "5303,0, 16.4, 15.2, 19.0\n"
                        "   1,   700, 500, 400, 330, 180\n"
                        "   2,   702, 502, 401, 331, 181\n"
                        "5301,0,1,3,3, 0.200,1,1,R       ,2024,05,14,07,31\n"
                        "   1,   700, 510, 405, 333, 182\n";

const std::string primax = "(c) ROAD SYSTEM 2016, Metric\n"
                           "Date [dd/mm/yy]:.......\t12/04/2023\n"
                           "Load plate radius [mm].\t150\n"
                           "Radial offset [cm].....\t0\t20\t30\t60\n"
                           "$2\nChainage [m]...........\t0\nLane...................\tR\n"
                           "Drop\tD(1)\tD(2)\tD(3)\tD(4)\tkPa\tkN\tAir\tSur.\tMan.\n"
                           "1\t500\t400\t330\t180\t700\t49.5\t8.6\t2.9\t0.0\n"
                           "2\t501\t401\t331\t181\t701\t49.5\t8.6\t2.9\t0.0\n";

const std::string kuab = "IKUAB FWD FILE    : road.fwd\n"
                         "IPlate Radius     : 15.0 (cm)\n"
                         "ISensor Distance  : 0.0 20.0 30.0 60.0 (cm)\n"
                         "J    Dist Imp  Load   D0   D1   D2   D3  Air  Pav  Time\n"
                         "J       m num    kN   My   My   My   My    C    C  hh:mm:ss\n"
                         "D 200 1 50.0 500 400 330 180 30 31 13:56:00\n"
                         "D 250 1 50.0 510 405 333 182 30 31 13:57:00\n";

const std::string pddx = "[Pavement Deflection Data Exchange File]\n[Units]\nLoadPlateRadiusUnits = millimeter\n"
                         "LoadUnits = kilo-Pascal\nDeflectionUnits = micron\nTemperatureUnits = Celsius\n"
                         "SensorLocationUnits = millimeter\nTestLocationUnits = meter\n"
                         "[Device Configuration]\nLoadPlateRadius = 150\nNumberOfDeflectionSensors = 4\n"
                         "DeflectionSensorXAxisDistances = 0, 200, 300, 600\n"
                         "[Test Location 0]\nTestLocation = 0\nNumberOfDrops = 2\n"
                         "DropData_1 = 700,500,400,330,180\nDropData_2 = 701,501,401,331,181\n"
                         "[Test Location 1]\nTestLocation = 50\nDropData_1 = 700,510,405,333,182\n";

} // namespace

TEST(FormatFaults, AMissingPlaceMovesNoOtherSensor) {
    const auto expect = [](const std::string& text, const std::string& readings) {
        const auto file = read(text);
        EXPECT_EQ(readings_of(file.stations[0].drops[0]), readings) << text;
    };
    for (const char* nil : {"N0", "   ", "N/A", "three"}) {
        expect(changed(f25, "   300,   600,N0", std::string(nil) + ",   600,N0"), "0=500 200=400 600=180");
        expect(changed(pddx, " 300, 600", " " + std::string(nil) + ", 600"), "0=500 200=400 600=180");
        expect(changed(primax, "\t20\t30\t60", "\t20\t" + std::string(nil) + "\t60"), "0=500 200=400 600=180");
    }
    expect(changed(kuab, "20.0 30.0 60.0", "20.0 - 60.0"), "0=500 200=400 600=180");
    // One without a place among others had readings: the file says so.
    for (const std::string& text :
         {changed(f25, "   300,   600,N0", "N0,   600,N0"), changed(pddx, " 300, 600", " N0, 600"),
          changed(primax, "\t20\t30\t60", "\t20\t\t60"), changed(kuab, "20.0 30.0 60.0", "20.0 - 60.0")}) {
        EXPECT_FALSE(read(text).remarks.empty()) << text;
    }
    // The plate: its stations are rejected, not the file.
    for (const std::string& text : {changed(pddx, "LoadPlateRadius = 150", "LoadPlateRadius = N/A"),
                                    changed(kuab, "IPlate Radius     : 15.0", "IPlate Radius     : -"),
                                    changed(primax, "Load plate radius [mm].\t150", "Load plate radius [mm].\t-")}) {
        EXPECT_NE(data::bowls_of(read(text).stations[0]).failure().reason.find("radius of the plate is not stated"),
                  std::string::npos);
    }
}

TEST(FormatFaults, StationsWithoutDropsAreSaid) {
    const auto expect = [](const std::string& text, int line) {
        const auto stations = read(text).stations;
        ASSERT_EQ(stations.size(), 2U) << text;
        const auto empty = stations[0].drops.empty() ? stations[0] : stations[1];
        EXPECT_EQ(data::bowls_of(empty).failure().reason, "it has no drops");
        EXPECT_EQ(empty.line, line);
    };
    expect(f25.substr(0, f25.rfind("   1,")), 8);
    expect(primax + "$2\nChainage [m]...........\t20\nLane...................\tR\n", 12);
    expect(pddx.substr(0, pddx.rfind("DropData_1")), 18);
}

TEST(FormatFaults, DropsWhoseNumberIsNotToBeReadAreCounted) {
    for (const auto& s :
         {read(changed(f25, "   2,", "   X,")).stations[0], read(changed(f25, "   2,", "N0  ,")).stations[0],
          read(changed(primax, "\n2\t", "\n-\t")).stations[0], read(changed(primax, "\n2\t", "\n\t")).stations[0]}) {
        ASSERT_EQ(s.drops.size(), 2U);
        EXPECT_EQ(s.drops[1].number, 2);
        EXPECT_TRUE(says(s.remarks, "is not a drop number"));
    }
}

TEST(FormatFaults, ReadingsWithoutAPlaceAreSaid) {
    EXPECT_TRUE(says(read(changed(f25, "330, 180\n", "330, 180, 90, 40\n")).remarks, "more than line 5020 places"));
    EXPECT_TRUE(read(changed(f25, "330, 180\n", "330, 180, 15.2\n")).remarks.empty()); // a temperature that writers add
    const auto fewer = read(changed(kuab, "20.0 30.0 60.0", "20.0 30.0"));
    EXPECT_TRUE(says(fewer.remarks, "4 columns of deflections and 3 sensor distances"));
    EXPECT_EQ(readings_of(fewer.stations[0].drops[0]), "0=500 200=400 300=330");
    EXPECT_EQ(fewer.stations[0].air_C, 30.0); // not the last deflection
}

TEST(FormatFaults, AKuabLineThatIsShortCostsItsDrop) {
    for (const char* line : {"D 200 1 50.0 500 400 180 30 31 13:56:00", "D 200 1 50.0 500 40"}) {
        const auto stations = read(changed(kuab, "D 200 1 50.0 500 400 330 180 30 31 13:56:00", line)).stations;
        const auto made = data::bowls_of(stations[0]);
        ASSERT_FALSE(made) << line;
        EXPECT_NE(made.failure().reason.find("line 6"), std::string::npos) << made.failure().reason;
        EXPECT_FALSE(stations[0].air_C);
        EXPECT_TRUE(data::bowls_of(stations[1]));
    }
}

TEST(FormatFaults, PddxKeysThatStandAgain) {
    const auto twice = read(changed(pddx, "DropData_2", "DropData_1"));
    ASSERT_EQ(twice.stations[0].drops.size(), 2U);
    EXPECT_EQ(readings_of(twice.stations[0].drops[0]), "0=500 200=400 300=330 600=180");
    EXPECT_EQ(readings_of(twice.stations[0].drops[1]), "0=501 200=401 300=331 600=181");
    EXPECT_TRUE(says(twice.stations[0].remarks, "stands again"));
    const auto radius =
        read(changed(pddx, "LoadPlateRadius = 150\n", "LoadPlateRadius = 150\nLoadPlateRadius = 225\n"));
    EXPECT_EQ(radius.stations[0].drops[0].radius_mm, 150.0);
    EXPECT_TRUE(says(radius.remarks, "loadplateradius stands again"));
    EXPECT_TRUE(says(read(changed(pddx, "NumberOfDrops = 2", "NumberOfDrops = 4")).stations[0].remarks,
                     "states 4 drops; there are 2"));
    EXPECT_TRUE(read(pddx).stations[0].remarks.empty());
}

TEST(FormatFaults, PrimaxForceAndPressureThatDiffer) {
    EXPECT_TRUE(says(read(changed(primax, "700\t49.5", "700\t149.5")).stations[0].remarks, "the line states 700 kPa"));
    EXPECT_TRUE(read(primax).stations[0].remarks.empty()); // 49.5 kN / (pi 0.15^2 m2) = 700 kPa
    EXPECT_TRUE(says(read(changed(primax, "Chainage [m]", "Chainage [xx]")).stations[0].remarks, "taken for metres"));
}

} // namespace fwd_faults
