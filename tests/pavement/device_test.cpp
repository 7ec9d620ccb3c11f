// Slopes and Benkelman beams against the closed form of a half-space, the layered engine and deflections by hand.
#include "support/sections.h"

#include "base/error.h"
#include "pavement/device.h"

#include <cmath>
#include <gtest/gtest.h>

using namespace test;

namespace {

constexpr double modulus = 100e6, poisson = 0.4, radius = 0.15, pressure = 595e3;

// A half-space under the plate, outside of it (Johnson 1985, Contact Mechanics, 3.4.2): with k = a/r
//     w = 4 (1 - nu^2) p r / (pi E) (E(k) - (1 - k^2) K(k)),    -dw/dr = 4 (1 - nu^2) p / (pi E) (K(k) - E(k))
double factor() {
    return 4.0 * (1.0 - poisson * poisson) * pressure / (std::numbers::pi * modulus);
}
double w(double r) {
    const double k = radius / r;
    return factor() * r * (std::comp_ellint_2(k) - (1.0 - k * k) * std::comp_ellint_1(k));
}
double fall(double r) {
    const double k = radius / r;
    return factor() * (std::comp_ellint_1(k) - std::comp_ellint_2(k));
}

Sensor reads(Quantity quantity, double x, double y) {
    return {0, quantity, x, y, 0.0, 0.0};
}

Case half_space() {
    Case c;
    c.layers = {linear_layer("ground", 3.0, modulus, poisson)};
    c.loads = {plate(radius, pressure)};
    c.half_space = true;
    c.settings.layered = true;
    return c;
}

std::vector<double> values_of(Case c) {
    c.settings.extent = c.default_extent();
    const auto response = run(c);
    EXPECT_TRUE(response) << response.failure().reason;
    return response->values;
}

TEST(Slope, IsThatOfTheClosedForm) {
    Case c = half_space();
    for (const double y : {0.2, 0.3, 0.6, 1.5}) {
        c.sensors.push_back(reads(Quantity::slope, 0.0, y));
        c.sensors.push_back(reads(Quantity::slope, 0.0, -y)); // behind the load the surface rises again
        c.sensors.push_back(reads(Quantity::slope, 0.3, y));  // beside it: the part of the fall that is along y
    }
    const auto found = values_of(c);
    std::size_t i = 0;
    for (const double y : {0.2, 0.3, 0.6, 1.5}) {
        // The difference of fourth order errs by h^4 w'''''/30: far away 4 (h/r)^4 of the slope, more near the plate.
        const double within = y < 0.25 ? 1e-3 : 20.0 * std::pow(0.01 / y, 4) + 1e-7;
        EXPECT_NEAR(found[i] / fall(y), 1.0, within) << y;
        EXPECT_NEAR(found[i + 1] / -fall(y), 1.0, within) << y;
        const double r = std::hypot(0.3, y);
        EXPECT_NEAR(found[i + 2] / (fall(r) * y / r), 1.0, 1e-5) << y;
        i += 3;
    }
}

TEST(Benkelman, ReadsItsTipLessItsFeet) {
    Case c = half_space();
    c.sensors = {reads(Quantity::benkelman, 0.0, 0.0), reads(Quantity::benkelman, 0.0, -0.5)};
    const auto found = values_of(c);
    const double rear = 410.0, front = 269.0; // cm from the tip; the standards' correction is 2.91 of the front feet
    ASSERT_NEAR(rear / (rear - front), 2.91, 0.005);
    const auto feet = [&](double y) {
        return rear / (rear - front) * w(std::hypot(0.165, y + 2.69)) - front / (rear - front) * w(y + 4.10);
    };
    const double under_the_load = 2.0 * (1.0 - poisson * poisson) * pressure * radius / modulus;
    EXPECT_NEAR(found[0] / (under_the_load - feet(0.0)), 1.0, 1e-5);
    EXPECT_NEAR(found[1] / (w(0.5) - feet(0.5)), 1.0, 1e-5) << "the beam lies away from the load";
    EXPECT_LT(found[0], 0.99 * under_the_load) << "feet in the bowl take something off";
}

// The same between two wheels, by finite elements in three dimensions, by those of a circle, and by the layered engine.
TEST(Devices, ReadTheSameInEveryEngine) {
    Case c;
    c.layers = {linear_layer("asphalt", 0.15, 3000e6, 0.35), linear_layer("base", 0.30, 300e6, 0.35),
                linear_layer("subgrade", 4.0, 60e6, 0.40)};
    for (const double y : {0.1, 0.2, 0.3, 0.45, 0.6, 0.9, 1.5}) {
        c.sensors.push_back(reads(Quantity::slope, 0.0, y));
    }
    c.sensors.push_back(reads(Quantity::benkelman, 0.0, 0.0));
    for (const bool dual : {false, true}) {
        c.loads = {dual ? dual_wheel(40e3, 650e3, Patch::circle) : plate()};
        c.settings.layered = true;
        const auto exact = values_of(c);
        c.settings.layered = false;
        const auto found = values_of(c);
        for (std::size_t i = 0; i < exact.size(); ++i) {
            EXPECT_NEAR(found[i] / exact[i], 1.0, 0.02) << i << (dual ? " dual" : "");
        }
    }
}

TEST(Devices, ReadTheSurfaceWithinTheWall) {
    Case c = half_space();
    c.sensors = {reads(Quantity::benkelman, 0.0, 0.0)};
    EXPECT_NEAR(reach_of(c.sensors[0]), 4.10, 1e-12);
    EXPECT_GT(c.default_extent(), 4.10);
    c.settings.extent = 4.0; // nearer than the rear foot
    EXPECT_THROW(check_sensor(c, c.sensors[0], {.key = "sensor"}), Error);
    c.settings.extent = 9.0;
    c.sensors[0].depth = 0.1;
    EXPECT_THROW(check_sensor(c, c.sensors[0], {.key = "sensor"}), Error);
}

} // namespace
