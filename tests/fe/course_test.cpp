// Readings over time: the extreme of a known function of time, its derivatives, and where it changes its place.
#include "fe/course.h"

#include <cmath>
#include <gtest/gtest.h>
#include <numbers>

using namespace pave;

namespace {

// a sin(2 pi t) exp(-t) at 40 steps of two periods: its first maximum at tan(2 pi t) = 2 pi, its first minimum half a
// period later.
fe::Course decaying(double a, bool with_slopes, double frequency = 1.0) {
    constexpr int steps = 80;
    constexpr double step = 2.0 / steps;
    fe::Course course(1, steps, 1, with_slopes);
    for (int i = 0; i < steps; ++i) {
        const double t = step * (i + 1);
        const double omega = 2.0 * std::numbers::pi * frequency;
        const double value = std::sin(omega * t) * std::exp(-t);
        course.values(0, i) = a * value;
        course.d_values[static_cast<std::size_t>(i)](0, 0) = value; // by a
        if (with_slopes) {
            const double slope = step * (omega * std::cos(omega * t) - std::sin(omega * t)) * std::exp(-t);
            course.slopes(0, i) = a * slope;
            course.d_slopes[static_cast<std::size_t>(i)](0, 0) = slope;
        }
    }
    return course;
}

} // namespace

TEST(Course, HasTheExtremeOfADecayingSineInEitherDirection) {
    const double omega = 2.0 * std::numbers::pi;
    const double at = std::atan(omega) / omega;
    const double most = std::sin(omega * at) * std::exp(-at);
    const double least = -most * std::exp(-0.5);
    for (const bool with_slopes : {true, false}) {
        const auto course = decaying(3.0, with_slopes);
        const double tolerance = with_slopes ? 3e-5 : 1e-3;
        EXPECT_NEAR(fe::peak(course, 0, 1.0).value, 3.0 * most, tolerance);
        EXPECT_NEAR(fe::peak(course, 0, -1.0).value, 3.0 * least, tolerance);
        EXPECT_NEAR(fe::peak(course, 0, 1.0).rates[0], most, tolerance);
        EXPECT_NEAR(fe::peak(course, 0, -1.0).rates[0], least, tolerance);
    }
}

// Where the extreme passes from one step to the next, it does not jump.
TEST(Course, HasAnExtremeThatIsContinuous) {
    for (const bool with_slopes : {true, false}) {
        double before = fe::peak(decaying(1.0, with_slopes, 1.0), 0, 1.0).value;
        double most = 0.0;
        for (int i = 1; i <= 4000; ++i) {
            const double now = fe::peak(decaying(1.0, with_slopes, 1.0 + 1e-4 * i), 0, 1.0).value;
            most = std::max(most, std::abs(now - before));
            before = now;
        }
        EXPECT_LT(most, 5e-5); // its slope by the frequency, at most 0.2, times the step, and what the cubic adds
    }
}

TEST(Course, IsAtRestBeforeAndHasOneInstantUnderALoadAtRest) {
    const fe::Course slow(Eigen::MatrixXd::Constant(1, 1, -2.0), Eigen::MatrixXd::Constant(1, 1, 5.0));
    EXPECT_EQ(fe::peak(slow, 0, 1.0).value, 0.0); // it only goes the other way
    EXPECT_EQ(fe::peak(slow, 0, 1.0).rates[0], 0.0);
    EXPECT_EQ(fe::peak(slow, 0, -1.0).value, -2.0);
    EXPECT_EQ(fe::peak(slow, 0, -1.0).rates[0], 5.0);
    EXPECT_EQ(fe::at_instant(slow, 0, 0).value, -2.0);
    const fe::History pulse = fe::haversine(0.03, 40);
    EXPECT_EQ(pulse.factors[pulse.largest()], 1.0);
    EXPECT_EQ(pulse.factors.back(), 0.0);
    EXPECT_DOUBLE_EQ(pulse.duration(), 0.03);
}
