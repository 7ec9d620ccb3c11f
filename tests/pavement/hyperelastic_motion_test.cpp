// A section with an energy in motion and in time: what it takes it gives back.
#include "support/differences.h"
#include "support/sections.h"

#include <gtest/gtest.h>

using namespace test;

namespace {

// A base that little confines at rest on a soft subgrade over rock, hit by a drop; read where it lasts.
Case dropped(bool hyperelastic, double until = 0.5) {
    Case c;
    c.layers = {linear_layer("asphalt", 0.08, 2500e6, 0.35), {}, linear_layer("subgrade", 2.0, 70e6, 0.4)};
    c.layers[1] = uzan_layer("base", 0.25, {.k1 = 2200, .k2 = 0.5, .k3 = -0.3, .n = 0.4});
    if (hyperelastic) {
        c.layers[1].law = material::find_law("hyperelastic");
        c.layers[1].parameters = {0.0, 2200, 0.5, 0.4, 0.35, 0.35, material::not_given, 5e3};
    }
    for (Layer& layer : c.layers) {
        layer.damping_time = 5e-3; // so that nothing swings at the end
    }
    Load load = plate(0.15, 700e3);
    load.history = haversine_history(0.025, until);
    c.loads = {load};
    c.settings.extent = 6.0;
    c.settings.refine = 0.4;
    c.settings.time_step = 2.5e-4;
    for (const double depth : {0.0, 0.12, 0.25, 0.5}) {
        Sensor sensor = depth == 0.0 ? deflection(0.0) : strain_zz(depth, 0.0);
        c.sensors.push_back(sensor);
        sensor.time = until;
        c.sensors.push_back(sensor);
    }
    return c;
}

} // namespace

TEST(HyperelasticPulse, GivesAllStrainBack) {
    const auto given_back = run(dropped(true));
    ASSERT_TRUE(given_back) << given_back.failure().reason;
    EXPECT_LT(given_back->statistics.kept_share, 1e-9);
    for (std::size_t i = 0; i < given_back->values.size(); i += 2) {
        EXPECT_LT(std::abs(given_back->values[i + 1]), 1e-3 * std::abs(given_back->values[i])) << i;
    }
    const auto warned = [](const Response& response) {
        for (const std::string& warning : response.warnings) {
            if (warning.find("of its largest strain after the pulse") != std::string::npos) {
                return warning;
            }
        }
        return std::string();
    };
    EXPECT_EQ(warned(*given_back), "");
    // The law of moduli beside it does not, and says what would.
    const auto kept = run(dropped(false));
    ASSERT_TRUE(kept);
    EXPECT_GT(kept->statistics.kept_share, 0.2);
    EXPECT_NE(warned(*kept).find("\"hyperelastic\""), std::string::npos) << warned(*kept);
}

// Slow against every wave, the section is at rest under each load.
TEST(HyperelasticPulse, IsTheSectionAtRestWhereTheLoadIsSlow) {
    Case c = dropped(true);
    for (Sensor& sensor : c.sensors) {
        sensor.time.reset();
    }
    for (Layer& layer : c.layers) {
        layer.damping_time = 0.0;
    }
    c.loads[0].history = haversine_history(4.0, 4.0);
    c.settings.time_step = 0.02;
    const auto moving = run(c);
    Case at_rest = c;
    at_rest.loads[0].history.clear();
    // Sides that are open hold a little otherwise than a smooth wall: far from both.
    c.settings.extent = at_rest.settings.extent = 12.0;
    const auto expected = run(at_rest);
    ASSERT_TRUE(moving && expected);
    for (std::size_t i = 0; i < expected->values.size(); ++i) {
        EXPECT_NEAR(moving->values[i] / expected->values[i], 1.0, 0.01) << i;
    }
}

TEST(HyperelasticPulse, ConvergesWithTheSquareOfTheStep) {
    const auto values = [](double step) {
        Case c = dropped(true, 0.03);
        c.settings.time_step = step;
        return run(c)->values;
    };
    const auto exact = values(2.5e-5);
    const auto error = [&](double step) {
        const auto found = values(step);
        double most = 0.0;
        for (std::size_t i = 0; i < found.size(); ++i) {
            most = std::max(most, std::abs(found[i] - exact[i]) / std::abs(exact[i]));
        }
        return most;
    };
    const double coarse = error(4e-4);
    EXPECT_LT(coarse, 0.02);
    EXPECT_LT(error(1e-4), coarse / 8.0);
}

TEST(HyperelasticPulse, HasExactDerivatives) {
    Case c = dropped(true, 0.03);
    c.settings.time_step = 5e-4;
    c.settings.refine = 0.3;
    c.sensors.push_back({0, Quantity::stress_zz, 0.0, 0.0, 0.2, 0.0});
    expect_exact_derivatives(c,
                             {"base.k1", "base.k", "base.n", "base.poisson_31", "base.stress_smoothing_kPa", "base.k0",
                              "base.density_kg_m3", "base.damping_time_ms", "base.thickness_mm", "subgrade.modulus_MPa",
                              "fwd.pressure_kPa", "asphalt.thickness_mm"},
                             5e-6);
}

// A load that acts for long finds a section that has relaxed: at rest, with the modulus that is left.
TEST(HyperelasticBesideAsphaltThatRelaxes, EndsAtRestWithDerivatives) {
    Case c = captif(3000, 45, {.k1 = 2000, .k2 = 0.5, .k3 = -0.3, .n = 0.4});
    c.layers[1].law = material::find_law("hyperelastic");
    c.layers[1].parameters = {0.0, 1800, 0.5, 0.4, 0.35, 0.35, material::not_given, 5e3};
    c.settings.refine = 0.4;
    Case at_rest = c;
    at_rest.layers[0].parameters[0] *= 0.5;
    c.layers[0] = {"asphalt",
                   0.03,
                   2200.0,
                   0.5,
                   0.0,
                   material::find_law("viscoelastic"),
                   {3000e6, 0.35, 20.0, 20.0, 261e3, 0.5, 1e-5, 0.0, 0.1, 0.0, 1.0, 0.0, 10.0}};
    c.loads[0].duration = 1.0;
    const auto found = run(c);
    const auto expected = run(at_rest);
    ASSERT_TRUE(found && expected) << found.failure().reason;
    for (std::size_t i = 0; i < expected->values.size(); ++i) {
        const double scale = std::max(std::abs(expected->values[i]), 1e-4);
        EXPECT_NEAR(found->values[i], expected->values[i], 5e-3 * scale) << i;
    }
    expect_exact_derivatives(c, {"base.k1", "base.k", "base.n", "asphalt.modulus_MPa"}, 5e-6);
}
