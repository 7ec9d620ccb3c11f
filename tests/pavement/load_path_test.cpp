// The load path in a fixed sequence of steps: readings are as smooth in the parameters as the law is, and end where
// finer steps end. Reference: the cubic through neighbours on a line, and the same path in many more steps.
#include "base/random.h"
#include "fe/load_path.h"
#include "support/sections.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <gtest/gtest.h>
#include <limits>
#include <span>

using namespace pave;
using namespace pave::pavement;
using namespace test;

namespace {

// The plate of a deflectometer on thin asphalt; a base with the numbers of a point of the unit cube.
Case section_at(const std::vector<double>& u) {
    const auto between = [&](std::size_t k, double low, double high) { return low + u[k] * (high - low); };
    Case c;
    c.layers = {linear_layer("asphalt", 0.055, 1e6 * std::exp(between(0, std::log(1500), std::log(9000))), 0.35),
                uzan_layer("base", 0.25,
                           {.k1 = std::exp(between(1, std::log(500), std::log(6000))),
                            .k2 = between(2, 0.1, 1.0),
                            .k3 = between(3, -1.0, 0.0),
                            .n = between(4, 0.15, 0.9)}),
                linear_layer("subgrade", 1.6, 1e6 * between(5, 30, 150), 0.4)};
    c.loads = {plate(0.15, 850e3)};
    for (const double x : {0.0, 0.3, 0.9}) {
        c.sensors.push_back(deflection(x));
    }
    for (const double z : {0.08, 0.17, 0.28, 0.45}) {
        c.sensors.push_back(strain_zz(z, 0.0));
    }
    c.sensors.push_back({0, Quantity::strain_xx, 0.0, 0.0, 0.054, 0.0});
    c.sensors.push_back({0, Quantity::stress_zz, 0.0, 0.0, 0.305, 0.0});
    c.settings.refine = 0.4;
    return c;
}

constexpr std::size_t dimension = 6;

std::vector<double> drawn(std::uint64_t number) {
    const RandomStream random(11, number);
    std::vector<double> u;
    for (std::size_t k = 0; k < dimension; ++k) {
        u.push_back(random.uniform(k));
    }
    return u;
}

// Of each sensor: the largest that the middle one of five points in a row is off the cubic through the others, over its
// value; points evenly on a straight line of this length from a drawn point.
std::vector<double> jumps_on_line(std::uint64_t number, double length, int points,
                                  const std::function<std::vector<double>(const std::vector<double>&)>& readings) {
    const RandomStream random(12, number);
    const std::vector<double> from = drawn(number);
    std::vector<double> to;
    double norm = 0.0;
    for (std::size_t k = 0; k < dimension; ++k) {
        to.push_back(random.normal(k));
        norm += to[k] * to[k];
    }
    std::vector<std::vector<double>> at;
    for (int i = 0; i < points; ++i) {
        std::vector<double> u = from;
        for (std::size_t k = 0; k < dimension; ++k) {
            u[k] += length * i / (points - 1) * to[k] / std::sqrt(norm);
        }
        at.push_back(readings(u));
    }
    std::vector<double> worst(at[0].size(), 0.0);
    for (std::size_t i = 2; i + 2 < at.size(); ++i) {
        for (std::size_t r = 0; r < worst.size(); ++r) {
            const double cubic = (4.0 * (at[i - 1][r] + at[i + 1][r]) - at[i - 2][r] - at[i + 2][r]) / 6.0;
            worst[r] = std::max(worst[r], std::abs(at[i][r] - cubic) / std::abs(at[i][r]));
        }
    }
    return worst;
}

double largest(const std::vector<double>& values) {
    return *std::max_element(values.begin(), values.end());
}

// A path of two numbers, the first of which is the load factor.
struct Pair {
    double factor = 0.0;
    double value = 0.0;
    void set_zero() { *this = {}; }
    void set_sum(const Pair& from, std::span<const double> factors, std::span<const Pair* const> rates) {
        *this = from;
        for (std::size_t j = 0; j < rates.size(); ++j) {
            factor += factors[j] * rates[j]->factor;
            value += factors[j] * rates[j]->value;
        }
    }
};

// Where d(value)/d(load factor) = rate(pair) ends.
double end_of(int steps, const std::function<double(const Pair&)>& rate) {
    fe::LoadPath<Pair> path;
    path.set_zero();
    const auto failure = path.follow(
        steps, false, fe::Deadline(std::numeric_limits<double>::infinity()),
        [&](const Pair& at, int i) {
            path.slope[i] = {1.0, rate(at)};
            return true;
        },
        [](double) {});
    EXPECT_FALSE(failure);
    EXPECT_NEAR(path.now.factor, 1.0, 1e-14);
    return path.now.value;
}

} // namespace

TEST(LoadSteps, IntegrateRatesOfTheLoadToTheFourthPowerExactly) {
    for (const int power : {0, 1, 2, 3, 4}) {
        const double found = end_of(1, [&](const Pair& at) { return std::pow(at.factor, power); });
        EXPECT_NEAR(found, 1.0 / (power + 1.0), 1e-14) << power;
    }
    EXPECT_GT(std::abs(end_of(1, [](const Pair& at) { return std::pow(at.factor, 5); }) - 1.0 / 6.0), 1e-5);
}

TEST(LoadSteps, AreOfThirdOrder) {
    const auto rate = [](const Pair& at) { return 2.0 * std::exp(-at.value) * (1.0 + at.factor); };
    const double exact = std::log(4.0); // exp(value) = 1 + 2 f + f^2
    double before = 0.0;
    for (const int steps : {32, 64, 128}) {
        const double error = std::abs(end_of(steps, rate) - exact);
        if (before > 0.0) {
            EXPECT_NEAR(std::log2(before / error), 3.0, 0.1) << steps;
        }
        before = error;
    }
}

TEST(LoadSteps, LeaveReadingsOnTheCubicThroughTheirNeighboursOnFiftyLines) {
    const ForwardModel model(section_at(drawn(0)));
    const auto workspace = model.make_workspace();
    const auto readings = [&](const std::vector<double>& u) {
        const auto response = model.run(section_at(u), {}, *workspace);
        EXPECT_TRUE(response);
        return response ? response->values : std::vector<double>(9, 0.0);
    };
    double worst = 0.0;
    for (std::uint64_t line = 0; line < 50; ++line) {
        worst = std::max(worst, largest(jumps_on_line(line, 0.06, 13, readings)));
    }
    std::printf("  largest jump of a reading: %.1e\n", worst);
    EXPECT_LT(worst, 1e-5);
}

TEST(LoadSteps, LeaveHalfAPerCentInAnyReadingAndGoWithTheirThirdPower) {
    const ForwardModel model(section_at(drawn(0)));
    const auto workspace = model.make_workspace();
    const auto readings = [&](std::uint64_t number, int steps) {
        Case c = section_at(drawn(number));
        c.settings.solver.load_steps = steps > 0 ? steps : c.settings.solver.load_steps;
        const auto response = model.run(c, {}, *workspace);
        EXPECT_TRUE(response);
        return response ? response->values : std::vector<double>(c.sensors.size(), 0.0);
    };
    double of_default = 0.0;
    double of_doubled = 0.0;
    for (std::uint64_t number = 0; number < 20; ++number) {
        const auto right = readings(number, 150);
        const auto own = readings(number, 0);
        const auto doubled = readings(number, 2 * Case{}.settings.solver.load_steps);
        for (std::size_t r = 0; r < right.size(); ++r) {
            of_default = std::max(of_default, std::abs(own[r] / right[r] - 1.0));
            of_doubled = std::max(of_doubled, std::abs(doubled[r] / right[r] - 1.0));
        }
    }
    std::printf("  largest error of a reading: %.1e, in twice as many steps %.1e\n", of_default, of_doubled);
    EXPECT_LT(of_default, 5e-3);
    EXPECT_LT(of_doubled, of_default / 5.0);
}
