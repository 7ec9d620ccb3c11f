// Published curves of temperature against numbers worked by hand.
#include "data/temperature_curves.h"

#include <gtest/gtest.h>

namespace explore {
namespace {

using data::TemperatureCurve;

// D0 400, D300 250, D600 170, D900 90 um.
const data::BowlIndices bowl{.d0_um = 400.0, .sci_um = 150.0, .bdi_um = 80.0, .bci_um = 80.0};
constexpr data::WhereMeasured site{.asphalt_C = 30.0, .asphalt_mm = 150.0, .latitude_deg = 40.0, .d900_um = 90.0};

TEST(TemperatureCurves, ThatOfTheGuideTakesDifferencesAndD0) {
    // lg h = 2.17609, lg phi = 1.60206, lg d = 1.95424. Slopes of lg dl by T: 12 in: -0.0275 + 0.012 * 3.48623 =
    // 0.014335; 24 in: -0.00622 * 3.13081 + 0.00838 * 3.48623 = 0.009741; 36 in: 0.008355. From 30 to 20 C: 0.71888,
    // 0.79907, 0.82499. dl_36: 10^2.32979 = 213.7 at 20 C, 10^2.41334 = 259.0 at 30 C.
    const auto at = data::indices_at(TemperatureCurve::fhwa, 20.0, site, bowl);
    EXPECT_EQ(at.why_not, "");
    EXPECT_TRUE(at.out_of_range.empty());
    EXPECT_NEAR(*at.d0_um, 400.0 * (90.0 + 213.7) / (90.0 + 259.0), 0.1);
    EXPECT_NEAR(*at.sci_um, 150.0 * 0.71888, 0.01);
    EXPECT_NEAR(*at.bdi_um, 230.0 * 0.79907 - 150.0 * 0.71888, 0.02);
    EXPECT_NEAR(*at.bci_um, 310.0 * 0.82499 - 230.0 * 0.79907, 0.03);
    // South of the equator as north of it; a bowl without temperature to take it from stays.
    data::WhereMeasured south = site;
    south.latitude_deg = -40.0;
    EXPECT_EQ(data::indices_at(TemperatureCurve::fhwa, 20.0, south, bowl).d0_um, at.d0_um);
    EXPECT_EQ(data::indices_at(TemperatureCurve::fhwa, 30.0, site, bowl).d0_um, bowl.d0_um);
}

TEST(TemperatureCurves, OfTheGuideWantPlaceThicknessAndASensor) {
    for (auto missing :
         {&data::WhereMeasured::asphalt_mm, &data::WhereMeasured::latitude_deg, &data::WhereMeasured::d900_um}) {
        data::WhereMeasured where = site;
        (where.*missing).reset();
        const auto at = data::indices_at(TemperatureCurve::fhwa, 20.0, where, bowl);
        EXPECT_NE(at.why_not, "");
        EXPECT_FALSE(at.d0_um || at.sci_um || at.bdi_um || at.bci_um);
        EXPECT_EQ(data::indices_at(TemperatureCurve::rws, 20.0, where, bowl).why_not, "");
    }
}

TEST(TemperatureCurves, OfRijkswaterstaatIsThatOfItsProgram) {
    // The parser of F25 files that is made for them, of a station at 16.4 C: 106.2 and 84.9 um, at 20 C 111.5 um and a
    // difference of 24.9 um.
    const data::BowlIndices its{.d0_um = 106.2, .sci_um = 106.2 - 84.9};
    const auto at = data::indices_at(TemperatureCurve::rws, 20.0, {.asphalt_C = 16.4}, its);
    EXPECT_NEAR(*at.d0_um, 111.5, 0.05);
    EXPECT_NEAR(*at.sci_um, 24.9, 0.05);
    EXPECT_FALSE(at.bdi_um || at.bci_um);
    // To another temperature through 20 C: 1 + 0.013926 * 10 + 0.0002298 * 100 = 1.16224 at 30 C.
    EXPECT_NEAR(*data::indices_at(TemperatureCurve::rws, 30.0, {.asphalt_C = 16.4}, its).d0_um, *at.d0_um * 1.16224,
                1e-3);
}

TEST(TemperatureCurves, ModuliByTheSlopeOrByTheIndianGuide) {
    // 1 - 0.238 ln 35 = 0.153827, 1 - 0.238 ln 25 = 0.233907.
    EXPECT_NEAR(*data::modulus_factor_by(TemperatureCurve::irc, 25.0, 35.0), 0.153827 / 0.233907, 1e-5);
    EXPECT_NEAR(*data::modulus_factor_by(TemperatureCurve::fhwa, 10.0, 21.0), 0.587, 0.001); // the guide's example
    EXPECT_FALSE(data::modulus_factor_by(TemperatureCurve::irc, -3.0, 35.0));
    EXPECT_FALSE(data::modulus_factor_by(TemperatureCurve::irc, 25.0, 70.0));
    const auto at = data::indices_at(TemperatureCurve::irc, 35.0, site, bowl);
    EXPECT_FALSE(at.d0_um || at.sci_um) << "it says nothing of deflections";
}

TEST(TemperatureCurves, SayWhatTheyWereNotMadeFor) {
    const auto beyond = [](TemperatureCurve curve, double reference, data::WhereMeasured where) {
        return data::indices_at(curve, reference, where, bowl).out_of_range;
    };
    EXPECT_TRUE(beyond(TemperatureCurve::fhwa, 20.0, site).empty());
    data::WhereMeasured where = site;
    where.asphalt_C = 44.0;
    where.latitude_deg = -12.0;
    const auto both = beyond(TemperatureCurve::fhwa, 20.0, where);
    ASSERT_EQ(both.size(), 2U);
    EXPECT_EQ(both[0], "44 C (it is used from 0 to 40 C)");
    EXPECT_EQ(both[1], "a latitude of 12 degrees (its sites lie between 25 and 55)");
    where.asphalt_mm = 30.0;
    EXPECT_EQ(beyond(TemperatureCurve::irc, 35.0, where),
              std::vector<std::string>{"30 mm of asphalt (it wants 40 mm at least)"});
    EXPECT_EQ(beyond(TemperatureCurve::irc, 15.0, site), std::vector<std::string>{"15 C (it is used from 20 to 45 C)"});
}

} // namespace
} // namespace explore
