// The course along a road against dense algebra, and what made-up courses are made with.
#include "analysis/road/road_course.h"
#include "analysis/road/road_findings.h"
#include "base/random.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <gtest/gtest.h>

using namespace explore;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

struct Road {
    std::vector<double> at, y, variance;
};

// Stations 10 to 40 m apart, their values by a process with these numbers, errors of 0.02 to 0.06.
Road made_up(std::size_t n, double sd, double length, std::uint64_t seed) {
    const pave::RandomStream stream(seed, 0xc0a2ULL);
    Road road;
    double place = 0.0;
    double f = sd * stream.normal(0);
    for (std::size_t i = 0; i < n; ++i) {
        const std::uint64_t own = 10 * (i + 1);
        if (i > 0) {
            const double step = 10.0 + 30.0 * stream.uniform(2 * own);
            const double rho = length > 0.0 ? std::exp(-step / length) : 0.0;
            place += step;
            f = rho * f + sd * std::sqrt(1.0 - rho * rho) * stream.normal(own + 1);
        }
        const double error = 0.02 + 0.04 * stream.uniform(2 * (own + 2));
        road.at.push_back(place);
        road.variance.push_back(error * error);
        road.y.push_back(0.4 + f + error * stream.normal(own + 3));
    }
    return road;
}

} // namespace

// Universal kriging by the covariance of all places (Chiles and Delfiner 2012, section 3.4).
TEST(RoadCourse, IsThatOfDenseAlgebra) {
    const Road road = made_up(30, 0.1, 80.0, 3);
    const auto n = static_cast<Index>(road.at.size());
    for (const auto& [sd, length] : {std::pair{0.12, 50.0}, {0.05, 300.0}, {0.2, 0.0}}) {
        MatrixXd k(n, n);
        for (Index i = 0; i < n; ++i) {
            for (Index j = 0; j < n; ++j) {
                const double apart =
                    std::abs(road.at[static_cast<std::size_t>(i)] - road.at[static_cast<std::size_t>(j)]);
                k(i, j) = sd * sd * (length > 0.0 ? std::exp(-apart / length) : i == j ? 1.0 : 0.0);
            }
        }
        MatrixXd c = k;
        c.diagonal() += Eigen::Map<const VectorXd>(road.variance.data(), n);
        const VectorXd y = Eigen::Map<const VectorXd>(road.y.data(), n);
        const VectorXd one = VectorXd::Ones(n);
        const MatrixXd inverse = c.inverse();
        const double information = one.dot(inverse * one);
        const double mean = one.dot(inverse * y) / information;
        double log_likelihood = 0.0;
        const auto course = analysis::course_with(road.at, road.y, road.variance, sd, length, &log_likelihood);
        EXPECT_NEAR(course.mean, mean, 1e-10);
        const VectorXd off = y - mean * one;
        EXPECT_NEAR(log_likelihood, -0.5 * (std::log(c.determinant()) + off.dot(inverse * off) + std::log(information)),
                    1e-8);
        for (Index i = 0; i < n; ++i) {
            const VectorXd weights = inverse * k.col(i);
            const double left = 1.0 - one.dot(weights);
            EXPECT_NEAR(course.value[static_cast<std::size_t>(i)], mean + weights.dot(off), 1e-10);
            EXPECT_NEAR(course.variance[static_cast<std::size_t>(i)],
                        k(i, i) - k.col(i).dot(weights) + left * left / information, 1e-10);
        }
    }
}

TEST(RoadCourse, FindsWhatMadeIt) {
    double log_length = 0.0;
    int smooth = 0;
    int inside = 0;
    int all = 0;
    constexpr int roads = 20;
    for (std::uint64_t seed = 1; seed <= roads; ++seed) {
        const Road road = made_up(200, 0.1, 150.0, 100 + seed);
        const auto course = analysis::course_of(road.at, road.y, road.variance);
        log_length += std::log(course.length / 150.0) / roads;
        smooth += course.p_none < 0.01 ? 1 : 0;
        EXPECT_NEAR(course.sd, 0.1, 0.05);
    }
    EXPECT_EQ(smooth, roads);
    EXPECT_NEAR(log_length, 0.0,
                0.2); // a length of some 33 lengths of road is known to a third, of 20 roads to a twelfth
    int alike = 0;    // where neighbours are no more alike than any two, one in twenty is said to be
    for (std::uint64_t seed = 1; seed <= 100; ++seed) {
        const Road road = made_up(40, 0.1, 0.0, 500 + seed);
        const auto course = analysis::course_of(road.at, road.y, road.variance);
        alike += course.p_none < 0.05 ? 1 : 0;
        const Road smooth_road = made_up(40, 0.1, 150.0, 900 + seed);
        const auto own = analysis::course_of(smooth_road.at, smooth_road.y, smooth_road.variance);
        inside += std::isfinite(own.variance[20]) && own.variance[20] < smooth_road.variance[20] ? 1 : 0;
        ++all;
    }
    EXPECT_LE(alike, 12);   // p = 2e-3 of more
    EXPECT_EQ(inside, all); // neighbours make a station's value better known
}

TEST(RoadCourse, LongerThanItsRoadIsSaidAsSuch) {
    EXPECT_EQ(analysis::course_length_words(9307.0, 2400.0), "more than the length of the road, 2400 m");
    EXPECT_EQ(analysis::course_length_words(412.0, 2400.0), "some 412 m");
}
