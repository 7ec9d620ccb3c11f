// Errors that the readings of a load share: generalised least squares by its closed form, coverage of ranges under
// noise that is drawn here, and what a study may say of it.
#include "analysis/studies/twin.h"
#include "landscape/minima.h"
#include "study/problems.h"
#include "support/formula.h"

#include "base/error.h"
#include "base/random.h"

#include <Eigen/Dense>
#include <cmath>
#include <gtest/gtest.h>

using namespace explore;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double offsets[] = {0.0, 0.2, 0.3, 0.45, 0.6, 0.9, 1.2, 1.5, 1.8}; // m
constexpr Index count = std::size(offsets);

// exp(-distance / length), written out.
MatrixXd correlation(double length) {
    MatrixXd r = MatrixXd::Identity(count, count);
    for (Index i = 0; i < count; ++i) {
        for (Index j = 0; j < count && length > 0.0; ++j) {
            r(i, j) = std::exp(-std::abs(offsets[i] - offsets[j]) / length);
        }
    }
    return r;
}

// The lower triangle whose product with its transpose is r (Cholesky), written out.
MatrixXd root_of(const MatrixXd& r) {
    MatrixXd root = MatrixXd::Zero(r.rows(), r.cols());
    for (Index j = 0; j < r.rows(); ++j) {
        for (Index i = j; i < r.rows(); ++i) {
            double left = r(i, j);
            for (Index k = 0; k < j; ++k) {
                left -= root(i, k) * root(j, k);
            }
            root(i, j) = i == j ? std::sqrt(left) : left / root(j, j);
        }
    }
    return root;
}

// A level and a slope.
MatrixXd line() {
    MatrixXd x(count, 2);
    for (Index i = 0; i < count; ++i) {
        x.row(i) << 1.0, 1.0 - offsets[i];
    }
    return x;
}

// Readings y of that line, each with such noise.
problem::Problem line_problem(const VectorXd& y, const std::vector<data::Noise>& noise) {
    problem::ParameterSpace space;
    for (const char* name : {"level", "slope"}) {
        space.axes.push_back({name, -1.0, 2.0, problem::Scale::linear, 0, 0.5});
    }
    std::vector<problem::Misfit::Term> terms;
    for (Index i = 0; i < count; ++i) {
        terms.push_back({.response = static_cast<std::size_t>(i),
                         .measured = y[i],
                         .noise = noise[static_cast<std::size_t>(i)],
                         .place = {.load = 0, .x = offsets[i]}});
    }
    const auto model = [x = line()](const VectorXd& p, VectorXd& r, MatrixXd& j) {
        r = x * p;
        j = x;
    };
    return {space, std::make_shared<test::Formula>(model), {problem::MisfitKind::noise, std::move(terms)}};
}

problem::Evaluation at(const problem::Problem& problem, const VectorXd& unit) {
    return problem.evaluate(std::vector<double>(unit.begin(), unit.end()), true, *problem.function->make_workspace());
}

// One step of Gauss and Newton, which ends a linear problem.
landscape::Minimum fitted(const problem::Problem& problem) {
    const VectorXd middle = VectorXd::Constant(2, 0.5);
    const problem::Evaluation e = at(problem, middle);
    const MatrixXd j = problem.residual_jacobian(e);
    const VectorXd unit = middle - (j.transpose() * j).ldlt().solve(j.transpose() * problem.residuals(e));
    landscape::Minimum m;
    m.evaluation = at(problem, unit);
    m.unit.assign(unit.begin(), unit.end());
    return m;
}

} // namespace

TEST(CorrelatedNoise, IsFittedByGeneralisedLeastSquares) {
    const MatrixXd x = line();
    VectorXd y(count);
    VectorXd deviation(count);
    std::vector<data::Noise> noise;
    for (Index i = 0; i < count; ++i) {
        y[i] = 0.4 + 0.3 * offsets[i] + 0.05 * std::sin(7.0 * static_cast<double>(i));
        deviation[i] = 0.02 + 0.005 * static_cast<double>(i);
        noise.push_back({.absolute = deviation[i], .correlation_length = 0.4});
    }
    const MatrixXd c = deviation.asDiagonal() * correlation(0.4) * deviation.asDiagonal();
    const MatrixXd information = x.transpose() * c.inverse() * x;
    const VectorXd beta = information.inverse() * x.transpose() * c.inverse() * y;

    const problem::Problem problem = line_problem(y, noise);
    const landscape::Minimum m = fitted(problem);
    const landscape::LocalAnalysis local = landscape::analyse(m, problem);
    const VectorXd left = y - x * beta;
    EXPECT_NEAR(problem.residuals(m.evaluation).squaredNorm(), left.dot(c.inverse() * left), 1e-9);
    for (Index k = 0; k < 2; ++k) {
        const auto n = static_cast<std::size_t>(k);
        EXPECT_NEAR(m.evaluation.parameters[n], beta[k], 1e-10);
        if (!local.widened) {
            EXPECT_NEAR(3.0 * local.standard_error[n], std::sqrt(information.inverse()(k, k)), 1e-10);
        }
    }
    EXPECT_FALSE(local.widened);

    // A reading that is wrong by any amount: chi2 falls by what it falls by without that reading.
    const MatrixXd j = problem.residual_jacobian(m.evaluation);
    const MatrixXd beyond = MatrixXd::Identity(count, count) - j * (j.transpose() * j).inverse() * j.transpose();
    const VectorXd r = problem.residuals(m.evaluation);
    for (std::size_t i = 0; i < count; ++i) {
        std::vector<std::size_t> others;
        std::vector<char> apart(count, 0);
        apart[i] = 1;
        for (std::size_t k = 0; k < count; ++k) {
            if (k != i) {
                others.push_back(k);
            }
        }
        const problem::Problem rest = problem.with_readings(others);
        const VectorXd shift = problem.change_by(i);
        const double fall = std::pow(shift.dot(r), 2) / shift.dot(beyond * shift);
        EXPECT_NEAR(r.squaredNorm() - fall, rest.residuals(fitted(rest).evaluation).squaredNorm(), 1e-8);
        // Set apart it says nothing of the others, and is what it is by itself.
        const VectorXd alone = problem.setting_apart(apart).residuals(m.evaluation);
        EXPECT_NEAR((alone(others) - rest.residuals(m.evaluation)).norm(), 0.0, 1e-12);
        EXPECT_NEAR(alone[static_cast<Index>(i)], problem.single_residuals(m.evaluation)[static_cast<Index>(i)], 1e-12);
    }
}

// d^2 R = own + common, of readings relative in part and in common, and of ones with an absolute part.
TEST(CorrelatedNoise, HasTheStatedCorrelation) {
    VectorXd y(count);
    std::vector<data::Noise> noise;
    MatrixXd c(count, count);
    const MatrixXd rho = correlation(0.3);
    constexpr double own = 0.03;
    constexpr double common = 0.04;
    for (Index i = 0; i < count; ++i) {
        y[i] = std::exp(-offsets[i]);
        noise.push_back({.absolute = i % 2 == 0 ? 0.01 : 0.0,
                         .relative = std::hypot(own, common),
                         .common_relative = common,
                         .correlation_length = 0.3});
    }
    VectorXd s(count);
    for (Index i = 0; i < count; ++i) {
        s[i] = std::hypot(noise[static_cast<std::size_t>(i)].absolute, own * y[i]);
    }
    for (Index i = 0; i < count; ++i) {
        for (Index k = 0; k < count; ++k) {
            c(i, k) = s[i] * s[k] * rho(i, k) + common * common * y[i] * y[k];
        }
    }
    const VectorXd d = c.diagonal().cwiseSqrt().cwiseInverse();
    const MatrixXd stated = d.asDiagonal() * c * d.asDiagonal();
    const problem::Problem problem = line_problem(y, noise);
    MatrixXd inverse_root(count, count);
    for (Index i = 0; i < count; ++i) {
        inverse_root.col(i) = problem.change_by(static_cast<std::size_t>(i));
    }
    EXPECT_NEAR((inverse_root * stated * inverse_root.transpose() - MatrixXd::Identity(count, count)).norm(), 0.0,
                1e-9);
    // Readings of another load or quantity are others.
    EXPECT_EQ(data::own_correlation({.load = 0}, {.load = 1}, 1.0), 0.0);
    EXPECT_EQ(data::own_correlation({.load = 0, .quantity = 1}, {.load = 0}, 1.0), 0.0);
    EXPECT_DOUBLE_EQ(data::own_correlation({.load = 0, .x = 3.0}, {.load = 0, .depth = 4.0}, 5.0), std::exp(-1.0));
}

// 4000 draws: the share of ranges estimate +- 1.96 standard errors that hold the true level and slope.
TEST(CorrelatedNoise, CoversTheTruthWhenItIsStatedAndNotWhenItIsTakenForIndependent) {
    constexpr int draws = 4000;
    constexpr double sigma = 0.02;
    constexpr double length = 0.6;
    const MatrixXd root = root_of(correlation(length));
    const VectorXd truth = VectorXd::Constant(2, 0.4);
    const pave::RandomStream random(20240611, 7);
    double covered[2][2] = {};
    for (int n = 0; n < draws; ++n) {
        VectorXd z(count);
        for (Index i = 0; i < count; ++i) {
            z[i] = random.normal(static_cast<std::uint64_t>(n * count + i));
        }
        const VectorXd y = line() * truth + sigma * root * z;
        for (const bool stated : {false, true}) {
            const data::Noise noise{.absolute = sigma, .correlation_length = stated ? length : 0.0};
            const problem::Problem problem = line_problem(y, std::vector<data::Noise>(count, noise));
            const landscape::Minimum m = fitted(problem);
            const auto error = landscape::analyse(m, problem).standard_error;
            for (std::size_t k = 0; k < 2; ++k) {
                const double off = m.evaluation.parameters[k] - truth[static_cast<Index>(k)];
                covered[stated ? 1 : 0][k] += std::abs(off) < 1.96 * 3.0 * error[k] ? 1.0 / draws : 0.0;
            }
        }
    }
    for (std::size_t k = 0; k < 2; ++k) {
        EXPECT_GT(covered[1][k], 0.93) << k;
        EXPECT_LT(covered[1][k], 0.97) << k;
        EXPECT_LT(covered[0][k], 0.88) << k;
        RecordProperty(k == 0 ? "level" : "slope", fmt::format("{} {}", covered[1][k], covered[0][k]));
    }
}

namespace {

study::Study
study_with(const std::string& noise, const std::string& misfit = "weighted",
           const std::string& rows = "fwd,deflection,0,0,0,0,0.9,mm,\nfwd,deflection,300,0,0,0,0.5,mm,\n"
                                     "fwd,deflection,900,0,0,0,0.2,mm,\nlow,deflection,0,0,0,0,0.5,mm,\n") {
    return study::study_of("schema = 1\n"
                           "[[layers]]\nname = \"base\"\nthickness_mm = 2000\ndensity_kg_m3 = 1900\nk0 = 0.5\n"
                           "law = \"linear\"\nmodulus_MPa = 50\npoisson = 0.4\n"
                           "[[loads]]\nname = \"fwd\"\ntype = \"plate\"\nradius_mm = 150\npressure_kPa = 566\n"
                           "[[loads]]\nname = \"low\"\ntype = \"plate\"\nradius_mm = 150\npressure_kPa = 300\n"
                           "[data]\nfiles = [\"bowl.csv\"]\nmisfit = \"" +
                               misfit + "\"\n[data.noise]\n" + noise +
                               "\n[[parameters]]\nname = \"base.modulus_MPa\"\nmin = 10\nmax = 500\nscale = \"log\"\n",
                           "memory.toml",
                           {{"bowl.csv", "load,quantity,x_mm,y_mm,depth_mm,gauge_mm,value,unit,sigma\n" + rows}});
}

std::string refusal(const std::string& noise, const std::string& misfit = "weighted", const std::string& rows = "") {
    try {
        rows.empty() ? study_with(noise, misfit) : study_with(noise, misfit, rows);
    } catch (const pave::Error& error) {
        return error.what();
    }
    return "";
}

} // namespace

TEST(CorrelatedNoise, IsReadFromTheStudy) {
    const study::Study study = study_with("relative = 0.03\ncommon_relative = 0.04\ncorrelation_mm = 300");
    EXPECT_NEAR(study.readings[1].noise.deviation(1.0), 0.05, 1e-15);
    EXPECT_NEAR(study.readings[1].noise.own_deviation(1.0), 0.03, 1e-15);
    EXPECT_TRUE(study::make_problem(study).noise_is_correlated());
    EXPECT_FALSE(study::make_problem(study_with("relative = 0.03\ncorrelation_mm = 0")).noise_is_correlated());
    // A sigma is the reading's own error.
    const study::Study own = study_with("common_relative = 0.04", "weighted", "fwd,deflection,0,0,0,0,1,mm,0.03\n");
    EXPECT_NEAR(own.readings[0].noise.deviation(1e-3), 0.05e-3, 1e-15);
    EXPECT_NEAR(own.readings[0].noise.own_deviation(1e-3), 0.03e-3, 1e-15);
}

TEST(CorrelatedNoise, IsRefusedWhereItMeansNothing) {
    for (const char* key : {"common_relative", "correlation_mm"}) {
        const std::string text = refusal(fmt::format("relative = 0.03\n{} = -1", key));
        EXPECT_NE(text.find("memory.toml:25"), std::string::npos) << text;
        EXPECT_NE(text.find(key), std::string::npos) << text;
        EXPECT_NE(text.find("out of range"), std::string::npos) << text;
        const std::string alone = refusal(fmt::format("{} = 0.1", key));
        EXPECT_NE(alone.find("each reading's own is stated"), std::string::npos) << alone;
        for (const char* misfit : {"log", "relative"}) {
            const std::string other = refusal(fmt::format("relative = 0.03\n{} = 0.1", key), misfit);
            EXPECT_NE(other.find("need a misfit by the stated noise"), std::string::npos) << other;
        }
    }
    EXPECT_NE(refusal("relative = 0.03\ncorrelation = 3").find("did you mean \"correlation_mm\""), std::string::npos);
    const std::string rows = "fwd,deflection,0,0,0,0,0.9,mm,\nfwd,deflection,0,0,0,0,0.8,mm,\n";
    const std::string twice = refusal("relative = 0.03\ncorrelation_mm = 300", "weighted", rows);
    EXPECT_NE(twice.find("bowl.csv:3"), std::string::npos) << twice;
    EXPECT_EQ(refusal("relative = 0.03\ncommon_relative = 0.1", "weighted", rows), "");
}

// Integrating over the rates of the sensors is a ridge: the least, over a standard normal number xi of each sensor, of
// the sum of (r - w xi)^2 / s^2 + xi^2, s the error of a reading by itself and w its drift.
TEST(DriftingNoise, IsTheLeastOverTheRateOfEverySensor) {
    constexpr double own = 2e-6; // m
    constexpr double rate = 1e-3;
    const pave::RandomStream random(5, 0);
    std::vector<problem::Misfit::Term> terms;
    std::vector<double> responses;
    for (std::size_t sensor = 0; sensor < 2; ++sensor) {
        for (std::size_t step = 0; step < 6; ++step) {
            const double time = 0.005 * static_cast<double>(step);
            problem::Misfit::Term term{.response = terms.size(), .measured = 1e-4};
            term.noise = {.absolute = own, .drift = rate * time};
            term.place = {.load = 0, .x = static_cast<double>(sensor), .time = time};
            responses.push_back(term.measured + 1e-5 * random.normal(terms.size()));
            terms.push_back(term);
        }
    }
    const problem::Misfit misfit(problem::MisfitKind::noise, terms);
    const auto drifts = misfit.drifts(responses);
    ASSERT_EQ(drifts.size(), 2U);
    double least = 0.0;
    for (std::size_t sensor = 0; sensor < 2; ++sensor) {
        double ww = 1.0;
        double wr = 0.0;
        double rr = 0.0;
        for (std::size_t i = 6 * sensor; i < 6 * (sensor + 1); ++i) {
            const double w = terms[i].noise.drift / own;
            const double r = (terms[i].measured - responses[i]) / own;
            ww += w * w;
            wr += w * r;
            rr += r * r;
        }
        least += rr - wr * wr / ww;
        EXPECT_NEAR(drifts[sensor].mean, wr / ww, 1e-9);
        EXPECT_NEAR(drifts[sensor].deviation, 1.0 / std::sqrt(ww), 1e-9);
    }
    EXPECT_NEAR(misfit.residuals(responses).squaredNorm(), least, 1e-8 * least);
}

// The twin of a study that says nothing of correlation has independent errors z; with it they are L z and one more for
// all readings of a load.
TEST(CorrelatedNoise, IsDrawnByTheTwin) {
    const analysis::TwinOptions options{.noise = 0.05, .seed = 3};
    const auto errors = [&](const std::string& noise) {
        const analysis::TwinResult twin = analysis::twin(study_with(noise), options);
        VectorXd e(4);
        for (std::size_t i = 0; i < 4; ++i) {
            e[static_cast<Index>(i)] = twin.readings[i].value / twin.exact[i] - 1.0;
        }
        return e;
    };
    const VectorXd z = errors("relative = 0.03");
    MatrixXd r = MatrixXd::Identity(4, 4);
    r(0, 1) = r(1, 0) = std::exp(-1.0);
    r(1, 2) = r(2, 1) = std::exp(-2.0);
    r(0, 2) = r(2, 0) = std::exp(-3.0);
    const VectorXd tied = root_of(r) * z;
    EXPECT_NEAR((errors("relative = 0.03\ncorrelation_mm = 300") - tied).norm(), 0.0, 1e-12);
    const VectorXd common = errors("relative = 0.03\ncorrelation_mm = 300\ncommon_relative = 0.1") - tied;
    EXPECT_GT(std::abs(common[0]), 1e-3);
    EXPECT_NEAR(common[1], common[0], 1e-12);
    EXPECT_NEAR(common[2], common[0], 1e-12);
    EXPECT_GT(std::abs(common[3] - common[0]), 1e-3);
}
