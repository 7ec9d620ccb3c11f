// Combinations of parameters in words: their rounding is smaller than what they are fixed to.
#include "analysis/unique/unique.h"
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

TEST(ACombination, OfAModulusAndAPressureHoldsAlongTheWholeValley) {
    // A linear section: deflections are those of modulus / pressure, of which ln modulus - pressure / 718 is the
    // tangent at 718 kPa.
    const study::Study study = test::layered_study(test::layered_bowl(), sought);
    const double pressure = 718.0;
    const std::vector<double> unit{0.5, 0.5, 0.5, (pressure - 400.0) / (1200.0 - 400.0), 0.5};
    for (const double error : {0.34, 0.015, 0.0004}) {
        const std::string text = analysis::combination_words(
            study, {.leading = 0, .others = {{3, -1.0 / pressure}}, .standard_error = error}, unit);
        const double power = number_after(text, "fwd.pressure_kPa^");
        EXPECT_LT(std::abs(power + 1.0) * std::log(1200.0 / 400.0), 0.1 * error) << text;
        EXPECT_LT(text.size(), 120U) << text;
    }
}

TEST(ACombination, OfPowersAndOfSumsHasDigitsEnough) {
    const study::Study study = test::layered_study(test::layered_bowl(), sought);
    const std::vector<double> unit(5, 0.5);
    const double power = 2.0 / 3.0;
    std::string text =
        analysis::combination_words(study, {.leading = 0, .others = {{1, power}}, .standard_error = 0.0005}, unit);
    EXPECT_LT(std::abs(number_after(text, "base.modulus_MPa^") - power) * std::log(1600.0 / 60.0), 0.1 * 0.0005)
        << text;
    // A linear leading number: thickness + c * pressure.
    const double slope = -1.0 / 7.0;
    text = analysis::combination_words(study, {.leading = 4, .others = {{3, slope}}, .standard_error = 0.05}, unit);
    EXPECT_LT(std::abs(number_after(text, "base.thickness_mm - ") + slope) * 800.0, 0.1 * 0.05) << text;
}
