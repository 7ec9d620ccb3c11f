// What follows from a ledger: ledgers written by hand (decision_table.cpp), and what holds of any.
#include "support/ledgers.h"

#include "base/random.h"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <set>

using namespace ledgers;

TEST(Decision, IsWhatTheTableSays) {
    const auto cases = table();
    EXPECT_GE(cases.size(), 40U);
    for (const Case& c : cases) {
        const auto found = decide(ledger_of(c, c.rows));
        EXPECT_EQ(diagnose::verdict_names[static_cast<int>(found.verdict)],
                  diagnose::verdict_names[static_cast<int>(c.verdict)])
            << c.what;
        EXPECT_EQ(found.causes, c.causes) << c.what;
        if (c.verdict != Verdict::adequate && c.verdict != Verdict::located && c.verdict != Verdict::cause_named) {
            EXPECT_EQ(static_cast<int>(found.reason), static_cast<int>(c.reason)) << c.what;
        }
    }
}

// Noise as stated would explain the readings; errors in common explain them so much better that their ranges are right.
TEST(Decision, TakesErrorsInCommonForTheNoiseWhereTheyAreFarMoreProbable) {
    for (const double log_weight : {1.0, 3.0}) { // 73 and 95 %
        Row shared = noise(0.95, log_weight, "shared");
        shared.is_independent = false;
        Case c{"shared", {nothing(36, 0), shared}, Verdict::adequate};
        c.score = 0.4;
        const auto found = decide(ledger_of(c, c.rows));
        EXPECT_EQ(found.verdict, Verdict::adequate);
        EXPECT_EQ(found.as_stated, log_weight < 2.0);
    }
}

// What another premise makes about as probable keeps a name from standing alone, one that was named by its premise too.
TEST(Decision, LetsNoNameStandAloneBesideAnotherPremise) {
    Row premise = fitted(Kind::effect, "there is no floor", 0, 0, 0);
    premise.is_premise = true;
    premise.hypothesis.terms = {{"floor-depth", "", ""}};
    const Case named{"named", {nothing(120, -60), noise(1.73, -30), effect("a", 38, -10)}, Verdict::cause_named};
    Case by_premise{"by premise", {nothing(40, 0), premise}, Verdict::cause_named};
    by_premise.score = 0.4;
    for (const double probability : {0.01, 0.35}) {
        const bool is_near = probability > 0.05;
        const auto beside = [&](const Case& c, const char* other) {
            Ledger ledger = ledger_of(c, c.rows);
            ledger.add(Ledger::Elsewhere{.words = other, .terms = {{other, "", ""}}, .probability = probability});
            return decide(ledger);
        };
        const auto by_name = beside(named, "floor-depth");
        EXPECT_EQ(by_name.verdict, is_near ? Verdict::ambiguous : Verdict::cause_named);
        EXPECT_EQ(by_name.causes,
                  is_near ? (std::vector<std::string>{"a", "floor-depth"}) : std::vector<std::string>{"a"});
        const auto without = beside(by_premise, "inertia");
        EXPECT_EQ(without.verdict, is_near ? Verdict::ambiguous : Verdict::cause_named);
        EXPECT_EQ(without.causes.front(), "floor-depth");
        EXPECT_EQ(without.causes.size(), is_near ? 2U : 1U);
        EXPECT_NEAR(without.hypotheses.front().probability, is_near ? 1.0 - probability : 1.0, 1e-12);
    }
}

TEST(Decision, DoesNotDependOnTheOrderOfRows) {
    for (const Case& c : table()) {
        const auto expected = decide(ledger_of(c, c.rows));
        std::vector<Row> rows = c.rows;
        for (std::size_t turn = 0; turn < rows.size(); ++turn) {
            std::rotate(rows.begin(), rows.begin() + 1, rows.end());
            std::swap(rows.front(), rows.back());
            const auto found = decide(ledger_of(c, rows));
            EXPECT_EQ(found.verdict, expected.verdict) << c.what;
            EXPECT_EQ(found.causes, expected.causes) << c.what;
            EXPECT_EQ(found.of_noise, expected.of_noise) << c.what;
        }
    }
}

TEST(Decision, NeverDropsANameForMoreEvidenceOfIt) {
    for (const Case& c : table()) {
        const auto before = decide(ledger_of(c, c.rows));
        for (std::size_t r = 0; r < c.rows.size(); ++r) {
            if (!c.rows[r].hypothesis.is_name() || c.rows[r].is_premise) {
                continue;
            }
            for (const double more : {0.5, 2.0, 5.0, 20.0}) {
                std::vector<Row> rows = c.rows;
                rows[r].log_evidence += more;
                const auto after = decide(ledger_of(c, rows));
                for (const auto& term : c.rows[r].hypothesis.terms) {
                    const auto names = [&](const auto& causes) {
                        return std::find(causes.begin(), causes.end(), term.effect) != causes.end();
                    };
                    EXPECT_LE(names(before.causes), names(after.causes)) << c.what << " +" << more;
                }
            }
        }
    }
}

TEST(Decision, OfAnyLedgerRestsOnItsRows) {
    const pave::RandomStream random(8, 0);
    std::uint64_t next = 0;
    const auto uniform = [&](double low, double high) { return low + (high - low) * random.uniform(next++); };
    for (int trial = 0; trial < 2000; ++trial) {
        const double chi2 = uniform(30, 200);
        Case c{"random", {nothing(chi2, -0.5 * chi2)}, Verdict::adequate};
        c.rows.push_back(noise(std::max(1.0, std::sqrt(chi2 / free_readings)), uniform(-60, -20)));
        for (int e = 0; e < 4; ++e) {
            Row row = effect(std::string(1, static_cast<char>('a' + e)), uniform(25, chi2), uniform(-40, -5),
                             e == 0 ? "base" : "");
            row.fit.at_end = uniform(0, 1) < 0.2;
            c.rows.push_back(row);
        }
        if (uniform(0, 1) < 0.5) {
            c.rows.push_back(
                correction(uniform(25, chi2), uniform(-40, -5), {uniform(0, 1) < 0.5 ? "base" : "subgrade"}));
        }
        c.says = static_cast<Says>(static_cast<int>(uniform(0, 3)));
        if (uniform(0, 1) < 0.3) {
            c.predicted = {{of_correction, 1.0, 2.0}};
        }
        const Ledger ledger = ledger_of(c, c.rows);
        const auto found = decide(ledger);
        double sum = 0.0;
        for (const auto& ranked : found.hypotheses) {
            sum += ranked.probability;
        }
        EXPECT_NEAR(sum, 1.0, 1e-9);
        EXPECT_TRUE(std::is_sorted(found.hypotheses.begin(), found.hypotheses.end(),
                                   [](const auto& a, const auto& b) { return a.probability > b.probability; }));
        const bool has_names = found.verdict == Verdict::cause_named || found.verdict == Verdict::ambiguous;
        EXPECT_EQ(has_names, !found.names.empty());
        EXPECT_EQ(has_names, !found.causes.empty());
        for (const std::size_t r : found.names) {
            EXPECT_TRUE(ledger.rows()[r].is_tried());
        }
        if (has_names) { // its model is that of a name
            ASSERT_TRUE(found.model);
            EXPECT_TRUE(ledger.rows()[*found.model].hypothesis.is_name());
        }
        if (found.verdict == Verdict::located) {
            ASSERT_TRUE(found.correction && found.model == found.correction);
            EXPECT_GE(ledger.rows()[*found.correction].fit.p_value, 0.005);
            // A name that leaves noise does not vanish.
            for (const Row& row : ledger.rows()) {
                EXPECT_FALSE(row.hypothesis.kind == Kind::effect && row.fit.p_value >= 0.05);
            }
        }
        if (found.verdict == Verdict::cause_named) {
            EXPECT_EQ(found.names.size(), 1U);
            EXPECT_FALSE(ledger.rows()[found.names[0]].fit.at_end);
            const double p = ledger.rows()[found.names[0]].fit.p_value;
            EXPECT_TRUE(p >= 0.05 || (p >= 0.005 && found.probability_of(found.names[0]) >= 0.95)) << p;
        }
    }
}
