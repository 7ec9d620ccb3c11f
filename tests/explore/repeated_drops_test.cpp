// The noise of made-up drops whose covariance is known: the parts come back within what so many drops can tell.
#include "analysis/survey/noise.h"

#include "base/error.h"
#include "base/random.h"

#include <Eigen/Cholesky>
#include <Eigen/Dense>
#include <cmath>
#include <gtest/gtest.h>

using namespace explore;
using analysis::NoiseModel;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double offsets_mm[] = {0.0, 200.0, 300.0, 450.0, 600.0, 900.0, 1200.0, 1500.0, 1800.0};
constexpr Index sensors = std::size(offsets_mm);

struct Truth {
    double relative = 0.006, common = 0.005, absolute_um = 0.0, correlation_mm = 0.0;
};

double bowl_um(double offset_mm) {
    return 500.0 * std::exp(-offset_mm / 700.0);
}

MatrixXd covariance(const Truth& t) {
    MatrixXd c(sensors, sensors);
    const auto own = [&](double x) { return std::hypot(t.relative, t.absolute_um / bowl_um(x)); };
    for (Index i = 0; i < sensors; ++i) {
        for (Index j = 0; j < sensors; ++j) {
            const double apart = std::abs(offsets_mm[i] - offsets_mm[j]);
            const double rho = i == j ? 1.0 : t.correlation_mm > 0.0 ? std::exp(-apart / t.correlation_mm) : 0.0;
            c(i, j) = t.common * t.common + rho * own(offsets_mm[i]) * own(offsets_mm[j]);
        }
    }
    return c;
}

data::FwdFile road(const Truth& truth, int stations, int drops, std::uint64_t seed) {
    const MatrixXd root = covariance(truth).llt().matrixL();
    data::FwdFile file;
    for (int s = 0; s < stations; ++s) {
        data::FwdStation station{.name = "s", .lane = {}, .file = "made up"};
        for (int d = 0; d < drops; ++d) {
            const pave::RandomStream random(seed, static_cast<std::uint64_t>(s * drops + d));
            VectorXd z(sensors);
            for (Index i = 0; i < sensors; ++i) {
                z[i] = random.normal(static_cast<std::uint64_t>(i));
            }
            const VectorXd e = root * z;
            // Drops of one level that differ in load: what is proportional to it is no noise.
            const double load = 1.0 + 0.02 * d;
            data::FwdDrop drop{.number = d + 1, .radius_mm = 150.0, .pressure_kPa = 600.0 * load, .readings = {}};
            for (Index i = 0; i < sensors; ++i) {
                drop.readings.push_back({offsets_mm[i], bowl_um(offsets_mm[i]) * load * std::exp(e[i])});
            }
            station.drops.push_back(std::move(drop));
        }
        file.stations.push_back(std::move(station));
    }
    return file;
}

// Half the width of a 95 % range of its logarithm, in standard deviations.
double off_by(const NoiseModel& model, NoiseModel::Part part, double truth) {
    const double deviation = std::log(model.high[part] / model.low[part]) / (2.0 * 1.96);
    return std::abs(std::log(model.value[part] / truth)) / deviation;
}

} // namespace

TEST(RepeatedDrops, GiveBackEveryPartOfTheirNoise) {
    const Truth truth{.relative = 0.01, .common = 0.006, .absolute_um = 0.8, .correlation_mm = 350.0};
    const auto result = analysis::noise_of_drops({road(truth, 200, 4, 1)});
    EXPECT_EQ(result.groups, 200U);
    EXPECT_EQ(result.degrees, 600);
    const NoiseModel& m = result.model;
    const double stated[] = {truth.relative, truth.common, truth.absolute_um, truth.correlation_mm};
    for (int part = 0; part < NoiseModel::parts; ++part) {
        EXPECT_LT(off_by(m, static_cast<NoiseModel::Part>(part), stated[part]), 3.5) << part;
        EXPECT_LT(m.low[part], m.value[part]);
    }
    // What the drops show: a standard deviation of 600 degrees of freedom is known to 1 / sqrt(1200).
    const MatrixXd c = covariance(truth);
    for (Index i = 0; i < sensors; ++i) {
        const auto& s = result.sensors[static_cast<std::size_t>(i)];
        EXPECT_NEAR(s.scatter / std::sqrt(c(i, i)), 1.0, 4.0 / std::sqrt(1200.0));
        if (i + 1 < sensors) { // Fisher's z of a correlation: 1 / sqrt(degrees)
            const double rho = c(i, i + 1) / std::sqrt(c(i, i) * c(i + 1, i + 1));
            EXPECT_NEAR(std::atanh(*s.with_next), std::atanh(rho), 4.0 / std::sqrt(600.0));
        }
    }
}

TEST(RepeatedDrops, RangesHoldTheTruthAsOftenAsTheySay) {
    const Truth truth{.relative = 0.01, .common = 0.006, .absolute_um = 0.0, .correlation_mm = 350.0};
    constexpr int trials = 60;
    int held = 0;
    for (int trial = 0; trial < trials; ++trial) {
        const auto m = analysis::noise_of_drops({road(truth, 60, 3, 100 + static_cast<std::uint64_t>(trial))}).model;
        held += m.low[NoiseModel::relative] <= truth.relative && truth.relative <= m.high[NoiseModel::relative] ? 1 : 0;
    }
    // 95 %, less what choosing the parts costs; the binomial's three standard deviations below 90 %.
    EXPECT_GE(held, static_cast<int>(trials * (0.9 - 3.0 * std::sqrt(0.9 * 0.1 / trials))));
}

TEST(RepeatedDrops, OneReadingThatItsRepeatsContradictChangesNothing) {
    const Truth truth{.relative = 0.01, .common = 0.006, .absolute_um = 0.0, .correlation_mm = 350.0};
    for (const int drops : {2, 3, 4}) {
        auto with_spike = road(truth, 100, drops, 5);
        const auto clean = analysis::noise_of_drops({with_spike}).model;
        with_spike.stations[17].drops[0].readings[7].deflection_um *= 9.0; // at 1500 mm
        const auto result = analysis::noise_of_drops({with_spike});
        for (const auto part : {NoiseModel::relative, NoiseModel::common, NoiseModel::correlation}) {
            EXPECT_GT(result.model.value[part], clean.low[part]) << drops << " " << part;
            EXPECT_LT(result.model.value[part], clean.high[part]) << drops << " " << part;
        }
        ASSERT_EQ(result.left_out.size(), 1U);
        EXPECT_NE(result.left_out[0].find("drop 1, all its sensors"), std::string::npos) << result.left_out[0];
        EXPECT_NE(result.left_out[0].find("at 1500 mm"), std::string::npos) << result.left_out[0];
        EXPECT_NE(pave::join(analysis::findings(result)).find("repeats contradict"), std::string::npos);
    }
}

TEST(RepeatedDrops, WhereTheModelMissesTheDropsItIsSaid) {
    auto unlike = road({.relative = 0.005, .common = 0.0}, 100, 4, 9);
    std::uint64_t draw = 0;
    const pave::RandomStream random(3, 1);
    for (auto& s : unlike.stations) { // one sensor that scatters five times as much
        for (auto& d : s.drops) {
            d.readings[2].deflection_um *= 1.0 + 0.025 * random.normal(draw++);
        }
    }
    const auto told = pave::join(analysis::findings(analysis::noise_of_drops({unlike})));
    EXPECT_NE(told.find("The model does not hold at 300 mm"), std::string::npos) << told;
    const auto plain = pave::join(analysis::findings(analysis::noise_of_drops({road({}, 100, 4, 9)})));
    EXPECT_EQ(plain.find("does not hold"), std::string::npos) << plain;
}

TEST(RepeatedDrops, LeaveOutPartsThatNothingTellsOf) {
    const auto m = analysis::noise_of_drops({road({.relative = 0.008, .common = 0.0}, 100, 3, 7)}).model;
    EXPECT_EQ(m.value[NoiseModel::common], 0.0);
    EXPECT_EQ(m.value[NoiseModel::correlation], 0.0);
    EXPECT_LT(off_by(m, NoiseModel::relative, 0.008), 3.5);
}

TEST(RepeatedDrops, AreNeeded) {
    EXPECT_THROW(analysis::noise_of_drops({road({}, 5, 1, 1)}), pave::Error);
}
