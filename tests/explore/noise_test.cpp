// Residuals in units of stated noise: variance 1 and no bias, whatever the value is. Reference: draws of the noise as
// it is stated, and what dividing by the measured value does with the same draws.
#include "data/noise.h"

#include "base/random.h"

#include <cmath>
#include <gtest/gtest.h>
#include <vector>

using explore::data::Noise;

namespace {

// The mean v of readings that were all drawn at 1, by Gauss-Newton on the residuals, with its standard error.
struct Estimate {
    double value = 1.0, error = 0.0;
};

Estimate fitted(const std::vector<double>& measured, const Noise& noise) {
    Estimate e;
    for (int step = 0; step < 30; ++step) {
        double slope2 = 0.0;
        double gradient = 0.0;
        for (const double m : measured) {
            const double slope = noise.slope(e.value, m);
            slope2 += slope * slope;
            gradient += slope * noise.residual(e.value, m);
        }
        e.value -= gradient / slope2;
        e.error = 1.0 / std::sqrt(slope2);
    }
    return e;
}

} // namespace

TEST(Noise, HasTheSlopeOfItsResidual) {
    for (const Noise noise :
         {Noise{.absolute = 0.02}, Noise{.relative = 0.1}, Noise{.absolute = 0.02, .relative = 0.1}}) {
        for (const double measured : {0.5, -0.3, 0.01}) {
            for (const double model : {0.4, 0.7, -0.2, 0.0}) {
                constexpr double h = 1e-6;
                const double quotient =
                    (noise.residual(model + h, measured) - noise.residual(model - h, measured)) / (2.0 * h);
                EXPECT_NEAR(noise.slope(model, measured), quotient, 1e-6 * quotient);
            }
        }
    }
}

TEST(Noise, IsAPlainDifferenceWhereItIsAbsolute) {
    const Noise noise{.absolute = 0.02};
    EXPECT_DOUBLE_EQ(noise.residual(0.55, 0.5), (0.55 - 0.5) / 0.02);
    EXPECT_DOUBLE_EQ(noise.deviation(7.0), 0.02);
    EXPECT_FALSE(Noise{}.is_stated());
}

// A tenth of relative noise, twelve readings of one value: 4000 fits.
TEST(Noise, OfAShareOfTheValueBiasesNoEstimateAndKeepsItsCoverage) {
    const Noise noise{.relative = 0.1};
    constexpr int trials = 4000;
    constexpr int readings = 12;
    double bias = 0.0;
    double bias_by_measured = 0.0;
    double chi2 = 0.0;
    int covered = 0;
    for (int t = 0; t < trials; ++t) {
        const pave::RandomStream random(42, static_cast<std::uint64_t>(t));
        std::vector<double> measured;
        double weights = 0.0;
        double weighted = 0.0;
        for (int i = 0; i < readings; ++i) {
            const double m = 1.0 + 0.1 * random.normal(static_cast<std::uint64_t>(i));
            measured.push_back(m);
            weights += 1.0 / (m * m); // sigma = 0.1 m
            weighted += m / (m * m);
        }
        const Estimate e = fitted(measured, noise);
        bias += (e.value - 1.0) / e.error / trials;
        bias_by_measured += (weighted / weights - 1.0) * std::sqrt(weights) * 10.0 / trials;
        covered += std::abs(e.value - 1.0) < 1.96 * e.error;
        for (const double m : measured) {
            chi2 += std::pow(noise.residual(1.0, m), 2) / (trials * readings);
        }
    }
    // The mean of 4000 standard normals is within 0.05 in 99.8 % of cases.
    EXPECT_NEAR(bias, 0.0, 0.05);
    EXPECT_LT(bias_by_measured, -0.5); // what is avoided: low readings weigh more
    EXPECT_NEAR(chi2, 1.0, 0.02);
    EXPECT_NEAR(covered / static_cast<double>(trials), 0.95, 0.012);
}
