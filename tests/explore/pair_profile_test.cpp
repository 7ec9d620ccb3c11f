// The profiled landscape where it is known: a quadratic by its covariance, a curved valley in closed form, a fit that
// jumps from one branch to another by brute force.
#include "landscape/pair_profile.h"
#include "support/formula.h"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>

using namespace explore;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using landscape::ProfiledLandscape;
using landscape::Slice;
using test::Formula;
using test::problem_of;

namespace {

// From the lowest end of a search at `start`, on lines over the whole box.
ProfiledLandscape landscape_of(const problem::Problem& problem, const std::vector<double>& start, int threads = 0,
                               landscape::PairProfileSettings settings = {}) {
    run::Engine engine(problem, nullptr, 0, {.threads = threads, .show_progress = false});
    const auto ends = engine.search({start}, *optimise::find_method("gauss-newton"), {});
    EXPECT_TRUE(ends && !(*ends)[0].search.unit.empty());
    landscape::Acceptance acceptance;
    acceptance.noise_is_stated = true;
    acceptance.threshold = 3.84;
    const std::vector<landscape::Reach> reach(problem.space.axes.size());
    auto result = landscape::profiled_landscape(engine, problem, acceptance, {(*ends)[0].search.unit},
                                                (*ends)[0].search.misfit, reach, settings);
    EXPECT_TRUE(result.has_value());
    return *result;
}

// Calls visit(values of the held parameters, rise) for every node.
template <class Visit>
void each_node(const Slice& slice, const Visit& visit) {
    const std::size_t width = slice.lines[0].size();
    for (std::size_t i = 0; i < slice.rise.size(); ++i) {
        std::vector<double> held{slice.lines[0][i % width]};
        if (slice.axes.size() > 1) {
            held.push_back(slice.lines[1][i / width]);
        }
        visit(held, slice.rise[i]);
    }
}

// In sqrt(chi2), where a figure's contours are read: within a tenth of a standard deviation or 1 %.
void expect_same_rise(double found, double wanted, const std::string& where) {
    const double root = std::sqrt(std::max(0.0, wanted)); // a scan by steps may miss the minimum by a little
    EXPECT_NEAR(std::sqrt(std::max(0.0, found)), root, std::max(0.1, 0.01 * root)) << where;
}

std::string words(const Slice& slice, const std::vector<double>& held) {
    std::string text;
    for (std::size_t a = 0; a < held.size(); ++a) {
        text += fmt::format(" p{} = {}", slice.axes[a], held[a]);
    }
    return text;
}

} // namespace

TEST(ProfileLines, HoldBothEndsTheBestValueAndAreDenserWithinReach) {
    for (const double best : {0.0, 0.013, 0.42, 0.99, 1.0}) {
        const landscape::Reach reach{std::max(0.0, best - 0.05), std::min(1.0, best + 0.05)};
        const auto lines = landscape::profile_lines(21, best, reach);
        ASSERT_EQ(lines.size(), 21u);
        EXPECT_TRUE(std::is_sorted(lines.begin(), lines.end()) &&
                    std::adjacent_find(lines.begin(), lines.end()) == lines.end());
        EXPECT_EQ(lines.front(), 0.0);
        EXPECT_EQ(lines.back(), 1.0);
        EXPECT_TRUE(std::any_of(lines.begin(), lines.end(), [&](double u) { return std::abs(u - best) < 1e-9; }));
        const auto inside =
            std::count_if(lines.begin(), lines.end(), [&](double u) { return u >= reach.low && u <= reach.high; });
        EXPECT_GE(inside, 6) << best; // evenly they would be two
    }
}

TEST(ProfiledLandscape, OfAQuadraticIsThatOfItsCovariance) {
    // r = A (x - c): the profile of the held parameters is (h - c)' (C_hh)^-1 (h - c), C = (A'A)^-1.
    constexpr int n = 4;
    MatrixXd a(6, n);
    a << 9, 1, 0, 2, //
        1, 8, 2, 0,  //
        0, 2, 7, 1,  //
        1, 0, 1, 10, //
        2, 1, 1, 0,  //
        0, 1, 2, 1;
    const VectorXd centre = VectorXd::LinSpaced(n, 0.45, 0.55);
    const auto problem = problem_of(n, Formula([=](const VectorXd& x, VectorXd& r, MatrixXd& j) {
                                        r = a * (x - centre);
                                        j = a;
                                    }),
                                    std::vector<double>(6, 0.0), 1.0);
    const MatrixXd covariance = (a.transpose() * a).inverse();
    const ProfiledLandscape found = landscape_of(problem, std::vector<double>(n, 0.2));
    ASSERT_EQ(found.pairs.size(), 6u);
    ASSERT_EQ(found.single.size(), 4u);
    EXPECT_LT(found.lower_by, 1e-3);
    std::vector<Slice> all = found.pairs;
    all.insert(all.end(), found.single.begin(), found.single.end());
    for (const Slice& slice : all) {
        std::vector<Index> held(slice.axes.begin(), slice.axes.end());
        const MatrixXd inverse = MatrixXd(covariance(held, held)).inverse();
        each_node(slice, [&](const std::vector<double>& at, double rise) {
            const VectorXd h = VectorXd::Map(at.data(), static_cast<Index>(at.size())) - centre(held);
            // Where the others are when they are free: within the box for this formula to hold.
            const VectorXd x = centre + MatrixXd(covariance(Eigen::all, held)) * inverse * h;
            if (x.minCoeff() >= 0.0 && x.maxCoeff() <= 1.0) {
                expect_same_rise(rise, h.dot(inverse * h), words(slice, at));
            }
        });
    }
}

TEST(ProfiledLandscape, OfACurvedValleyIsItsClosedForm) {
    // z is fitted: min over z of s1^2 (z - g)^2 + s4^2 (z - 1/2)^2 = (g - 1/2)^2 / (1/s1^2 + 1/s4^2), g(x, y) in (0,
    // 1).
    const double s1 = 50.0;
    const double s2 = 30.0;
    const double s3 = 2.0;
    const double s4 = 10.0;
    const auto g = [](double x, double y) { return 0.2 + 0.5 * x * y; };
    const auto problem = problem_of(3, Formula([=](const VectorXd& x, VectorXd& r, MatrixXd& j) {
                                        r.resize(4);
                                        r << s1 * (x[2] - g(x[0], x[1])), s2 * (x[1] - 0.9 * x[0] * x[0]),
                                            s3 * (x[0] - 0.5), s4 * (x[2] - 0.5);
                                        j = MatrixXd::Zero(4, 3);
                                        j.row(0) << -s1 * 0.5 * x[1], -s1 * 0.5 * x[0], s1;
                                        j.row(1) << -s2 * 1.8 * x[0], s2, 0.0;
                                        j(2, 0) = s3;
                                        j(3, 2) = s4;
                                    }),
                                    std::vector<double>(4, 0.0), 1.0);
    const auto profiled = [&](double x, double y) {
        return std::pow(g(x, y) - 0.5, 2) / (1.0 / (s1 * s1) + 1.0 / (s4 * s4)) + std::pow(s2 * (y - 0.9 * x * x), 2) +
               std::pow(s3 * (x - 0.5), 2);
    };
    double lowest = 1e9;
    for (int i = 0; i <= 2000; ++i) {
        for (int k = 0; k <= 2000; ++k) {
            lowest = std::min(lowest, profiled(i / 2000.0, k / 2000.0));
        }
    }
    const ProfiledLandscape found = landscape_of(problem, {0.2, 0.8, 0.5});
    ASSERT_EQ(found.pairs[0].axes, (std::vector<std::size_t>{0, 1}));
    each_node(found.pairs[0], [&](const std::vector<double>& at, double rise) {
        expect_same_rise(rise, profiled(at[0], at[1]) - lowest, words(found.pairs[0], at));
    });
    each_node(found.single[0], [&](const std::vector<double>& at, double rise) {
        double wanted = 1e9;
        for (int k = 0; k <= 20000; ++k) {
            wanted = std::min(wanted, profiled(at[0], k / 20000.0));
        }
        expect_same_rise(rise, wanted - lowest, words(found.single[0], at));
    });
}

namespace {

// z has two branches, near 1/4 and 3/4; which is the lower changes with x.
problem::Problem branches(double failing = 0.0) {
    return problem_of(3,
                      Formula(
                          [](const VectorXd& x, VectorXd& r, MatrixXd& j) {
                              r.resize(4);
                              r << 40.0 * (x[2] - 0.25) * (x[2] - 0.75), 6.0 * (x[2] - x[0]), 3.0 * (x[1] - 0.4),
                                  2.0 * (x[0] - 0.3);
                              j = MatrixXd::Zero(4, 3);
                              j(0, 2) = 40.0 * (2.0 * x[2] - 1.0);
                              j(1, 0) = -6.0;
                              j(1, 2) = 6.0;
                              j(2, 1) = 3.0;
                              j(3, 0) = 2.0;
                          },
                          failing),
                      std::vector<double>(4, 0.0), 1.0);
}

double branches_profile(double x, double y) {
    double lowest = 1e9;
    for (int i = 0; i <= 4000; ++i) {
        const double z = i / 4000.0;
        lowest = std::min(lowest, std::pow(40.0 * (z - 0.25) * (z - 0.75), 2) + std::pow(6.0 * (z - x), 2));
    }
    return lowest + std::pow(3.0 * (y - 0.4), 2) + std::pow(2.0 * (x - 0.3), 2);
}

} // namespace

TEST(ProfiledLandscape, FollowsTheLowerBranchOfWhatIsFitted) {
    double lowest = 1e9;
    for (int i = 0; i <= 1000; ++i) {
        lowest = std::min(lowest, branches_profile(i / 1000.0, 0.4));
    }
    const ProfiledLandscape found = landscape_of(branches(), {0.2, 0.5, 0.2});
    std::vector<Slice> of_x{found.pairs[0], found.single[0]};
    for (const Slice& slice : of_x) {
        each_node(slice, [&](const std::vector<double>& at, double rise) {
            expect_same_rise(rise, branches_profile(at[0], at.size() > 1 ? at[1] : 0.4) - lowest, words(slice, at));
        });
    }
}

TEST(ProfiledLandscape, IsTheSameForAnyNumberOfThreadsAndSaysWhereThereIsNoAnswer) {
    const ProfiledLandscape one = landscape_of(branches(0.02), {0.2, 0.5, 0.2}, 1);
    const ProfiledLandscape four = landscape_of(branches(0.02), {0.2, 0.5, 0.2}, 4);
    for (std::size_t p = 0; p < one.pairs.size(); ++p) {
        for (std::size_t i = 0; i < one.pairs[p].rise.size(); ++i) {
            const double a = one.pairs[p].rise[i];
            const double b = four.pairs[p].rise[i];
            EXPECT_TRUE(a == b || (std::isnan(a) && std::isnan(b)));
        }
    }
    // No point beyond p0 = 0.7 has an answer: those nodes are holes, the others are as they were.
    const auto model = [](const VectorXd& x, VectorXd& r, MatrixXd& j) {
        r = 5.0 * (x - VectorXd::Constant(3, 0.4));
        j = 5.0 * MatrixXd::Identity(3, 3);
    };
    class Cut final : public problem::ForwardFunction {
    public:
        explicit Cut(Formula inner) : inner_(std::move(inner)) {}
        std::unique_ptr<Workspace> make_workspace() const override { return inner_.make_workspace(); }
        pave::Outcome<problem::Prediction> evaluate(std::span<const double> x, bool with_jacobian,
                                                    Workspace& workspace) const override {
            if (x[0] > 0.7) {
                return pave::Failure{pave::Status::failed, "beyond"};
            }
            return inner_.evaluate(x, with_jacobian, workspace);
        }

    private:
        Formula inner_;
    };
    problem::Problem cut = problem_of(3, Formula(model), std::vector<double>(3, 0.0), 1.0);
    cut.function = std::make_shared<Cut>(Formula(model));
    const ProfiledLandscape found = landscape_of(cut, {0.2, 0.2, 0.2});
    each_node(found.pairs[0],
              [&](const std::vector<double>& at, double rise) { EXPECT_EQ(std::isnan(rise), at[0] > 0.7) << at[0]; });
    each_node(found.pairs[2], [&](const std::vector<double>& at, double rise) {
        expect_same_rise(rise, 25.0 * (std::pow(at[0] - 0.4, 2) + std::pow(at[1] - 0.4, 2)), words(found.pairs[2], at));
    });
}
