// What of the ends of searches is a minimum, and how far parameters reach where an inequality holds them: by a dense
// grid.
#include "landscape/allowed_share.h"
#include "landscape/held_ranges.h"
#include "support/formula.h"

#include <gsl/gsl_cdf.h>
#include <gtest/gtest.h>

using namespace explore;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using test::Formula;

namespace minima_test { // of names that other tests have too
namespace {

constexpr double sigma = 0.05;

MatrixXd two_by_three() {
    MatrixXd a(3, 2);
    a << 1.0, 0.2, 0.3, 0.9, -0.4, 0.5;
    return a;
}

Formula linear(const MatrixXd& a) {
    return Formula([a](const VectorXd& x, VectorXd& responses, MatrixXd& jacobian) {
        responses = a * x;
        jacobian = a;
    });
}

// p0 + p1 <= bound, or == bound.
class Sum final : public problem::Limit {
public:
    explicit Sum(double bound, bool equality = false) : bound_(bound), equality_(equality) {}
    std::string text() const override { return "p0 + p1 <= bound"; }
    bool is_equality() const override { return equality_; }
    double value(std::span<const double> p, std::span<const double>) const override {
        return (p[0] + p[1] - bound_) / tolerance;
    }
    Eigen::RowVectorXd gradient(std::span<const double>, std::span<const double>, const MatrixXd&) const override {
        return Eigen::RowVector2d(1.0, 1.0) / tolerance;
    }
    static constexpr double tolerance = 1e-4;

private:
    double bound_;
    bool equality_;
};

// Of a linear problem, the noise as it is stated: |root d + rest|^2 without what it was taken larger by.
landscape::LocalAnalysis by_stated_noise(const landscape::Minimum& best, const problem::Problem& problem,
                                         const MatrixXd& a, const VectorXd& wanted) {
    landscape::LocalAnalysis local = landscape::analyse(best, problem);
    local.widened = false;
    local.noise_is_stated = true;
    const VectorXd at = VectorXd::Map(best.unit.data(), 2);
    const Eigen::HouseholderQR<MatrixXd> qr(a / sigma);
    local.root = qr.matrixQR().topRows(2).triangularView<Eigen::Upper>();
    local.rest = (qr.householderQ().transpose() * (a * at - wanted) / sigma).head(2);
    return local;
}

run::Endpoint end_at(run::Engine& engine, const std::vector<double>& unit, int start, bool converged) {
    run::Endpoint end;
    end.start = start;
    end.evaluation = engine.evaluate_one(unit);
    end.search = {.unit = unit,
                  .misfit = end.evaluation.misfit,
                  .evaluations = 9,
                  .converged = converged,
                  .stopped = false,
                  .ended = {}};
    return end;
}

const std::vector<double> measured{0.8, 0.9, 0.1}; // by themselves they call for p0 + p1 = 1.35

} // namespace

TEST(Minima, AnEndThatCameEarlyIsNone) {
    const auto problem = test::problem_of(2, linear(two_by_three()), measured, sigma);
    run::Engine engine(problem, nullptr, 0, {.threads = 1, .show_progress = false});
    const std::vector<double> low{0.6, 0.7};
    const std::vector<double> high{0.1, 0.2};
    ASSERT_LT(engine.evaluate_one(low).misfit, engine.evaluate_one(high).misfit);
    EXPECT_EQ(landscape::distinct_minima({end_at(engine, low, 0, true), end_at(engine, high, 1, true)}, problem).size(),
              2);
    const auto one =
        landscape::distinct_minima({end_at(engine, low, 0, true), end_at(engine, high, 1, false)}, problem);
    ASSERT_EQ(one.size(), 1);
    EXPECT_EQ(one[0].members, std::vector<int>{0});
    // Beside a minimum that is known it belongs to that; and the lowest of all is said, with what it is.
    const auto near =
        landscape::distinct_minima({end_at(engine, low, 0, true), end_at(engine, {0.602, 0.7}, 1, false)}, problem);
    ASSERT_EQ(near.size(), 1);
    EXPECT_EQ(near[0].members.size(), 2);
    const auto lowest =
        landscape::distinct_minima({end_at(engine, low, 0, false), end_at(engine, high, 1, true)}, problem);
    ASSERT_EQ(lowest.size(), 2);
    EXPECT_FALSE(lowest[0].converged);
}

// One reading of two parameters without noise: the valley p0 + p1 = 0.5, met to 1e-9, 3e-7 and 8e-7 of the reading.
TEST(Minima, EndsThatDifferByRoundingAreOne) {
    problem::ParameterSpace space;
    for (const char* name : {"p0", "p1"}) {
        space.axes.push_back({name, 0.0, 1.0, problem::Scale::linear, 0, 0.5});
    }
    const problem::Problem problem(space, std::make_shared<Formula>(linear(MatrixXd::Ones(1, 2))),
                                   {problem::MisfitKind::relative, {{0, 0.5, 0.5, 1.0}}});
    run::Engine engine(problem, nullptr, 0, {.threads = 1, .show_progress = false});
    const auto minima = landscape::distinct_minima({end_at(engine, {0.2, 0.3 + 0.5e-9}, 0, true),
                                                    end_at(engine, {0.4, 0.1 + 1.5e-7}, 1, true),
                                                    end_at(engine, {0.1, 0.4 - 4e-7}, 2, true)},
                                                   problem);
    EXPECT_EQ(minima.size(), 1);
    // Where it can be told it is.
    EXPECT_EQ(
        landscape::distinct_minima({end_at(engine, {0.2, 0.3}, 0, true), end_at(engine, {0.4, 0.11}, 1, true)}, problem)
            .size(),
        2);
}

// The valley p0 + p1 = 0.5 of one reading with noise: its lowest end lies on a bound, by rounding.
TEST(Minima, StandsOffItsBoundsWhereTheMisfitTellsNothing) {
    const auto problem = test::problem_of(2, linear(MatrixXd::Ones(1, 2)), {0.5}, sigma);
    run::Engine engine(problem, nullptr, 0, {.threads = 1, .show_progress = false});
    const auto lowest = end_at(engine, {0.5, 0.0}, 0, true);
    const auto inside = end_at(engine, {0.3, 0.2 + 1e-9}, 1, true);
    ASSERT_LT(lowest.search.misfit, inside.search.misfit);
    const auto minima = landscape::distinct_minima({lowest, inside}, problem);
    ASSERT_EQ(minima.size(), 1);
    EXPECT_TRUE(minima[0].on_bound.empty());
    EXPECT_EQ(minima[0].members, (std::vector<int>{1, 0}));
    // A bound that the readings ask for stays.
    const auto higher = end_at(engine, {0.3, 0.2 + 0.05 * sigma}, 1, true);
    EXPECT_EQ(landscape::distinct_minima({lowest, higher}, problem)[0].on_bound.size(), 1);
}

// The profile over the triangle that the limit leaves, by a grid: of the rise of chi2 above its lowest value there.
TEST(HeldRanges, EndWhereTheProfileOverWhatIsAllowedDoes) {
    const MatrixXd a = two_by_three();
    constexpr double allowed = 3.841458820694124;      // 95 % of chi2 with one degree of freedom
    const Eigen::Vector2d slope(0.7, -1.3);            // of a quantity
    for (const double bound : {0.9, 1.2, 1.34, 1.4}) { // from far within what the readings want to beyond it
        problem::Problem problem = test::problem_of(2, linear(a), measured, sigma);
        problem.limits.push_back(std::make_shared<Sum>(bound));
        run::Engine engine(problem, nullptr, 0, {.threads = 1, .show_progress = false});
        const auto ends =
            engine.search({{0.3, 0.3}}, *optimise::find_method("gauss-newton"), {.step_tolerance = 1e-9}, 0);
        const auto best = landscape::distinct_minima(*ends, problem)[0];
        const auto local = by_stated_noise(best, problem, a, VectorXd::Map(measured.data(), 3));
        const auto ranges = landscape::held_ranges(problem, best, local);
        ASSERT_TRUE(ranges.any()) << bound;
        const auto of_quantity = landscape::held_range(problem, best, local, slope);
        constexpr int steps = 1000;
        double lowest = INFINITY;
        const Eigen::Matrix<double, 3, 2> slopes = a;
        const Eigen::Vector3d wanted = VectorXd::Map(measured.data(), 3);
        const auto chi2 = [&](double x, double y) {
            return (slopes * Eigen::Vector2d(x, y) - wanted).squaredNorm() / (sigma * sigma);
        };
        const auto each = [&](const auto& visit) {
            for (int i = 0; i <= steps; ++i) {
                for (int j = 0; j <= steps; ++j) {
                    const double x = static_cast<double>(i) / steps;
                    const double y = static_cast<double>(j) / steps;
                    if (x + y <= bound + 1e-12) { // nodes on it count
                        visit(x, y, chi2(x, y));
                    }
                }
            }
        };
        each([&](double, double, double value) { lowest = std::min(lowest, value); });
        double low[3] = {INFINITY, INFINITY, INFINITY};
        double high[3] = {-INFINITY, -INFINITY, -INFINITY};
        each([&](double x, double y, double value) {
            if (value - lowest <= allowed) {
                const double values[3] = {x, y, slope.dot(Eigen::Vector2d(x, y))};
                for (int q = 0; q < 3; ++q) {
                    low[q] = std::min(low[q], values[q]);
                    high[q] = std::max(high[q], values[q]);
                }
            }
        });
        for (int k = 0; k < 2; ++k) {
            if (const auto& range = ranges.parameters[static_cast<std::size_t>(k)]) {
                EXPECT_NEAR(range->low, low[k], 2.5e-3) << bound << " p" << k;
                EXPECT_NEAR(range->high, high[k], 2.5e-3) << bound << " p" << k;
            } else { // the standard error tells it
                const MatrixXd normal = a.transpose() * a;
                const double half = 1.96 * sigma * std::sqrt(normal.inverse()(k, k));
                const double width = high[k] - low[k];
                EXPECT_NEAR(best.unit[static_cast<std::size_t>(k)] - half, low[k], 0.06 * width) << bound << " p" << k;
                EXPECT_NEAR(best.unit[static_cast<std::size_t>(k)] + half, high[k], 0.06 * width) << bound << " p" << k;
            }
        }
        if (of_quantity) {
            const double here = slope.dot(Eigen::Vector2d(best.unit[0], best.unit[1]));
            EXPECT_NEAR(here + of_quantity->low, low[2], 4e-3) << bound;
            EXPECT_NEAR(here + of_quantity->high, high[2], 4e-3) << bound;
        }
    }
    // One that nothing comes near changes nothing.
    problem::Problem problem = test::problem_of(2, linear(a), measured, sigma);
    problem.limits.push_back(std::make_shared<Sum>(1.95));
    run::Engine engine(problem, nullptr, 0, {.threads = 1, .show_progress = false});
    const auto ends = engine.search({{0.3, 0.3}}, *optimise::find_method("gauss-newton"), {}, 0);
    const auto best = landscape::distinct_minima(*ends, problem)[0];
    EXPECT_FALSE(landscape::held_ranges(problem, best, landscape::analyse(best, problem)).any());
}

// The readings want p0 beyond its bound, 1: the profile of p1 is taken over p0 up to there, by a fine scan.
TEST(HeldRanges, AtABoundEndWhereTheProfileInTheBoxDoes) {
    MatrixXd a(3, 2); // which trades p0 for p1
    a << 1.0, 0.9, 0.3, 0.5, -0.4, 0.1;
    const VectorXd wanted = a * Eigen::Vector2d(1.03, 0.4);
    const problem::Problem problem = test::problem_of(2, linear(a), {wanted.begin(), wanted.end()}, sigma);
    run::Engine engine(problem, nullptr, 0, {.threads = 1, .show_progress = false});
    const auto ends = engine.search({{0.3, 0.3}}, *optimise::find_method("gauss-newton"), {.step_tolerance = 1e-9}, 0);
    const auto best = landscape::distinct_minima(*ends, problem)[0];
    ASSERT_EQ(best.on_bound.size(), 1);
    const auto local = by_stated_noise(best, problem, a, wanted);
    EXPECT_FALSE(landscape::held_ranges(problem, best, local).any());
    const auto ranges = landscape::held_ranges(problem, best, local, true);
    ASSERT_TRUE(ranges.any() && ranges.of(0) && ranges.of(1));
    const auto profile = [&](double p1) {
        const VectorXd rest = wanted - p1 * a.col(1);
        const double p0 = std::min(1.0, a.col(0).dot(rest) / a.col(0).squaredNorm());
        return (rest - p0 * a.col(0)).squaredNorm() / (sigma * sigma);
    };
    constexpr double step = 1e-4;
    double lowest = INFINITY;
    for (double p1 = 0.0; p1 <= 1.0; p1 += step) {
        lowest = std::min(lowest, profile(p1));
    }
    double low = INFINITY;
    double high = -INFINITY;
    for (double p1 = 0.0; p1 <= 1.0; p1 += step) {
        if (profile(p1) - lowest <= 3.841458820694124) { // 95 % of chi2 with one degree of freedom
            low = std::min(low, p1);
            high = std::max(high, p1);
        }
    }
    EXPECT_NEAR(ranges.of(1)->low, low, 2e-3);
    EXPECT_NEAR(ranges.of(1)->high, high, 2e-3);
    EXPECT_NEAR(ranges.of(0)->high, 1.0, 1e-9);
}

TEST(AllowedShare, IsTheVolumeThatConstraintsLeave) {
    problem::Problem problem = test::problem_of(2, linear(two_by_three()), measured, sigma);
    EXPECT_FALSE(landscape::allowed_share(problem, 1));
    problem.limits.push_back(std::make_shared<Sum>(0.6));
    const auto triangle = landscape::allowed_share(problem, 1);
    ASSERT_TRUE(triangle);
    EXPECT_NEAR(triangle->log, std::log(0.5 * 0.6 * 0.6), 4.0 * triangle->error);
    EXPECT_LT(triangle->error, 0.02);
    // Of a prior of p0, normal and cut off at the box: the mean of what is left for p1.
    problem.space.axes[0].prior = {.mean = 0.2, .sd = 0.3};
    double sum = 0.0;
    double whole = 0.0;
    for (double p = 5e-5; p < 1.0; p += 1e-4) {
        const double density = std::exp(-0.5 * std::pow((p - 0.2) / 0.3, 2));
        whole += density;
        sum += density * std::max(0.0, 0.6 - p);
    }
    const auto known = landscape::allowed_share(problem, 1);
    ASSERT_TRUE(known);
    EXPECT_NEAR(known->log, std::log(sum / whole), 4.0 * known->error);
    // An equality is met within its tolerance t: sqrt(2 pi) t times the density of p0 + p1 at the bound.
    problem.space.axes[0].prior.reset();
    problem.limits = {std::make_shared<Sum>(0.6, true)};
    const auto plane = landscape::allowed_share(problem, 1);
    ASSERT_TRUE(plane);
    EXPECT_NEAR(plane->log, std::log(std::sqrt(2.0 * std::acos(-1.0)) * Sum::tolerance * 0.6), 4.0 * plane->error);
    EXPECT_LT(plane->error, 0.25);
}

} // namespace minima_test
