// Cases in which every effect finds something to act on, and effects applied to them.
#pragma once

#include "pavement/effects/catalog.h"
#include "support/sections.h"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <numbers>

namespace test {

inline Load circular_wheel() {
    Load load;
    load.name = "wheel";
    load.type = LoadType::wheel;
    load.patch = Patch::circle;
    load.force = 40e3;
    load.pressure = 650e3;
    return load;
}

// A plate and a circular wheel; deflections, gauges and points.
inline Case axisymmetric_case(Integration integration = Integration::incremental) {
    Case c = captif(3000, 40, {.k1 = 2000, .k2 = 0.4, .k3 = -0.3, .n = 0.4, .eta = 0.3}, integration);
    c.loads.push_back(circular_wheel());
    c.sensors = {deflection(0.0), deflection(0.45), strain_zz(0.1875, 0.075), strain_zz(0.42, 0.0)};
    c.sensors.push_back({1, Quantity::strain_zz, 0.08, 0.0, 0.2, 0.075});
    c.sensors.push_back({1, Quantity::strain_zz, 0.05, 0.0, 0.45, 0.0});
    c.sensors.push_back({1, Quantity::deflection, 0.21, 0.0, 0.0, 0.0});
    c.sensors.push_back({1, Quantity::stress_zz, 0.05, 0.0, 0.25, 0.0});
    c.sensors.push_back({1, Quantity::strain_xx, 0.02, 0.0, 0.027, 0.0});
    c.settings.refine = 0.5;
    return c;
}

// The same plate with the history of a pulse, its wheel at rest.
inline Case in_motion(Case c) {
    c.loads[0].history = haversine_history(0.025, 0.04, 25);
    for (Layer& layer : c.layers) {
        layer.damping_time = 5e-4;
    }
    c.settings.time_step = 1e-3;
    return c;
}

inline Case solid_case() {
    Case c = axisymmetric_case();
    c.loads = {dual_wheel()};
    c.sensors = {deflection(0.17),
                 strain_zz(0.1875, 0.075, 0.17),
                 strain_zz(0.42, 0.0, 0.15),
                 {0, Quantity::stress_xx, 0.1, 0.0, 0.25, 0.0},
                 {0, Quantity::strain_xx, 0.17, 0.0, 0.027, 0.0}};
    c.settings.extent = 2.0;
    c.settings.refine = 0.4;
    c.settings.solver.linear_tolerance = 1e-11;
    return c;
}

inline Case with(Case c, const Effect& effect, double size, bool present = false) {
    AppliedEffect applied;
    applied.effect = &effect;
    applied.size = size;
    applied.present = present;
    c.effects.push_back(std::move(applied));
    return c;
}
inline Case with(Case c, std::string_view name, double size) {
    return with(std::move(c), *find_effect(name), size);
}

inline std::vector<double> values_of(const Case& c) {
    const auto response = test::run(c);
    EXPECT_TRUE(response) << response.failure().reason;
    return response ? response->values : std::vector<double>(c.sensors.size(), 0.0);
}

inline double largest_change(const std::vector<double>& a, const std::vector<double>& b) {
    double largest = 0.0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        largest = std::max(largest, std::abs(a[i] / b[i] - 1.0));
    }
    return largest;
}

// A column of linear soil under a plate as wide as its smooth wall: everything is one-dimensional.
inline Case column(double modulus, double poisson, double depth, double density = 2000.0) {
    Case c;
    c.layers = {linear_layer("soil", depth, modulus, poisson)};
    c.layers[0].density = density;
    c.settings.extent = 0.5;
    c.loads = {plate(0.4999999, 100e3)};
    c.sensors = {deflection(0.0)};
    c.settings.refine = 4.0;
    return c;
}
inline double oedometric(double modulus, double poisson) {
    return modulus * (1.0 - poisson) / ((1.0 + poisson) * (1.0 - 2.0 * poisson));
}

inline Case three_layers() {
    Case c;
    c.layers = {linear_layer("asphalt", 0.15, 3000e6, 0.35), linear_layer("base", 0.3, 300e6, 0.35),
                linear_layer("subgrade", 1.5, 60e6, 0.40)};
    c.loads = {plate(0.15, 600e3)};
    c.settings.extent = 8.0;
    return c;
}

} // namespace test
