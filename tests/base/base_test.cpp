#include "base/error.h"
#include "base/random.h"
#include "base/text.h"
#include "base/windows_1252.h"

#include <cmath>
#include <gtest/gtest.h>

using namespace pave;

TEST(Error, SaysWhereWhatWasFoundAndWhatIsAllowed) {
    EXPECT_STREQ(Error({"a.toml", 7, "base.k1"}, "must be positive", "-3", "> 0").what(),
                 "a.toml:7: base.k1: must be positive; found -3; allowed: > 0");
    EXPECT_STREQ(Error({.file = "a.toml"}, "cannot be read").what(), "a.toml: cannot be read");
    EXPECT_STREQ(Error({.key = "base.k1"}, "is missing").what(), "base.k1: is missing");
}

TEST(Error, ShowsWhatOthersWroteInOneLineThatEnds) {
    EXPECT_STREQ(Error({.key = "a\nb\x1b[2J"}, "unknown", std::string("x\0y", 3)).what(),
                 "a\\nb\\x1b[2J: unknown; found x\\x00y");
    EXPECT_LT(std::string(Error({.file = std::string(9999, 'f')}, "unknown", std::string(9999, 'x')).what()).size(),
              600U);
}

// Well-formed sequences and their nearest neighbours that are not: table 3-7 of the Unicode standard.
TEST(Text, TellsUtf8FromOtherBytes) {
    for (const std::string_view good : {"", "abc", "\xc3\xa9", "\xe0\xa0\x80", "\xed\x9f\xbf", "\xee\x80\x80",
                                        "\xef\xbb\xbf", "\xf0\x90\x80\x80", "\xf4\x8f\xbf\xbf"}) {
        EXPECT_EQ(first_not_utf8(good), std::string_view::npos) << printable(good);
    }
    for (const std::string_view bad :
         {"\x80", "\xc0\x80", "\xc1\xbf", "\xc3", "\xc3(", "\xe0\x9f\xbf", "\xed\xa0\x80", "\xe2\x82",
          "\xf0\x8f\xbf\xbf", "\xf4\x90\x80\x80", "\xf5\x80\x80\x80", "\xff"}) {
        EXPECT_EQ(first_not_utf8(bad), 0U) << printable(bad);
        EXPECT_EQ(first_not_utf8("ab\xc3\xa9" + std::string(bad)), 4U) << printable(bad);
    }
    EXPECT_EQ(first_not_utf8(std::string_view("a\0b", 3)), 1U);
    EXPECT_EQ(to_utf8("caf\xe9"), "caf\xc3\xa9"); // ISO 8859-1
    EXPECT_EQ(to_utf8("caf\xc3\xa9"), "caf\xc3\xa9");
    EXPECT_EQ(to_utf8("\xff"), "\xc3\xbf");
    // Windows-1252 (RFC-registered table): en dash, quotes, euro; 0x81 is nothing there.
    EXPECT_EQ(to_utf8("a \x96 b"), "a \u2013 b");
    EXPECT_EQ(to_utf8("\x93x\x94 \x80"), "\u201cx\u201d \u20ac");
    EXPECT_EQ(to_utf8("\x81"), "\xc2\x81");
    EXPECT_TRUE(is_of_windows_1252("\u2013") && is_of_windows_1252("\u0178"));
    EXPECT_FALSE(is_of_windows_1252("\u00e9") || is_of_windows_1252("\u2212") || is_of_windows_1252("a"));
}

TEST(Text, IsShownInOneLine) {
    EXPECT_EQ(printable("plain, \xc3\xa9"), "plain, \xc3\xa9");
    EXPECT_EQ(printable("a\tb\nc\rd\x7f\xff"), "a\\tb\\nc\\x0dd\\x7f\\xff");
    EXPECT_EQ(printable("abcdef", 6), "abcdef");
    EXPECT_EQ(printable("abcdef", 5), "abcde...");
    EXPECT_EQ(printable("abcd\xc3\xa9", 5), "abcd..."); // no half characters
}

TEST(NearestName, FindsASlipAndNothingFarOff) {
    const std::vector<std::string> names{"thickness_mm", "density_kg_m3", "modulus_MPa", "k0"};
    EXPECT_EQ(nearest_name("thicknes_mm", names), "thickness_mm"); // one letter left out
    EXPECT_EQ(nearest_name("thiickness_mm", names), "thickness_mm");
    EXPECT_EQ(nearest_name("modullus_MPA", names), "modulus_MPa");
    EXPECT_EQ(nearest_name("zzz", names), "");
    EXPECT_EQ(nearest_name("", names), "k0"); // two letters are a slip, three of a short word are not
    EXPECT_EQ(nearest_name("pqk", {"n12"}), "");
    EXPECT_EQ(nearest_name("k5", {"k2", "k3"}), "k2"); // the first of two as near
    EXPECT_EQ(nearest_name("unik", {"fit", "unique"}), "unique");
    EXPECT_EQ(nearest_name("uniform", {"fit", "unique"}), "");
}

TEST(Join, SeparatesNames) {
    EXPECT_EQ(join({}), "");
    EXPECT_EQ(join({"a"}), "a");
    EXPECT_EQ(join({"a", "b", "c"}), "a, b, c");
}

// Moments of the uniform and of the normal distribution within five standard errors, of numbers along a stream and of
// the same number of neighbouring streams.
TEST(RandomStream, HasTheMomentsOfItsDistributions) {
    constexpr int count = 100000;
    for (const bool along : {true, false}) {
        double uniform[3] = {};
        double normal[5] = {};
        for (int i = 0; i < count; ++i) {
            const RandomStream stream(5, along ? 0 : i);
            const double u = stream.uniform(along ? i : 0);
            const double next = stream.uniform(along ? i + 1 : 1);
            const double x = stream.normal(along ? i : 0);
            ASSERT_TRUE(u > 0.0 && u < 1.0);
            uniform[0] += u / count;
            uniform[1] += u * u / count;
            uniform[2] += u * next / count;
            for (int k = 1; k < 5; ++k) {
                normal[k] += std::pow(x, k) / count;
            }
        }
        const double error = 5.0 / std::sqrt(count);
        EXPECT_NEAR(uniform[0], 1.0 / 2.0, error * std::sqrt(1.0 / 12.0));
        EXPECT_NEAR(uniform[1], 1.0 / 3.0, error * std::sqrt(4.0 / 45.0));
        EXPECT_NEAR(uniform[2], 1.0 / 4.0, error * std::sqrt(13.0 / 144.0));
        EXPECT_NEAR(normal[1], 0.0, error);
        EXPECT_NEAR(normal[2], 1.0, error * std::sqrt(2.0));
        EXPECT_NEAR(normal[3], 0.0, error * std::sqrt(15.0));
        EXPECT_NEAR(normal[4], 3.0, error * std::sqrt(96.0));
    }
}

TEST(RandomStream, IsAFunctionOfSeedStreamAndPlace) {
    const RandomStream stream(5, 3);
    EXPECT_EQ(stream.uniform(7), RandomStream(5, 3).uniform(7));
    EXPECT_NE(stream.uniform(7), RandomStream(6, 3).uniform(7));
    EXPECT_NE(stream.uniform(7), RandomStream(5, 4).uniform(7));
    EXPECT_NE(stream.uniform(7), stream.uniform(8));
}
