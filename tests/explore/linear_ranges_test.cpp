// Ranges of `unique` where everything is linear, against the solution of the convex problem by its faces: the farthest
// point of an ellipsoid within a box and linear inequalities.
#include "landscape/uniqueness.h"
#include "support/formula.h"

#include <Eigen/QR>
#include <cmath>
#include <gtest/gtest.h>

using namespace explore;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double chi2_95 = 3.841459; // 95 % of chi2 with one degree of freedom

struct Face {
    VectorXd normal;
    double end = 0.0; // normal . x <= end
};

// r + J x in units of the noise, an output g . x, and inequalities of the study.
struct Linear {
    MatrixXd jacobian;
    VectorXd residuals, output;
    std::vector<Face> limits;

    Index dimension() const { return jacobian.cols(); }
    double chi2(const VectorXd& x) const { return (residuals + jacobian * x).squaredNorm(); }
    std::vector<Face> faces() const {
        std::vector<Face> all = limits;
        for (Index k = 0; k < dimension(); ++k) {
            all.push_back({VectorXd::Unit(dimension(), k), 1.0});
            all.push_back({-VectorXd::Unit(dimension(), k), 0.0});
        }
        return all;
    }
    bool allows(const VectorXd& x) const {
        for (const Face& f : faces()) {
            if (f.normal.dot(x) > f.end + 1e-9) {
                return false;
            }
        }
        return true;
    }

    // Calls `found` with the points of the cut of every set of faces that matter: a point of it and a basis of it.
    void cuts(const std::function<void(const VectorXd& point, const MatrixXd& basis)>& found) const {
        const std::vector<Face> all = faces();
        const Index n = dimension();
        for (unsigned set = 0; set < (1U << all.size()); ++set) {
            std::vector<std::size_t> on;
            for (std::size_t i = 0; i < all.size(); ++i) {
                if ((set >> i & 1U) != 0U) {
                    on.push_back(i);
                }
            }
            const auto count = static_cast<Index>(on.size());
            if (count > n) {
                continue;
            }
            MatrixXd normals(count, n);
            VectorXd ends(count);
            for (Index i = 0; i < count; ++i) {
                normals.row(i) = all[on[static_cast<std::size_t>(i)]].normal.transpose();
                ends[i] = all[on[static_cast<std::size_t>(i)]].end;
            }
            VectorXd point = VectorXd::Zero(n);
            MatrixXd basis = MatrixXd::Identity(n, n);
            if (count > 0) {
                const Eigen::FullPivLU<MatrixXd> lu(normals);
                if (lu.rank() < count) {
                    continue;
                }
                point = normals.completeOrthogonalDecomposition().solve(ends);
                basis = count < n ? MatrixXd(lu.kernel()) : MatrixXd(n, 0);
            }
            found(point, basis);
        }
    }

    double lowest() const {
        double least = INFINITY;
        cuts([&](const VectorXd& point, const MatrixXd& basis) {
            VectorXd x = point;
            if (basis.cols() > 0) {
                x +=
                    basis *
                    MatrixXd(jacobian * basis).completeOrthogonalDecomposition().solve(-(residuals + jacobian * point));
            }
            if (allows(x)) {
                least = std::min(least, chi2(x));
            }
        });
        return least;
    }

    // The largest g . x that is allowed and no higher than `most`: on some cut it is a corner, or touches the
    // ellipsoid.
    double farthest(const VectorXd& g, double most) const {
        double far = -INFINITY;
        const auto look_at = [&](const VectorXd& x) {
            if (allows(x) && chi2(x) <= most + 1e-7) {
                far = std::max(far, g.dot(x));
            }
        };
        cuts([&](const VectorXd& point, const MatrixXd& basis) {
            if (basis.cols() == 0) {
                look_at(point);
                return;
            }
            const MatrixXd j = jacobian * basis;
            const MatrixXd h = j.transpose() * j;
            Eigen::CompleteOrthogonalDecomposition<MatrixXd> solver;
            solver.setThreshold(1e-11);
            solver.compute(h);
            const VectorXd y0 = solver.solve(-(j.transpose() * (residuals + jacobian * point)));
            const VectorXd slope = basis.transpose() * g;
            const VectorXd way = solver.solve(slope);
            if ((h * way - slope).norm() > 1e-7 * slope.norm()) {
                return; // without an end here: it lies on a smaller cut
            }
            const double size = way.dot(h * way);
            const double left = most - chi2(point + basis * y0);
            if (left >= 0.0 && size > 1e-20) {
                look_at(point + basis * (y0 + way * std::sqrt(left / size)));
            } else if (left >= 0.0) { // the same all over the cut
                look_at(point + basis * y0);
            }
        });
        return far;
    }
};

class Inequality final : public problem::Limit {
public:
    explicit Inequality(Face face) : face_(std::move(face)) {}
    std::string text() const override { return "a.x <= b"; }
    bool is_equality() const override { return false; }
    double value(std::span<const double> x, std::span<const double>) const override {
        return tolerances * (face_.normal.dot(VectorXd::Map(x.data(), static_cast<Index>(x.size()))) - face_.end);
    }
    Eigen::RowVectorXd gradient(std::span<const double>, std::span<const double>, const MatrixXd&) const override {
        return tolerances * face_.normal.transpose();
    }

private:
    static constexpr double tolerances = 1e4; // of what the sides can differ by
    Face face_;
};

// Readings of unequal weight about a truth anywhere in the box or a little outside of it, nearly dependent columns
// among them; with an inequality that the truth lies near, every other time.
Linear drawn(int seed) {
    const pave::RandomStream random(static_cast<std::uint64_t>(seed), 4242);
    std::uint64_t at = 0;
    const auto uniform = [&](double low, double high) { return low + (high - low) * random.uniform(at++); };
    Linear l;
    const auto n = static_cast<Index>(2.0 + 2.0 * random.uniform(at++));
    const Index readings = 1 + static_cast<Index>(static_cast<double>(n + 4) * random.uniform(at++));
    l.jacobian.resize(readings, n);
    l.output.resize(n);
    VectorXd truth(n);
    for (Index k = 0; k < n; ++k) {
        truth[k] = uniform(-0.1, 1.1);
        l.output[k] = uniform(-2.0, 2.0);
        for (Index i = 0; i < readings; ++i) {
            l.jacobian(i, k) = uniform(-1.0, 1.0) * std::pow(10.0, uniform(0.0, 2.0));
        }
    }
    if (seed % 3 == 0) { // a valley
        l.jacobian.col(1) = l.jacobian.col(0) * uniform(0.5, 1.5) + 0.02 * l.jacobian.col(1);
    }
    l.residuals = -l.jacobian * truth;
    for (Index i = 0; i < readings; ++i) {
        l.residuals[i] += uniform(-1.5, 1.5);
    }
    if (seed % 2 == 0) {
        Face face;
        face.normal.resize(n);
        for (Index k = 0; k < n; ++k) {
            face.normal[k] = uniform(-1.0, 1.0);
        }
        face.end = face.normal.dot(truth.cwiseMax(0.0).cwiseMin(1.0)) + uniform(-0.1, 0.1);
        l.limits.push_back(face);
    }
    return l;
}

problem::Problem linear_problem(const Linear& l) {
    const auto model = [l](const VectorXd& x, VectorXd& r, MatrixXd& j) {
        const Index readings = l.jacobian.rows();
        r.resize(readings + 1);
        r << l.jacobian * x, l.output.dot(x);
        j.resize(readings + 1, x.size());
        j << l.jacobian, l.output.transpose();
    };
    const VectorXd measured = -l.residuals;
    problem::Problem problem = test::problem_of(static_cast<int>(l.dimension()), test::Formula(model),
                                                {measured.begin(), measured.end()}, 1.0);
    for (const Face& limit : l.limits) {
        problem.limits.push_back(std::make_shared<Inequality>(limit));
    }
    return problem;
}

} // namespace

class RangesOfALinearModel : public ::testing::TestWithParam<int> {};

TEST_P(RangesOfALinearModel, AreThoseOfTheConvexProblem) {
    constexpr int of_a_part = 20;
    for (int seed = of_a_part * GetParam(); seed < of_a_part * (GetParam() + 1); ++seed) {
        const Linear linear = drawn(seed);
        const double lowest = linear.lowest();
        if (!std::isfinite(lowest)) {
            continue; // nothing is allowed
        }
        const problem::Problem problem = linear_problem(linear);
        run::Engine engine(problem, nullptr, 0, {.threads = 1, .show_progress = false});
        const auto u = landscape::uniqueness({.fitted = problem,
                                              .everything = problem,
                                              .fitted_engine = engine,
                                              .everything_engine = engine,
                                              .outputs = {static_cast<std::size_t>(linear.jacobian.rows())},
                                              .groups = {},
                                              .seed = 1},
                                             {.explore = 16, .verify = 2});
        ASSERT_TRUE(u && u->acceptance) << seed;
        const double found = std::pow(u->minima[0].evaluation.misfit, 2);
        EXPECT_NEAR(found, lowest, 1e-3 * std::max(1.0, lowest)) << seed;
        // Of noise that chi2 contradicts its own size, and Fisher's quantile; else chi2's.
        const double rise = u->acceptance->widened ? u->acceptance->threshold * u->acceptance->variance : chi2_95;
        const auto expect = [&](const landscape::Range& range, const VectorXd& g, const std::string& what) {
            const double high = linear.farthest(g, lowest + rise);
            const double low = -linear.farthest(-g, lowest + rise);
            constexpr double gives_way = 1e-3; // what inequalities do, by a quadratic penalty
            const double allowed = 5e-3 * (high - low) + (linear.limits.empty() ? 1e-5 : gives_way) * g.norm();
            EXPECT_NEAR(range.low, low, allowed) << "seed " << seed << ", " << what << " to " << high;
            EXPECT_NEAR(range.high, high, allowed) << "seed " << seed << ", " << what << " from " << low;
        };
        for (Index k = 0; k < linear.dimension(); ++k) {
            expect(u->parameters[static_cast<std::size_t>(k)], VectorXd::Unit(linear.dimension(), k),
                   fmt::format("p{}", k));
        }
        expect(u->outputs[0], linear.output, "the output");
    }
}

INSTANTIATE_TEST_SUITE_P(Parts, RangesOfALinearModel, ::testing::Range(0, 5));
