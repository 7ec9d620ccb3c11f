// Many runs of a forward model at once, against each of them alone.
#include "support/sections.h"

#include <gtest/gtest.h>

namespace {

using namespace test;

std::vector<Parameter> parameters_of(const Case& c, const std::vector<std::string>& paths) {
    std::vector<Parameter> list;
    for (const std::string& path : paths) {
        list.push_back(find_parameter(c, path, {}));
    }
    return list;
}

// Largest difference of deflections, and of each column of their derivatives, relative to the largest.
void expect_near(const Response& a, const Response& b, double tolerance) {
    constexpr Eigen::Index deflections = 6;
    const auto first = [](const Response& r) {
        return Eigen::Map<const Eigen::VectorXd>(r.values.data(), deflections);
    };
    EXPECT_LT((first(a) - first(b)).cwiseAbs().maxCoeff(), tolerance * first(a).cwiseAbs().maxCoeff());
    for (Eigen::Index k = 0; k < a.jacobian.cols(); ++k) {
        const auto column = a.jacobian.col(k).head(deflections);
        EXPECT_LT((column - b.jacobian.col(k).head(deflections)).cwiseAbs().maxCoeff(),
                  10.0 * tolerance * column.cwiseAbs().maxCoeff())
            << k;
    }
    EXPECT_EQ(a.warnings, b.warnings);
}

Case nominal() {
    Case c = captif(3000, 40, {5500, 0.7, -1.5, 0.4});
    c.settings.solver.load_steps = 4;
    return c;
}

TEST(RunMany, GivesEachItsOwnAnswer) {
    Case c = nominal();
    c.loads.push_back(plate(0.15, 400e3));
    c.loads[1].name = "lighter";
    Sensor lighter = deflection(0.3);
    lighter.load = 1;
    c.sensors.push_back(lighter);
    const ForwardModel model(c);
    EXPECT_GT(model.lanes(), 1);
    std::vector<Case> cases(7, c);
    cases[1].layers[1].thickness = 0.20; // another mesh
    cases[2].layers[1].parameters[1] = 900.0;
    cases[3].layers[1].parameters[5] = 1.5; // no material has this ratio
    cases[4].layers[1].thickness = 0.20;
    cases[4].layers[2].parameters[0] = 90e6;
    cases[5].layers[0].thickness = -0.01;
    cases[6].loads[0].pressure = 300e3;
    const auto by = parameters_of(c, {"base.k1", "base.k2", "subgrade.modulus_MPa"});
    const auto workspace = model.make_workspace();
    const auto together = model.run_many(cases, by, *workspace);
    ASSERT_EQ(together.size(), cases.size());
    for (std::size_t i = 0; i < cases.size(); ++i) {
        const auto alone = model.run(cases[i], by, *model.make_workspace());
        ASSERT_EQ(static_cast<bool>(alone), static_cast<bool>(together[i])) << i;
        if (alone) {
            expect_near(*alone, *together[i], 1e-11);
            EXPECT_NEAR(alone->values.back(), together[i]->values.back(), 1e-11 * alone->values.back());
        } else {
            EXPECT_EQ(alone.failure().reason, together[i].failure().reason);
        }
        const auto by_itself = model.run_many({&cases[i], 1}, by, *workspace);
        if (together[i]) {
            EXPECT_EQ(by_itself[0]->values, together[i]->values) << i;
            EXPECT_EQ(by_itself[0]->jacobian, together[i]->jacobian) << i;
        }
    }
    EXPECT_EQ(together[3].status(), Status::invalid_parameters);
    EXPECT_EQ(together[5].status(), Status::invalid_parameters);
}

// A run that lanes do not follow goes as it does alone, to the bit.
TEST(RunMany, LeavesWhatGoesAloneAsItIs) {
    Case secant = nominal();
    secant.settings.integration = Integration::secant;
    secant.layers[1].parameters[9] = material::not_given;
    Case linear = nominal();
    linear.layers[1] = linear_layer("base", 0.277, 200e6, 0.35);
    linear.settings.layered = false;
    Case slipping = nominal();
    slipping.layers[0].compliance = 1e-9;
    for (const Case& c : {secant, linear, slipping}) {
        const ForwardModel model(c);
        std::vector<Case> cases(3, c);
        cases[1].layers[2].parameters[0] = 60e6;
        const auto workspace = model.make_workspace();
        const auto together = model.run_many(cases, {}, *workspace);
        for (std::size_t i = 0; i < cases.size(); ++i) {
            const auto alone = model.run(cases[i], {}, *workspace);
            ASSERT_TRUE(alone && together[i]);
            EXPECT_EQ(alone->values, together[i]->values);
        }
    }
    EXPECT_EQ(ForwardModel(slipping).lanes(), 1);
}

} // namespace
