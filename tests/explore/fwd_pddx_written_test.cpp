// Stations written as PDDX and read again are the stations.
#include "data/fwd_pddx_written.h"
#include "support/folder.h"

#include <cmath>
#include <fstream>
#include <gtest/gtest.h>

namespace explore {
namespace {

data::FwdFile read_again(const std::string& text) {
    const std::string file = test::own_folder() + "again.ddx";
    std::ofstream(file, std::ios::binary) << text;
    return data::read_fwd(file);
}

data::FwdStation station(double chainage, double radius, std::vector<data::FwdReading> readings) {
    data::FwdStation s{.name = "anything", .lane = "R1", .chainage_m = chainage, .date = "2024-05-06", .file = {}};
    s.drops.push_back({.number = 2, .radius_mm = radius, .pressure_kPa = 566.1, .readings = readings});
    s.drops.push_back({.number = 3, .radius_mm = radius, .pressure_kPa = 708.25, .readings = readings});
    return s;
}

TEST(PddxWritten, GivesStationsBack) {
    data::FwdFile file;
    file.stations.push_back(station(1250.125, 150.0, {{-300.0, 300.1}, {0.0, 512.3}, {300.0, 301.7}}));
    auto& s = file.stations[0];
    s.time = "13:15";
    s.comment = "crack = wide,\nthen [patch]";
    s.latitude = 48.9712345;
    s.longitude = -2.5;
    s.air_C = 15.5;
    s.asphalt_C = 21.25;                                                                 // and no surface
    file.stations.push_back(station(1300.0, 150.0, {{0.0, 100.0}, {900.0, 0.1 + 0.2}})); // another layout
    file.stations[1].drops[1].pressure_kPa = NAN;
    const auto texts = data::pddx_of({&file, 1});
    ASSERT_EQ(texts.size(), 1U);
    const auto again = read_again(texts[0]);
    EXPECT_TRUE(again.remarks.empty()) << again.remarks[0];
    ASSERT_EQ(again.stations.size(), 2U);
    for (std::size_t i = 0; i < 2; ++i) {
        const auto& then = file.stations[i];
        const auto& now = again.stations[i];
        EXPECT_TRUE(now.remarks.empty()) << now.remarks[0];
        EXPECT_EQ(now.chainage_m, then.chainage_m);
        EXPECT_EQ(now.lane, then.lane);
        EXPECT_EQ(now.date, then.date);
        EXPECT_EQ(now.time, then.time);
        EXPECT_EQ(now.latitude, then.latitude);
        EXPECT_EQ(now.longitude, then.longitude);
        EXPECT_EQ(now.air_C, then.air_C);
        EXPECT_EQ(now.surface_C, then.surface_C);
        EXPECT_EQ(now.asphalt_C, then.asphalt_C);
        ASSERT_EQ(now.drops.size(), 2U);
        for (std::size_t d = 0; d < 2; ++d) {
            EXPECT_EQ(now.drops[d].number, then.drops[d].number);
            EXPECT_DOUBLE_EQ(now.drops[d].radius_mm, then.drops[d].radius_mm);
            EXPECT_TRUE(std::isnan(then.drops[d].pressure_kPa)
                            ? std::isnan(now.drops[d].pressure_kPa)
                            : std::abs(now.drops[d].pressure_kPa - then.drops[d].pressure_kPa) < 1e-9);
            ASSERT_EQ(now.drops[d].readings.size(), then.drops[d].readings.size());
            for (std::size_t r = 0; r < now.drops[d].readings.size(); ++r) {
                EXPECT_DOUBLE_EQ(now.drops[d].readings[r].offset_mm, then.drops[d].readings[r].offset_mm);
                EXPECT_DOUBLE_EQ(now.drops[d].readings[r].deflection_um, then.drops[d].readings[r].deflection_um);
            }
        }
    }
    EXPECT_EQ(again.stations[0].comment, "crack = wide, then [patch]");
}

TEST(PddxWritten, ForcesStayForces) {
    data::FwdFile file;
    file.stations.push_back(station(10.0, 150.0, {{0.0, 512.3}}));
    for (auto& drop : file.stations[0].drops) {
        drop.force_kN = 40.7;
    }
    const auto again = read_again(data::pddx_of({&file, 1})[0]);
    EXPECT_DOUBLE_EQ(*again.stations[0].drops[0].force_kN, 40.7);
    EXPECT_NEAR(again.stations[0].drops[0].pressure_kPa, 40.7 / (M_PI * 0.0225), 1e-9);
}

TEST(PddxWritten, PlatesDatesAndProfilesArePartedAndStationsWithoutDropsLeftOut) {
    data::FwdFile file;
    file.stations = {station(0.0, 150.0, {{0.0, 500.0}}),  station(10.0, 225.0, {{0.0, 500.0}}),
                     station(20.0, 150.0, {{0.0, 500.0}}), station(30.0, 150.0, {{0.0, 500.0}}),
                     station(40.0, 150.0, {{0.0, 500.0}}), station(50.0, 150.0, {{0.0, 500.0}})};
    file.stations[3].date = "2024-05-07";
    file.stations[4].profile = "A 6";
    file.stations[5].drops.clear();
    const auto texts = data::pddx_of({&file, 1});
    ASSERT_EQ(texts.size(), 4U);
    EXPECT_EQ(read_again(texts[0]).stations.size(), 2U);
    EXPECT_DOUBLE_EQ(read_again(texts[1]).stations[0].drops[0].radius_mm, 225.0);
    EXPECT_EQ(read_again(texts[2]).stations[0].date, "2024-05-07");
    EXPECT_NE(texts[3].find("SectionName = A 6"), std::string::npos);
}

} // namespace
} // namespace explore
