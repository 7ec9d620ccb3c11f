// A section in motion in three dimensions: against superposed transform solutions of two circles, energy, derivatives.
#include "reference/layered_pulse.h"
#include "support/differences.h"
#include "support/motion.h"
#include "support/sections.h"

#include "pavement/load_model.h"
#include "pavement/pulse.h"

#include <Eigen/QR>
#include <gtest/gtest.h>

using namespace test;

namespace {

constexpr double duration = 0.025; // s
constexpr double pressure = 700e3; // Pa
constexpr double spacing = 0.34;   // m

Load moving_dual(Patch patch) {
    Load load = dual_wheel(2.0 * std::numbers::pi * 0.1 * 0.1 * pressure, pressure, patch, spacing);
    load.history = haversine_history(duration, 0.045);
    return load;
}

Case layered_section(bool half_space) {
    Case c;
    c.layers = {linear_layer("asphalt", 0.15, 3e9, 0.35), linear_layer("base", 0.4, 300e6, 0.35),
                linear_layer("subgrade", half_space ? 8.0 : 2.5, 80e6, 0.4)};
    for (Layer& layer : c.layers) {
        layer.damping_time = 5e-4;
    }
    c.half_space = half_space;
    c.loads = {moving_dual(Patch::circle)};
    c.settings.extent = 8.0;
    c.settings.time_step = 5e-4;
    c.settings.refine = 1.2;
    return c;
}

// Two rectangles on a base that follows the stress, a coarse mesh.
Case on_a_base_that_follows_the_stress() {
    Case c = captif(3000, 45, {.k1 = 2000, .k2 = 0.5, .k3 = -0.3, .n = 0.4, .residual_stress = 20e3});
    for (Layer& layer : c.layers) {
        layer.damping_time = 5e-4;
    }
    c.loads = {moving_dual(Patch::rectangle)};
    c.loads[0].history = haversine_history(duration, 0.03);
    c.settings.refine = 0.35;
    c.settings.time_step = 1e-3;
    c.settings.extent = 4.0;
    c.settings.solver.linear_tolerance = 1e-10;
    c.sensors.clear();
    for (const double time : {0.0082, 0.0213}) {
        for (Sensor sensor : {deflection(0.17), deflection(0.9), strain_zz(0.2, 0.075, 0.17),
                              Sensor{0, Quantity::stress_zz, 0.0, 0.0, 0.25, 0.0}}) {
            sensor.time = time;
            c.sensors.push_back(sensor);
        }
    }
    return c;
}

} // namespace

// Both kinds of bottom.
class SolidPulseOn : public testing::TestWithParam<bool> {};

// Where nothing follows the stress, two circles are the sum of one and one. At every sensor and time within 1.5 % of
// the sensor's largest.
TEST_P(SolidPulseOn, IsTheSumOfTheTransformSolutionsOfTwoCircles) {
    Case c = layered_section(GetParam());
    std::vector<reference::MovingLayer> layers;
    for (const Layer& layer : c.layers) {
        layers.push_back(
            {layer.thickness, layer.parameters[0], layer.parameters[1], layer.density, layer.damping_time});
    }
    const std::vector<std::pair<double, double>> places{{0.0, 0.0}, {0.17, 0.0}, {0.6, 0.0}, {0.0, 0.9}, {0.9, 0.9}};
    std::vector<double> times;
    for (int i = 1; i <= 22; ++i) {
        times.push_back(2e-3 * i);
    }
    std::vector<double> radii; // of each place, from the one and the other circle
    for (const auto& [x, y] : places) {
        radii.push_back(std::hypot(x - spacing / 2.0, y));
        radii.push_back(std::hypot(x + spacing / 2.0, y));
        for (const double t : times) {
            c.sensors.push_back(deflection(x));
            c.sensors.back().y = y;
            c.sensors.back().time = t;
        }
    }
    const auto exact = reference::layered_pulse(layers, c.half_space, 0.1, pressure, duration, radii, times);
    const auto found = run(c);
    ASSERT_TRUE(found) << found.failure().reason;
    for (std::size_t i = 0; i < places.size(); ++i) {
        double peak = 0.0;
        double error = 0.0;
        for (std::size_t j = 0; j < times.size(); ++j) {
            const double sum = exact[2 * i][j] + exact[2 * i + 1][j];
            peak = std::max(peak, std::abs(sum));
            error = std::max(error, std::abs(found->values[i * times.size() + j] - sum));
        }
        EXPECT_LT(error, 0.01 * peak) << "at " << places[i].first << ", " << places[i].second;
    }
}

INSTANTIATE_TEST_SUITE_P(BothBottoms, SolidPulseOn, testing::Bool());

// As in pulse_test.cpp. What the wall seems to take before anything gets there, and what still moves at the end, is of
// the mesh: 2.4 %, 0.4 %, 0.04 % and 0.5 %, 0.8 %, 0.2 % of the work at a refinement of 0.6, 1 and 1.6.
TEST(SolidPulse, LeavesWithTheEnergyThatTheLoadBrought) {
    Case c = layered_section(true);
    for (Layer& layer : c.layers) {
        layer.damping_time = 0.0;
    }
    c.settings.time_step = 1e-3;
    const auto after = [&](double until) { return marched_until<Solid>(c, haversine_history(duration, until)); };
    const auto early = after(0.012);
    EXPECT_GT(early.work, 0.0);
    EXPECT_LT(early.absorbed, 5e-3 * early.work);
    EXPECT_LT(early.kinetic, early.work);
    const auto late = after(0.3);
    EXPECT_NEAR(late.absorbed, late.work, 0.02 * late.work);
    EXPECT_LT(late.kinetic, 0.01 * late.work);
}

// As in pulse_test.cpp: over two seconds nothing has inertia.
TEST(SolidPulse, IsTheLoadAtRestWhenItIsSlow) {
    Case still = captif(3000, 45, {.k1 = 2000, .k2 = 0.5, .k3 = -0.3, .n = 0.4, .residual_stress = 20e3});
    still.loads = {dual_wheel()};
    still.sensors = {deflection(0.17), deflection(0.0), deflection(0.9), strain_zz(0.2, 0.075, 0.17)};
    still.settings.extent = 6.0;
    Case slow = still;
    slow.loads[0].history = haversine_history(2.0, 2.0);
    slow.settings.time_step = 0.02;
    const auto at_rest = run(still);
    const auto moving = run(slow);
    ASSERT_TRUE(at_rest && moving);
    for (std::size_t i = 0; i < 3; ++i) {
        EXPECT_NEAR(moving->values[i], at_rest->values[i], 0.005 * at_rest->values[0]) << i;
    }
    EXPECT_NEAR(moving->values[3] / at_rest->values[3], 1.0, 0.01);
}

TEST(SolidPulse, HasExactDerivatives) {
    Case c = on_a_base_that_follows_the_stress();
    c.half_space = true;
    expect_exact_derivatives(c,
                             {"asphalt.modulus_MPa", "base.k1", "base.k2", "base.k3", "base.n", "base.density_kg_m3",
                              "base.damping_time_ms", "subgrade.modulus_MPa", "subgrade.density_kg_m3",
                              "dual.time_shift_ms", "dual.pressure_kPa", "base.thickness_mm"},
                             1e-5);
}

// The displacements that a motion takes span a subspace that it lies in: looked for there, with all Gauss points, it is
// the same, though the subspace has 30 dimensions of some thousand.
TEST(SolidPulse, InTheSubspaceOfItsOwnMotionIsItself) {
    Case c = on_a_base_that_follows_the_stress();
    const auto full = make_finite_element_model(c, 0);
    const auto workspace = full->make_workspace();
    std::vector<Eigen::VectorXd> fields;
    full->watch(*workspace, [&](const Eigen::VectorXd& u, const Eigen::VectorXd&) { fields.push_back(u); });
    const auto expected = full->run(c, materials_of(c), {}, {}, *workspace);
    ASSERT_TRUE(expected);
    Eigen::MatrixXd spanned(fields[0].size(), static_cast<Eigen::Index>(fields.size()));
    for (std::size_t i = 0; i < fields.size(); ++i) {
        spanned.col(static_cast<Eigen::Index>(i)) = fields[i];
    }
    const Eigen::HouseholderQR<Eigen::MatrixXd> qr(spanned);
    fe::Subspace own{qr.householderQ() * Eigen::MatrixXd::Identity(spanned.rows(), spanned.cols()), {}};
    const auto parts = parts_of<Solid>(c, 0);
    for (int q = 0; q < parts.model.elements() * fe::Hex20::gauss; ++q) {
        if (parts.model.topology->layer[static_cast<std::size_t>(q / fe::Hex20::gauss)] == 1) {
            own.points.push_back({q, 1.0});
        }
    }
    const auto reduced = make_pulse_model(c, 0, std::move(own));
    const auto found = reduced->run(c, materials_of(c), {}, {}, *reduced->make_workspace());
    ASSERT_TRUE(found);
    for (std::size_t i = 0; i < c.sensors.size(); ++i) {
        EXPECT_NEAR(found->values[i], expected->values[i], 1e-6 * std::abs(expected->values[i])) << i;
    }
}

// A wall at 2.5 m, far too near, changes deflections by 6 % of the largest; were its dashpots across and along
// exchanged, by 14 %.
TEST(SolidPulse, LosesItsWavesThroughAWallThatIsNear) {
    Case c = layered_section(true);
    c.settings.refine = 1.0;
    c.loads[0].history = haversine_history(duration, 0.06);
    for (int i = 5; i <= 29; ++i) {
        for (const double x : {0.0, 0.9}) {
            c.sensors.push_back(deflection(x));
            c.sensors.back().time = 2e-3 * i;
        }
    }
    const auto far = run(c);
    c.settings.extent = 2.5;
    const auto near = run(c);
    ASSERT_TRUE(far && near);
    double error = 0.0;
    for (std::size_t i = 0; i < c.sensors.size(); ++i) {
        error = std::max(error, std::abs(near->values[i] - far->values[i]));
    }
    EXPECT_LT(error, 0.08 * *std::max_element(far->values.begin(), far->values.end()));
}
