// Ledgers written by hand, and what a diagnosis concludes from each.
#pragma once

#include "diagnose/decision.h"

#include <gsl/gsl_cdf.h>

namespace ledgers {

using namespace explore;
using diagnose::Ledger;
using diagnose::Reason;
using diagnose::Row;
using diagnose::Says;
using diagnose::Verdict;
using hypotheses::Kind;

inline constexpr int free_readings = 40;

// A fit of so many numbers that leaves chi2.
inline Row fitted(Kind kind, const std::string& name, double chi2, int numbers, double log_weight) {
    Row row{.hypothesis = {.kind = kind, .name = name}};
    row.fit.chi2 = chi2;
    row.fit.numbers = numbers;
    row.fit.dof = free_readings - numbers;
    row.fit.p_value = gsl_cdf_chisq_Q(chi2, row.fit.dof);
    row.log_evidence = log_weight;
    return row;
}

inline Row nothing(double chi2, double log_weight) {
    return fitted(Kind::none, "nothing is wrong", chi2, 0, log_weight);
}

inline Row noise(double k, double log_weight, const std::string& name = "size") {
    Row row = fitted(Kind::noise, name, k * k * free_readings, 0, log_weight);
    row.noise = k;
    return row;
}

// "base" changes the stiffness of that layer, "readings" what instruments say, "" something else.
inline Row effect(const std::string& name, double chi2, double log_weight, const std::string& subject = "") {
    Row row = fitted(Kind::effect, name, chi2, 1, log_weight);
    row.hypothesis.terms = {{name, "", subject}};
    return row;
}

inline Row two(const std::string& a, const std::string& b, double chi2, double log_weight) {
    Row row = fitted(Kind::effects, a + " with " + b, chi2, 2, log_weight);
    row.hypothesis.terms = {{a, "", ""}, {b, "", ""}};
    return row;
}

inline Row wrong_readings(std::vector<std::string> which, double chi2, double log_weight) {
    Row row = fitted(Kind::readings, "", chi2, static_cast<int>(which.size()), log_weight);
    for (const std::string& own : which) {
        row.hypothesis.name += own;
        row.hypothesis.terms.push_back({"outlier", own, "readings"});
    }
    return row;
}

inline Row correction(double chi2, double log_weight, std::vector<std::string> subjects = {"subgrade"},
                      int numbers = 4) {
    Row row = fitted(Kind::correction, "correction", chi2, numbers, log_weight);
    row.hypothesis.subjects = std::move(subjects);
    return row;
}
inline const std::string of_correction = "correction: correction";

inline Row at_end(Row row) {
    row.fit.at_end = true;
    return row;
}

inline Row with_pattern(Row row, double chi2, int dof) {
    row.fit.pattern_chi2 = chi2;
    row.fit.pattern_dof = dof;
    row.fit.p_pattern = gsl_cdf_chisq_Q(chi2, dof);
    return row;
}

struct Case {
    std::string what;
    std::vector<Row> rows;
    Verdict verdict;
    std::vector<std::string> causes = {};
    Reason reason = Reason::none;
    std::vector<Ledger::Chance> chances = {};
    std::vector<Ledger::Confounded> confounded = {};
    std::vector<Ledger::Predicted> predicted = {};
    std::vector<Ledger::Beyond> beyond = {};
    Says says = Says::at_places;
    double score = 1e-4; // at the study's model
    bool noise_is_stated = true;
};

inline Ledger ledger_of(const Case& c, const std::vector<Row>& rows) {
    Ledger ledger(c.noise_is_stated);
    for (const Row& row : rows) {
        ledger.add(row);
        if (row.hypothesis.kind == Kind::correction) {
            ledger.add(Ledger::Located{row.hypothesis.key(), c.says});
        }
    }
    for (const auto& own : c.chances) {
        ledger.add(own);
    }
    for (const auto& own : c.confounded) {
        ledger.add(own);
    }
    for (const auto& own : c.predicted) {
        ledger.add(own);
    }
    for (const auto& own : c.beyond) {
        ledger.add(own);
    }
    ledger.add_score(c.score);
    return ledger;
}

// A ledger a rule.
std::vector<Case> table();

} // namespace ledgers
