// Sobol indices against closed forms, elasticities against the scaling of linear elasticity.
#include "landscape/sensitivity.h"
#include "run/engine.h"
#include "support/sections.h"

#include <cmath>
#include <functional>
#include <gtest/gtest.h>
#include <numbers>

using namespace explore;

namespace {

using Formula = std::function<std::vector<double>(std::span<const double>)>;

// A formula as a model; it has no answer where `hole` says so.
class Analytic final : public problem::ForwardFunction {
public:
    explicit Analytic(Formula formula, std::function<bool(std::span<const double>)> hole = {})
        : formula_(std::move(formula)),
          hole_(std::move(hole)) {}

    std::unique_ptr<Workspace> make_workspace() const override { return std::make_unique<Workspace>(); }
    pave::Outcome<problem::Prediction> evaluate(std::span<const double> p, bool, Workspace&) const override {
        if (hole_ && hole_(p)) {
            return pave::Failure{pave::Status::no_equilibrium, "a hole"};
        }
        return problem::Prediction{formula_(p), {}, {}};
    }

private:
    Formula formula_;
    std::function<bool(std::span<const double>)> hole_;
};

problem::Problem problem_of(std::vector<problem::Axis> axes, std::shared_ptr<const Analytic> function) {
    return {{std::move(axes)}, std::move(function), problem::Misfit(problem::MisfitKind::log, {})};
}

std::vector<problem::Evaluation> evaluate(const problem::Problem& problem, int rows) {
    run::Engine engine(problem, nullptr, 0, {.threads = 2, .show_progress = false});
    return *engine.evaluate(search::radial(problem.space.dimension(), rows, 1));
}

landscape::GlobalSensitivity indices(const problem::Problem& problem, int rows,
                                     const std::vector<std::size_t>& responses = {0}) {
    return landscape::sobol_indices(evaluate(problem, rows), problem.space.axes.size(), responses, 1);
}

// sin x1 + a sin2 x2 + b x3^4 sin x1, each x uniform in [-pi, pi] (Ishigami and Homma 1990).
constexpr double a = 7.0;
constexpr double b = 0.1;
std::vector<double> ishigami(std::span<const double> x) {
    const double s = std::sin(x[1]);
    return {std::sin(x[0]) + a * s * s + b * std::pow(x[2], 4) * std::sin(x[0])};
}

std::vector<problem::Axis> ishigami_axes() {
    const double pi = std::numbers::pi;
    return {{"x1", -pi, pi}, {"x2", -pi, pi}, {"x3", -pi, pi}};
}

// Its variances by integration: V1, V2, V13.
const double v1 = 0.5 * std::pow(1 + b * std::pow(std::numbers::pi, 4) / 5, 2);
const double v2 = a * a / 8;
const double v13 = b * b * std::pow(std::numbers::pi, 8) * (1.0 / 18 - 1.0 / 50);
const double variance = v1 + v2 + v13;
const std::vector<double> ishigami_first{v1 / variance, v2 / variance, 0.0};
const std::vector<double> ishigami_total{(v1 + v13) / variance, v2 / variance, v13 / variance};

} // namespace

TEST(RadialDesign, TakesOneCoordinateFromTheOtherSampleAndGrowsAtItsEnd) {
    const auto design = search::radial(3, 16, 7);
    ASSERT_EQ(design.points.size(), 16U * 5U);
    for (std::size_t j = 0; j < 16; ++j) {
        const auto& pa = design.points[5 * j];
        const auto& pb = design.points[5 * j + 1];
        for (std::size_t i = 0; i < 3; ++i) {
            EXPECT_NE(pa[i], pb[i]);
            for (std::size_t k = 0; k < 3; ++k) {
                EXPECT_EQ(design.points[5 * j + 2 + i][k], k == i ? pb[k] : pa[k]);
            }
        }
    }
    const auto longer = search::radial(3, 32, 7);
    EXPECT_TRUE(std::equal(design.points.begin(), design.points.end(), longer.points.begin()));
}

TEST(SobolIndices, OfTheIshigamiFunctionAreItsClosedForms) {
    // The numbers commonly printed for a = 7, b = 0.1.
    EXPECT_NEAR(ishigami_first[0], 0.3139, 5e-5);
    EXPECT_NEAR(ishigami_first[1], 0.4424, 5e-5);
    EXPECT_NEAR(ishigami_total[0], 0.5576, 5e-5);
    EXPECT_NEAR(ishigami_total[2], 0.2437, 5e-5);
    const auto problem = problem_of(ishigami_axes(), std::make_shared<Analytic>(ishigami));
    const auto result = indices(problem, 4096);
    ASSERT_EQ(result.responses.size(), 1U);
    EXPECT_EQ(result.complete, 4096U);
    const auto& g = result.responses[0];
    EXPECT_NEAR(g.mean, a / 2, 0.02);
    EXPECT_NEAR(g.variance / variance, 1.0, 0.01);
    for (std::size_t i = 0; i < 3; ++i) {
        EXPECT_NEAR(g.first[i].value, ishigami_first[i], 0.01) << i;
        EXPECT_NEAR(g.total[i].value, ishigami_total[i], 0.01) << i;
        EXPECT_LE(g.first[i].low, ishigami_first[i]) << i;
        EXPECT_GE(g.first[i].high, ishigami_first[i]) << i;
        EXPECT_LE(g.total[i].low, ishigami_total[i]) << i;
        EXPECT_GE(g.total[i].high, ishigami_total[i]) << i;
    }
    EXPECT_NEAR(g.interactions.value, v13 / variance, 0.02);
    // Intervals of a sixteenth of the rows are four times as wide.
    const auto small = indices(problem, 256).responses[0];
    for (std::size_t i = 0; i < 3; ++i) {
        EXPECT_NEAR((small.total[i].high - small.total[i].low) / (g.total[i].high - g.total[i].low), 4.0, 1.0) << i;
    }
}

TEST(SobolIndices, OfASumAreTheVariancesOfItsTerms) {
    // y = 3 x1 - 2 ln x2 + 1000: the terms are uniform with widths 3 * 2 and 2 ln 10, and nothing interacts. The second
    // response does not vary.
    const auto problem = problem_of({{"x1", 4.0, 6.0}, {"x2", 1.0, 10.0, problem::Scale::log}, {"x3", 0.0, 1.0}},
                                    std::make_shared<Analytic>([](std::span<const double> x) {
                                        return std::vector<double>{3 * x[0] - 2 * std::log(x[1]) + 1000, 0.3};
                                    }));
    const double w1 = 36.0;
    const double w2 = std::pow(2 * std::log(10.0), 2);
    const auto result = indices(problem, 1024, {0, 1});
    const auto& g = result.responses[0];
    const std::vector<double> exact{w1 / (w1 + w2), w2 / (w1 + w2), 0.0};
    EXPECT_NEAR(g.variance / ((w1 + w2) / 12), 1.0, 0.01);
    for (std::size_t i = 0; i < 3; ++i) {
        EXPECT_NEAR(g.first[i].value, exact[i], 0.01) << i;
        EXPECT_NEAR(g.total[i].value, exact[i], 0.01) << i;
    }
    EXPECT_EQ(g.total[2].value, 0.0) << "a parameter that is not in the formula";
    EXPECT_EQ(result.responses[1].variance, 0.0);
    EXPECT_TRUE(std::isnan(result.responses[1].first[0].value));
    EXPECT_TRUE(std::isnan(result.responses[1].total[0].low));
}

TEST(SobolIndices, LeaveOutWholeRowsThatHoldAHole) {
    // Holes all over the box that follow none of the parameters: the indices stay what they are.
    const auto hole = [](std::span<const double> x) {
        const double h = 1e4 * (std::sin(12.9 * x[0]) + std::sin(78.2 * x[1]) + std::sin(37.7 * x[2]));
        return h - std::floor(h) < 0.1;
    };
    const auto problem = problem_of(ishigami_axes(), std::make_shared<Analytic>(ishigami, hole));
    const auto evaluations = evaluate(problem, 4096);
    std::size_t whole = 0;
    for (std::size_t j = 0; j < 4096; ++j) {
        bool any = false;
        for (std::size_t c = 0; c < 5; ++c) {
            any = any || hole(evaluations[5 * j + c].parameters);
        }
        whole += any ? 0 : 1;
    }
    EXPECT_NEAR(static_cast<double>(whole) / 4096.0, std::pow(0.9, 5), 0.05);
    const auto result = landscape::sobol_indices(evaluations, 3, {0}, 1);
    EXPECT_EQ(result.rows, 4096U);
    EXPECT_EQ(result.complete, whole);
    for (std::size_t i = 0; i < 3; ++i) {
        EXPECT_NEAR(result.responses[0].first[i].value, ishigami_first[i], 0.05) << i;
        EXPECT_NEAR(result.responses[0].total[i].value, ishigami_total[i], 0.05) << i;
    }
}

TEST(SobolIndices, AreNotGivenWhereHardlyAnythingHasAnAnswer) {
    const auto problem =
        problem_of(ishigami_axes(), std::make_shared<Analytic>(ishigami, [](std::span<const double>) { return true; }));
    const auto result = indices(problem, 16);
    EXPECT_EQ(result.rows, 16U);
    EXPECT_EQ(result.complete, 0U);
    EXPECT_TRUE(result.responses.empty());
}

TEST(Elasticities, OfALinearSectionSumToMinusOneOverItsModuliAndAreOneForThePressure) {
    // All moduli times c: every displacement and strain divided by c, so by Euler's theorem on homogeneous functions
    // the elasticities by the moduli sum to -1; stresses do not change: 0. All are proportional to the pressure.
    test::Case c;
    c.layers = {test::linear_layer("asphalt", 0.1, 3e9, 0.35), test::linear_layer("base", 0.3, 300e6, 0.35),
                test::linear_layer("subgrade", 1.1, 50e6, 0.4)};
    c.loads = {test::plate()};
    c.sensors = {test::deflection(0.0), test::deflection(0.6), test::strain_zz(0.25, 0.075), test::strain_zz(0.5, 0.0)};
    c.sensors.push_back({0, test::Quantity::stress_zz, 0.0, 0.0, 0.3, 0.0});
    const std::vector<std::string> paths{"asphalt.modulus_MPa", "base.modulus_MPa", "subgrade.modulus_MPa",
                                         "fwd.pressure_kPa", "base.residual_stress_kPa"};
    const auto response = test::run(c, paths);
    ASSERT_TRUE(response);
    problem::Evaluation e;
    e.parameters = {3000.0, 300.0, 50.0, 595.0, 0.0};
    e.responses = response->values;
    e.jacobian = response->jacobian;
    const Eigen::MatrixXd elasticity = landscape::elasticities(e);
    ASSERT_EQ(elasticity.rows(), 5);
    for (Eigen::Index i = 0; i < 5; ++i) {
        EXPECT_NEAR(elasticity.row(i).head(3).sum(), i < 4 ? -1.0 : 0.0, 1e-6) << i;
        EXPECT_NEAR(elasticity(i, 3), 1.0, 1e-6) << i;
        EXPECT_TRUE(std::isnan(elasticity(i, 4))) << "a parameter of zero has no percentage";
    }
    EXPECT_LT(elasticity(0, 2), -0.3) << "the subgrade carries the deflection";
}
