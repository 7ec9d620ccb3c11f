// The function between known points: exact where theory says so, elsewhere about as wrong as it says.
#include "inference/kriging.h"

#include <cmath>
#include <gtest/gtest.h>

namespace {

using namespace explore::inference;

struct Known {
    Eigen::VectorXd values;
    Eigen::MatrixXd slopes;
};

// A polynomial of second degree, and a function that is none.
Known truth(double x, double y) {
    const double wave = std::sin(3.0 * x + y);
    Known known{Eigen::VectorXd(2), Eigen::MatrixXd(2, 2)};
    known.values << 1.0 + 2.0 * x - y + 3.0 * x * y + y * y, std::exp(-2.0 * x) + wave;
    known.slopes << 2.0 + 3.0 * y, -1.0 + 3.0 * x + 2.0 * y, -2.0 * std::exp(-2.0 * x) + 3.0 * std::cos(3.0 * x + y),
        std::cos(3.0 * x + y);
    return known;
}

// Points of a Kronecker sequence, which fills the square evenly.
std::vector<KnownPoint> points(int count, bool with_slopes) {
    std::vector<KnownPoint> list;
    for (int k = 1; k <= count; ++k) {
        const double x = std::fmod(k * 0.7548776662, 1.0), y = std::fmod(k * 0.5698402910, 1.0);
        const Known known = truth(x, y);
        list.push_back({{x, y}, known.values, with_slopes ? known.slopes : Eigen::MatrixXd()});
    }
    return list;
}

class KrigingOf : public testing::TestWithParam<bool> {};

TEST_P(KrigingOf, KnownPointsAreGivenBack) {
    const Kriging between(points(30, GetParam()));
    for (const KnownPoint& point : between.known()) {
        const auto at = between.at(point.unit, true);
        // The square root of what keeps the matrix from being singular (1e-9), in units of the process, is a bound.
        EXPECT_LT(((at.values - point.values).cwiseAbs().array() / between.ranges().array()).maxCoeff(), 1e-3);
        EXPECT_LT((at.deviations.array() / between.ranges().array()).maxCoeff(), 1e-3);
        if (GetParam()) {
            EXPECT_LT((at.slopes - point.slopes).cwiseAbs().maxCoeff(), 1e-3);
        }
    }
}

TEST_P(KrigingOf, APolynomialIsExactAndSlopesAreThoseOfTheValues) {
    const Kriging between(points(30, GetParam()));
    for (const double x : {0.05, 0.4, 0.93}) {
        for (const double y : {0.1, 0.55, 0.97}) {
            const std::vector<double> at = {x, y};
            const auto here = between.at(at, true);
            const Known known = truth(x, y);
            EXPECT_NEAR(here.values[0], known.values[0], 1e-8);
            EXPECT_NEAR(here.slopes(0, 0), known.slopes(0, 0), 1e-6);
            EXPECT_NEAR(here.slopes(0, 1), known.slopes(0, 1), 1e-6);
            constexpr double h = 1e-4;
            for (int j = 0; j < 2; ++j) {
                std::vector<double> up = at, down = at;
                up[static_cast<std::size_t>(j)] += h;
                down[static_cast<std::size_t>(j)] -= h;
                const double slope = (between.at(up, false).values[1] - between.at(down, false).values[1]) / (2.0 * h);
                EXPECT_NEAR(here.slopes(1, j), slope, 1e-4);
            }
        }
    }
}

TEST_P(KrigingOf, ErrorsAreAboutAsLargeAsItSaysAndFallWithMorePoints) {
    double before = 1.0;
    for (const int count : {15, 60}) {
        const Kriging between(points(count, GetParam()));
        double error = 0.0, deviations = 0.0;
        for (int k = 1; k <= 200; ++k) {
            const std::vector<double> at = {std::fmod(0.3 + k * 0.7548776662, 1.0),
                                            std::fmod(0.7 + k * 0.5698402910, 1.0)};
            const auto here = between.at(at, false);
            const double own = std::abs(here.values[1] - truth(at[0], at[1]).values[1]);
            error = std::max(error, own);
            deviations = std::max(deviations, here.deviations[1]);
        }
        EXPECT_LT(error, before / 10.0);
        EXPECT_LT(error, 5.0 * deviations);
        before = error;
    }
}

INSTANTIATE_TEST_SUITE_P(Slopes, KrigingOf, testing::Bool());

} // namespace
