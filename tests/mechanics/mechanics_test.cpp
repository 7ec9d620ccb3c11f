#include "mechanics/cross_anisotropic.h"

#include "base/random.h"

#include <gtest/gtest.h>

using namespace pave::mechanics;

namespace {

CrossAnisotropy random_solid(std::uint64_t stream) {
    const pave::RandomStream random(11, stream);
    CrossAnisotropy solid;
    solid.n = 0.1 + 1.4 * random.uniform(0);
    solid.nu12 = -0.2 + 0.6 * random.uniform(1);
    solid.nu31 = 0.1 + 0.3 * random.uniform(2);
    if (random.uniform(3) < 0.5) {
        solid.shear_ratio = 0.1 + random.uniform(4);
    }
    solid.modulus_is_vertical = random.uniform(5) < 0.5;
    return solid;
}

// The compliance of a solid with a vertical axis of symmetry, written down from the definitions of its constants.
Stiffness<6> compliance(const CrossAnisotropy& solid) {
    const double e3 = solid.modulus_is_vertical ? 1.0 : 1.0 / solid.n;
    const double e1 = solid.n * e3;
    Stiffness<6> s = Stiffness<6>::Zero();
    s(0, 0) = s(1, 1) = 1.0 / e1;
    s(2, 2) = 1.0 / e3;
    s(0, 1) = s(1, 0) = -solid.nu12 / e1;
    s(0, 2) = s(1, 2) = s(2, 0) = s(2, 1) = -solid.nu31 / e3;
    s(3, 3) = s(4, 4) = solid.shear_ratio ? 1.0 / (*solid.shear_ratio * e3) : 1.0 / e1 + (1.0 + 2.0 * solid.nu31) / e3;
    s(5, 5) = 2.0 * (1.0 + solid.nu12) / e1;
    return s;
}

} // namespace

TEST(CrossAnisotropy, StiffnessIsTheInverseOfTheCompliance) {
    for (int k = 0; k < 200; ++k) {
        const CrossAnisotropy solid = random_solid(k);
        if (!solid.impossible().empty()) {
            continue;
        }
        const Stiffness<6> one = solid.unit_stiffness() * compliance(solid);
        EXPECT_LT((one - Stiffness<6>::Identity()).lpNorm<Eigen::Infinity>(), 1e-12);
    }
}

TEST(CrossAnisotropy, IsPossibleExactlyWhenTheStrainEnergyIsPositive) {
    int possible = 0;
    for (int k = 0; k < 500; ++k) {
        const pave::RandomStream random(12, k);
        CrossAnisotropy solid;
        solid.n = 0.05 + 4.0 * random.uniform(0);
        solid.nu12 = -1.2 + 2.4 * random.uniform(1);
        solid.nu31 = -0.8 + 1.6 * random.uniform(2);
        solid.shear_ratio = 0.3;
        const Eigen::SelfAdjointEigenSolver<Stiffness<6>> eigen(compliance(solid));
        EXPECT_EQ(solid.impossible().empty(), eigen.eigenvalues().minCoeff() > 0.0);
        possible += solid.impossible().empty() ? 1 : 0;
    }
    EXPECT_GT(possible, 50);
    EXPECT_LT(possible, 450);
    // On the border some strain costs nothing, exactly: 1 - 1/2 - 2 / 4 = 0.
    EXPECT_FALSE((CrossAnisotropy{.n = 1.0, .nu12 = 0.5, .nu31 = 0.5, .shear_ratio = {}}).impossible().empty());
}

TEST(CrossAnisotropy, IsIsotropicWhenTheModuliAreEqual) {
    const CrossAnisotropy solid{.n = 1.0, .nu12 = 0.3, .nu31 = 0.3, .shear_ratio = {}, .modulus_is_vertical = false};
    const Stiffness<6> c = solid.unit_stiffness();
    const double lambda = 0.3 / (1.3 * 0.4);
    const double shear = 1.0 / 2.6;
    EXPECT_NEAR(c(0, 0), lambda + 2.0 * shear, 1e-14);
    EXPECT_NEAR(c(2, 2), lambda + 2.0 * shear, 1e-14);
    EXPECT_NEAR(c(0, 2), lambda, 1e-14);
    EXPECT_NEAR(c(3, 3), shear, 1e-14);
}

TEST(CrossAnisotropy, DerivativesAgreeWithFiniteDifferences) {
    using Variable = CrossAnisotropy::Variable;
    for (int k = 0; k < 50; ++k) {
        CrossAnisotropy solid = random_solid(k);
        solid.shear_ratio = solid.shear_ratio.value_or(0.4);
        const auto check = [&](Variable variable, auto change) {
            constexpr double h = 1e-5;
            CrossAnisotropy low = solid;
            CrossAnisotropy high = solid;
            change(low, -h);
            change(high, h);
            const Stiffness<6> numeric = (high.unit_stiffness() - low.unit_stiffness()) / (2.0 * h);
            const Stiffness<6> exact = solid.unit_stiffness_derivative(variable);
            EXPECT_LT((numeric - exact).norm(), 1e-7 * (1.0 + exact.norm()));
        };
        check(Variable::n, [](CrossAnisotropy& s, double h) { s.n += h; });
        check(Variable::nu12, [](CrossAnisotropy& s, double h) { s.nu12 += h; });
        check(Variable::nu31, [](CrossAnisotropy& s, double h) { s.nu31 += h; });
        check(Variable::shear_ratio, [](CrossAnisotropy& s, double h) { *s.shear_ratio += h; });
    }
}

TEST(Invariants, AreThoseOfThePrincipalStresses) {
    for (int k = 0; k < 50; ++k) {
        const pave::RandomStream random(13, k);
        Voigt<6> s;
        for (int i = 0; i < 6; ++i) {
            s[i] = random.normal(i);
        }
        Eigen::Matrix3d t;
        t << s[0], s[5], s[3], s[5], s[1], s[4], s[3], s[4], s[2];
        const Eigen::Vector3d p = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(t).eigenvalues();
        const double tau =
            std::sqrt(std::pow(p[0] - p[1], 2) + std::pow(p[1] - p[2], 2) + std::pow(p[2] - p[0], 2)) / 3.0;
        EXPECT_NEAR(invariants<6>(s).theta, -p.sum(), 1e-12);
        EXPECT_NEAR(invariants<6>(s).tau, tau, 1e-12);
    }
}

TEST(Invariants, GradientOfTheOctahedralShearAgreesWithFiniteDifferences) {
    const pave::RandomStream random(14, 0);
    Voigt<6> s;
    for (int i = 0; i < 6; ++i) {
        s[i] = random.normal(i);
    }
    const Voigt<6> exact = tau_times_gradient<6>(s) / invariants<6>(s).tau;
    for (int i = 0; i < 6; ++i) {
        Voigt<6> low = s;
        Voigt<6> high = s;
        low[i] -= 1e-6;
        high[i] += 1e-6;
        EXPECT_NEAR((invariants<6>(high).tau - invariants<6>(low).tau) / 2e-6, exact[i], 1e-8);
    }
}
