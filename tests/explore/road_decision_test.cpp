// What follows for a road from scores and fits that are made up; expected verdicts are those of the rules of decide(),
// probabilities by hand.
#include "analysis/road/road_decision.h"

#include <cmath>
#include <gsl/gsl_cdf.h>
#include <gtest/gtest.h>
#include <numbers>

using namespace explore;
using analysis::RoadDiagnosis;
using analysis::RoadEffect;
using diagnose::Verdict;

namespace {

constexpr double dof = 200.0;
const problem::Axis axis{
    .name = "floor-depth.size", .low = -1000.0, .high = 1000.0, .scale = problem::Scale::linear, .start = 0.0};

RoadDiagnosis road(double chi2) {
    RoadDiagnosis d;
    d.chi2 = chi2;
    d.dof = dof;
    d.p_value = gsl_cdf_chisq_Q(chi2, dof);
    return d;
}

// Of a size that lies 0.2 of the range from none, known to 0.02 of it.
RoadEffect fitted(std::size_t candidate, const std::string& name, double chi2, double p_familywise) {
    RoadEffect effect;
    effect.candidate = candidate;
    effect.name = name;
    effect.p_familywise = p_familywise;
    effect.chi2 = chi2;
    effect.p_value = gsl_cdf_chisq_Q(chi2, dof - 1.0);
    effect.log_evidence = analysis::road_evidence(hypotheses::Kind::effect, chi2, dof, axis, 400.0, 0.7, 0.02);
    return effect;
}

} // namespace

TEST(RoadDecision, NothingIsLackingWhereNoScoreStandsOut) {
    RoadDiagnosis d = road(205.0);
    RoadEffect seen;
    seen.name = "floor-depth";
    seen.p_familywise = 0.4;
    d.effects = {seen};
    decide_on_road(d, {});
    EXPECT_EQ(d.decision.verdict, Verdict::adequate);
    EXPECT_TRUE(d.causes.empty());
    EXPECT_EQ(d.decision.noise_factor, 1.0);
}

TEST(RoadDecision, NoiseThatIsLargerThanStatedIsTheAnswerWhereNothingElseIs) {
    RoadDiagnosis d = road(1.5 * 1.5 * dof);
    decide_on_road(d, {});
    EXPECT_EQ(d.decision.verdict, Verdict::adequate);
    EXPECT_NEAR(d.decision.noise_factor, 1.5, 0.02); // the root of chi2 / dof, a little less by what is known of it
}

TEST(RoadDecision, NamesWhatExplainsAndSortsByProbability) {
    RoadDiagnosis d = road(300.0);
    d.effects = {fitted(3, "drift", 260.0, 1e-4), fitted(5, "floor-depth", 198.0, 1e-8)};
    RoadEffect untried;
    untried.candidate = 1;
    untried.name = "load-magnitude";
    d.effects.push_back(untried);
    decide_on_road(d, {});
    ASSERT_EQ(d.decision.verdict, Verdict::cause_named);
    ASSERT_EQ(d.causes, (std::vector<std::size_t>{0}));
    EXPECT_EQ(d.effects[0].name, "floor-depth");
    EXPECT_EQ(d.effects[1].name, "drift");
    EXPECT_EQ(d.effects[2].name, "load-magnitude");
}

TEST(RoadDecision, SaysWhatReadingsDoNotTellApart) {
    RoadDiagnosis d = road(300.0);
    d.effects = {fitted(3, "drift", 199.0, 1e-8), fitted(5, "floor-depth", 198.0, 1e-8)};
    decide_on_road(d, {});
    EXPECT_EQ(d.decision.verdict, Verdict::ambiguous);
    EXPECT_EQ(d.causes, (std::vector<std::size_t>{0, 1}));
    d = road(300.0);
    d.effects = {fitted(3, "drift", 210.0, 1e-8), fitted(5, "floor-depth", 198.0, 1e-8)};
    decide_on_road(d, {});
    EXPECT_EQ(d.decision.verdict, Verdict::cause_named);
    d.causes.clear();
    decide_on_road(d, {{.a = 5, .b = 3, .rate = 0.8}}); // the best possible decision errs in one case of five
    EXPECT_EQ(d.decision.verdict, Verdict::ambiguous);
}

TEST(RoadDecision, NamesNothingAloneAtTheEndOfItsRange) {
    RoadDiagnosis d = road(300.0);
    d.effects = {fitted(5, "floor-depth", 198.0, 1e-8)};
    d.effects[0].ends_range = true;
    decide_on_road(d, {});
    EXPECT_EQ(d.decision.verdict, Verdict::ambiguous);
}

// ln E = -1/2 S + ln p(size) + 1/2 ln(2 pi) + ln(deviation), with Cauchy's density; the size of the noise is 1 half of
// the time, and else so much that residuals with S = n hardly tell.
TEST(RoadDecision, EvidenceIsLaplacesByHand) {
    const double scale = 0.2;
    const auto cauchy = [&](double u) { return std::atan(u / scale) / std::numbers::pi; };
    const double density =
        1.0 / (std::numbers::pi * scale * (cauchy(0.5) - cauchy(-0.5)) * (1.0 + std::pow(0.2 / scale, 2)));
    // That the size is cut off where the data say nothing adds a precision of 2 pi p(0)^2, which counts little here.
    const double prior_there = 2.0 * std::numbers::pi * std::pow(density * (1.0 + std::pow(0.2 / scale, 2)), 2);
    const double by_hand = -100.0 + std::log(density) + 0.5 * std::log(2.0 * std::numbers::pi) -
                           0.5 * std::log(1.0 / (0.02 * 0.02) + prior_there);
    const double difference =
        analysis::road_evidence(hypotheses::Kind::effect, 200.0, dof, axis, 400.0, 0.7, 0.02) - by_hand;
    // ln of 1/2 + 1/2 of the average over k: 1/sqrt(2 n) wide beside 0.35.
    const double average = std::sqrt(2.0 * std::numbers::pi) / std::sqrt(2.0 * dof + 1.0 / (0.35 * 0.35)) /
                           (0.35 * std::sqrt(2.0 * std::numbers::pi));
    EXPECT_NEAR(difference, std::log(0.5 + 0.5 * average), 0.01);
}

// Of two layouts that fit alike, the one that sensors moved to in whole is the more probable: 3 % of the largest move
// is one standard deviation, and 0.91 of it three.
TEST(RoadDecision, ALayoutIsAWhole) {
    const auto evidence = [](double size) {
        return analysis::road_evidence(hypotheses::Kind::layout, 200.0, dof, axis, 600.0, size, 0.002);
    };
    const double whole = axis.unit(600.0);
    const double none = axis.unit(0.0);
    EXPECT_NEAR(evidence(whole) - evidence(none + 0.91 * (whole - none)), 0.5 * 3.0 * 3.0, 1e-6);
}
