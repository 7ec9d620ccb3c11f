// Numbers that follow others: the same as the section written out, with derivatives by the chain rule.
#include "pavement/tie.h"
#include "support/differences.h"
#include "support/sections.h"

#include <gtest/gtest.h>

using namespace test;

namespace {

Case section() {
    Case c = captif(3000.0, 60.0, {2000.0, 0.5, -0.3, 0.5});
    c.sensors = {deflection(0.0), deflection(0.3), deflection(0.9), strain_zz(0.15, 0.0)};
    return c;
}

Response response_of(const Case& c, const std::vector<Parameter>& parameters) {
    const ForwardModel model(c);
    const auto workspace = model.make_workspace();
    auto outcome = model.run(c, parameters, *workspace);
    EXPECT_TRUE(outcome) << (outcome ? "" : outcome.failure().reason);
    return std::move(outcome).value();
}

} // namespace

TEST(Ties, AreTheSectionWrittenOutWhateverTheirOrder) {
    Case tied = section();
    add_tie(tied, "asphalt.modulus_MPa", "50 * subgrade.modulus_MPa - 0.5 * base.k1", {});
    add_tie(tied, "subgrade.modulus_MPa", "30 + base.k1 / 40", {}); // that the other one reads
    Case written = section();
    find_parameter(written, "subgrade.modulus_MPa", {}).in(written) = (30.0 + 2000.0 / 40.0) * 1e6;
    find_parameter(written, "asphalt.modulus_MPa", {}).in(written) = (50.0 * 80.0 - 1000.0) * 1e6;
    const auto a = response_of(tied, {});
    const auto b = response_of(written, {});
    EXPECT_EQ(a.values, b.values);
}

TEST(Ties, AreInTheDerivatives) {
    Case tied = section();
    add_tie(tied, "subgrade.modulus_MPa", "30 + base.k1 / 40", {});
    const Parameter k1 = find_parameter(tied, "base.k1", {});
    const auto exact = response_of(tied, {k1});
    const ForwardModel model(tied);
    const auto workspace = model.make_workspace();
    const auto rates = central_differences(model, tied, k1, 2.0, exact, *workspace);
    ASSERT_TRUE(rates);
    const auto d = disagreement(exact, 0, 2000.0, rates->rates);
    EXPECT_LT(d.worst, 1e-4 * d.scale);
    // Without the tie the derivative is another one.
    const auto alone = response_of(section(), {find_parameter(section(), "base.k1", {})});
    EXPECT_GT(std::abs(exact.jacobian(2, 0) / alone.jacobian(2, 0)), 2.0);
}

TEST(Ties, OutOfRangeOrInACircleAreRefused) {
    Case c = section();
    add_tie(c, "base.n", "base.k2", {});
    EXPECT_EQ(apply_ties(c), "");
    EXPECT_THROW(add_tie(c, "base.k2", "2 * base.n", {}), Error);
    EXPECT_THROW(add_tie(c, "base.k1", "base.k1 + 1", {}), Error);
    EXPECT_THROW(add_tie(c, "base.k9", "1", {}), Error);
    EXPECT_THROW(add_tie(c, "base.k1", "base.k9", {}), Error);
    add_tie(c, "subgrade.modulus_MPa", "-base.k1", {});
    EXPECT_NE(apply_ties(c).find("out of its range"), std::string::npos);
}
