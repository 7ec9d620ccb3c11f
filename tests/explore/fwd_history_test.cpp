// Time histories in F25 files: blocks laid out as Dynatest's description of the format has them.
#include "analysis/studies/new_study.h"
#include "data/fwd.h"
#include "data/fwd_f25.h"

#include "base/error.h"

#include <cmath>
#include <fmt/format.h>
#include <gtest/gtest.h>

using namespace explore;

namespace {

const std::string head = "5001,25.10,1,40, 3, 1\r\n5020, 150, 0, 300, 900\r\n5021, 300, N0, N0, N0\r\n";
const std::string first = "5301,0,1,4,3, 31.500,1,1,N0 ,,1991,06,05,14,07\r\n";
const std::string second = "5301,0,1,4,3, 31.600,1,1,N0 ,,1991,06,05,14,12\r\n";
const std::string drops = "1, 574, 434, 300, 120\r\n2, 800, 600, 410, 160\r\n";

// Of the first station unless it is of another; position: -1 in this file.
std::string block(int drop, const std::string& station = "0,1,4,3, 31.500,1,1,N0 ,,1991,06,05,14,07", int lines = 3,
                  const std::string& position = "         -1", int step_us = 200) {
    std::string text = fmt::format("5185,{}, {}, 3, {},{}\r\n", station, drop, step_us, position);
    const char* samples[] = {"1001, 0, 0, 0, 0\r\n", "1002, 250, 100, N0, 7\r\n", "1003, 574, 434, 300, 11\r\n"};
    for (int i = 0; i < lines; ++i) {
        text += samples[i];
    }
    return text;
}

data::FwdFile f25_file(const std::string& text) {
    return data::read_fwd_f25(text, "a.f25", {});
}

} // namespace

TEST(F25History, IsThatOfItsDrop) {
    for (const std::string& text : {head + first + drops + block(2) + second + drops, // behind
                                    head + first + block(2) + drops + second + drops, // before
                                    head + block(2) + first + drops + second + drops}) {
        const data::FwdFile file = f25_file(text);
        ASSERT_EQ(file.stations.size(), 2U);
        EXPECT_TRUE(file.remarks.empty());
        ASSERT_EQ(file.stations[0].drops.size(), 2U);
        EXPECT_FALSE(file.stations[0].drops[0].history);
        EXPECT_FALSE(file.stations[1].drops[1].history);
        const auto& history = file.stations[0].drops[1].history;
        ASSERT_TRUE(history);
        EXPECT_DOUBLE_EQ(history->step_ms, 0.2);
        EXPECT_EQ(history->pressure_kPa, (std::vector<double>{0.0, 250.0, 574.0}));
        EXPECT_EQ(history->offsets_mm, (std::vector<double>{0.0, 300.0, 900.0}));
        ASSERT_EQ(history->deflection_um.size(), 9U);
        EXPECT_EQ(history->deflection_um[3], 100.0);
        EXPECT_TRUE(std::isnan(history->deflection_um[4]));
        EXPECT_EQ(history->deflection_um[8], 11.0);
    }
}

TEST(F25History, WhatCannotBeTakenIsSaidAndCostsNothingElse) {
    const auto remark = [&](const std::string& text) {
        const data::FwdFile file = f25_file(head + first + drops + text);
        EXPECT_EQ(file.stations.size(), 1U);
        EXPECT_EQ(file.stations[0].drops.size(), 2U);
        EXPECT_FALSE(file.stations[0].drops[0].history) << text;
        EXPECT_EQ(file.remarks.size(), 1U) << text;
        return file.remarks.empty() ? "" : file.remarks[0];
    };
    EXPECT_NE(remark(block(1, "0,1,4,3, 31.500,1,1,N0 ,,1991,06,05,14,07", 2)).find("2 of 3 samples"),
              std::string::npos);
    EXPECT_NE(remark(block(1, "0,1,4,3, 99.900,1,1,N0 ,,1991,06,05,14,07")).find("no drop 1"), std::string::npos);
    EXPECT_NE(remark(block(3)).find("no drop 3"), std::string::npos);
    EXPECT_NE(remark(block(1, "0,1,4,3, 31.500,1,1,N0 ,,1991,06,05,14,07", 0, "2048")).find("binary"),
              std::string::npos);
    EXPECT_NE(remark("5185\r\n").find("line 7"), std::string::npos);
    EXPECT_NE(remark("5185,0,1,4,3, 31.500,1,1,N0,,1991,06,05,14,07, 1, 90000, 200, -1\r\n").find("90000 samples"),
              std::string::npos);
}

TEST(F25History, MakesAStudyOfPulses) {
    const std::string own = "0,1,4,3, 31.500,1,1,N0 ,,1991,06,05,14,07";
    const data::FwdFile file = f25_file(head + first + drops + block(1, own) + block(2, own, 3, "-1", 1000));
    const analysis::NewStudy made = analysis::study_of_pulses("s", file, "a.f25", "");
    ASSERT_EQ(made.histories.size(), 2U);
    EXPECT_EQ(made.histories[1].first, "s-drop-2.csv");
    EXPECT_NE(made.histories[1].second.find("2,574"), std::string::npos) << made.histories[1].second;
    EXPECT_NE(made.study.find("history = \"s-drop-1.csv\""), std::string::npos);
    EXPECT_NE(made.readings.find("drop-2,deflection,0,0,0,0,100,um"), std::string::npos) << made.readings;
    EXPECT_EQ(made.readings.find("nan"), std::string::npos);
    EXPECT_THROW(analysis::study_of_pulses("s", f25_file(head + first + drops), "a.f25", ""), pave::Error);
}
