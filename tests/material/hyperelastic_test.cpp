// The law whose strain derives from an energy, at a point.
#include "base/random.h"
#include "base/units.h"
#include "material/catalog.h"

#include <cmath>
#include <gtest/gtest.h>
#include <numbers>

using namespace pave;
using mechanics::Stiffness;
using mechanics::Voigt;

namespace {

constexpr double pa = 1e5;

const material::Law& law() {
    return *material::find_law("hyperelastic");
}

std::vector<double> parameters(double k, double n = 0.4, double k1 = 1500.0, double delta = 5e3) {
    return {0.0, k1, k, n, 0.3, 0.25, material::not_given, delta};
}

Stiffness<6> compliance(const std::vector<double>& p) {
    return law().unit_stiffness(p, {}).inverse();
}

Voigt<6> strain(const std::vector<double>& p, const Voigt<6>& stress) {
    const Voigt<6> direction = compliance(p) * stress;
    return direction / law().energy()->secant(p, stress.dot(direction)).value;
}

double complementary(const std::vector<double>& p, const Voigt<6>& stress) {
    return law().energy()->complementary(p, stress.dot(compliance(p) * stress));
}

// (A - h A s (x) A s)/E
Stiffness<6> tangent(const std::vector<double>& p, const Voigt<6>& stress) {
    const Stiffness<6> a = compliance(p);
    const Voigt<6> direction = a * stress;
    const auto s = law().energy()->secant(p, stress.dot(direction));
    return (a - s.hardening * (direction * direction.transpose())) / s.value;
}

// In compression and tension, with shear.
Voigt<6> random_stress(std::uint64_t stream) {
    const RandomStream random(31, stream);
    Voigt<6> stress;
    for (int i = 0; i < 6; ++i) {
        stress[i] = 150e3 * random.normal(static_cast<std::uint64_t>(i));
    }
    return std::exp(3.0 * random.normal(7)) * stress; // of any size
}

double random_exponent(std::uint64_t stream) {
    return -0.99 + 1.98 * RandomStream(32, stream).uniform(0);
}

} // namespace

TEST(Hyperelastic, StrainIsTheGradientOfTheEnergyAndTheTangentThatOfTheStrain) {
    // The last: moduli that meet their limit, at large stress or at small.
    for (const double k1 : {1500.0, 9e5}) {
        for (std::uint64_t i = 0; i < 100; ++i) {
            const auto p = parameters(random_exponent(i), 0.4, k1);
            const Voigt<6> stress = random_stress(i);
            const double h = 1e-4 * stress.norm();
            Voigt<6> gradient;
            Stiffness<6> slope;
            for (int j = 0; j < 6; ++j) {
                const auto moved = [&](double by) {
                    Voigt<6> s = stress;
                    s[j] += by * h;
                    return s;
                };
                gradient[j] = (8.0 * (complementary(p, moved(1)) - complementary(p, moved(-1))) -
                               (complementary(p, moved(2)) - complementary(p, moved(-2)))) /
                              (12.0 * h);
                slope.col(j) = (8.0 * (strain(p, moved(1)) - strain(p, moved(-1))) -
                                (strain(p, moved(2)) - strain(p, moved(-2)))) /
                               (12.0 * h);
            }
            EXPECT_LT((gradient - strain(p, stress)).norm(), 1e-8 * gradient.norm()) << p[2];
            EXPECT_LT((slope - tangent(p, stress)).norm(), 1e-8 * slope.norm()) << p[2];
            EXPECT_LT((slope - slope.transpose()).norm(), 1e-8 * slope.norm()) << p[2];
        }
    }
}

TEST(Hyperelastic, IsConvexForEveryExponentBelowOne) {
    for (std::uint64_t i = 0; i < 2000; ++i) {
        auto p = parameters(random_exponent(i));
        const RandomStream random(33, i);
        p[3] = 0.05 + random.uniform(0);
        p[4] = -0.2 + 0.6 * random.uniform(1);
        p[5] = -0.2 + 0.6 * random.uniform(2);
        const Voigt<6> stress = random_stress(i);
        const Stiffness<6> soft = tangent(p, stress);
        const double least =
            Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(Eigen::MatrixXd(soft), Eigen::EigenvaluesOnly)
                .eigenvalues()[0];
        EXPECT_GT(least, 0.0) << p[2];
        // Between any two stresses too.
        const Voigt<6> other = random_stress(i + 10000);
        EXPECT_GT((strain(p, stress) - strain(p, other)).dot(stress - other), 0.0) << p[2];
    }
}

// Along a path from no stress the tangent grows: E/(1 - k) where the floor does not count.
TEST(Hyperelastic, HasATangentModulusAboveItsSecant) {
    const auto p = parameters(0.6, 1.0, 1500.0, 1.0);
    Voigt<6> stress = Voigt<6>::Zero();
    stress[2] = -2.0 * pa;
    const double e = 1500.0 * pa * std::pow(2.0, 0.6); // Q = stress^2 of the horizontal modulus, here that of all
    EXPECT_NEAR(stress[2] / strain(p, stress)[2], e, 1e-6 * e);
    EXPECT_NEAR(1.0 / tangent(p, stress)(2, 2), e / 0.4, 1e-6 * e);
}

TEST(Hyperelastic, FindsTheStressOfEveryStrain) {
    for (const double k1 : {1500.0, 9e5}) { // the second meets the limit of moduli
        for (std::uint64_t i = 0; i < 500; ++i) {
            const auto p = parameters(random_exponent(i), 0.4, k1);
            const Voigt<6> stress = random_stress(i);
            const Voigt<6> e = strain(p, stress);
            const double q = stress.dot(compliance(p) * stress);
            EXPECT_NEAR(law().energy()->stress_square(p, e.dot(law().unit_stiffness(p, {}) * e)) / q, 1.0, 1e-11)
                << p[2];
        }
    }
    EXPECT_EQ(law().energy()->stress_square(parameters(0.5), 0.0), 0.0);
}

TEST(Hyperelastic, HasExactRatesOfItsSecant) {
    for (std::uint64_t i = 0; i < 50; ++i) {
        const auto p = parameters(random_exponent(i));
        const Voigt<6> stress = random_stress(i);
        const double q = stress.dot(compliance(p) * stress);
        const auto& energy = *law().energy();
        const auto here = energy.secant(p, q);
        const double h = 1e-5 * q;
        EXPECT_NEAR(here.hardening * here.value * q,
                    (energy.secant(p, q + h).value - energy.secant(p, q - h).value) / h * q, 1e-8 * here.value);
        EXPECT_NEAR(here.d_hardening * q * q,
                    (energy.secant(p, q + h).hardening - energy.secant(p, q - h).hardening) / (2.0 * h) * q * q, 1e-8);
        for (std::size_t j = 1; j < p.size(); ++j) {
            if (std::isnan(p[j])) {
                continue;
            }
            auto low = p;
            auto high = p;
            const double step = 1e-5 * std::abs(p[j]);
            low[j] -= step;
            high[j] += step;
            const auto rate = energy.secant_rate(p, q, here, j);
            EXPECT_NEAR(rate.value * p[j],
                        (energy.secant(high, q).value - energy.secant(low, q).value) / (2 * step) * p[j],
                        1e-8 * here.value)
                << j;
            EXPECT_NEAR(rate.hardening * p[j] * q,
                        (energy.secant(high, q).hardening - energy.secant(low, q).hardening) / (2 * step) * p[j] * q,
                        1e-8)
                << j;
        }
    }
}

namespace {

// What a closed cycle of stress leaves of strain, over its largest: the sum of tangent compliance times change of
// stress, that of a law of moduli its C^-1/E.
template <class Tangent>
double kept(Tangent tangent) {
    const auto stress = [](double t) { // compression negative; passes tension
        Voigt<6> s = Voigt<6>::Zero();
        s[0] = s[1] = -(30e3 + 60e3 * std::cos(t));
        s[2] = -(150e3 + 140e3 * std::sin(t + 0.15));
        s[3] = 20e3 * std::sin(2.0 * t);
        return s;
    };
    constexpr int steps = 4000;
    const double h = 2.0 * std::numbers::pi / steps;
    Voigt<6> sum = Voigt<6>::Zero();
    double largest = 0.0;
    for (int i = 0; i < steps; ++i) { // of a periodic function: the midpoint rule has no error to speak of
        const double t = (i + 0.5) * h;
        const double d = 1e-3;
        const Voigt<6> rate =
            (8.0 * (stress(t + d) - stress(t - d)) - (stress(t + 2 * d) - stress(t - 2 * d))) / (12 * d);
        sum += h * tangent(stress(t)) * rate;
        largest = std::max(largest, sum.norm());
    }
    return sum.norm() / largest;
}

} // namespace

TEST(Hyperelastic, NoClosedCycleOfStressLeavesStrain) {
    for (const double k : {0.3, 0.6, 0.9, -0.5}) {
        const auto p = parameters(k, 0.4, 1500.0, 20e3);
        EXPECT_LT(kept([&](const Voigt<6>& s) { return tangent(p, s); }), 1e-10) << k;
    }
    // The others leave some; the figures are those of docs/theory/laws.md.
    for (const auto& [name, p] : std::initializer_list<std::pair<const char*, std::vector<double>>>{
             {"uzan", {0, 800, 0.6, -0.3, 0.4, 0.3, 0.25, NAN, 20e3, 0}},
             {"k-theta", {0, 800, 0.6, 0.4, 0.3, 0.25, NAN, 20e3, 0}},
             {"lade-nelson", {800, 0.3, 0.3, 20e3}}}) {
        const material::Law& other = *material::find_law(name);
        const double share = kept([&, &p = p](const Voigt<6>& s) {
            const auto at = mechanics::invariants<6>(s);
            return Stiffness<6>(other.unit_stiffness(p, at).inverse() / other.modulus(p, at).value);
        });
        std::printf("  %-14s keeps %.1f %% of the largest strain of a closed cycle\n", name, 100 * share);
        EXPECT_GT(share, 0.02) << name;
    }
}

// Q = (1 - 2 nu)/3 (theta^2 + R J2) where the layer is isotropic: the modulus of Lade and Nelson, as a secant.
TEST(Hyperelastic, HasTheInvariantOfLadeAndNelsonWhereItIsIsotropic) {
    const double nu = 0.3;
    const double k = 0.5;
    const double share = (1.0 - 2.0 * nu) / 3.0;
    const std::vector<double> own{1.0, 900.0, k, 1.0, nu, nu, material::not_given, 4e3};
    const std::vector<double> other{900.0 * std::pow(share, k / 2.0), k / 2.0, nu, 4e3 / std::sqrt(share)};
    for (std::uint64_t i = 0; i < 50; ++i) {
        const Voigt<6> stress = random_stress(i);
        const auto at = mechanics::invariants<6>(stress);
        const double expected = material::find_law("lade-nelson")->modulus(other, at).value;
        const double q = stress.dot(compliance(own) * stress);
        EXPECT_NEAR(law().energy()->secant(own, q).value, expected, 1e-11 * expected);
        EXPECT_NEAR(law().modulus(own, at).value, expected, 1e-11 * expected);
    }
}

TEST(Hyperelastic, IsThePrintedEquationUnderVerticalStress) {
    // The vertical modulus: Q is the square of the stress.
    std::vector<double> p = parameters(0.4, 0.3, 1200.0, 1.0);
    p[0] = 1.0;
    Voigt<6> stress = Voigt<6>::Zero();
    stress[2] = -3.0 * pa;
    const double e = 1200.0 * pa * std::pow(3.0, 0.4);
    const Voigt<6> found = strain(p, stress);
    EXPECT_NEAR(found[2], -3.0 * pa / e, 1e-9 * std::abs(found[2]));
    EXPECT_NEAR(found[0], 0.25 * 3.0 * pa / e, 1e-9 * std::abs(found[0])); // nu31
    // The horizontal one: E3 = E1/n, Q = n stress^2.
    p[0] = 0.0;
    const double along = 1200.0 * pa * std::pow(std::sqrt(0.3) * 3.0, 0.4);
    EXPECT_NEAR(strain(p, stress)[2], -0.3 * 3.0 * pa / along, 1e-9 * std::abs(strain(p, stress)[2]));
}
