// What a user may write as arithmetic, and what is refused.
#include "base/error.h"
#include "base/expression.h"

#include <cmath>
#include <gtest/gtest.h>

using pave::Expression;

namespace {

const std::vector<std::string> names{"base.k1", "subgrade top.modulus_MPa", "drop:1.pressure_kPa", "2nd.k2"};

double value_of(const std::string& text) {
    const Expression e(text, names);
    return e.value(std::vector<double>(e.reads().size(), 3.0));
}

std::string complaint(const std::string& text) {
    try {
        value_of(text);
    } catch (const std::invalid_argument& error) {
        return error.what();
    }
    return "";
}

} // namespace

TEST(AnExpression, TakesNumbersNamesAndTheFunctionsOfThePage) {
    EXPECT_DOUBLE_EQ(value_of("1.5e1 * base.k1 - .5^2 / (2+1E0)"), 45.0 - 0.25 / 3.0);
    EXPECT_DOUBLE_EQ(value_of("exp(0.5) + ln(2) + log10(1000) + sqrt(2)"),
                     std::exp(0.5) + std::log(2.0) + 3.0 + std::sqrt(2.0));
    EXPECT_DOUBLE_EQ(value_of("abs(-2) + min(base.k1, 1) + max(1, 2, 4)"), 7.0);
    EXPECT_DOUBLE_EQ(value_of("2 * subgrade top.modulus_MPa"), 6.0);
    EXPECT_DOUBLE_EQ(value_of("drop:1.pressure_kPa + 2nd.k2"), 6.0); // names may hold what expressions do not
}

TEST(AnExpression, RefusesWhatThePageDoesNotList) {
    for (const std::string text :
         {"sin(1)",    "log2(8)", "rint(1.2)",    "sign(-1)", "sum(1, 2)", "avg(1, 2)", "atan(1)",   "_pi",    "_e",
          "pi",        "_0",      "base.k1 + _0", "e",        "1 < 2",     "1 > 2",     "1 && 1",    "1 || 0", "!1",
          "1 ? 2 : 3", "a = 1",   "1; 2",         "#1",       "0x10",      "1e",        "2 base.k1", "\"a\"",  ""}) {
        EXPECT_NE(complaint(text), "") << text;
    }
}

TEST(AnExpression, AsksWhichLogarithmIsMeant) {
    EXPECT_NE(complaint("1000*log(base.k1)").find("ln or log10"), std::string::npos);
    EXPECT_NE(complaint("lg(base.k1)").find("ln, log10"), std::string::npos); // in the list of functions
}

TEST(AnExpression, SuggestsTheNameThatIsMeant) {
    EXPECT_NE(complaint("2 * base.k3").find("\"base.k3\" is no known name, did you mean \"base.k1\"?"),
              std::string::npos);
}

TEST(NearestName, KnowsAWordThatIsCutShortOrGoesOn) {
    const std::vector<std::string> keys{"noise", "noise_floor", "noise_relative", "modulus_MPa", "k2"};
    EXPECT_EQ(pave::nearest_name("noise_rel", keys), "noise_relative");
    EXPECT_EQ(pave::nearest_name("modulus", keys), "modulus_MPa");
    EXPECT_EQ(pave::nearest_name("noise_relative_percent", keys), "noise_relative");
    EXPECT_EQ(pave::nearest_name("noise_flor", keys), "noise_floor");
    EXPECT_EQ(pave::nearest_name("time", {"name", "time_ms"}), "time_ms"); // not two letters that differ
    EXPECT_EQ(pave::nearest_name("weight", {"weighting", "weights"}), "weights");
    EXPECT_EQ(pave::nearest_name("viscosity", keys), "");
}
