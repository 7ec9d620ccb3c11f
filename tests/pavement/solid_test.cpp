// Three-dimensional runs against closed forms, published numbers and the axisymmetric model.
#include "reference/multilayer_elastic.h"
#include "support/sections.h"

#include <gtest/gtest.h>
#include <numbers>
#include <span>

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
        const auto o = observe(sensor, parts.mesh, parts.model, parts.mesh, incompressible_layers(c));
        values.push_back(o.on_stress.empty() ? o.of_displacement(solved->displacement.data())
                                             : o.of_stress(solved->stress, 1, 0));
    }
    return values;
}

Case dual_circles(std::span<const reference::ElasticLayer> stack, double radius, double spacing) {
    Case c;
    for (const auto& layer : stack) {
        c.layers.push_back(
            linear_layer("layer" + std::to_string(c.layers.size()), layer.thickness, layer.modulus, layer.poisson));
    }
    const double pressure = 650e3;
    c.loads = {dual_wheel(2 * std::numbers::pi * radius * radius * pressure, pressure, Patch::circle, spacing)};
    return c;
}

// What a sensor on the x axis reads, by superposition of the transform solution.
double sum_of_circles(std::span<const reference::ElasticLayer> stack, const Case& c, const Sensor& sensor) {
    const auto footprint = c.loads[0].footprint();
    double sum = 0.0;
    for (const double centre : {-footprint.centre, footprint.centre}) {
        const auto part = reference::multilayer_elastic(stack, reference::Floor::rigid_rough, footprint.half_x,
                                                        c.loads[0].pressure, std::abs(sensor.x - centre), sensor.depth);
        switch (sensor.quantity) {
        case Quantity::deflection: sum += part.u_z; break;
        case Quantity::strain_zz: sum -= part.eps_zz; break;
        case Quantity::strain_xx: sum -= part.eps_rr; break;
        case Quantity::strain_yy: sum -= part.eps_tt; break;
        case Quantity::stress_zz: sum -= part.sigma_zz; break;
        case Quantity::stress_xx: sum -= part.sigma_rr; break;
        case Quantity::stress_yy: sum -= part.sigma_tt; break;
        default: ADD_FAILURE() << "no closed form of this quantity here";
        }
    }
    return sum;
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

// A multidepth deflectometer: every engine has the displacement within the layers.
TEST(SolidModel, ReadsDeflectionsAtAnyDepthAsTheMultilayerSolutionHasThem) {
    const reference::ElasticLayer stack[] = {{0.12, 2500e6, 0.35}, {0.28, 250e6, 0.35}, {1.20, 70e6, 0.40}};
    Case c;
    for (const auto& layer : stack) {
        c.layers.push_back(
            linear_layer("layer" + std::to_string(c.layers.size()), layer.thickness, layer.modulus, layer.poisson));
    }
    c.loads = {plate(0.15, 600e3)};
    for (const double x : {0.0, 0.3, 0.5}) {
        for (const double z : {0.0, 0.06, 0.12, 0.33, 0.7, 1.1}) {
            c.sensors.push_back({0, Quantity::deflection, x, 0.0, z, 0.0});
        }
    }
    c.settings.layered = true;
    const auto layered = run(c);
    c.settings.layered = false;
    const auto solid = solid_readings(c);
    const auto axisymmetric = run(c);
    ASSERT_TRUE(layered && axisymmetric);
    for (std::size_t i = 0; i < c.sensors.size(); ++i) {
        const Sensor& s = c.sensors[i];
        const double exact =
            reference::multilayer_elastic(stack, reference::Floor::rigid_rough, 0.15, 600e3, s.x, s.depth).u_z;
        EXPECT_NEAR(layered->values[i] / exact, 1.0, 1e-6) << i;
        EXPECT_NEAR(axisymmetric->values[i] / exact, 1.0, 0.01) << i;
        EXPECT_NEAR(solid[i] / exact, 1.0, 0.01) << i;
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
    Case c = dual_circles(stack, 0.1, 0.34);
    for (const double x : {0.0, 0.17}) {
        c.sensors.push_back(deflection(x));
        for (const double z : {0.2, 0.3, 0.5, 0.8}) {
            c.sensors.push_back(strain_zz(z, 0.0, x));
        }
    }
    const auto response = run(c);
    ASSERT_TRUE(response);
    for (std::size_t i = 0; i < c.sensors.size(); ++i) {
        EXPECT_NEAR(response->values[i] / sum_of_circles(stack, c, c.sensors[i]), 1.0, 0.01) << i;
    }
}

// Two circles that touch, to rounding or nearly, and two that stand a little apart.
TEST(SolidModel, OfCirclesThatTouchIsTheSumOfTwoCircles) {
    const reference::ElasticLayer stack[] = {{0.10, 2000e6, 0.35}, {0.30, 300e6, 0.35}, {1.10, 60e6, 0.40}};
    const double radius = 0.1;
    for (const double gap : {0.0, 1e-12, 1e-3}) {
        Case c = dual_circles(stack, radius, 2.0 * radius + gap);
        c.sensors = {deflection(0.0),
                     deflection(radius),
                     strain_zz(0.25, 0.0),
                     strain_zz(0.25, 0.0, radius),
                     {0, Quantity::stress_zz, 0.0, 0.0, 0.2, 0.0}};
        const auto response = run(c);
        ASSERT_TRUE(response) << gap << ": " << response.failure().reason;
        for (std::size_t i = 0; i < c.sensors.size(); ++i) {
            EXPECT_NEAR(response->values[i] / sum_of_circles(stack, c, c.sensors[i]), 1.0, 0.01) << gap << " " << i;
        }
    }
}

// At the bottom of thin asphalt, each place alone: under the centre of a circle, at its edge and between the two.
TEST(SolidModel, HasTheHorizontalStrainsAndStressesAtTheBottomOfThinAsphalt) {
    const reference::ElasticLayer stack[] = {{0.015, 3000e6, 0.35}, {0.277, 300e6, 0.35}, {1.193, 40e6, 0.40}};
    const double radius = 0.1;
    const std::vector<Quantity> quantities{Quantity::strain_xx, Quantity::strain_yy, Quantity::stress_xx,
                                           Quantity::stress_yy};
    std::vector<double> errors;
    std::vector<double> largest(quantities.size(), 0.0);
    for (const double x : {0.17, 0.17 + radius, 0.0}) {
        Case c = dual_circles(stack, radius, 0.34);
        for (const auto quantity : quantities) {
            c.sensors.push_back({0, quantity, x, 0.0, 0.015 - 1e-7, 0.0});
        }
        const auto response = run(c);
        ASSERT_TRUE(response);
        for (std::size_t k = 0; k < quantities.size(); ++k) {
            const double exact = sum_of_circles(stack, c, c.sensors[k]);
            errors.push_back(std::abs(response->values[k] - exact));
            largest[k] = std::max(largest[k], std::abs(exact));
        }
    }
    for (std::size_t i = 0; i < errors.size(); ++i) {
        const bool at_edge = i / quantities.size() == 1;
        EXPECT_LT(errors[i], (at_edge ? 0.025 : 0.012) * largest[i % quantities.size()]) << i;
    }
}

// The structure of a mesh is that of the nominal case; other spacings move its lines, or the load on them.
TEST(SolidModel, FollowsASpacingFromCirclesThatTouch) {
    const reference::ElasticLayer stack[] = {{0.10, 2000e6, 0.35}, {0.30, 300e6, 0.35}, {1.10, 60e6, 0.40}};
    const double radius = 0.1;
    Case nominal = dual_circles(stack, radius, 2.0 * radius);
    nominal.sensors = {deflection(0.0), strain_zz(0.25, 0.0)};
    const ForwardModel model(nominal);
    const auto workspace = model.make_workspace();
    for (const double spacing : {0.22, 0.26, 0.2}) {
        Case c = nominal;
        c.loads[0].spacing = spacing;
        const auto response = model.run(c, {}, *workspace);
        ASSERT_TRUE(response) << spacing;
        for (std::size_t i = 0; i < c.sensors.size(); ++i) {
            EXPECT_NEAR(response->values[i] / sum_of_circles(stack, c, c.sensors[i]), 1.0, 0.01) << spacing << " " << i;
        }
    }
    Case overlapping = nominal;
    overlapping.loads[0].spacing = 0.19;
    EXPECT_FALSE(model.run(overlapping, {}, *workspace));
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
