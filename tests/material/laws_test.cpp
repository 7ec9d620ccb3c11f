// Every law of the catalogue, without being asked.
#include "base/random.h"
#include "base/units.h"
#include "material/catalog.h"

#include <cmath>
#include <gtest/gtest.h>
#include <numbers>

using namespace pave;
using material::Law;

namespace {

// Parameters inside realistic bounds, SI.
std::vector<double> random_parameters(const Law& law, std::uint64_t stream) {
    const RandomStream random(21, stream);
    std::vector<double> p;
    for (const auto& info : law.parameters()) {
        const double u = random.uniform(p.size());
        double value = 0.0;
        if (!info.choices.empty()) {
            value = u < 0.5 ? 0.0 : 1.0;
        } else if (info.key.starts_with("k1")) {
            value = 500.0 + 7500.0 * u;
        } else if (info.key.starts_with("k3")) {
            value = -2.0 * u;
        } else if (info.key == "modulus_MPa") {
            value = 20.0 + 5000.0 * u;
        } else if (info.key.size() == 2 && info.key[0] == 'g') { // shares
            value = 0.05 + 0.15 * u;
        } else if (info.key == "n_lowest") {
            value = 0.01 + 0.1 * u;
        } else if (info.key == "activation_kJ_mol") {
            value = 100.0 + 300.0 * u;
        } else if (info.key.ends_with("_smoothing_kPa")) {
            value = 1.0 + 20.0 * u;
        } else if (info.key.starts_with("poisson")) {
            value = 0.1 + 0.3 * u;
        } else {
            value = 0.1 + 0.8 * u;
        }
        p.push_back(value * info.to_si);
    }
    return p;
}

mechanics::Invariants random_state(std::uint64_t stream) {
    const RandomStream random(22, stream);
    return {-50e3 + 600e3 * random.uniform(0), 200e3 * random.uniform(1)};
}

} // namespace

TEST(EveryLaw, HasPositiveModulusAndDerivativesThatAgreeWithFiniteDifferences) {
    for (const Law* law : material::laws()) {
        SCOPED_TRACE(law->name());
        int turned = 0;
        for (int k = 0; k < 100; ++k) {
            const auto p = random_parameters(*law, k);
            const auto at = random_state(k);
            const auto m = law->modulus(p, at);
            EXPECT_GT(m.value, 0.0);
            const double h = 1.0; // Pa
            const double by_theta =
                (law->modulus(p, {at.theta + h, at.tau}).value - law->modulus(p, {at.theta - h, at.tau}).value) /
                (2 * h);
            const double by_tau =
                (law->modulus(p, {at.theta, at.tau + h}).value - law->modulus(p, {at.theta, at.tau - h}).value) /
                (2 * h);
            const double scale = m.value / 1e5;
            EXPECT_NEAR(m.d_theta, by_theta, 1e-6 * (scale + std::abs(by_theta)));
            EXPECT_NEAR(m.d_tau, by_tau, 1e-6 * (scale + std::abs(by_tau)));
            const auto unit = [&](double theta, double tau) {
                return law->unit_stiffness(p, {at.theta + theta, at.tau + tau});
            };
            const auto gradient = law->unit_stiffness_gradient(p, at);
            const double unit_scale = unit(0, 0).norm() / 1e5;
            EXPECT_LT((gradient.d_theta - (unit(h, 0) - unit(-h, 0)) / (2 * h)).norm(), 1e-6 * unit_scale);
            EXPECT_LT((gradient.d_tau - (unit(0, h) - unit(0, -h)) / (2 * h)).norm(), 1e-6 * unit_scale);
            turned += gradient.d_theta.isZero(0.0) ? 0 : 1;
            for (std::size_t i = 0; i < p.size(); ++i) {
                if (!law->parameters()[i].choices.empty()) {
                    continue;
                }
                auto low = p;
                auto high = p;
                const double step = 1e-5 * std::abs(p[i]);
                low[i] -= step;
                high[i] += step;
                const double numeric = (law->modulus(high, at).value - law->modulus(low, at).value) / (2 * step);
                EXPECT_NEAR(law->modulus_derivative(p, at, m, i), numeric, 1e-6 * (m.value / std::abs(p[i])));
                const mechanics::Stiffness<6> c =
                    (law->unit_stiffness(high, at) - law->unit_stiffness(low, at)) / (2 * step);
                EXPECT_LT((law->unit_stiffness_derivative(p, at, i) - c).norm(), 1e-6 * (1.0 + c.norm()));
                const auto terms = law->relaxation(p);
                const auto shorter = law->relaxation(low);
                const auto longer = law->relaxation(high);
                const auto rates = law->relaxation_derivative(p, i);
                ASSERT_EQ(rates.size(), terms.size());
                EXPECT_TRUE(terms.empty() || law->relaxes());
                for (std::size_t t = 0; t < terms.size(); ++t) {
                    const double share = (longer[t].share - shorter[t].share) / (2 * step);
                    const double time = (longer[t].time - shorter[t].time) / (2 * step);
                    EXPECT_NEAR(rates[t].share, share, 1e-6 * std::abs(terms[t].share / p[i]));
                    EXPECT_NEAR(rates[t].time, time, 1e-6 * std::abs(terms[t].time / p[i]) + 1e-6 * std::abs(time));
                }
            }
        }
        EXPECT_EQ(turned > 0, law->turns());
    }
}

// A solid stores energy under any strain: its stiffness is symmetric and positive definite. Over all that a study may
// state.
TEST(EveryLaw, IsASolidWhereItDoesNotCallItselfImpossibleAndNowhereElse) {
    for (const Law* law : material::laws()) {
        SCOPED_TRACE(law->name());
        int solids = 0;
        int others = 0;
        for (int k = 0; k < 3000; ++k) {
            const RandomStream random(23, static_cast<std::uint64_t>(k));
            std::vector<double> p = random_parameters(*law, k);
            for (std::size_t i = 0; i < p.size(); ++i) {
                const auto& info = law->parameters()[i];
                if (info.key == "n" || info.key == "n_highest" || info.key == "shear_ratio" ||
                    info.key.starts_with("poisson")) {
                    const double high = std::min(info.high, 3.0);
                    p[i] = info.low + (high - info.low) * random.uniform(i);
                }
            }
            const mechanics::Stiffness<6> c = law->unit_stiffness(p, random_state(k));
            const std::string why = law->impossible(p);
            const bool possible = why.empty();
            if (why.starts_with("deviator") || why.starts_with("the shares") ||
                why.starts_with("n_lowest")) { // of the modulus, not of the solid
                continue;
            }
            if (!c.allFinite()) {
                EXPECT_FALSE(possible);
                continue;
            }
            EXPECT_LT((c - c.transpose()).norm(), 1e-12 * c.norm());
            const Eigen::VectorXd eigenvalues =
                Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(Eigen::MatrixXd(c), Eigen::EigenvaluesOnly)
                    .eigenvalues();
            if (std::abs(eigenvalues[0]) > 1e-9 * eigenvalues.cwiseAbs().maxCoeff()) { // not on the border
                // What turns is possible where it is at every stress.
                EXPECT_TRUE(possible == (eigenvalues[0] > 0.0) || (law->turns() && !possible)) << k << " " << why;
                ++(possible ? solids : others);
            }
        }
        EXPECT_GT(solids, 100);
        EXPECT_TRUE(others > 100 || !law->index_of("n")) << others; // isotropic: its ranges leave nothing out
    }
}

TEST(EveryLaw, SaysWhetherItDependsOnStress) {
    for (const Law* law : material::laws()) {
        const auto p = random_parameters(*law, 3);
        EXPECT_EQ(law->stress_dependent(), law->modulus(p, {1e5, 0.0}).value != law->modulus(p, {2e5, 1e5}).value)
            << law->name();
    }
}

TEST(EveryLaw, NamesEachParameterOnceAndHasARange) {
    for (const Law* law : material::laws()) {
        const auto infos = law->parameters();
        for (std::size_t i = 0; i < infos.size(); ++i) {
            EXPECT_EQ(law->index_of(infos[i].key), i);
            EXPECT_LT(infos[i].low, infos[i].high) << infos[i].key;
            EXPECT_FALSE(infos[i].meaning.empty());
        }
    }
}

TEST(Uzan, IsThePrintedEquationInCompression) {
    const Law& law = *material::find_law("uzan");
    // k1 = 1000, k2 = 0.6, k3 = -0.4, smoothing negligible; theta = 3 pa, tau = pa: E = 1000 pa 3^0.6 2^-0.4
    const std::vector<double> p{0, 1000, 0.6, -0.4, 0.5, 0.35, 0.35, material::not_given, 1e-3, 0.0};
    EXPECT_NEAR(law.modulus(p, {3e5, 1e5}).value, 1000 * 1e5 * std::pow(3.0, 0.6) * std::pow(2.0, -0.4), 1e-3);
}

TEST(Uzan, FloorOfThetaIsDeltaAtZeroAndFallsOffInTension) {
    const Law& law = *material::find_law("uzan");
    const std::vector<double> p{0, 1000, 1.0, 0.0, 0.5, 0.35, 0.35, material::not_given, 5e3, 0.0};
    EXPECT_NEAR(law.modulus(p, {0.0, 0.0}).value, 1000 * 5e3, 1e-3);
    // Far in tension thp -> delta^2/|theta| = 25e6/1e6 = 25 Pa.
    EXPECT_NEAR(law.modulus(p, {-1e6, 0.0}).value, 1000 * 25.0, 1.0);
}

TEST(Uzan, NeverExceedsTheModulusLimitAndSaysSo) {
    const Law& law = *material::find_law("uzan");
    const std::vector<double> p{0, 4500, 2.1, 30, 0.25, 0.35, 0.35, material::not_given, 5e3, 0.0};
    const auto m = law.modulus(p, {5e5, 3e5});
    EXPECT_EQ(m.value, material::modulus_limit);
    EXPECT_TRUE(m.limited);
    EXPECT_EQ(m.d_theta, 0.0);
}

namespace {

// Work per volume along a closed path of stress: the sum of s : C^-1 ds / E(s), s the whole stress, pa.
double work_of_cycle(const Law& law, const std::vector<double>& p) {
    const auto stress = [](double t) { // compression negative
        mechanics::Voigt<6> s = mechanics::Voigt<6>::Zero();
        s[0] = s[1] = -(100e3 + 60e3 * std::cos(t));
        s[2] = -(150e3 + 120e3 * std::sin(t));
        s[3] = 20e3 * std::sin(2.0 * t);
        return s;
    };
    constexpr int steps = 2000;
    const double h = 2.0 * std::numbers::pi / steps;
    double work = 0.0;
    for (int i = 0; i < steps; ++i) { // of a periodic function: the midpoint rule has no error to speak of
        const double t = (i + 0.5) * h;
        const mechanics::Voigt<6> s = stress(t);
        const mechanics::Voigt<6> rate = (stress(t + 1e-4) - stress(t - 1e-4)) / 2e-4;
        const auto at = mechanics::invariants<6>(s);
        work += h * s.dot(law.unit_stiffness(p, at).inverse() * rate) / law.modulus(p, at).value;
    }
    return work;
}

// Of the largest energy on the way.
double share_of_energy(const Law& law, const std::vector<double>& p) {
    const double energy = 0.5 * 270e3 * 270e3 / law.modulus(p, {270e3 + 200e3, 50e3}).value;
    return std::abs(work_of_cycle(law, p)) / energy;
}

} // namespace

TEST(LadeNelson, NoClosedCycleOfStressMakesWork) {
    const Law& law = *material::find_law("lade-nelson");
    for (const double lambda : {0.2, 0.35, -0.3}) {
        EXPECT_LT(share_of_energy(law, {800, lambda, 0.3, 5e3}), 1e-7) << lambda;
    }
    // The others do: what their law leaves out. The figures are those of docs/theory/laws.md.
    for (const auto& [name, p] : std::initializer_list<std::pair<const char*, std::vector<double>>>{
             {"uzan", {0, 800, 0.6, -0.3, 1, 0.3, 0.3, NAN, 5e3, 0}},
             {"k-theta", {0, 800, 0.6, 1, 0.3, 0.3, NAN, 5e3, 0}},
             {"uzan-deviator", {0, 800, 0.6, -0.3, 10e3, 1, 0.3, 0.3, NAN, 5e3, 0}},
             {"uzan-separate", {800, 0.6, -0.3, 300, 0.9, -0.6, 250, 0.8, -0.3, 0.03, 1, 0.3, 0.3, 5e3, 0}},
             {"dresden", {0, 800, 800, 0.5, 0.33, 20e6, 5e3, 1, 0.3, 0.3, NAN, 5e3, 0}}}) {
        const Law& other = *material::find_law(name);
        ASSERT_EQ(p.size(), other.parameters().size());
        const double share = share_of_energy(other, p);
        std::printf("  %-14s %.2f %% of the largest stored energy in a closed cycle\n", name, 100 * share);
        EXPECT_GT(share, 1e-3);
    }
}

TEST(LadeNelson, IsThePrintedEquation) {
    // nu = 0.2: R = 6 * 1.2/0.6 = 12; theta = 3 pa, tau = pa: J2 = 1.5 pa^2; E = m pa (9 + 18)^lambda
    EXPECT_NEAR(material::find_law("lade-nelson")->modulus(std::vector<double>{500, 0.3, 0.2, 1e-3}, {3e5, 1e5}).value,
                500e5 * std::pow(27.0, 0.3), 1e-3);
}

TEST(KTheta, IsUzanWithoutShear) {
    const std::vector<double> own{0, 900, 0.6, 0.7, 0.3, 0.35, NAN, 5e3, 0.5};
    const std::vector<double> uzan{0, 900, 0.6, 0.0, 0.7, 0.3, 0.35, NAN, 5e3, 0.5};
    for (int k = 0; k < 20; ++k) {
        const auto at = random_state(k);
        EXPECT_DOUBLE_EQ(material::find_law("k-theta")->modulus(own, at).value,
                         material::find_law("uzan")->modulus(uzan, at).value);
    }
}

TEST(UzanDeviator, IsThePrintedEquationInTheTriaxialTest) {
    // s3 = pa, s1 = 3 pa: theta = 5 pa, deviator 2 pa, tau = sqrt(2)/3 * 2 pa
    const std::vector<double> with_floor{0, 900, 0.6, -0.2, 1.0, 1.0, 0.3, 0.35, NAN, 1e-3, 0.0};
    const double tau = std::sqrt(2.0) / 3.0 * 2e5;
    EXPECT_NEAR(material::find_law("uzan-deviator")->modulus(with_floor, {5e5, tau}).value,
                900e5 * std::pow(5.0, 0.6) * std::pow(2.0, -0.2), 1.0);
}

TEST(UzanSeparate, GivesEachModulusItsPrintedEquation) {
    const Law& law = *material::find_law("uzan-separate");
    const std::vector<double> p{900, 0.6, -0.3, 200, 0.9, -0.6, 250, 0.8, 0.2, 0.01, 5, 0.2, 0.3, 1e-3, 0.0};
    const auto modulus = [](double k1, double k2, double k3) { // at theta = 3 pa, tau = pa
        return k1 * 1e5 * std::pow(3.0, k2) * std::pow(2.0, k3);
    };
    const mechanics::Invariants at{3e5, 1e5};
    const double e = law.modulus(p, at).value;
    const mechanics::Stiffness<6> compliance = law.unit_stiffness(p, at).inverse() / e;
    EXPECT_NEAR(e, modulus(900, 0.6, -0.3), 1e-3);
    EXPECT_NEAR(1.0 / compliance(2, 2), modulus(900, 0.6, -0.3), 1e-3);
    EXPECT_NEAR(1.0 / compliance(0, 0), modulus(200, 0.9, -0.6), 1e-3);
    EXPECT_NEAR(1.0 / compliance(3, 3), modulus(250, 0.8, 0.2), 1e-3);
    EXPECT_NEAR(-compliance(0, 2) * e, 0.3, 1e-12);
    EXPECT_NEAR(-compliance(0, 1) * modulus(200, 0.9, -0.6), 0.2, 1e-12);
    // The ratio of the first two stays between its limits.
    const auto horizontal = [&](double lowest, double highest) {
        auto limited = p;
        limited[9] = lowest;
        limited[10] = highest;
        return 1.0 / law.unit_stiffness(limited, at).inverse()(0, 0);
    };
    EXPECT_NEAR(horizontal(0.5, 1.0), 0.5, 1e-12);
    EXPECT_NEAR(horizontal(0.01, 0.1), 0.1, 1e-12);
}

TEST(UzanSeparate, IsUzanWhereTheExponentsAreOne) {
    const std::vector<double> own{900, 0.6, -0.4, 270, NAN, NAN, 180, NAN, NAN, 0.01, 1, 0.3, 0.35, 5e3, 0.5};
    const std::vector<double> uzan{1, 900, 0.6, -0.4, 0.3, 0.3, 0.35, 0.2, 5e3, 0.5};
    const Law& law = *material::find_law("uzan-separate");
    const Law& other = *material::find_law("uzan");
    for (int k = 0; k < 20; ++k) {
        const auto at = random_state(k);
        EXPECT_DOUBLE_EQ(law.modulus(own, at).value, other.modulus(uzan, at).value);
        EXPECT_TRUE(law.unit_stiffness(own, at).isApprox(other.unit_stiffness(uzan, at), 1e-14));
    }
}

TEST(Dresden, IsThePrintedEquationInTheTriaxialTest) {
    // s3 = pa, s1 = 4 pa: theta = 6 pa, deviator 3 pa; E = (q + c) pa 4^q2 + d
    std::vector<double> p{0, 700, 500, 0.5, 0.33, 30e6, 1.0, 1.0, 0.3, 0.35, NAN, 1e-3, 0.0};
    const double tau = std::sqrt(2.0) / 3.0 * 3e5;
    EXPECT_NEAR(material::find_law("dresden")->modulus(p, {6e5, tau}).value, 1200e5 * std::pow(4.0, 0.33) + 30e6, 1.0);
    // s3 = pa/4, s1 = pa
    EXPECT_NEAR(material::find_law("dresden")->modulus(p, {1.5e5, std::sqrt(2.0) / 3.0 * 0.75e5}).value, 950e5 + 30e6,
                1.0);
    // In tension (theta has its floor at zero) nothing is left of the confinement: s1 = 4/3 pa.
    EXPECT_NEAR(material::find_law("dresden")->modulus(p, {-1e5, std::sqrt(2.0) / 3.0 * 2e5}).value,
                700e5 * std::pow(4.0 / 3.0, 0.33) + 30e6, 1e3);
}

TEST(Bilinear, IsThePrintedEquationAwayFromItsCorners) {
    const Law& law = *material::find_law("bilinear");
    // Er = K1 + K3 (K2 - q) below K2, K1 - K4 (q - K2) above it; corners are rounded over 3 kPa.
    const std::vector<double> p{0, 60e6, 1000, 178, 41e3, 14e3, 145e3, 1.0, 0.4, 0.4, NAN, 5e3, 0.0};
    const auto at = [&](double q) { return law.modulus(p, {1e5, std::sqrt(2.0) / 3.0 * q}).value; };
    EXPECT_EQ(law.impossible(p), "");
    EXPECT_NEAR(at(28e3), 60e6 + 1000 * 13e3, 0.02 * 13e6);
    EXPECT_NEAR(at(100e3), 60e6 - 178 * 59e3, 0.02 * 10e6);
    EXPECT_NEAR(at(0.0), 60e6 + 1000 * 27e3, 0.02 * 27e6);   // as at the lowest deviator stress
    EXPECT_NEAR(at(400e3), 60e6 - 178 * 104e3, 0.02 * 18e6); // as at the highest
    auto weak = p;
    weak[1] = 15e6;
    EXPECT_NE(law.impossible(weak), "") << "negative at the highest deviator stress";
}

// A repeated-load triaxial test on a fine-grained soil, four inches long: recoverable deformation in thousandths of an
// inch at deviators of 1 to 10 psi under confining pressures of 6, 3 and 0 psi, and the four numbers of the law that
// its source fits to them ("Resilient Modulus Calculation", scribd.com/document/841422833).
TEST(Bilinear, IsTheCurveThatIsFittedToATriaxialTest) {
    constexpr double psi = 6894.757;
    const Law& law = *material::find_law("bilinear");
    const std::vector<double> p{1,  5422.110 * psi, 942.9, 366.7, 5.489 * psi, 0.0, 21 * psi, 1.0, 0.4, 0.4, NAN, 5e3,
                                0.0};
    struct Measured {
        double deviator; // psi
        double deformations[3];
    };
    for (const auto& m :
         {Measured{1, {0.392, 0.416, 0.456}}, Measured{2, {0.816, 0.868, 1.04}}, Measured{4, {2.052, 2.224, 3.02}},
          Measured{8, {5.712, 7.112, 9.412}}, Measured{10, {7.692, 11.112, 16.0}}}) {
        double mean = 0.0;
        for (const double d : m.deformations) {
            mean += m.deviator / (d * 1e-3 / 4.0) / 3.0;
        }
        const double tau = m.deviator * psi * std::numbers::sqrt2 / 3.0;
        const double theta = (m.deviator + 9.0) * psi; // confined by 3 psi; the law does not mind
        EXPECT_NEAR(law.modulus(p, {theta, tau}).value / (mean * psi), 1.0, 0.025) << m.deviator;
    }
}

TEST(EveryLaw, IsProportionalToItsScaleParametersTogether) {
    for (const Law* law : material::laws()) {
        for (int k = 0; k < 10; ++k) {
            const auto p = random_parameters(*law, k);
            auto twice = p;
            for (const std::size_t i : law->scale_parameters()) {
                twice[i] *= 2.0;
            }
            const auto at = random_state(k);
            EXPECT_NEAR(law->modulus(twice, at).value, 2.0 * law->modulus(p, at).value,
                        1e-9 * law->modulus(p, at).value)
                << law->name();
        }
    }
}
