// The figure of profiles: how much of the box a panel shows.
#include "report/figures.h"

#include <cmath>
#include <gtest/gtest.h>

using namespace explore;
using report::Json;

namespace {

// A parabola of ln(value) about the best, that the data accept within a factor.
Json profile_of(const std::string& name, double best, double factor) {
    Json down = Json::array();
    Json up = Json::array();
    for (const double share : {0.5, 1.0, 1.2}) {
        down.push_back({best * std::pow(factor, -share), 3.84 * share * share});
        up.push_back({best * std::pow(factor, share), 3.84 * share * share});
    }
    return {{"name", name}, {"best", best}, {"low", best / factor}, {"high", best * factor}, {"profile", {down, up}}};
}

} // namespace

TEST(ProfilesFigure, ShowsLittleMoreThanIsAcceptedWhereThatIsASmallPartOfTheBox) {
    const double min = 2.0;
    const double max = 5e5;
    const Json unique = {
        {"model", "full"},
        {"acceptance", {{"chi2_rise_allowed", 3.84}}},
        {"parameters",
         {{{"name", "base.modulus_MPa"}, {"scale", "log"}, {"min", min}, {"max", max}},
          {{"name", "subgrade.modulus_MPa"}, {"scale", "log"}, {"min", min}, {"max", max}},
          {{"name", "asphalt.modulus_MPa"}, {"scale", "log"}, {"min", min}, {"max", max}}}},
        {"profiles",
         {profile_of("base.modulus_MPa", 300.0, 1.05), profile_of("subgrade.modulus_MPa", 1000.0, 200.0),
          profile_of("asphalt.modulus_MPa", 2.05, 1.02)}},
        {"outputs", Json::array()}};
    const report::Figure figure = report::profiles_figure(unique);
    ASSERT_GE(figure.panels.size(), 3U);
    const auto& sharp = figure.panels[0].x;
    const double accepted = 2.0 * std::log(1.05);
    EXPECT_LT(std::log(sharp.high / sharp.low), 3.0 * accepted); // the stroke fills a third of its panel, at least
    EXPECT_LT(sharp.low, 300.0 / 1.05);
    EXPECT_GT(sharp.high, 300.0 * 1.05);
    EXPECT_GE(sharp.ticks.size(), 2U);
    const auto& wide = figure.panels[1].x;
    EXPECT_EQ(wide.low, min);
    EXPECT_EQ(wide.high, max);
    const auto& at_bound = figure.panels[2].x; // never beyond the box
    EXPECT_GE(at_bound.low, min);
    EXPECT_LT(at_bound.high, 2.3);
}
