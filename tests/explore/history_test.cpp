// Histories and readings in time: what is read, and how errors at two times are tied.
#include "data/history.h"
#include "data/noise.h"
#include "data/reading.h"

#include <cmath>
#include <gtest/gtest.h>

using namespace explore;

TEST(History, IsReadFromColumnsInAnyOrderWithOthersBeside) {
    const auto force =
        data::history_of("# a drop\nD1,force_kN,time_ms\n0.1,-0.5,-2\n0.2,50,3.5\n0.1,0,10\n", "drop.csv");
    EXPECT_TRUE(force.is_force);
    EXPECT_EQ(force.time_ms, (std::vector<double>{-2.0, 3.5, 10.0}));
    EXPECT_EQ(force.values, (std::vector<double>{-0.5, 50.0, 0.0}));
    EXPECT_FALSE(data::history_of("time_ms,pressure_kPa\n0,0\n1,700\n", "drop.csv").is_force);
}

TEST(History, LeavesReadingsWithoutTimesAsTheyWere) {
    const std::string header(data::measurement_header());
    const auto plain = data::measurements_of(header + "\nfwd,deflection,300,0,0,0,0.5,mm,\n", "a.csv");
    EXPECT_FALSE(plain[0].time_ms);
    EXPECT_EQ(plain[0].label(), "fwd.deflection@300,0,0");
    EXPECT_EQ(data::measurement_rows(plain), header + "\nfwd,deflection,300,0,0,0,0.5,mm,\n");
}

TEST(History, TellsReadingsOfOnePlaceApartByTheirTimes) {
    const std::string text = "time_ms," + std::string(data::measurement_header()) +
                             "\n12.5,fwd,deflection,300,0,0,0,0.5,mm,\n,fwd,deflection,300,0,0,0,0.6,mm,0.1\n";
    const auto readings = data::measurements_of(text, "a.csv");
    ASSERT_TRUE(readings[0].time_ms);
    EXPECT_EQ(*readings[0].time_ms, 12.5);
    EXPECT_FALSE(readings[1].time_ms);
    EXPECT_EQ(readings[0].label(), "fwd.deflection@300,0,0,12.5ms");
    EXPECT_EQ(readings[0].words(), "deflection at 300 mm under fwd at 12.5 ms");
    EXPECT_EQ(readings[0].place_words(), readings[1].place_words());
    EXPECT_EQ(data::measurement_rows(readings), text);
}

TEST(History, TiesErrorsAtTwoTimes) {
    const auto at = [](double x, std::optional<double> time) {
        return data::NoisePlace{.load = 0, .x = x, .time = time};
    };
    EXPECT_DOUBLE_EQ(data::own_correlation(at(0.0, 0.01), at(0.0, 0.015), 0.0, 0.005), std::exp(-1.0));
    EXPECT_DOUBLE_EQ(data::own_correlation(at(0.0, 0.01), at(3.0, 0.015), 1.5, 0.005), std::exp(-3.0));
    EXPECT_EQ(data::own_correlation(at(0.0, 0.01), at(3.0, 0.01), 0.0, 0.005), 0.0);       // another sensor
    EXPECT_EQ(data::own_correlation(at(0.0, 0.01), at(0.0, 0.02), 1.5, 0.0), 0.0);         // another time
    EXPECT_EQ(data::own_correlation(at(0.0, 0.01), at(0.0, std::nullopt), 1.5, 1.0), 0.0); // the load as a whole
    EXPECT_EQ(data::own_correlation(at(0.0, 0.01), at(0.0, 0.01), 1.5, 0.0), 1.0);
}
