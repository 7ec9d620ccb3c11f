// Combinations of parameters in words: their rounding is smaller than what they are fixed to.
#include "analysis/unique.h"
#include "support/layered_study.h"

#include <cmath>
#include <gtest/gtest.h>

using namespace explore;

namespace {

// The number that follows `before` in the text.
double number_after(const std::string& text, const std::string& before) {
    const std::size_t at = text.find(before);
    EXPECT_NE(at, std::string::npos) << text;
    return at == std::string::npos ? NAN : std::stod(text.substr(at + before.size()));
}

const std::string sought = "[[parameters]]\nname = \"fwd.pressure_kPa\"\nmin = 400\nmax = 1200\n"
                           "[[parameters]]\nname = \"base.thickness_mm\"\nmin = 300\nmax = 400\n";

} // namespace

TEST(ACombination, OfALargeLinearNumberCanBeUsedOverItsWholeRange) {
    const study::Study study = test::layered_study(test::layered_bowl(), sought);
    for (const double coefficient : {-1.0 / 718.37, 1.0 / 1234.5}) {
        for (const double error : {0.34, 0.015, 0.0004}) {
            const std::string text = analysis::combination_words(
                study, {.leading = 0, .others = {{3, coefficient}}, .standard_error = error});
            const std::string before = coefficient < 0.0 ? "exp(-fwd.pressure_kPa/" : "exp(fwd.pressure_kPa/";
            const double printed = std::copysign(1.0, coefficient) / number_after(text, before);
            EXPECT_LT(std::abs(printed - coefficient) * (1200.0 - 400.0), 0.1 * error) << text;
            EXPECT_LT(text.size(), 120U) << text;
        }
    }
}

TEST(ACombination, OfPowersAndOfSumsHasDigitsEnough) {
    const study::Study study = test::layered_study(test::layered_bowl(), sought);
    const double power = 2.0 / 3.0;
    std::string text =
        analysis::combination_words(study, {.leading = 0, .others = {{1, power}}, .standard_error = 0.0005});
    EXPECT_LT(std::abs(number_after(text, "base.modulus_MPa^") - power) * std::log(1600.0 / 60.0), 0.1 * 0.0005)
        << text;
    // A linear leading number: thickness + c * pressure.
    const double slope = -1.0 / 7.0;
    text = analysis::combination_words(study, {.leading = 4, .others = {{3, slope}}, .standard_error = 0.05});
    EXPECT_LT(std::abs(number_after(text, "base.thickness_mm - ") + slope) * 800.0, 0.1 * 0.05) << text;
}
