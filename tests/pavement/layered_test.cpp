// The layered engine as the model of a load, beside finite elements; half-spaces under both; gears.
#include "support/differences.h"
#include "support/sections.h"

#include "base/error.h"
#include "pavement/effects/catalog.h"
#include "reference/multilayer_elastic.h"

#include <gtest/gtest.h>

using namespace test;

namespace {

Case bowl(bool half_space) {
    Case c;
    c.layers = {linear_layer("asphalt", 0.12, 3000e6, 0.35), linear_layer("base", 0.25, 400e6, 0.35),
                linear_layer("subgrade", half_space ? 3.0 : 2.5, 60e6, 0.40)};
    c.loads = {plate()};
    for (const double x : {0.0, 0.2, 0.3, 0.6, 0.9, 1.2, 1.8}) {
        c.sensors.push_back(deflection(x));
    }
    c.sensors.push_back(strain_zz(0.25, 0.075));
    c.sensors.push_back(strain_zz(0.45, 0.1, 0.3));
    c.sensors.push_back({0, Quantity::strain_xx, 0.1, 0.05, 0.11, 0.0});
    c.sensors.push_back({0, Quantity::strain_yy, 0.1, 0.05, 0.11, 0.0});
    c.sensors.push_back({0, Quantity::stress_zz, 0.0, 0.0, 0.5, 0.0});
    c.sensors.push_back({0, Quantity::stress_xx, 0.1, 0.0, 0.06, 0.0});
    c.half_space = half_space;
    c.settings.extent = c.default_extent();
    return c;
}

std::vector<double> values_of(Case c, bool layered) {
    c.settings.layered = layered;
    const auto response = run(c);
    EXPECT_TRUE(response) << response.failure().reason;
    return response->values;
}

double worst_relative(const std::vector<double>& found, const std::vector<double>& expected, std::size_t from,
                      std::size_t to) {
    double worst = 0.0;
    for (std::size_t i = from; i < to; ++i) {
        worst = std::max(worst, std::abs(found[i] / expected[i] - 1.0));
    }
    return worst;
}

// The finite elements come nearer as they get smaller.
TEST(LayeredLoad, FiniteElementsAgreeWithinTheirOwnError) {
    for (const bool half_space : {false, true}) {
        Case c = bowl(half_space);
        c.settings.extent = 12.0; // the wall out of sight
        const auto exact = values_of(c, true);
        const auto coarse = values_of(c, false);
        c.settings.refine = 2.0;
        const auto fine = values_of(c, false);
        EXPECT_LT(worst_relative(coarse, exact, 0, 7), 0.003) << half_space;
        EXPECT_LT(worst_relative(fine, exact, 0, 7), 0.0025) << half_space;
        EXPECT_LT(worst_relative(coarse, exact, 7, 13), 0.02) << half_space;
        EXPECT_LT(worst_relative(fine, exact, 7, 13), 0.006) << half_space;
    }
}

TEST(LayeredLoad, ReadsWhatAnIndependentProgramComputes) {
    const Case c = bowl(true);
    const auto values = values_of(c, true);
    const std::vector<reference::ElasticLayer> layers{{0.12, 3000e6, 0.35}, {0.25, 400e6, 0.35}, {0.0, 60e6, 0.40}};
    const auto at = [&](double r, double z) {
        return reference::multilayer_elastic(layers, reference::Floor::half_space, 0.15, 595e3, r, z);
    };
    for (std::size_t i = 0; i < 7; ++i) {
        const double exact = at(c.sensors[i].x, 0.0).u_z;
        EXPECT_NEAR(values[i], exact, 1e-8 * exact);
    }
    const double gauge = (at(0.0, 0.25 - 0.0375).u_z - at(0.0, 0.25 + 0.0375).u_z) / 0.075;
    EXPECT_NEAR(values[7], gauge, 1e-7 * gauge);
    const auto field = at(std::hypot(0.1, 0.05), 0.11);
    EXPECT_NEAR(values[9], -(0.8 * field.eps_rr + 0.2 * field.eps_tt), 1e-7 * std::abs(values[9]));
    EXPECT_NEAR(values[10], -(0.2 * field.eps_rr + 0.8 * field.eps_tt), 1e-7 * std::abs(values[10]));
    EXPECT_NEAR(values[11], -at(0.0, 0.5).sigma_zz, 1e-7 * values[11]);
    EXPECT_NEAR(values[12], -at(0.1, 0.06).sigma_rr, 1e-7 * std::abs(values[12]));
}

TEST(LayeredLoad, DerivativesAreThoseOfDifferences) {
    for (const auto& [half_space, slips] : {std::pair{false, false}, {true, false}, {true, true}}) {
        Case c = bowl(half_space);
        c.settings.layered = true;
        c.effects.push_back({find_effect("contact-pressure-shape"), 0.2, true});
        c.effects.push_back({find_effect("load-magnitude"), 1.1, true});
        std::vector<std::string> paths{"asphalt.modulus_MPa",  "base.modulus_MPa",
                                       "subgrade.modulus_MPa", "base.poisson",
                                       "subgrade.poisson",     "asphalt.thickness_mm",
                                       "base.thickness_mm",    "fwd.radius_mm",
                                       "fwd.pressure_kPa",     "contact-pressure-shape.size",
                                       "load-magnitude.size",  "base.density_kg_m3"};
        if (slips) {
            c.effects.push_back({find_effect("interface-slip-asphalt-base"), 0.3, true});
            paths.emplace_back("interface-slip-asphalt-base.size");
        }
        if (!half_space) {
            paths.emplace_back("subgrade.thickness_mm");
        }
        std::vector<Parameter> parameters;
        for (const std::string& path : paths) {
            parameters.push_back(find_parameter(c, path, {}));
        }
        const ForwardModel model(c);
        const auto workspace = model.make_workspace();
        const auto exact = model.run(c, parameters, *workspace);
        ASSERT_TRUE(exact) << exact.failure().reason;
        for (std::size_t p = 0; p < parameters.size(); ++p) {
            const double size = std::max(std::abs(parameters[p].get(c)), 0.1);
            const auto found = central_differences(model, c, parameters[p], 2e-3 * size, *exact, *workspace);
            ASSERT_TRUE(found);
            const auto d = disagreement(*exact, p, size, found->rates);
            EXPECT_LT(d.worst, 2e-6 * std::max(d.scale, 0.1)) << paths[p];
        }
    }
}

// The same numbers whatever ran before and with whatever derivatives.
TEST(LayeredLoad, IsAPureFunction) {
    Case c = bowl(false);
    c.settings.layered = true;
    const ForwardModel model(c);
    const auto workspace = model.make_workspace();
    const auto first = model.run(c, {}, *workspace);
    Case other = c;
    other.layers[0].thickness = 0.02;
    other.loads[0].radius = 0.2;
    ASSERT_TRUE(model.run(other, {}, *workspace));
    const auto again = model.run(c, {find_parameter(c, "base.modulus_MPa", {})}, *workspace);
    ASSERT_TRUE(first && again);
    EXPECT_EQ(first->values, again->values);
    const auto fresh = model.run(other, {}, *model.make_workspace());
    const auto used = model.run(other, {}, *workspace);
    EXPECT_EQ(fresh->values, used->values);
}

TEST(LayeredLoad, AWallThatIsWantedIsKept) {
    Case c = bowl(false);
    c.settings.extent = 2.0;
    const auto walled = values_of(c, false);
    const auto open = values_of(c, true);
    EXPECT_GT(std::abs(walled[6] / open[6] - 1.0), 0.01);
}

// Two circular patches: the quarter model in three dimensions against the sum of two circles.
TEST(HalfSpace, ADualInThreeDimensionsAgreesWithTheLayeredEngine) {
    Case c = bowl(true);
    c.loads = {dual_wheel(40e3, 650e3, Patch::circle)};
    c.sensors = {deflection(0.17), deflection(0.0), deflection(0.9), strain_zz(0.25, 0.075, 0.17)};
    c.settings.extent = c.default_extent();
    const auto exact = values_of(c, true);
    const auto found = values_of(c, false);
    EXPECT_LT(worst_relative(found, exact, 0, 3), 0.01);
    EXPECT_LT(worst_relative(found, exact, 3, 4), 0.03);
}

// With k2 = k3 = 0 Uzan's law is linear: the load path over elements without end against the layered engine.
TEST(HalfSpace, AStressDependentLowestLayerIsAllowed) {
    Case c = bowl(true);
    const auto exact = values_of(c, true);
    c.layers[2] = uzan_layer("subgrade", 3.0, {.k1 = 600.0, .k2 = 0.0, .k3 = 0.0, .n = 1.0});
    c.layers[2].parameters[5] = c.layers[2].parameters[6] = 0.40;
    const auto found = values_of(c, false);
    EXPECT_LT(worst_relative(found, exact, 0, 7), 0.004);
    c.layers[2] = uzan_layer("subgrade", 3.0, {.k1 = 600.0, .k2 = 0.3, .k3 = -0.5, .n = 1.0});
    const auto softer = run(c, {"base.thickness_mm", "subgrade.k2"});
    ASSERT_TRUE(softer) << softer.failure().reason;
    const ForwardModel model(c);
    for (const char* path : {"base.thickness_mm", "subgrade.k2"}) {
        const auto parameter = find_parameter(c, path, {});
        const auto workspace = model.make_workspace();
        const auto exact_rates = model.run(c, {parameter}, *workspace);
        const auto rates = central_differences(model, c, parameter, 1e-3 * parameter.get(c), *exact_rates, *workspace);
        ASSERT_TRUE(rates);
        const auto d = disagreement(*exact_rates, 0, parameter.get(c), rates->rates);
        EXPECT_LT(d.worst, 1e-3 * d.scale) << path;
    }
}

TEST(Gear, IsTheSumOfItsWheels) {
    Case c = bowl(true);
    Load gear;
    gear.name = "gear";
    gear.type = LoadType::gear;
    gear.patch = Patch::circle;
    gear.pressure = 1.2e6;
    gear.wheels = {{0.0, 0.0, 100e3}, {0.9, 0.0, 100e3}, {0.3, 1.1, 60e3}};
    c.loads = {gear};
    const auto all = values_of(c, false);
    std::vector<double> sum(all.size(), 0.0);
    for (const auto& wheel : gear.wheels) {
        Case one = bowl(true);
        one.loads[0].radius = std::sqrt(wheel.force / gear.pressure / std::numbers::pi);
        one.loads[0].pressure = gear.pressure;
        for (Sensor& sensor : one.sensors) {
            sensor.x -= wheel.x;
            sensor.y -= wheel.y;
        }
        const auto part = values_of(one, true);
        for (std::size_t i = 0; i < sum.size(); ++i) {
            sum[i] += part[i];
        }
    }
    for (std::size_t i = 0; i < sum.size(); ++i) {
        EXPECT_NEAR(all[i], sum[i], 1e-8 * std::abs(sum[i])) << i;
    }
    c.layers[1] = uzan_layer("base", 0.25, {.k1 = 1500.0, .k2 = 0.5, .k3 = -0.3, .n = 0.4});
    EXPECT_THROW(ForwardModel{c}, Error);
    c.layers[1] = linear_layer("base", 0.25, 400e6, 0.35);
    c.loads[0].wheels[1].x = 0.1;
    EXPECT_THROW(ForwardModel{c}, Error);
}

} // namespace
