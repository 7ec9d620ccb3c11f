// Corrections in place of names, on linear models.
#include "diagnose/evidence.h"
#include "diagnose/location.h"
#include "support/formula.h"

#include "base/random.h"

#include <cmath>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <map>

using namespace explore;
using diagnose::Members;
using diagnose::Verdict;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr Index readings = 40;
constexpr Index parameters = 3;
constexpr std::size_t candidates = 3;
constexpr std::size_t coefficients = 4;

// Three parameters, three candidates with sizes from -1 to 1, two channels of four coefficients: the logarithm of a
// factor acts.
struct World {
    MatrixXd a, signatures, changes;
    VectorXd data;
    std::map<std::size_t, std::string> layers; // whose stiffness is all that a candidate changes

    explicit World(std::uint64_t seed) {
        const pave::RandomStream random(seed, 0);
        std::uint64_t next = 0;
        const auto draw = [&] { return random.normal(next++); };
        a = MatrixXd::NullaryExpr(readings, parameters, [&] { return 10.0 * draw(); });
        signatures = MatrixXd::NullaryExpr(readings, static_cast<Index>(candidates), [&] { return 3.0 * draw(); });
        changes = MatrixXd::NullaryExpr(readings, 2 * static_cast<Index>(coefficients), [&] { return 4.0 * draw(); });
        data = a * VectorXd::Constant(parameters, 0.4) + VectorXd::NullaryExpr(readings, draw);
    }

    problem::Problem problem(const Members& members) const {
        problem::ParameterSpace space;
        MatrixXd matrix(readings, parameters + static_cast<Index>(members.size()));
        matrix.leftCols(parameters) = a;
        for (Index k = 0; k < parameters; ++k) {
            space.axes.push_back({fmt::format("p{}", k), 0.0, 1.0});
        }
        for (std::size_t m = 0; m < members.size(); ++m) {
            const bool is_size = members[m] < candidates;
            space.axes.push_back({fmt::format("m{}", members[m]), is_size ? -1.0 : 0.05, is_size ? 1.0 : 20.0,
                                  is_size ? problem::Scale::linear : problem::Scale::log});
            matrix.col(parameters + static_cast<Index>(m)) =
                is_size ? signatures.col(static_cast<Index>(members[m]))
                        : changes.col(static_cast<Index>(members[m] - candidates));
        }
        std::vector<problem::Misfit::Term> terms;
        for (Index i = 0; i < readings; ++i) {
            terms.push_back({static_cast<std::size_t>(i), data[i], 1.0, 1.0, {.absolute = 1.0}});
        }
        const Index first = std::count_if(members.begin(), members.end(), [](std::size_t m) { return m < candidates; });
        test::Formula formula([matrix, first](const VectorXd& x, VectorXd& responses, MatrixXd& jacobian) {
            VectorXd y = x;
            jacobian = matrix;
            for (Index k = parameters + first; k < x.size(); ++k) {
                y[k] = std::log(x[k]);
                jacobian.col(k) /= x[k];
            }
            responses = matrix * y;
        });
        return {space, std::make_shared<test::Formula>(std::move(formula)), {problem::MisfitKind::weighted, terms}};
    }

    diagnose::Diagnosis diagnose(diagnose::Says says = diagnose::Says::at_places) const {
        diagnose::Workbench bench(
            {.problem = [this](const Members& members, diagnose::Mesh) { return problem(members); },
             .run = [](const Members&, diagnose::Mesh) { return 0; },
             .store = nullptr,
             .threads = 0});
        diagnose::DiagnosisTask task{.bench = bench, .candidates = {}, .groups = {}, .places = {}, .loads = {}};
        for (std::size_t j = 0; j < candidates; ++j) {
            task.candidates.push_back(
                {.effect = fmt::format("e{}", j), .on = "", .null = 0.5, .typical = 0.7, .reading = {}, .layer = ""});
        }
        for (const auto& [candidate, layer] : layers) {
            task.candidates[candidate].layer = layer;
        }
        task.channels = {{"first", "base", candidates, coefficients},
                         {"second", "subgrade", candidates + coefficients, coefficients}};
        for (std::size_t g = 0; g < 2; ++g) {
            diagnose::ReadingGroup group{.name = fmt::format("group{}", g), .terms = {}};
            for (std::size_t i = 0; i < static_cast<std::size_t>(readings) / 2; ++i) {
                group.terms.push_back(g * static_cast<std::size_t>(readings) / 2 + i);
            }
            task.places.push_back({group.name, group.terms});
            task.groups.push_back(std::move(group));
        }
        auto result = diagnose::diagnose(task, {.explore = 8, .starts = 1, .bootstrap = 5}, says);
        EXPECT_TRUE(result.has_value());
        return *result;
    }
};

} // namespace

TEST(Location, NamesNothingWhereTheModelIsAdequateOrAnEffectExplainsTheData) {
    int corrected = 0;
    int named = 0;
    constexpr std::uint64_t worlds = 30;
    for (std::uint64_t seed = 0; seed < worlds; ++seed) {
        World plain(seed);
        corrected += plain.diagnose().location ? 1 : 0;
        World one(1000 + seed);
        one.data += 0.7 * one.signatures.col(1);
        const auto found = one.diagnose();
        named +=
            found.verdict() == Verdict::cause_named && found.decision.causes == std::vector<std::string>{"e1"} ? 1 : 0;
    }
    EXPECT_LE(corrected, 3);
    EXPECT_GE(named, 26);
}

// An effect that one coefficient of the second channel follows almost, and data of that channel: what is named may be
// something else there. Not where both say the same of one layer and the effect explains all, nor where the correction
// has another signature.
TEST(Location, LeavesANameBesideACorrectionThatFitsAsWell) {
    int rivals = 0;
    int alone = 0;
    int in_another_layer = 0;
    int elsewhere = 0;
    constexpr std::uint64_t worlds = 20;
    for (std::uint64_t seed = 0; seed < worlds; ++seed) {
        World world(3000 + seed);
        World other = world;
        world.signatures.col(1) = world.changes.col(5) + 0.05 * world.signatures.col(1);
        World shaped = world; // beside the effect's own shape a little of another: more than it says
        shaped.data += 0.7 * world.changes.col(5) + 0.1 * world.changes.col(6);
        world.data += 0.7 * world.signatures.col(1);
        const auto found = shaped.diagnose();
        rivals += found.verdict() == Verdict::ambiguous && found.decision.causes == std::vector<std::string>{"e1"} &&
                  found.location && found.location->corrections[0].channel == 1;
        world.layers = {{1, "subgrade"}};
        alone += world.diagnose().verdict() == Verdict::cause_named ? 1 : 0;
        shaped.layers = {{1, "base"}};
        in_another_layer += shaped.diagnose().verdict() == Verdict::cause_named ? 1 : 0;
        other.data += 0.7 * other.signatures.col(1);
        elsewhere += other.diagnose().verdict() == Verdict::cause_named ? 1 : 0;
    }
    EXPECT_GE(rivals, 15);
    EXPECT_GE(alone, 17);
    EXPECT_LE(in_another_layer, 5);
    EXPECT_GE(elsewhere, 17);
}

// Two effects at once are both said, and that one thing may do so as well.
TEST(Location, OfTwoEffectsLeavesRoomForOneThatTheCatalogueLacks) {
    int both = 0;
    for (std::uint64_t seed = 0; seed < 20; ++seed) {
        World world(4000 + seed);
        world.data += 0.7 * (world.signatures.col(1) - world.signatures.col(2));
        const auto found = world.diagnose();
        EXPECT_TRUE(found.verdict() == Verdict::ambiguous) << seed;
        both += found.explanations.size() == 1 && found.decision.causes.size() == 2 ? 1 : 0;
    }
    EXPECT_GE(both, 18);
}

// A third of the correction below: residuals as of noise 1.9 times as large as stated, and nothing else would call it
// more. By likelihoods that is 40 ln 1.9 = 26, more than a correction costs.
TEST(Location, IsWeighedAgainstNoiseThatIsLargerThanStated) {
    int adequate = 0;
    int more_probable = 0;
    constexpr int worlds = 20;
    for (int w = 0; w < worlds; ++w) {
        World world(6000 + static_cast<std::uint64_t>(w));
        world.data += 0.35 * world.changes.rightCols(4) * VectorXd{{-0.8, -0.6, 0.1, 0.5}};
        const auto found = world.diagnose();
        adequate += found.verdict() == Verdict::adequate ? 1 : 0;
        const auto& first = found.ledger.rows()[found.decision.hypotheses[0].row];
        more_probable += first.hypothesis.kind == hypotheses::Kind::correction ? 1 : 0;
    }
    EXPECT_LE(adequate, 4);
    EXPECT_GE(more_probable, 16);
}

// The coefficients are those of ridge regression with the prior that was found (Hoerl and Kennard 1970; here C and not
// the identity), and their bands hold the truth.
TEST(Location, FindsTheChannelAndItsCoefficients) {
    int located = 0;
    int within = 0;
    int places = 0;
    for (std::uint64_t seed = 0; seed < 25; ++seed) {
        World world(2000 + seed);
        const VectorXd truth{{-0.8, -0.6, 0.1, 0.5}};
        world.data += world.changes.rightCols(4) * truth;
        const auto found = world.diagnose();
        if (found.verdict() != Verdict::located) {
            continue;
        }
        ASSERT_TRUE(found.location);
        const auto& location = *found.location;
        located += location.corrections[0].channel == 1 ? 1 : 0;
        EXPECT_TRUE(found.decision.causes.empty());
        EXPECT_LT(location.corrections[0].p_familywise, 0.05);
        if (location.corrections.size() > 1) {
            continue;
        }
        MatrixXd all(readings, parameters + 4);
        all << world.a, world.changes.rightCols(4);
        MatrixXd precision = all.transpose() * all;
        precision.bottomRightCorner(4, 4) +=
            diagnose::prior_correlation(4).inverse() / std::pow(location.corrections[0].strength, 2);
        const VectorXd expected = precision.ldlt().solve(all.transpose() * world.data);
        const auto& unit = location.fit.model.unit;
        constexpr double slope = 2.0 * 2.995732273553991; // ln 400
        for (Index i = 0; i < 4; ++i) {
            const auto k = static_cast<std::size_t>(parameters + i);
            const double value = (unit[k] - 0.5) * slope;
            EXPECT_NEAR(value, expected[parameters + i], 1e-2);
            const auto at = static_cast<Index>(k);
            const double deviation = slope * std::sqrt(location.covariance(at, at));
            EXPECT_NEAR(deviation, std::sqrt(precision.inverse()(at, at)), 0.02 * deviation);
            within += std::abs(value - truth[i]) < 1.96 * deviation ? 1 : 0;
            ++places;
        }
        EXPECT_EQ(location.fit.dof, readings - parameters);
    }
    EXPECT_GE(located, 23);
    EXPECT_GE(within, 0.88 * places);
}

// What is known between places only locates what no name explains, and displaces no name.
TEST(Location, OfPlacesThatAreKnownBesideEachOtherTakesNoNameAway) {
    int unexplained = 0;
    int located = 0;
    int displaced = 0;
    for (std::uint64_t seed = 0; seed < 12; ++seed) {
        World world(2000 + seed);
        world.data += world.changes.rightCols(4) * VectorXd{{-0.8, -0.6, 0.1, 0.5}};
        using diagnose::Says;
        unexplained += world.diagnose(Says::nothing).verdict() == Verdict::unexplained;
        located += world.diagnose(Says::between_places).verdict() == Verdict::located;
        // A name that explains it, but for what one coefficient more does.
        World named(5000 + seed);
        named.signatures.col(1) = named.changes.col(5) + 0.2 * named.changes.col(6);
        named.data += named.changes.col(5) * 0.7;
        if (named.diagnose(Says::nothing).verdict() == Verdict::unexplained) {
            continue;
        }
        const auto known = named.diagnose(Says::at_places);
        displaced += known.is_located() && known.effects[0].fit->p_value >= diagnose::level_noise;
        EXPECT_FALSE(named.diagnose(Says::between_places).is_located()) << seed;
    }
    EXPECT_GE(unexplained, 11);
    EXPECT_GE(located, 11);
    EXPECT_EQ(displaced, 0);
}
