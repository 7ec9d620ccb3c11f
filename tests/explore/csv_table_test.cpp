// Tables as spreadsheets save them: which separator, which decimal mark.
#include "data/csv.h"
#include "data/history.h"
#include "data/reading.h"
#include "run/program.h"

#include <gtest/gtest.h>

using namespace explore::data;

namespace {

const std::string plain = "# two readings\nload,quantity,x_mm,y_mm,depth_mm,gauge_mm,value,unit,sigma\n"
                          "fwd,deflection,0,0,0,0,0.475,mm,0.02\n\"fwd, again\",deflection,300,0,0,0,0.25,mm,\n";

std::string with(std::string text, char separator, bool decimal_comma) {
    text = text.substr(text.find('\n') + 1);
    std::string out;
    bool quoted = false;
    for (const char c : text) {
        quoted = quoted != (c == '"');
        out += c == ',' && !quoted ? separator : c == '.' && decimal_comma ? ',' : c;
    }
    return out;
}

void expect_the_two(const std::string& text) {
    const auto readings = measurements_of(text, "a.csv");
    ASSERT_EQ(readings.size(), 2U) << text;
    EXPECT_EQ(readings[0].value, 0.475);
    EXPECT_EQ(readings[0].sigma, 0.02);
    EXPECT_EQ(readings[1].load, "fwd, again");
    EXPECT_EQ(readings[1].x_mm, 300.0);
    EXPECT_EQ(readings[1].value, 0.25);
    EXPECT_FALSE(readings[1].sigma);
}

std::string complaint(const std::string& text) {
    try {
        measurements_of(text, "a.csv");
    } catch (const pave::Error& error) {
        return error.what();
    }
    return "";
}

} // namespace

TEST(ATable, IsReadWithSemicolonsTabsAndDecimalCommas) {
    expect_the_two(plain);
    for (const char separator : {';', '\t', '|'}) {
        for (const bool comma : {false, true}) {
            expect_the_two(with(plain, separator, comma));
            expect_the_two("\xef\xbb\xbf# a comment, with commas\n\n" + with(plain, separator, comma));
        }
    }
    expect_the_two("sep=;\r\n" + with(plain, ';', true));
}

TEST(ATable, WithFullStopsHasNoDecimalCommas) {
    // 1,200 beside 0.475 is a thousand and two hundred or nothing.
    std::string text = with(plain, ';', false);
    text.replace(text.find("300"), 3, "1,200");
    EXPECT_NE(complaint(text).find("not a number"), std::string::npos);
    EXPECT_NE(complaint(text).find("1,200"), std::string::npos);
}

// The rarer sign is the mistake, and its line is named: 1.200 among decimal commas is no 1.2.
TEST(ATable, WithDecimalCommasHasNoFullStops) {
    std::string text = with(plain, ';', true);
    text.replace(text.find("300"), 3, "1.200");
    const std::string words = complaint(text);
    EXPECT_NE(words.find("a full stop among numbers with decimal commas"), std::string::npos) << words;
    EXPECT_NE(words.find("\"1.200\""), std::string::npos) << words;
    EXPECT_NE(words.find("a.csv:3"), std::string::npos) << words;
}

TEST(ATable, OfCommasHasNoDecimalCommas) {
    EXPECT_NE(
        complaint("load,quantity,x_mm,y_mm,depth_mm,gauge_mm,value,unit,sigma\nfwd,deflection,0,0,0,0,0,475,mm,\n")
            .find("wrong number of cells"),
        std::string::npos);
}

TEST(ATable, SuggestsTheColumnThatIsMeant) {
    std::string text = plain;
    text.replace(text.find("depth_mm"), 8, "depth");
    EXPECT_NE(complaint(text).find("did you mean \"depth_mm\"?"), std::string::npos);
}

TEST(AHistory, IsReadFromASpreadsheetToo) {
    const auto history = history_of("time_ms;force_kN\n0;0\n2,5;12,25\n5;0\n", "drop.csv");
    EXPECT_TRUE(history.is_force);
    EXPECT_EQ(history.time_ms, (std::vector<double>{0.0, 2.5, 5.0}));
    EXPECT_EQ(history.values, (std::vector<double>{0.0, 12.25, 0.0}));
}

TEST(AWordOfACommand, IsQuotedWhereAShellWouldSplitIt) {
    EXPECT_EQ(run::shell_word("output/road-1_b.toml"), "output/road-1_b.toml");
    EXPECT_EQ(run::shell_word("out put"), "'out put'");
    EXPECT_EQ(run::shell_word("it's"), "'it'\\''s'");
    EXPECT_EQ(run::shell_word("a$b"), "'a$b'");
    EXPECT_EQ(run::shell_word(""), "''");
}
