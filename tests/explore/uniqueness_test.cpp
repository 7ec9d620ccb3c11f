// The analysis of uniqueness on landscapes whose minima, valleys and ranges are known from formulas.
#include "landscape/next_measurement.h"
#include "landscape/uniqueness.h"
#include "support/formula.h"

#include "base/random.h"

#include <atomic>
#include <cmath>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <numbers>

using namespace explore;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using test::Formula;
using test::problem_of;

namespace {

landscape::Uniqueness analyse(const problem::Problem& problem, const landscape::UniquenessSettings& settings,
                              std::uint64_t seed, std::vector<std::size_t> outputs = {},
                              std::vector<std::vector<std::size_t>> groups = {}, run::Engine* explorer = nullptr) {
    run::Engine engine(problem, nullptr, 0, {.threads = 0, .show_progress = false});
    auto result = landscape::uniqueness({.fitted = problem,
                                         .everything = problem,
                                         .fitted_engine = engine,
                                         .everything_engine = engine,
                                         .outputs = std::move(outputs),
                                         .groups = std::move(groups),
                                         .seed = seed,
                                         .explorer = explorer},
                                        settings);
    EXPECT_TRUE(result.has_value());
    return *result;
}

// Random numbers of a trial, in the order they are requested.
class Draw {
public:
    explicit Draw(std::uint64_t seed) : stream_(seed, 0x7e57ULL) {}
    double between(double low, double high) { return low + (high - low) * stream_.uniform(next_++); }
    double normal() { return stream_.normal(next_++); }

private:
    pave::RandomStream stream_;
    std::uint64_t next_ = 0;
};

// A sum of squares with several minima at known places. Coordinate k < wells has the residuals s (x - a)(x - b) and
// t (x - a): a double well whose minima and ridge are the roots of a cubic. The others have s (x - a). A basin is the
// product of intervals between the ridges.
struct Wells {
    int dimension, wells;
    std::vector<double> a, b;
    double s = 40.0, t = 1.0;

    explicit Wells(std::uint64_t seed) {
        Draw draw(seed);
        dimension = 4 + static_cast<int>(seed % 3);
        wells = 2 + static_cast<int>(seed % 2);
        for (int k = 0; k < dimension; ++k) {
            a.push_back(draw.between(0.15, 0.35));
            b.push_back(draw.between(0.55, 0.85));
            if (draw.between(0.0, 1.0) < 0.5) {
                std::swap(a.back(), b.back());
            }
        }
    }

    problem::Problem problem(double failing = 0.0) const {
        const auto model = [w = *this](const VectorXd& x, VectorXd& r, MatrixXd& j) {
            r = VectorXd::Zero(w.dimension + w.wells);
            j = MatrixXd::Zero(r.size(), x.size());
            for (int k = 0; k < w.dimension; ++k) {
                const auto i = static_cast<std::size_t>(k);
                if (k < w.wells) {
                    r[k] = w.s * (x[k] - w.a[i]) * (x[k] - w.b[i]);
                    j(k, k) = w.s * (2.0 * x[k] - w.a[i] - w.b[i]);
                    r[w.dimension + k] = w.t * (x[k] - w.a[i]);
                    j(w.dimension + k, k) = w.t;
                } else {
                    r[k] = w.s * (x[k] - w.a[i]);
                    j(k, k) = w.s;
                }
            }
        };
        problem::Problem p = problem_of(dimension, Formula(model, failing),
                                        std::vector<double>(static_cast<std::size_t>(dimension + wells)), 1.0);
        return p;
    }

    // Roots of d/dx of the sum of squares of coordinate k, by bisection between the extremes of the derivative.
    struct Roots {
        double low, ridge, high;
    };
    Roots roots(int k) const {
        const auto i = static_cast<std::size_t>(k);
        const auto slope = [&](double x) {
            return s * s * (x - a[i]) * (x - b[i]) * (2.0 * x - a[i] - b[i]) + t * t * (x - a[i]);
        };
        const auto bisect = [&](double low, double high) {
            for (int n = 0; n < 100; ++n) {
                const double middle = 0.5 * (low + high);
                ((slope(low) < 0.0) == (slope(middle) < 0.0) ? low : high) = middle;
            }
            return low;
        };
        const double first = std::min(a[i], b[i]);
        const double last = std::max(a[i], b[i]);
        const double quarter = 0.21 * (last - first); // the extremes of a cubic lie at (1 -+ 1/sqrt 3)/2
        return {bisect(first - 0.05, first + quarter), bisect(first + quarter, last - quarter),
                bisect(last - quarter, last + 0.05)};
    }

    struct Known {
        std::vector<double> at;
        double basin;
    };
    std::vector<Known> minima() const {
        std::vector<Known> all{{{}, 1.0}};
        for (int k = 0; k < dimension; ++k) {
            std::vector<Known> next;
            for (const Known& m : all) {
                if (k >= wells) {
                    next.push_back(m);
                    next.back().at.push_back(a[static_cast<std::size_t>(k)]);
                    continue;
                }
                const Roots r = roots(k);
                next.push_back(m);
                next.back().at.push_back(r.low);
                next.back().basin *= r.ridge;
                next.push_back(m);
                next.back().at.push_back(r.high);
                next.back().basin *= 1.0 - r.ridge;
            }
            all = std::move(next);
        }
        return all;
    }
};

bool found_all(const Wells& wells, const landscape::Uniqueness& u) {
    for (const auto& known : wells.minima()) {
        const bool found = std::any_of(u.minima.begin(), u.minima.end(), [&](const landscape::Minimum& m) {
            double apart = 0.0;
            for (std::size_t k = 0; k < known.at.size(); ++k) {
                apart = std::max(apart, std::abs(m.unit[k] - known.at[k]));
            }
            return apart < 0.02;
        });
        if (!found && known.basin >= 0.01) {
            return false;
        }
    }
    return true;
}

// Well-posed: four amplitudes and rates of two decays, twenty readings.
void decays(const VectorXd& x, VectorXd& r, MatrixXd& j) {
    const Index n = 20;
    r.resize(n);
    j.resize(n, 4);
    for (Index i = 0; i < n; ++i) {
        const double t = 0.05 + 0.25 * static_cast<double>(i);
        const double fast = 2.0 + 4.0 * x[1];
        const double slow = 0.1 + 0.5 * x[3];
        r[i] = (1.0 + x[0]) * std::exp(-fast * t) + (1.0 + x[2]) * std::exp(-slow * t);
        j(i, 0) = std::exp(-fast * t);
        j(i, 1) = -4.0 * t * (1.0 + x[0]) * std::exp(-fast * t);
        j(i, 2) = std::exp(-slow * t);
        j(i, 3) = -0.5 * t * (1.0 + x[2]) * std::exp(-slow * t);
    }
}

} // namespace

TEST(Uniqueness, FindsEveryMinimumWithABasinOfOnePercentInAtLeast95Of100Trials) {
    int complete = 0;
    for (std::uint64_t seed = 1; seed <= 100; ++seed) {
        const Wells wells(seed);
        const auto u = analyse(wells.problem(), {.explore = 512, .verify = 60, .max_searches = 400}, seed);
        EXPECT_LE(u.ends.size(), 400U);
        complete += found_all(wells, u) ? 1 : 0;
    }
    EXPECT_GE(complete, 95);
}

TEST(Uniqueness, FindsTheSameMinimaWhenThirtyPercentOfTheEvaluationsFail) {
    int complete = 0;
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
        const Wells wells(seed);
        const auto u = analyse(wells.problem(0.3), {.explore = 512, .verify = 60, .max_searches = 400}, seed);
        complete += found_all(wells, u) ? 1 : 0;
    }
    EXPECT_GE(complete, 19);
}

// The explorer's landscape is the same moved by 3 % of the box: what it found must be sought again.
TEST(Uniqueness, SeeksAgainWhatAQuickerModelFound) {
    int complete = 0;
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
        const Wells wells(seed);
        Wells moved = wells;
        for (auto* list : {&moved.a, &moved.b}) {
            for (double& x : *list) {
                x += 0.03;
            }
        }
        const problem::Problem quick = moved.problem();
        run::Engine engine(quick, nullptr, 0, {.threads = 0, .show_progress = false});
        const auto u =
            analyse(wells.problem(), {.explore = 512, .verify = 60, .max_searches = 400}, seed, {}, {}, &engine);
        complete += found_all(wells, u) ? 1 : 0;
        EXPECT_GE(engine.tally().computed, 512); // the sample and the searches are its
        std::size_t members = 0;
        for (const auto& minimum : u.minima) {
            members += minimum.members.size();
        }
        EXPECT_EQ(members, u.ends.size()); // every search of either has its minimum
    }
    EXPECT_GE(complete, 19);
}

// p0 and p1 are seen only through p0 - (p1 - 1/2)^2, which the readings fix: the valley is that parabola, from bound to
// bound.
TEST(Uniqueness, TracesACurvedNullValleyToItsBounds) {
    const auto model = [](const VectorXd& x, VectorXd& r, MatrixXd& j) {
        r.resize(6);
        j = MatrixXd::Zero(6, 4);
        const double u = x[0] - std::pow(x[1] - 0.5, 2);
        for (Index i = 0; i < 6; ++i) {
            const double c = 1.0 + 0.3 * static_cast<double>(i);
            r[i] = c * u + std::sin(c) * x[2] + c * c * x[3];
            j(i, 0) = c;
            j(i, 1) = -2.0 * c * (x[1] - 0.5);
            j(i, 2) = std::sin(c);
            j(i, 3) = c * c;
        }
    };
    VectorXd truth(4);
    truth << 0.42, 0.45, 0.5, 0.5;
    VectorXd measured;
    MatrixXd unused;
    model(truth, measured, unused);
    const auto u = analyse(problem_of(4, Formula(model), {measured.begin(), measured.end()}, 1e-3),
                           {.explore = 128, .verify = 24}, 3);
    EXPECT_EQ(u.verdict, landscape::Verdict::non_unique);
    EXPECT_TRUE(u.valley);
    EXPECT_FALSE(u.alternatives); // its ends are no separate minima
    ASSERT_EQ(u.traces.size(), 2U);
    double lowest = 1.0;
    double highest = 0.0;
    for (const auto& trace : u.traces) {
        EXPECT_EQ(trace.end, landscape::WalkEnd::bound);
        for (const auto& p : trace.points) {
            EXPECT_LT(p.rise, 0.01);
            lowest = std::min(lowest, p.unit[1]);
            highest = std::max(highest, p.unit[1]);
            EXPECT_NEAR(p.unit[0] - std::pow(p.unit[1] - 0.5, 2), 0.42 - 0.0025, 5e-3);
        }
    }
    EXPECT_LT(lowest, 1e-6);
    EXPECT_GT(highest, 1.0 - 1e-6);
}

TEST(Uniqueness, NamesTheCombinationThatTheDataFix) {
    // Readings see p0 p1^2 alone: ln p0 + 2 ln p1.
    const auto model = [](const VectorXd& x, VectorXd& r, MatrixXd& j) {
        r.resize(3);
        j.resize(3, 2);
        for (Index i = 0; i < 3; ++i) {
            const double c = 1.0 + static_cast<double>(i);
            r[i] = c * x[0] * x[1] * x[1];
            j(i, 0) = c * x[1] * x[1];
            j(i, 1) = 2.0 * c * x[0] * x[1];
        }
    };
    auto p = problem_of(2, Formula(model), {4.0, 8.0, 12.0}, 0.04);
    for (auto& axis : p.space.axes) {
        axis = {axis.name, 0.25, 8.0, problem::Scale::log, 0, 1.0};
    }
    const auto u = analyse(p, {.explore = 64, .verify = 12}, 1);
    EXPECT_EQ(u.verdict, landscape::Verdict::non_unique);
    ASSERT_EQ(u.directions.fixed.size(), 1U);
    const auto& c = u.directions.fixed[0];
    ASSERT_EQ(c.others.size(), 1U);
    EXPECT_NEAR(c.leading == 0 ? c.others[0].coefficient : 1.0 / c.others[0].coefficient, 2.0, 1e-6);
    // One reading of 4 c with sigma 0.04 fixes the logarithm to 0.01 / c: together 0.01 / sqrt(1 + 4 + 9).
    EXPECT_NEAR(c.standard_error * (c.leading == 0 ? 1.0 : 2.0), 0.01 / std::sqrt(14.0), 1e-4);
}

TEST(Uniqueness, CallsWellPosedProblemsUniqueAndItsRangesCoverTheTruth) {
    int non_unique = 0;
    int trials = 0;
    std::vector<int> covered(5, 0);
    for (std::uint64_t seed = 1; seed <= 100; ++seed) {
        Draw draw(seed);
        VectorXd truth(4);
        for (Index k = 0; k < 4; ++k) {
            truth[k] = draw.between(0.35, 0.65);
        }
        // Response 20 is no reading: the sum of the amplitudes, an output.
        const auto model = [](const VectorXd& x, VectorXd& r, MatrixXd& j) {
            decays(x, r, j);
            r.conservativeResize(21);
            j.conservativeResize(21, Eigen::NoChange);
            r[20] = x[0] + x[2];
            j.row(20) << 1.0, 0.0, 1.0, 0.0;
        };
        VectorXd exact;
        MatrixXd unused;
        decays(truth, exact, unused);
        constexpr double sigma = 0.003;
        std::vector<double> measured;
        for (const double v : exact) {
            measured.push_back(v + sigma * draw.normal());
        }
        const auto u =
            analyse(problem_of(4, Formula(model), measured, sigma), {.explore = 64, .verify = 12}, seed, {20});
        non_unique += u.verdict == landscape::Verdict::non_unique ? 1 : 0;
        if (u.acceptance->widened) {
            continue; // one in a hundred by construction
        }
        ++trials;
        for (std::size_t k = 0; k < 4; ++k) {
            const double value = truth[static_cast<Index>(k)];
            covered[k] += u.parameters[k].low <= value && value <= u.parameters[k].high ? 1 : 0;
        }
        covered[4] += u.outputs[0].low <= truth[0] + truth[2] && truth[0] + truth[2] <= u.outputs[0].high ? 1 : 0;
    }
    EXPECT_LE(non_unique, 5);
    EXPECT_GE(trials, 95);
    for (const int count : covered) {
        EXPECT_GE(count, 90 * trials / 100);
        EXPECT_LE(count, trials);
    }
}

// On a linear model the profile is the parabola of the covariance matrix: exact ranges.
TEST(Profile, OfALinearModelIsTheEllipsoidsShadow) {
    MatrixXd a(6, 3);
    a << 1, 2, 0, 0, 1, 1, 2, 0, 1, 1, 1, 1, 0, 2, 1, 1, 0, 3;
    const auto model = [a](const VectorXd& x, VectorXd& r, MatrixXd& j) {
        r = a * x;
        j = a;
    };
    VectorXd truth(3);
    truth << 0.5, 0.45, 0.55;
    const VectorXd measured = a * truth;
    constexpr double sigma = 0.1;
    const auto u = analyse(problem_of(3, Formula(model), {measured.begin(), measured.end()}, sigma),
                           {.explore = 32, .verify = 4}, 1, {0});
    const MatrixXd covariance = sigma * sigma * (a.transpose() * a).inverse();
    constexpr double quantile = 1.959964; // 95 %, normal
    for (Index k = 0; k < 3; ++k) {
        const auto& range = u.parameters[static_cast<std::size_t>(k)];
        EXPECT_NEAR(range.high - truth[k], quantile * std::sqrt(covariance(k, k)), 0.01 * std::sqrt(covariance(k, k)));
        EXPECT_NEAR(truth[k] - range.low, quantile * std::sqrt(covariance(k, k)), 0.01 * std::sqrt(covariance(k, k)));
        EXPECT_EQ(kind_of(range), landscape::ProfileKind::bounded);
    }
    const double error = std::sqrt(a.row(0) * covariance * a.row(0).transpose());
    EXPECT_NEAR(u.outputs[0].high - measured[0], quantile * error, 0.02 * error);
}

// Readings that are linear in the parameters accept an ellipsoid: an output exp(a'x) lies between exp(a'x0 -+ s), with
// s the root of the threshold times the standard error of a'x. Where outputs cost more than the readings, few runs of
// everything find these ends.
TEST(Uniqueness, EndsOfOutputsThatCostMoreAreThoseOfTheFormula) {
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
        Draw draw(seed);
        constexpr int d = 3;
        constexpr double sigma = 0.01;
        const MatrixXd a = MatrixXd::NullaryExpr(6, d, [&] { return draw.between(-1.0, 1.0); });
        const MatrixXd b = MatrixXd::NullaryExpr(2, d, [&] { return draw.between(-6.0, 6.0); });
        const VectorXd x0 = VectorXd::NullaryExpr(d, [&] { return draw.between(0.4, 0.6); });
        const VectorXd measured = a * x0;
        std::atomic<int> runs = 0;
        const auto model = [&](bool with_outputs) {
            return Formula([&, with_outputs](const VectorXd& x, VectorXd& responses, MatrixXd& jacobian) {
                responses.resize(with_outputs ? 8 : 6);
                responses.head(6) = a * x;
                jacobian.resize(responses.size(), d);
                jacobian.topRows(6) = a;
                if (with_outputs) {
                    ++runs;
                    responses.tail(2) = (b * x).array().exp();
                    jacobian.bottomRows(2) = responses.tail(2).asDiagonal() * b;
                }
            });
        };
        const std::vector<double> readings(measured.begin(), measured.end());
        const problem::Problem fitted = problem_of(d, model(false), readings, sigma);
        const problem::Problem everything = problem_of(d, model(true), readings, sigma);
        const run::EngineSettings quiet{.threads = 0, .show_progress = false};
        run::Engine engine(fitted, nullptr, 0, quiet);
        run::Engine everything_engine(everything, nullptr, 0, quiet);
        const auto u = landscape::uniqueness({.fitted = fitted,
                                              .everything = everything,
                                              .fitted_engine = engine,
                                              .everything_engine = everything_engine,
                                              .outputs = {6, 7},
                                              .groups = {},
                                              .seed = seed,
                                              .explorer = nullptr,
                                              .outputs_cost_more = true},
                                             {.explore = 32, .verify = 4});
        ASSERT_TRUE(u && u->outputs.size() == 2);
        const MatrixXd covariance = sigma * sigma * (a.transpose() * a).inverse();
        for (Index o = 0; o < 2; ++o) {
            const VectorXd direction = b.row(o);
            const double half = std::sqrt(u->acceptance->threshold * direction.dot(covariance * direction));
            const double middle = direction.dot(x0);
            const auto& range = u->outputs[static_cast<std::size_t>(o)];
            const double allowed = 0.002 * (std::exp(middle + half) - std::exp(middle - half));
            EXPECT_NEAR(range.low, std::exp(middle - half), allowed) << seed;
            EXPECT_NEAR(range.high, std::exp(middle + half), allowed) << seed;
        }
        EXPECT_LE(runs, 30) << "of four ends";
    }
}

TEST(Profile, SaysWhichOtherBoundStopsIt) {
    // Readings fix p0 + p1 alone: p0 can only fall until p1 meets its upper bound.
    const auto model = [](const VectorXd& x, VectorXd& r, MatrixXd& j) {
        r.resize(2);
        j.resize(2, 2);
        r << x[0] + x[1], 2.0 * (x[0] + x[1]);
        j << 1.0, 1.0, 2.0, 2.0;
    };
    const auto u = analyse(problem_of(2, Formula(model), {1.3, 2.6}, 0.01), {.explore = 32, .verify = 4}, 1);
    const auto& p0 = u.parameters[0];
    EXPECT_NEAR(p0.low, 0.3, 0.02);
    EXPECT_EQ(p0.low_end, landscape::WalkEnd::threshold);
    EXPECT_EQ(p0.low_bounds, (std::vector<landscape::BoundMet>{{1, true}}));
    EXPECT_EQ(p0.high_end, landscape::WalkEnd::bound);
    EXPECT_EQ(p0.high_bounds, (std::vector<landscape::BoundMet>{{0, true}}));
}

TEST(Pass, BetweenTwoWellsIsTheirRidge) {
    Wells wells(2);
    wells.t = 0.0; // both wells fit exactly
    wells.s = 100.0;
    const auto u = analyse(wells.problem(), {.explore = 256, .verify = 24}, 1);
    EXPECT_TRUE(u.alternatives);
    EXPECT_EQ(u.alternative_of.size(), 4U);
    EXPECT_EQ(u.passes.size(), 6U);
    for (const auto& p : u.passes) {
        // The ridge between two wells is (s (a - b)^2 / 4)^2 high. Minima that differ in two coordinates: one after the
        // other crosses the higher ridge, both at once their sum.
        double highest = 0.0;
        double sum = 0.0;
        for (int k = 0; k < wells.wells; ++k) {
            const auto i = static_cast<std::size_t>(k);
            if (std::abs(u.minima[p.a].unit[i] - u.minima[p.b].unit[i]) > 0.1) {
                const double ridge = std::pow(wells.s * std::pow(wells.a[i] - wells.b[i], 2) / 4.0, 2);
                highest = std::max(highest, ridge);
                sum += ridge;
            }
        }
        EXPECT_GT(p.pass.rise, 0.99 * highest); // sampled: the very top may lie between two points
        EXPECT_LT(p.pass.rise, 1.001 * sum);
    }
}

TEST(MergeTree, FindsTheTwoWellsOfASampledLineAndTheirPass) {
    std::vector<std::vector<double>> points;
    std::vector<double> misfit;
    for (int i = 0; i <= 100; ++i) {
        const double x = 0.01 * i;
        points.push_back({x});
        misfit.push_back(std::abs(std::cos(2.0 * std::numbers::pi * x)) +
                         0.1 * x); // wells at 1/4 and 3/4, pass near 1/2
    }
    const auto tree = landscape::merge_tree(points, misfit, 2);
    ASSERT_EQ(tree.size(), 2U);
    EXPECT_NEAR(points[tree[0].point][0], 0.25, 0.011);
    EXPECT_NEAR(points[tree[1].point][0], 0.75, 0.011);
    EXPECT_EQ(tree[1].joins, 0);
    EXPECT_NEAR(tree[1].pass, 1.05, 1e-2);
    // A hole in between: there is no pass.
    for (int i = 45; i < 55; ++i) {
        misfit[static_cast<std::size_t>(i)] = std::numeric_limits<double>::quiet_NaN();
    }
    std::vector<std::vector<double>> apart = points;
    for (std::size_t i = 50; i < apart.size(); ++i) {
        apart[i][0] += 1.0;
    }
    EXPECT_EQ(landscape::merge_tree(apart, misfit, 2)[1].joins, -1);
}

TEST(Unseen, IsTheRuleOfThreeAndTheKnownEstimators) {
    // Boender and Rinnooy Kan 1987 and Chao 1984 by hand: 3 minima in 20 starts, one of them once, none twice.
    std::vector<int> found(12, 0);
    found.insert(found.end(), 7, 1);
    found.insert(found.begin() + 4, 2);
    const auto u = landscape::unseen(found, 2);
    EXPECT_EQ(u.starts, 20);
    EXPECT_EQ(u.since_new, 15);
    EXPECT_NEAR(u.volume_bound, 1.0 - std::pow(0.05, 1.0 / 15.0), 1e-12);
    EXPECT_LT(u.volume_bound, 3.0 / 15.0);
    EXPECT_NEAR(u.volume_mean, 3.0 * 4.0 / (20.0 * 19.0), 1e-12);
    EXPECT_NEAR(u.expected_minima, 3.0 * 19.0 / 15.0, 1e-12);
    EXPECT_NEAR(u.chao, 3.0, 1e-12);
}

// Two groups that read the same parameters with a shift between them.
TEST(Conflict, IsFoundWhereTheGroupsDisagreeAndElsewhereAsOftenAsItsLevelSays) {
    const auto model = [](const VectorXd& x, VectorXd& r, MatrixXd& j) {
        r.resize(12);
        j.resize(12, 2);
        for (Index i = 0; i < 12; ++i) {
            const double c = 0.2 * static_cast<double>(i % 6);
            r[i] = x[0] + c * x[1];
            j.row(i) << 1.0, c;
        }
    };
    const auto p_value = [&](double shift, std::uint64_t seed) {
        Draw draw(seed);
        std::vector<double> measured;
        for (int i = 0; i < 12; ++i) {
            measured.push_back(0.5 + 0.2 * (i % 6) * 0.5 + (i < 6 ? 0.0 : shift) + 0.01 * draw.normal());
        }
        const auto u = analyse(problem_of(2, Formula(model), measured, 0.01), {.explore = 16, .verify = 2}, seed, {},
                               {{0, 1, 2, 3, 4, 5}, {6, 7, 8, 9, 10, 11}});
        return u.conflict->p_value;
    };
    int false_alarms = 0;
    for (std::uint64_t seed = 1; seed <= 200; ++seed) {
        false_alarms += p_value(0.0, seed) < 0.05 ? 1 : 0;
    }
    // 200 at 5 %: 10 expected, binomial standard deviation 3.1; where the misfit contradicts the noise the threshold
    // moves.
    EXPECT_GE(false_alarms, 2);
    EXPECT_LE(false_alarms, 20);
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
        EXPECT_LT(p_value(0.05, seed), 1e-3);
    }
}

TEST(NextMeasurement, ThatSeesTheFlatDirectionComesFirstAndItsGainIsThatOfBayes) {
    const auto model = [](const VectorXd& x, VectorXd& r, MatrixXd& j) {
        r.resize(2);
        j.resize(2, 2);
        r << x[0] + x[1], x[0] + x[1];
        j << 1.0, 1.0, 1.0, 1.0;
    };
    const auto p = problem_of(2, Formula(model), {1.0, 1.0}, 0.01);
    const auto u = analyse(p, {.explore = 32, .verify = 4}, 1);
    MatrixXd candidates(2, 2); // the sum again; the difference
    candidates << 100.0, 100.0, 100.0, -100.0;
    MatrixXd predictions(1, 2);
    predictions << 1.0, -1.0;
    const auto effects = landscape::rank_candidates(p, *u.acceptance, u.minima[0], candidates, predictions);
    EXPECT_EQ(effects[0].candidate, 1U);
    // Box variance 1/12 along (1, -1)/sqrt 2: precision 12 before, 12 + 2e4 after.
    EXPECT_NEAR(effects[0].predictions[0], std::sqrt(12.0 / (12.0 + 2e4)), 1e-6);
    EXPECT_NEAR(effects[0].gain, 0.5 * std::log((12.0 + 2e4) / 12.0), 1e-6);
    EXPECT_NEAR(effects[1].predictions[0], 1.0, 1e-9);
}
