// The .fwd files of three makers of deflectometers. The layouts are those of public files, remade with few values.
#include "base/error.h"
#include "data/fwd.h"
#include "support/folder.h"

#include <cmath>
#include <fstream>
#include <gtest/gtest.h>
#include <numbers>

using namespace explore;

namespace {

std::vector<data::FwdStation> stations_of(const std::string& text) {
    const std::string file = test::own_folder() + "road.fwd";
    std::ofstream(file, std::ios::binary) << text;
    return data::read_fwd(file).stations;
}

std::string complaint(const std::string& text) {
    try {
        stations_of(text);
    } catch (const pave::Error& error) {
        return error.what();
    }
    return "none";
}

std::string changed(std::string text, std::string_view old, std::string_view now) {
    text.replace(text.find(old), old.size(), now);
    return text;
}

const std::string primax = "\r\n____\r\n(c) ROAD SYSTEM 2016, Metric\r\n$1\r\n"
                           "Date [dd/mm/yy]:.......\t12/04/2023\r\n"
                           "Load plate radius [mm].\t150\r\n"
                           "                       \tR(1)\tR(2)\tR(3)\r\n"
                           "Radial offset [cm].....\t-20\t0\t20\r\n"
                           "Tolerance [%]..........\t5\t5\t5\r\n"
                           "$2\r\nChainage [m]...........\t20\r\nLane...................\tR\r\n"
                           "Position of Drop:\tLongitude: 2\xb0"
                           "30'00.0000\"W\tLatitude: 48\xb0"
                           "58'26.1930\"N\tAltitude: 0.0 m\r\n"
                           "$3\r\nSequence: 1/1\tNo. of drops: 2\tFallheight: 0\tTime: 09:31\r\n\r\n"
                           "Drop\tD(1)\tD(2)\tD(3)\tkPa\tkN\tAir\tSur.\tMan.\tPulse time\r\n"
                           "1\t58.6\t114.5\t71.1\t822\t58.1\t8.6\t2.9\t4.0\t25.40\r\n"
                           "LoadCell (0)[kN].......\t-\t58.1\t0.1\t0.2\r\n"
                           "2\t58.2\t115,8\t72.0\t0\t58.0\t8.6\t2.9\t4.0\t25.40\r\n";

const std::string kuab = "IKUAB FWD FILE    : road.fwd\n"
                         "HLane             : LHS\n"
                         "IDate Created     : 12/04/2016\n"
                         "IPlate Radius     : 15.0 (cm)\n"
                         "ISensor Distance  : 0.0 20.0 30.0 (cm)\n"
                         "J    Dist Imp  Load   D0   D1   D2  Air  Pav  Emod    Time\n"
                         "J       m num    kN   My   My   My    C    C   MPa hh:mm:ss\n"
                         "D 200 1 41.5 388 184 124 30 31 0032.96315 03213.82190 13:56:00\n"
                         "D 200 2 41.3 380 180 122 30 31 95 0032.96315 03213.82190 13:56:10\n"
                         "D 250 2 41.3 402 - 128 30 31 0032.96415 03213.82290 13:58:00\n";

std::string r80(const std::string& drops) {
    std::string text =
        "R80    102    ROAD A\r\n70103300        69994.3703111  1\r\n"
        "150   0 200 300 600 90012001500  5.91  0.00  7.87 11.81 23.62 35.43 47.24 59.06\r\n"
        "   R  D1  D2  D3  D4  D5  D6  D7     R    D1    D2    D3    D4    D5    D6    D7\r\nC:\\ROADA\r\n"
        "S     0.00  8.600  3  0I20931   47   37   32\r\nS    20.00 10.300  8  0I21027   51   46   32\r\n"
        "12394260276336160       .302\r\n8   15  3.5 15  3   20  3   10\r\nLd 107 1.000 89.0\r\n"
        "*\r\n123.....\r\n1111111111\r\n*\r\n";
    return text + "G0000001+48.97+2.58999.9\r\nS     0.00  8.600  3  0I20931   47   37   32\r\n" + drops;
}

} // namespace

TEST(Primax, GivesStationsDropsAndSensors) {
    const auto stations = stations_of(primax);
    ASSERT_EQ(stations.size(), 1U);
    const data::FwdStation& s = stations[0];
    EXPECT_EQ(s.chainage_m, 20.0);
    EXPECT_EQ(s.lane, "R");
    EXPECT_EQ(s.date, "12/04/2023");
    EXPECT_EQ(s.time, "09:31");
    EXPECT_EQ(s.longitude, -2.5);
    EXPECT_NEAR(*s.latitude, 48.0 + 58.0 / 60.0 + 26.193 / 3600.0, 1e-9);
    EXPECT_EQ(s.air_C, 8.6);
    EXPECT_EQ(s.surface_C, 2.9);
    EXPECT_EQ(s.asphalt_C, 4.0);
    ASSERT_EQ(s.drops.size(), 2U); // the time history is none
    EXPECT_EQ(s.drops[0].radius_mm, 150.0);
    EXPECT_EQ(s.drops[0].pressure_kPa, 822.0);
    EXPECT_EQ(s.drops[0].readings[0].offset_mm, -200.0);
    EXPECT_EQ(s.drops[0].readings[1].deflection_um, 114.5);
    // Some writers put 0 for the pressure: 58 kN / (pi 0.15^2 m2).
    EXPECT_NEAR(s.drops[1].pressure_kPa, 58.0 / (std::numbers::pi * 0.15 * 0.15), 1e-9);
    EXPECT_EQ(s.drops[1].readings[1].deflection_um, 115.8);
}

TEST(Primax, WhatIsMissingCostsThatReadingAndNothingElse) {
    EXPECT_EQ(stations_of(changed(primax, "114.5", ""))[0].drops[0].readings.size(), 2U);
    EXPECT_EQ(stations_of(changed(primax, "114.5", "-"))[0].drops[0].readings.size(), 2U);
    EXPECT_EQ(stations_of(changed(primax, "\t71.1\t822\t58.1\t8.6\t2.9\t4.0\t25.40", ""))[0].drops[0].readings.size(),
              2U);
    EXPECT_FALSE(stations_of(changed(primax, "\t20\r\nLane", "\t?\r\nLane"))[0].chainage_m);
    EXPECT_NE(complaint(changed(primax, "Load plate radius [mm].\t150", "")).find("before the plate"),
              std::string::npos);
    EXPECT_NE(complaint(primax.substr(0, primax.find("Drop\tD(1)"))).find("no drops"), std::string::npos);
}

TEST(Kuab, GivesStationsDropsAndSensors) {
    const auto stations = stations_of(kuab);
    ASSERT_EQ(stations.size(), 2U);
    const data::FwdStation& s = stations[0];
    EXPECT_EQ(s.chainage_m, 200.0);
    EXPECT_EQ(s.lane, "LHS");
    EXPECT_EQ(s.date, "12/04/2016");
    EXPECT_EQ(s.time, "13:56:00");
    EXPECT_NEAR(*s.latitude, 32.96315 / 60.0, 1e-9);        // 00 degrees 32.96315 minutes
    EXPECT_NEAR(*s.longitude, 32.0 + 13.8219 / 60.0, 1e-9); // 032 degrees 13.8219 minutes
    EXPECT_EQ(s.air_C, 30.0);
    EXPECT_EQ(s.surface_C, 31.0);
    ASSERT_EQ(s.drops.size(), 2U);
    EXPECT_EQ(s.drops[0].radius_mm, 150.0);
    EXPECT_NEAR(s.drops[0].pressure_kPa, 41.5 / (std::numbers::pi * 0.15 * 0.15), 1e-9);
    EXPECT_EQ(s.drops[0].readings[1].offset_mm, 200.0);
    EXPECT_EQ(s.drops[0].readings[1].deflection_um, 184.0);
    EXPECT_EQ(stations[1].drops[0].readings.size(), 2U); // one was not read
}

TEST(Kuab, ReadsItsOwnUnits) {
    std::string text = changed(kuab, "m num    kN   My   My   My    C    C", "ft num   lbf  mil  mil  mil    F    F");
    const data::FwdStation s = stations_of(changed(text, "41.5 388 184 124 30 31", "9000 20 10 6 50 77"))[0];
    EXPECT_NEAR(*s.chainage_m, 60.96, 1e-9);
    EXPECT_NEAR(*s.drops[0].force_kN, 9.0 * 4.4482216, 1e-5);
    EXPECT_NEAR(s.drops[0].readings[0].deflection_um, 508.0, 1e-9);
    EXPECT_NEAR(*s.surface_C, 25.0, 1e-9);
    EXPECT_NE(complaint(changed(kuab, "kN   My", "kN  elbow")).find("unknown unit"), std::string::npos);
    EXPECT_NE(complaint(changed(kuab, "IPlate Radius     : 15.0 (cm)\n", "")).find("before the plate"),
              std::string::npos);
}

TEST(R80, GivesStationsDropsAndSensors) {
    const auto stations =
        stations_of(r80("821 115  71  57  43  36  27  20\r\n 820 116  72  58  44  36  27  20\r\n"
                        "S    20.00  8.800  3  0I20933   48   37   32\r\n82111411002  72  48  37  28  21\r\n"));
    ASSERT_EQ(stations.size(), 2U); // those of the header are none
    const data::FwdStation& s = stations[0];
    EXPECT_EQ(s.chainage_m, 0.0);
    EXPECT_EQ(s.time, "0931");
    EXPECT_EQ(s.air_C, 8.6);
    EXPECT_EQ(s.surface_C, 3.0);
    EXPECT_EQ(s.latitude, 48.97);
    EXPECT_EQ(s.longitude, 2.58);
    ASSERT_EQ(s.drops.size(), 2U);
    for (const data::FwdDrop& drop : s.drops) { // with and without the blank before the first number
        EXPECT_EQ(drop.radius_mm, 150.0);
        ASSERT_EQ(drop.readings.size(), 7U);
        EXPECT_EQ(drop.readings[6].offset_mm, 1500.0);
        EXPECT_EQ(drop.readings[6].deflection_um, 20.0);
    }
    EXPECT_EQ(s.drops[0].pressure_kPa, 821.0);
    EXPECT_EQ(s.drops[1].readings[0].deflection_um, 116.0);
    // Numbers of four figures touch.
    EXPECT_EQ(stations[1].drops[0].readings[0].deflection_um, 1141.0);
    EXPECT_EQ(stations[1].drops[0].readings[1].deflection_um, 1002.0);
    EXPECT_EQ(stations[1].drops[0].pressure_kPa, 821.0);
    // Decimals, which touch in some files.
    const auto decimals = stations_of(r80("821.25115.20 71.10 57.00 43.00 36.00 27.00 20.50\r\n"));
    EXPECT_EQ(decimals[0].drops[0].pressure_kPa, 821.25);
    EXPECT_EQ(decimals[0].drops[0].readings[0].deflection_um, 115.2);
    EXPECT_EQ(decimals[0].drops[0].readings[6].deflection_um, 20.5);
}

TEST(R80, SaysWhatIsWrong) {
    EXPECT_NE(complaint(r80("")).find("no drops"), std::string::npos);
    EXPECT_NE(complaint(changed(r80(""), "150   0 200", "150   0  xx")).find("not a number"), std::string::npos);
}
