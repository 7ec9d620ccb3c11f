// Three-dimensional runs against closed forms, published numbers and the axisymmetric model.
#include "reference/multilayer_elastic.h"
#include "support/sections.h"

#include <gtest/gtest.h>
#include <numbers>

using namespace test;

namespace {

Load wheel(Patch patch) {
    Load load = dual_wheel(40e3, 650e3, patch);
    load.type = LoadType::wheel;
    return load;
}

// Readings of one load on the solid model, whatever model would serve it best.
std::vector<double> solid_readings(const Case& c) {
    const auto parts = parts_of<Solid>(c, 0);
    fe::Solver<fe::Hex20> solver(parts.model);
    const auto solved = solver.incremental(parts.layers, parts.load, {}, c.settings.solver);
    EXPECT_TRUE(solved);
    std::vector<double> values;
    for (const Sensor& sensor : c.sensors) {
        const auto o = observe(sensor, parts.mesh, parts.model, parts.mesh);
        values.push_back(o.on_stress.empty() ? o.of_displacement(solved->displacement.data())
                                             : o.of_stress(solved->stress, 1, 0));
    }
    return values;
}

} // namespace

TEST(SolidLoad, SumsToTheForceOfTheWheels) {
    Case c = captif(3000, 40, {.k1 = 2000, .k2 = 0.5, .k3 = -0.3, .n = 0.4});
    c.sensors = {deflection(0.0)};
    for (const Load& load : {wheel(Patch::rectangle), wheel(Patch::circle), dual_wheel(),
                             dual_wheel(40e3, 650e3, Patch::circle), dual_wheel(31e3, 870e3, Patch::circle, 0.5)}) {
        c.loads = {load};
        const auto parts = parts_of<Solid>(c, 0);
        EXPECT_NEAR(4.0 * parts.load.sum() / load.total_force(), 1.0, 1e-10);
    }
    // A mesh that knows nothing of the patch: its edges cross the cells anywhere.
    c.loads = {wheel(Patch::rectangle)};
    const auto parts = parts_of<Solid>(c, 0);
    for (const Patch patch : {Patch::circle, Patch::rectangle}) {
        for (const double force : {7e3, 23e3, 61e3}) {
            Load other = dual_wheel(force, 700e3, patch, 0.613);
            other.patch_width = 0.137;
            EXPECT_NEAR(4.0 * other.pressure * Solid::unit_load(parts.mesh, parts.model, other).sum() / force, 1.0,
                        1e-10);
        }
    }
}

TEST(SolidLoad, HasTheMomentOfItsPatches) {
    // The centroid of what acts on the quarter lies at the centre of the patch: x = spacing / 2 for a dual. A field
    // that grows linearly with x is in the shape functions, so the load times x sums to force times spacing / 2.
    Case c = captif(3000, 40, {.k1 = 2000, .k2 = 0.5, .k3 = -0.3, .n = 0.4});
    c.sensors = {deflection(0.0)};
    for (const Patch patch : {Patch::circle, Patch::rectangle}) {
        c.loads = {dual_wheel(40e3, 650e3, patch)};
        const auto parts = parts_of<Solid>(c, 0);
        double moment = 0.0;
        std::vector<char> seen(static_cast<std::size_t>(parts.model.free_unknowns()), 0);
        for (int e = 0; e < parts.model.elements(); ++e) {
            for (int i = 0; i < fe::Hex20::nodes; ++i) {
                const int k =
                    parts.model.topology->unknowns[static_cast<std::size_t>(e)][static_cast<std::size_t>(3 * i + 2)];
                if (k >= 0 && seen[static_cast<std::size_t>(k)]++ == 0) {
                    moment += parts.load[k] * parts.model.coordinates[static_cast<std::size_t>(e)](0, i);
                }
            }
        }
        EXPECT_NEAR(4.0 * moment / (40e3 * 0.17), 1.0, 1e-10);
    }
}

TEST(SolidModel, AgreesWithTheMultilayerSolutionAndTheAxisymmetricModelUnderOneCircle) {
    const reference::ElasticLayer stack[] = {{0.10, 2000e6, 0.35}, {0.30, 300e6, 0.35}, {1.10, 60e6, 0.40}};
    Case c;
    for (const auto& layer : stack) {
        c.layers.push_back(
            linear_layer("layer" + std::to_string(c.layers.size()), layer.thickness, layer.modulus, layer.poisson));
    }
    c.loads = {plate(0.15, 600e3)};
    const double d = 0.3 / std::numbers::sqrt2;
    c.sensors = {
        deflection(0.0), deflection(0.2), deflection(0.3), {0, Quantity::deflection, d, d, 0.0, 0.0}, deflection(0.6)};
    for (const double z : {0.15, 0.25, 0.45, 0.7}) {
        c.sensors.push_back(strain_zz(z, 0.0));
        c.sensors.push_back({0, Quantity::stress_zz, 0.0, 0.0, z, 0.0});
    }
    c.sensors.push_back({0, Quantity::strain_xx, 0.0, 0.0, 0.0999, 0.0});
    const auto solid = solid_readings(c);
    const auto axisymmetric = run(c);
    ASSERT_TRUE(axisymmetric);
    for (std::size_t i = 0; i < c.sensors.size(); ++i) {
        const Sensor& s = c.sensors[i];
        const auto exact = reference::multilayer_elastic(stack, reference::Floor::rigid_rough, 0.15, 600e3,
                                                         std::hypot(s.x, s.y), s.depth);
        const double value = s.quantity == Quantity::deflection  ? exact.u_z
                             : s.quantity == Quantity::strain_zz ? -exact.eps_zz
                             : s.quantity == Quantity::stress_zz ? -exact.sigma_zz
                                                                 : -exact.eps_rr;
        EXPECT_NEAR(solid[i] / value, 1.0, 0.01) << i;
        EXPECT_NEAR(axisymmetric->values[i] / value, 1.0, 0.01) << i;
        EXPECT_NEAR(solid[i] / axisymmetric->values[i], 1.0, 0.01) << i;
    }
}

TEST(SolidModel, GivesTheAnswerOfTheAxisymmetricModelForAStressDependentBase) {
    const Case c = captif(3000, 45, {.k1 = 2000, .k2 = 0.5, .k3 = -0.3, .n = 0.4});
    const auto solid = solid_readings(c);
    const auto axisymmetric = run(c);
    ASSERT_TRUE(axisymmetric);
    for (std::size_t i = 0; i < c.sensors.size(); ++i) {
        // The far deflection crosses zero: of the largest there.
        const bool far = c.sensors[i].x > 1.5;
        const double scale = far ? axisymmetric->values[0] : axisymmetric->values[i];
        EXPECT_NEAR((solid[i] - axisymmetric->values[i]) / scale, 0.0, far ? 0.002 : 0.01) << i;
    }
}

// The benchmark of the AMADEUS project (European Commission, 2000) as several multilayer programs reproduce it: two
// circles of 0.7 MPa, radius 106.6 mm, at x = +-170 mm on 260 mm of 5000 MPa and 500 mm of 200 MPa over a half-space of
// 50 MPa. Microstrain, tension negative: horizontal along y at the bottom of layer 1, vertical at the top of 2 and 3.
TEST(SolidModel, ReproducesTheAmadeusDualWheel) {
    Case c;
    // Deep and wide enough for a half-space as far as strains under the wheels are concerned.
    c.layers = {linear_layer("asphalt", 0.26, 5000e6, 0.35), linear_layer("base", 0.50, 200e6, 0.40),
                linear_layer("soil", 15.0, 50e6, 0.45)};
    c.settings.extent = 15.0;
    c.loads = {dual_wheel(2 * std::numbers::pi * 0.1066 * 0.1066 * 0.7e6, 0.7e6, Patch::circle)};
    std::vector<double> published;
    const auto read = [&](double x, double h1, double v2, double v3) {
        c.sensors.push_back({0, Quantity::strain_yy, x, 0.0, 0.26 - 1e-7, 0.0});
        c.sensors.push_back({0, Quantity::strain_zz, x, 0.0, 0.26, 0.0});
        c.sensors.push_back({0, Quantity::strain_zz, x, 0.0, 0.76, 0.0});
        published.insert(published.end(), {h1, v2, v3});
    };
    read(0.17, -85, 186, 170);
    read(0.0, -89, 183, 177);
    const auto response = run(c);
    ASSERT_TRUE(response);
    for (std::size_t i = 0; i < published.size(); ++i) {
        EXPECT_NEAR(response->values[i] * 1e6 / published[i], 1.0, 0.02) << i;
    }
}

// Against the transform solution: a dual is the sum of two circles.
TEST(SolidModel, OfALinearDualIsTheSumOfTwoCircles) {
    const reference::ElasticLayer stack[] = {{0.10, 2000e6, 0.35}, {0.30, 300e6, 0.35}, {1.10, 60e6, 0.40}};
    Case c;
    for (const auto& layer : stack) {
        c.layers.push_back(
            linear_layer("layer" + std::to_string(c.layers.size()), layer.thickness, layer.modulus, layer.poisson));
    }
    const double radius = 0.1, pressure = 650e3, spacing = 0.34;
    c.loads = {dual_wheel(2 * std::numbers::pi * radius * radius * pressure, pressure, Patch::circle, spacing)};
    for (const double x : {0.0, 0.17}) {
        c.sensors.push_back(deflection(x));
        for (const double z : {0.2, 0.3, 0.5, 0.8}) {
            c.sensors.push_back(strain_zz(z, 0.0, x));
        }
    }
    const auto response = run(c);
    ASSERT_TRUE(response);
    for (std::size_t i = 0; i < c.sensors.size(); ++i) {
        const Sensor& s = c.sensors[i];
        double exact = 0.0;
        for (const double centre : {-spacing / 2, spacing / 2}) {
            const auto part = reference::multilayer_elastic(stack, reference::Floor::rigid_rough, radius, pressure,
                                                            std::abs(s.x - centre), s.depth);
            exact += s.quantity == Quantity::deflection ? part.u_z : -part.eps_zz;
        }
        EXPECT_NEAR(response->values[i] / exact, 1.0, 0.01) << i;
    }
}

TEST(SolidModel, ReadsASensorOnAnySideOfTheLoadAlike) {
    Case c = captif(3000, 40, {.k1 = 2000, .k2 = 0.5, .k3 = -0.3, .n = 0.4});
    c.loads = {dual_wheel()};
    c.settings.refine = 0.4;
    c.sensors.clear();
    for (const double sx : {1.0, -1.0}) {
        for (const double sy : {1.0, -1.0}) {
            c.sensors.push_back({0, Quantity::strain_zz, sx * 0.17, sy * 0.1, 0.2, 0.075});
            c.sensors.push_back({0, Quantity::strain_xx, sx * 0.17, sy * 0.1, 0.2, 0.0});
        }
    }
    const auto response = run(c);
    ASSERT_TRUE(response);
    for (std::size_t i = 2; i < c.sensors.size(); ++i) {
        EXPECT_EQ(response->values[i], response->values[i % 2]);
    }
}

TEST(SolidModel, AnalysesItsMatrixOnceForAllThreadsAndGeometries) {
    Case c = captif(3000, 40, {.k1 = 2000, .k2 = 0.5, .k3 = -0.3, .n = 0.4});
    c.loads = {dual_wheel()};
    c.settings.refine = 0.3;
    c.sensors = {deflection(0.17), strain_zz(0.2, 0.075, 0.17)};
    const int before = fe::CholeskyAnalysis::made();
    const ForwardModel model(c);
    const auto first = model.make_workspace();
    const auto second = model.make_workspace();
    const auto here = model.run(c, {}, *first);
    Case thicker = c;
    thicker.layers[1].thickness = 0.3;
    ASSERT_TRUE(model.run(thicker, {}, *first)); // another geometry on the same structure
    Case softer = c;
    softer.layers[1].parameters[1] = 1000.0;
    ASSERT_TRUE(model.run(softer, {}, *second));
    const auto again = model.run(c, {}, *first);
    const auto there = model.run(c, {}, *second);
    EXPECT_EQ(fe::CholeskyAnalysis::made() - before, 1);
    // And what ran before changes no bit.
    ASSERT_TRUE(here && again && there);
    EXPECT_EQ(here->values, again->values);
    EXPECT_EQ(here->values, there->values);
}
