// A plate on its foundation against closed forms and published regressions.
#include "layered/plate.h"

#include <cmath>
#include <gtest/gtest.h>
#include <numbers>
#include <vector>

using namespace pave::layered;

namespace {

// AREA by the trapezium rule, inches: of sensors and a plate of 5.9055 in (150 mm).
double area(Foundation foundation, const std::vector<double>& at, double l) {
    const double radius = 5.9055;
    double sum = 0.0;
    for (std::size_t i = 1; i < at.size(); ++i) {
        sum += 0.5 *
               (plate_deflection(foundation, radius, at[i], l) + plate_deflection(foundation, radius, at[i - 1], l)) *
               (at[i] - at[i - 1]);
    }
    return sum / plate_deflection(foundation, radius, 0.0, l);
}

} // namespace

// Under a point load P the dense liquid gives way by P/(8 k l^2), the solid by P/(3 sqrt(3) C l).
TEST(Plate, UnderASmallCircleIsThatUnderAPoint) {
    const double radius = 1e-3;
    const double l = 0.8;
    const double load = std::numbers::pi * radius * radius;
    EXPECT_NEAR(plate_deflection(Foundation::dense_liquid, radius, 0.0, l) / (load / (8.0 * l * l)), 1.0, 1e-4);
    EXPECT_NEAR(plate_deflection(Foundation::elastic_solid, radius, 0.0, l) / (load / (3.0 * std::sqrt(3.0) * l)), 1.0,
                1e-3);
    // -P kei(r/l) / (2 pi k l^2); kei(1) = -0.49499464, kei(2) = -0.20240007 (Abramowitz and Stegun, table 9.12).
    const double unit = load / (2.0 * std::numbers::pi * l * l);
    EXPECT_NEAR(plate_deflection(Foundation::dense_liquid, radius, l, l) / unit, 0.49499464, 1e-5);
    EXPECT_NEAR(plate_deflection(Foundation::dense_liquid, radius, 2.0 * l, l) / unit, 0.20240007, 1e-5);
}

// Westergaard (1926, 1948) in the middle of a slab: P/(8 k l^2) (1 + (ln(a/(2 l)) + 0.57722 - 1.25) (a/l)^2 / (2 pi)).
TEST(Plate, IsWestergaardsUnderTheLoad) {
    const double l = 0.9;
    for (const double radius : {0.1, 0.15, 0.2}) {
        const double load = std::numbers::pi * radius * radius;
        const double share = radius / l;
        const double westergaard =
            load / (8.0 * l * l) *
            (1.0 + (std::log(share / 2.0) + 0.5772157 - 1.25) * share * share / (2.0 * std::numbers::pi));
        EXPECT_NEAR(plate_deflection(Foundation::dense_liquid, radius, 0.0, l) / westergaard, 1.0, 2e-4) << radius;
    }
}

// Regressions of l by AREA: K. T. Hall, "Performance, evaluation, and rehabilitation of asphalt-overlaid concrete
// pavements" (1991), and FHWA-RD-00-086: l = (ln((n - AREA)/a)/-b)^c, in inches, within 1.5 %.
TEST(Plate, HasTheAreaOfThePublishedRegressions) {
    const std::vector<double> four{0, 12, 24, 36};
    const std::vector<double> seven{0, 8, 12, 18, 24, 36, 60};
    for (const double l : {20.0, 30.0, 40.0, 50.0}) {
        const double liquid = area(Foundation::dense_liquid, four, l);
        EXPECT_NEAR(std::pow(std::log((36.0 - liquid) / 1812.279) / -2.559, 4.387) / l, 1.0, 0.015) << l;
        const double solid = area(Foundation::elastic_solid, four, l);
        EXPECT_NEAR(std::pow(std::log((36.0 - solid) / 4521.676) / -3.645, 5.334) / l, 1.0, 0.015) << l;
        const double of_seven = area(Foundation::dense_liquid, seven, l);
        EXPECT_NEAR(std::pow(std::log((60.0 - of_seven) / 289.708) / -0.698, 2.566) / l, 1.0, 0.015) << l;
    }
}

TEST(Plate, OfAThicknessBendsByItsCube) {
    EXPECT_DOUBLE_EQ(flexural_rigidity(30e9, 0.25, 0.15), 30e9 * 0.015625 / (12.0 * 0.9775));
}
